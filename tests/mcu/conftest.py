"""Exports of every kind, built once; tests on the emulator skip where its tools are not installed."""

import shutil

import pytest

from robustnav.benchmark.mcu import FILTERS, RATE_HZ
from robustnav.export.build import build
from robustnav.export.emulator import GCC, QEMU
from robustnav.export.tree import sources, write

MISSING = [tool for tool in (GCC, QEMU) if not shutil.which(tool)]


def pytest_collection_modifyitems(items):
    for item in items:
        if "mcu" in item.path.parts and MISSING:
            item.add_marker(pytest.mark.skip(reason=f"not installed: {', '.join(MISSING)}"))


@pytest.fixture(scope="session")
def exported(tmp_path_factory):
    """Return by name a filter of the benchmark: its unit and the folder it was written to."""
    made = {}

    def get(name):
        if name not in made:
            chosen = FILTERS[name]
            unit, replay = build(chosen.make(), name.replace("-", "_"), chosen.real, RATE_HZ)
            made[name] = unit, write(tmp_path_factory.mktemp(name), sources(unit, replay))
        return made[name]

    return get
