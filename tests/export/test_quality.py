"""What checkers of firmware say of the exported C: nothing but what docs/firmware.md gives a reason for."""

import re
import shutil
import subprocess
from pathlib import Path

import pytest

DEVIATIONS = {"2.3", "2.4", "2.5", "8.9", "10.1", "10.8", "12.1", "15.5", "15.6", "20.10"}
FORMS = [("nine", "float"), ("level_staged", "float"), ("mekf", "float"), ("nine", "int32")]
TIDY = (
    "-*,bugprone-*,cert-*,clang-analyzer-*,-bugprone-easily-swappable-parameters,-bugprone-reserved-identifier,"
    "-cert-dcl37-c"
)


@pytest.mark.parametrize(("name", "real"), FORMS)
def test_misra_deviations_are_the_listed_ones(name, real, exported):
    if shutil.which("cppcheck") is None:
        pytest.skip("not installed: cppcheck")
    one = exported(name, real)
    command = ["cppcheck", "--quiet", "--std=c99", "--addon=misra", f"{one.unit.name}.c"]
    said = subprocess.run(command, cwd=one.folder, capture_output=True, text=True, check=True).stderr
    found = set(re.findall(r"misra-c2012-([\d.]+)", said))
    assert found, "the addon did not run"
    assert found <= DEVIATIONS


def test_every_deviation_has_its_reason():
    text = (Path(__file__).parents[2] / "docs" / "firmware.md").read_text()
    assert set(re.findall(r"^\| (\d+\.\d+) \|", text, re.M)) == DEVIATIONS


@pytest.mark.parametrize(("name", "real"), FORMS)
def test_clang_tidy_is_silent(name, real, exported):
    if shutil.which("clang-tidy") is None:
        pytest.skip("not installed: clang-tidy")
    one = exported(name, real)
    command = ["clang-tidy", "--quiet", f"-checks={TIDY}", f"{one.unit.name}.c", "--", "-std=c99", "-I."]
    said = subprocess.run(command, cwd=one.folder, capture_output=True, text=True, check=False).stdout
    assert not re.findall(r"(?:warning|error): .*", said)
