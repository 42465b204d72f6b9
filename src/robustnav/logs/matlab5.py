"""Real numeric arrays of a MATLAB 5 file, no more: SciPy's reader, made for everything, crashes on damaged files.

MathWorks, MAT-File Format, section "Level 5 MAT-File Format".
"""

from __future__ import annotations

import struct
import zlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from robustnav.logs.files import unusable
from robustnav.records import Array

EXPECTED = "a MATLAB 5 file"
HEADER = 128  # bytes
MATRIX, COMPRESSED = 14, 15
TYPES = {1: "i1", 2: "u1", 3: "i2", 4: "u2", 5: "i4", 6: "u4", 7: "f4", 9: "f8", 12: "i8", 13: "u8"}
NUMERIC_CLASSES = range(6, 16)  # double, single and the integers; below are cells, structures, objects, text, sparse
COMPLEX = 0x0800
LARGEST = 256 * 2**20  # bytes of one array after decompression


class Damage(Exception):
    """What is wrong inside an element, before the file is named."""


@dataclass(frozen=True)
class Variable:
    """One variable: its values as floats, or None and in ``kind`` why it holds no real numbers."""

    kind: str
    values: Array | None


def load_matlab5(path: Path) -> dict[str, Variable]:
    """Return the variables of a MATLAB 5 file by name.

    Raises
    ------
    InputError : another format, a file that is cut or damaged, or an array beyond 256 MiB.
    """
    try:
        data = path.read_bytes()
    except OSError as why:
        raise unusable(path, why.strerror or str(why), EXPECTED, do="check its permissions") from why
    order = {b"IM": "<", b"MI": ">"}.get(data[126:128], "")
    if not order or struct.unpack(order + "H", data[124:126]) != (0x0100,):
        got = f"a header of {min(len(data), HEADER)} bytes that is none of version 5"
        do = "save it with -v7 or -v6; version 7.3 is another format"
        raise unusable(path, got, EXPECTED, place="header", do=do)
    variables: dict[str, Variable] = {}
    done = HEADER
    try:
        for kind, body, end in _elements(data, HEADER, order):
            name, variable = _variable(_unpacked(kind, body, order), order)
            if name in variables:
                raise Damage(f"variable {name!r} twice")
            variables[name] = variable
            done = end
    except (Damage, zlib.error) as why:
        raise unusable(path, str(why), EXPECTED, place=f"after byte {done}", do="copy the recording again") from why
    return variables


def _elements(data: bytes, start: int, order: str) -> Iterator[tuple[int, bytes, int]]:
    """Yield type, content and end of each element; small ones carry their content inside the tag."""
    at = start
    while at < len(data):
        if at + 8 > len(data):
            raise Damage("a file that ends inside an element")
        first, size = struct.unpack_from(order + "II", data, at)
        if first >> 16:
            kind, size, begin, end = first & 0xFFFF, first >> 16, at + 4, at + 8
        else:
            kind, begin = first, at + 8
            end = begin + size + (0 if kind == COMPRESSED else -size % 8)
        if begin + size > min(end, len(data)):
            raise Damage(f"an element of {size} bytes where {max(0, min(end, len(data)) - begin)} are left")
        yield kind, data[begin : begin + size], min(end, len(data))
        at = end


def _unpacked(kind: int, body: bytes, order: str) -> bytes:
    """Return the content of a matrix element, decompressed if need be."""
    if kind == COMPRESSED:
        unpack = zlib.decompressobj()
        inner = unpack.decompress(body, LARGEST)
        if not unpack.eof:
            raise Damage("compressed data that end early, or beyond 256 MiB")
        kind, body, _ = next(_elements(inner, 0, order), (0, b"", 0))
    if kind != MATRIX:
        raise Damage(f"an element of type {kind} where a matrix should be")
    return body


def _variable(body: bytes, order: str) -> tuple[str, Variable]:
    """Return name and values of one matrix element."""
    parts = [(kind, content) for kind, content, _ in _elements(body, 0, order)]
    if len(parts) < 3 or len(parts[0][1]) != 8 or len(parts[1][1]) % 4:
        raise Damage("a matrix without flags, dimensions and name")
    flags = struct.unpack(order + "II", parts[0][1])[0]
    shape = tuple(np.frombuffer(parts[1][1], order + "i4").tolist())
    name = parts[2][1].decode("latin-1")
    if flags & 0xFF not in NUMERIC_CLASSES:
        return name, Variable("no numeric array", None)
    if flags & COMPLEX or len(parts) != 4 or parts[3][0] not in TYPES:
        return name, Variable("no real array", None)
    kind, content = parts[3]
    dtype = np.dtype(order + TYPES[kind])
    if len(shape) != 2 or min(shape) < 0 or shape[0] * shape[1] * dtype.itemsize != len(content):
        raise Damage(f"{len(content)} bytes for variable {name!r} of shape {shape}")
    with np.errstate(invalid="ignore"):  # a signalling NaN is a NaN
        values = np.array(np.frombuffer(content, dtype).reshape(shape, order="F"), float, order="C")
    return name, Variable("real", values)
