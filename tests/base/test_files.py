"""Files are whole or not there."""

import pytest

from robustnav.errors import InputError
from robustnav.files import write_whole


def test_text_and_lines_are_written_whole_into_missing_folders(tmp_path):
    path = write_whole(tmp_path / "new" / "a.txt", "one\n")
    assert path.read_bytes() == b"one\n"
    write_whole(path, (f"{i}\n" for i in range(3)))
    assert path.read_bytes() == b"0\n1\n2\n"
    assert [p.name for p in path.parent.iterdir()] == ["a.txt"]


def test_a_failure_leaves_what_was_there(tmp_path):
    path = write_whole(tmp_path / "a.txt", "old")

    def lines():
        yield "new"
        raise RuntimeError("half way")

    with pytest.raises(RuntimeError):
        write_whole(path, lines())
    assert path.read_text() == "old"
    assert [p.name for p in tmp_path.iterdir()] == ["a.txt"]


def test_what_cannot_be_written_is_named(tmp_path):
    with pytest.raises(InputError, match="a folder"):
        write_whole(tmp_path, "")
    (tmp_path / "file").write_text("")
    with pytest.raises(InputError, match="cannot write"):
        write_whole(tmp_path / "file" / "below", "")
