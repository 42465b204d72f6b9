"""The command line: files are written, numbers are printed, bad words are named."""

import json

import pytest

from robustnav.cli import main
from robustnav.export import emulator


@pytest.fixture(autouse=True)
def no_tools(monkeypatch):
    monkeypatch.setattr(emulator.shutil, "which", lambda name: None)


def test_export_writes_and_says_so(tmp_path, capsys):
    out = tmp_path / "ahrs"
    assert main(["export", "attitude", "h2", "--out", str(out), "--name", "ahrs", "--steady", "--json"]) == 0
    said = json.loads(capsys.readouterr().out)
    assert said["name"] == "ahrs"
    assert said["cost"] == []
    assert sorted(said["files"]) == sorted(p.name for p in out.iterdir())
    assert "Not measured here" in (out / "README.md").read_text()


@pytest.mark.parametrize("words", [["inclination", "h2"], ["inclination", "mekf"], ["uwb_2d", "ekf"]])
def test_every_model_has_a_verb(words, tmp_path, capsys):
    assert main(["export", *words, "--out", str(tmp_path / "x")]) == 0
    assert "cost not measured" in capsys.readouterr().err


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["pendulum", "h2"], "attitude, inclination"),
        (["attitude", "vqf"], "filter 'vqf'"),
        (["uwb_3d", "h2"], "filter 'h2'"),
        (["inclination", "h2", "--type", "int32"], "constant gain on models.attitude"),
    ],
)
def test_bad_words_are_named(words, says, tmp_path, capsys):
    assert main(["export", *words, "--out", str(tmp_path / "x")]) == 2
    assert says in capsys.readouterr().err


def test_counting_needs_tools(capsys):
    assert main(["benchmark", "mcu"]) == 2
    assert "apt-get install gcc-arm-none-eabi" in capsys.readouterr().err
