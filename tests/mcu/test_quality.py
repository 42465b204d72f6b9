"""What checkers of firmware say of the exported C: nothing but what docs/firmware.md gives a reason for."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

DEVIATIONS = {"2.3", "2.4", "2.5", "8.9", "10.1", "10.8", "12.1", "15.5", "15.6", "20.10"}
FORMS = ["h2-6axis", "h2-9axis", "h2-9axis-int32", "h2-9axis-schedule", "mekf-9axis", "uwb-3d-range"]
TIDY = (
    "-*,bugprone-*,cert-*,clang-analyzer-*,-bugprone-easily-swappable-parameters,-bugprone-reserved-identifier,"
    "-cert-dcl37-c"
)


@pytest.mark.parametrize("name", FORMS[:5])
def test_misra_deviations_are_the_listed_ones(name, exported):
    if shutil.which("cppcheck") is None:
        pytest.skip("not installed: cppcheck")
    unit, folder = exported(name)
    command = ["cppcheck", "--quiet", "--std=c99", "--addon=misra", f"{unit.name}.c"]
    said = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=True).stderr
    found = set(re.findall(r"misra-c2012-([\d.]+)", said))
    assert found, "the addon did not run"
    assert found <= DEVIATIONS


def test_every_deviation_has_its_reason():
    text = (Path(__file__).parents[2] / "docs" / "firmware.md").read_text()
    assert set(re.findall(r"^\| (\d+\.\d+) \|", text, re.M)) == DEVIATIONS


@pytest.mark.parametrize("name", FORMS)
def test_clang_tidy_is_silent(name, exported):
    if shutil.which("clang-tidy") is None:
        pytest.skip("not installed: clang-tidy")
    unit, folder = exported(name)
    command = ["clang-tidy", "--quiet", f"-checks={TIDY}", f"{unit.name}.c", "--", "-std=c99", "-I."]
    said = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False).stdout
    assert not re.findall(r"(?:warning|error): .*", said)
