"""What an exported filter costs on a Cortex-M, without hardware: built, run under an emulator, counted to the instruction.

The filter is linked twice, once as it is and once with every function empty: the difference of the two counts is what is
executed inside the functions, returns included.  Counts are instructions, not cycles: no pipeline, no wait states.
"""

from __future__ import annotations

import re
import shutil
import subprocess
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from robustnav.engine.user import find_compiler, kernel_folder
from robustnav.errors import RobustnavError
from robustnav.export.boards import BOARDS, Board
from robustnav.export.unit import Unit

GCC, QEMU = "arm-none-eabi-gcc", "qemu-system-arm"
FAST = ("-O2", "-ffp-contract=fast")  # said aloud: -std=c99 alone turns contraction off
EXACT = ("-O2", "-ffp-contract=off")
_COMMON = ("-std=c99", "-ffunction-sections", "-fdata-sections", "-fno-math-errno", "-fstack-usage")
_EMPTY = 2  # instructions of a function that returns 0 at once


class NoEmulator(RobustnavError):
    """A cross compiler or an emulator that is not installed."""


def require_tools() -> None:
    """Raise ``NoEmulator`` naming the tools that are missing."""
    missing = [tool for tool in (GCC, QEMU) if not shutil.which(tool)]
    if missing:
        raise NoEmulator(
            "cost on a microcontroller",
            got=f"no {', '.join(missing)}",
            expected="a cross compiler and an emulator",
            do="on Debian: apt-get install gcc-arm-none-eabi libnewlib-arm-none-eabi qemu-system-arm",
        )


@dataclass(frozen=True)
class Cost:
    """What one piece of work costs on one core.

    ``instructions`` executed inside the functions: mean over the rows, with ``least`` and ``most``; ``flash`` of
    filter, libm and libgcc [B], ``libraries`` of the latter two; ``state`` and ``stack`` [B]; ``frame``: largest frame
    gcc states, None where one is not bounded; ``digest`` of the replayed states; ``refused`` rows.
    """

    instructions: float
    least: int
    most: int
    flash: int
    libraries: int
    state: int
    stack: int
    frame: int | None
    digest: str
    refused: int

    @property
    def ram(self) -> int:
        """State, static memory and stack [B]."""
        return self.state + self.stack


def empty_source(unit: Unit) -> str:
    """Return the C of the filter with every function that takes readings empty."""
    bodies = [f"{head}\n{{\n{_unused(head)}    return 0;\n}}\n" for head in unit.heads]
    return f'#include "{unit.name}.h"\n\n' + "\n".join(bodies)


def _unused(head: str) -> str:
    names = [part.split("[")[0].split()[-1].lstrip("*") for part in head[head.index("(") + 1 : -1].split(",")]
    return "".join(f"    (void){n};\n" for n in names)


def cost(unit: Unit, folder: Path, core: str, work: int = 0, flags: Sequence[str] = FAST) -> Cost:
    """Return what the ``work``-th counted work of an exported filter costs on a core.

    Parameters
    ----------
    unit : the filter.
    folder : where its files are; a folder ``build`` is made in it.
    core : a key of ``BOARDS``.
    work : which of ``unit.counted``.
    flags : of the filter's own file.

    Raises
    ------
    NoEmulator : a tool is missing.
    RobustnavError : it does not compile, or the run ends in a fault.
    """
    require_tools()
    board, out = BOARDS[core], folder / "build" / f"{core}-{work}-{'-'.join(f.strip('-') for f in flags)}"
    out.mkdir(parents=True, exist_ok=True)
    empty = out / f"{unit.name}_empty.c"
    empty.write_text(empty_source(unit))
    own = _compile(board, folder / f"{unit.name}.c", out, folder, flags)
    whole = _run(board, _link(board, out, "whole", [own, *_main(unit, board, out, folder, work)]), out / "whole")
    nothing = _compile(board, empty, out, folder, flags)
    rest = _start(unit, board, out, folder)
    none = _run(board, _link(board, out, "none", [nothing, rest, *_main(unit, board, out, folder, work)]), out / "none")
    _link(board, out, "probe", [own, *_main(unit, board, out, folder, work, probe=True)])
    inside = _EMPTY * len(unit.counted[work].calls)
    used = _bytes(out / "probe.map", own.name)
    libraries = used.get("libm", 0) + used.get("libgcc", 0)
    return Cost(
        instructions=whole["mean"] - none["mean"] + inside,
        least=int(whole["min"] - none["max"]) + inside,
        most=int(whole["max"] - none["min"]) + inside,
        flash=used.get("filter", 0) + libraries,
        libraries=libraries,
        state=int(whole["state"]),
        stack=int(whole["stack"] - none["stack"]),
        frame=_frame(out / f"{unit.name}.su"),
        digest=str(whole["hash"]),
        refused=int(whole["refused"]),
    )


def _main(unit: Unit, board: Board, out: Path, folder: Path, work: int, *, probe: bool = False) -> list[Path]:
    own = kernel_folder() / "mcu" / "board"
    defines = (f'-DRN_REPLAY="{unit.name}_replay.h"', f"-DRN_COUNT={work}", *(["-DRN_PROBE"] if probe else []))
    return [_compile(board, own / name, out, folder, (*EXACT, *defines)) for name in ("main.c", "startup.c")]


def _start(unit: Unit, board: Board, out: Path, folder: Path) -> Path:
    """The filter's own object again: the linker takes reset from it where the empty functions have their names."""
    weak = [f"-D{_name(head)}=unused_{_name(head)}" for head in unit.heads]
    source = out / f"{unit.name}_rest.c"
    source.write_text((folder / f"{unit.name}.c").read_text())
    return _compile(board, source, out, folder, (*FAST, *weak))


def _name(head: str) -> str:
    return head[: head.index("(")].split()[-1]


def _compile(board: Board, source: Path, out: Path, folder: Path, flags: Sequence[str]) -> Path:
    to = out / f"{source.stem}.o"
    _call([GCC, *board.flags.split(), *_COMMON, *flags, "-I", str(folder), "-c", str(source), "-o", str(to)])
    return to


def _link(board: Board, out: Path, name: str, objects: Sequence[Path]) -> Path:
    elf = out / f"{name}.elf"
    script = kernel_folder() / "mcu" / "board" / "link.ld"
    where = {"ROM_ORG": board.rom, "ROM_LEN": board.rom_length, "RAM_ORG": board.ram, "RAM_LEN": board.ram_length}
    symbols = [f"-Wl,--defsym={k}={v}" for k, v in where.items()]
    options = ["-nostartfiles", "-Wl,--gc-sections", f"-Wl,-Map={out / name}.map", "-T", str(script), *symbols]
    libraries = ["-lm", "-lc", "-lgcc", "-lnosys"]
    _call([GCC, *board.flags.split(), *options, "-o", str(elf), *map(str, objects), *libraries])
    return elf


def _run(board: Board, elf: Path, counts: Path) -> dict[str, float | str]:
    """Run to the semihosting exit under the counting plugin; a fault leaves with 99."""
    options = ["-nographic", "-monitor", "none", "-serial", "none", "-semihosting-config", "enable=on,target=native"]
    plugin = ["-plugin", f"{_plugin(elf.parent.parent)},out={counts}.count"]
    said = _call([QEMU, "-M", board.machine, *options, *plugin, "-kernel", str(elf)])
    words = Path(f"{counts}.count").read_text().split() + said.split()
    pairs = dict(zip(words[::2], words[1::2], strict=True))
    return {k: v if k == "hash" else float(v) for k, v in pairs.items()}


def _plugin(build: Path) -> Path:
    """Compile the counting plugin for this emulator's plugin interface, once."""
    found = re.search(r"version (\d+)\.(\d+)", _call([QEMU, "--version"]))
    major, minor = map(int, found.groups()) if found else (0, 0)
    api = 1 if major < 9 else 2 if (major, minor) < (9, 1) else 3
    to = build / f"count{api}.so"
    if not to.exists():
        source = kernel_folder() / "mcu" / "board" / "count.c"
        _call([*find_compiler(), "-O2", "-shared", "-fPIC", f"-DPLUGIN_API={api}", "-o", str(to), str(source)])
    return to


def _bytes(map_file: Path, own: str) -> dict[str, int]:
    """Bytes kept by owner; flash includes the image of initialised data."""
    total: dict[str, int] = {}
    text = map_file.read_text().split("Linker script and memory map", 1)[1]
    text = re.sub(r"\n (\.\S+)\n +(0x)", r"\n \1 \2", text)  # long section names wrap
    for name, size, owner in re.findall(r"^ (\.\S+|COMMON) +0x[0-9a-f]+ +0x([0-9a-f]+) (\S.*)$", text, re.M):
        who = "filter" if own and owner.endswith(f"/{own}") else "libm" if "libm.a" in owner else None
        who = "libgcc" if "libgcc.a" in owner else who
        if who and name.startswith((".text", ".rodata", ".data", ".ARM.exidx", ".init_array")):
            total[who] = total.get(who, 0) + int(size, 16)
    return total


def _frame(usage: Path) -> int | None:
    rows = [line.split("\t") for line in usage.read_text().splitlines()]
    return max((int(n) for _, n, _ in rows), default=0) if all(kind == "static" for *_, kind in rows) else None


def _call(command: Sequence[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, stdin=subprocess.DEVNULL, check=False)
    if done.returncode:
        got = f"exit code {done.returncode}: {(done.stdout + done.stderr).strip()[:800]}"
        raise RobustnavError("command failed", place=" ".join(command)[:400], got=got, expected="exit code 0")
    return done.stdout + done.stderr
