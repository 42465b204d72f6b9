"""Strapdown integration: coning and sculling, pre-integration, navigation equations on WGS-84."""
