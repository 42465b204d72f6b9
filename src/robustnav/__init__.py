"""Robust state estimators for small drones and inertial navigation."""

__version__ = "0.1.0"
