"""Peers on a Cortex-M, compiled from sources that the user points to: x-io Fusion and VQF.  No line of theirs is here.

A peer is called through a small file of ours; the same file with the peer's function replaced by an empty one gives the
cost of the call, which is taken off.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from robustnav.errors import InputError
from robustnav.export.emulator import FAST, Program
from robustnav.frames import Array

ROWS = 200
WARM_UP = 700  # updates before the count: peers do more while they start


@dataclass(frozen=True)
class PeerFilter:
    """One function of a peer: its ``name``; the ``files`` it is compiled from; ``glue``: text that calls it; ``stub``:
    what stands in for it when the call alone is counted; ``suffix`` of both; ``factors`` from SI to its units."""

    name: str
    files: tuple[Path, ...]
    glue: str
    stub: str
    suffix: str
    factors: tuple[float, float, float]

    def program(self, folder: Path, rate_hz: float) -> Program:
        """Write the glue and return what is linked."""
        folder.mkdir(parents=True, exist_ok=True)
        glue = folder / f"glue{self.suffix}"
        glue.write_text(self.glue.replace("RATE_HZ", repr(rate_hz)))
        stub = folder / f"stub{self.suffix}"
        stub.write_text(self.stub)
        (folder / "peer.h").write_text(_PEER)
        (folder / "peer_replay.h").write_text(_replay(_rows(rate_hz, self.factors)))
        includes = tuple(dict.fromkeys([folder, *(f.parent for f in self.files)]))
        return Program(
            (*self.files, glue), (glue, stub), "peer_replay.h", 0, 1, includes, (*FAST, "-DVQF_SINGLE_PRECISION")
        )


def peers_in(folders: Sequence[Path]) -> list[PeerFilter]:
    """Return the peers whose sources are in folders.

    Raises
    ------
    InputError : a folder has no source of a known peer.
    """
    found: list[PeerFilter] = []
    for folder in folders:
        own = [*_fusion(folder), *_vqf(folder)]
        if not own:
            got = "a folder without them" if folder.is_dir() else "no such folder"
            raise InputError("--peer-source", place=str(folder), got=got, expected="FusionAhrs.c or vqf.cpp in it")
        found += own
    return found


def _first(folder: Path, name: str) -> Path | None:
    whole = sorted(folder.rglob(name), key=lambda p: (len(p.parts), str(p)))
    return next((p for p in whole if p.with_suffix(".hpp").exists() or p.with_suffix(".h").exists()), None)


def _fusion(folder: Path) -> list[PeerFilter]:
    ahrs = _first(folder, "FusionAhrs.c")
    if ahrs is None:
        return []
    six = "FusionAhrsUpdateNoMagnetometer(&ahrs, vector(row), vector(row + 3))"
    nine = "FusionAhrsUpdate(&ahrs, vector(row), vector(row + 3), vector(row + 6))"
    factors = (180.0 / np.pi, 1.0 / 9.80665, 1e6)
    return [
        PeerFilter(f"fusion-{axes}axis", (ahrs,), _FUSION.replace("CALL", call), stub, ".c", factors)
        for axes, call, stub in ((6, six, _FUSION_STUB), (9, nine, _FUSION_STUB))
    ]


def _vqf(folder: Path) -> list[PeerFilter]:
    out = []
    for name, kind in (("basicvqf", "BasicVQF"), ("vqf", "VQF")):
        source = _first(folder, f"{name}.cpp")
        if source is not None:
            glue = _VQF.replace("HEADER", f"{name}.hpp").replace("KIND", kind)
            out.append(PeerFilter(f"{name}-9axis", (source,), glue, _vqf_stub(name, kind), ".cpp", (1.0, 1.0, 1e6)))
    return out


def _vqf_stub(name: str, kind: str) -> str:
    bodies = f"void {kind}::update(const vqf_real_t *, const vqf_real_t *, const vqf_real_t *) {{}}\n"
    bodies += f"{kind}::{kind}(vqf_real_t, vqf_real_t, vqf_real_t) {{}}\n"
    bodies += f"{kind}Params::{kind}Params() {{}}\n"
    bodies += f"void {kind}::getQuat9D(vqf_real_t *) const {{}}\n"
    return f'#include "{name}.hpp"\n{bodies}'


_PEER = """#ifndef PEER_H
#define PEER_H
int peer_reset(void);
int peer_update(const float *row);
void peer_output(float *out);
unsigned peer_bytes(void);
#endif
"""
_FUSION = """#include "FusionAhrs.h"
#include "peer.h"
static FusionAhrs ahrs;
static FusionVector vector(const float *v)
{
    const FusionVector out = {.axis = {v[0], v[1], v[2]}};
    return out;
}
int peer_reset(void)
{
    FusionAhrsInitialise(&ahrs);
    return 0;
}
int peer_update(const float *row)
{
    CALL;
    return 0;
}
void peer_output(float *out)
{
    const FusionQuaternion q = FusionAhrsGetQuaternion(&ahrs);
    for (int i = 0; i < 4; i++) out[i] = q.array[i];
}
unsigned peer_bytes(void) { return (unsigned)sizeof ahrs; }
"""
_FUSION_STUB = """#include "FusionAhrs.h"
void FusionAhrsInitialise(FusionAhrs *const a) { (void)a; }
void FusionAhrsUpdate(FusionAhrs *const a, const FusionVector g, const FusionVector f, const FusionVector m)
{
    (void)a, (void)g, (void)f, (void)m;
}
void FusionAhrsUpdateNoMagnetometer(FusionAhrs *const a, const FusionVector g, const FusionVector f)
{
    (void)a, (void)g, (void)f;
}
FusionQuaternion FusionAhrsGetQuaternion(const FusionAhrs *const a)
{
    const FusionQuaternion q = {.array = {1.0f, 0.0f, 0.0f, 0.0f}};
    (void)a;
    return q;
}
"""
_VQF = """#include <new>
#include "HEADER"
extern "C" {
#include "peer.h"
}
alignas(8) static unsigned char room[sizeof(KIND)];
static KIND *filter;
int peer_reset(void)
{
    filter = new (room) KIND((vqf_real_t)(1.0 / RATE_HZ));
    return 0;
}
int peer_update(const float *row)
{
    filter->update(row, row + 3, row + 6);
    return 0;
}
void peer_output(float *out) { filter->getQuat9D(out); }
unsigned peer_bytes(void) { return sizeof(KIND); }
"""


def _rows(rate_hz: float, factors: tuple[float, float, float]) -> Array:
    """Return sensor rows (n, 9) in a peer's units: a carrier that swings, level sensors with a little noise."""
    rng, t = np.random.default_rng(3), np.arange(ROWS) / rate_hz
    gyro = 0.4 * np.sin(2 * np.pi * 0.8 * t[:, None] + np.array([0.0, 1.0, 2.0]))
    accel = np.array([0.0, 0.0, 9.80665]) + 0.3 * rng.standard_normal((ROWS, 3))
    mag = np.array([24e-6, 1e-6, -41e-6]) + 1e-6 * rng.standard_normal((ROWS, 3))
    out: Array = np.hstack([gyro * factors[0], accel * factors[1], mag * factors[2]])
    return out


def _replay(rows: Array) -> str:
    """Return the replay header of a peer, as an exported filter has it."""
    numbers = ",\n".join("{" + ", ".join(f"{float(np.float32(v))!r}f" for v in row) + "}" for row in rows)
    return _REPLAY.replace("NUMBERS", numbers).replace("LENGTH", str(len(rows))).replace("WARM", str(WARM_UP))


_REPLAY = """#ifndef PEER_REPLAY_H
#define PEER_REPLAY_H
#include "peer.h"
typedef float real;
typedef float rn_row_number;
typedef struct { int none; } rn_replay_state;
#define RN_ROWS LENGTH
#define RN_COLUMNS 9
#define RN_OUTPUTS 4
#define RN_STATE_BYTES peer_bytes()
static const float replay_row[RN_ROWS][9] = {
NUMBERS};
static const unsigned char replay_present[RN_ROWS];
static int replay_reset(rn_replay_state *s)
{
    (void)s;
    (void)peer_reset();
    for (int i = 0; i < WARM; i++) (void)peer_update(replay_row[0]);
    return 0;
}
static void replay_output(const rn_replay_state *s, float *out)
{
    (void)s;
    peer_output(out);
}
static int replay_step(rn_replay_state *s, const float *row, int present)
{
    (void)s;
    (void)present;
    return peer_update(row);
}
static int replay_counted(rn_replay_state *s, const float *row)
{
    (void)s;
    return peer_update(row);
}
#endif
"""
