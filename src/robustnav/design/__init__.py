"""Gains decided before any data: H2 and H-infinity observers, gain schedules, error bounds and their certificates."""

from robustnav.design.bounds import PathRows, posterior_bound
from robustnav.design.certificates import (
    Certificate,
    RateHistoryCertificate,
    rate_history_certificate,
    verify_h2,
)
from robustnav.design.hinf import HinfDesign, hinf_norm, hinf_observer
from robustnav.design.lmi import PolytopeDesign, h2_lmi, h2_lmi_polytope, h2_lmi_structured, hinf_lmi
from robustnav.design.plant import Plant
from robustnav.design.riccati import H2Design, h2_riccati
from robustnav.design.schedule import GainTable, SensorRows, Startup, Turning, gain_table

__all__ = [
    "Certificate",
    "GainTable",
    "H2Design",
    "HinfDesign",
    "PathRows",
    "Plant",
    "PolytopeDesign",
    "RateHistoryCertificate",
    "SensorRows",
    "Startup",
    "Turning",
    "gain_table",
    "h2_lmi",
    "h2_lmi_polytope",
    "h2_lmi_structured",
    "h2_riccati",
    "hinf_lmi",
    "hinf_norm",
    "hinf_observer",
    "posterior_bound",
    "rate_history_certificate",
    "verify_h2",
]
