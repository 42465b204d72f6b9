"""What a filter costs on a Cortex-M, without hardware: built, run under an emulator, counted to the instruction.

It is linked twice, once as it is and once with every counted function empty: the difference of the two counts is what
is executed inside the functions, returns included.  Instructions are not cycles: no pipeline, no wait states.
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

GCC, GXX, QEMU = "arm-none-eabi-gcc", "arm-none-eabi-g++", "qemu-system-arm"
FAST = ("-O2", "-ffp-contract=fast")  # said aloud: -std=c99 alone turns contraction off
EXACT = ("-O2", "-ffp-contract=off")
_COMMON = ("-ffunction-sections", "-fdata-sections", "-fno-math-errno", "-fstack-usage", "-DNDEBUG")
_C = ("-std=c99",)
_CXX = ("-std=c++17", "-fno-exceptions", "-fno-rtti", "-fno-threadsafe-statics")
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
    filter, libm and libgcc [B], ``libraries`` of the latter two; ``state`` and ``stack`` [B], the latter the larger of
    what was painted over and of ``frame``, the largest frame gcc states, None where one is not bounded; ``digest`` of
    the replayed states; ``refused`` rows.
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


@dataclass(frozen=True)
class Program:
    """What is linked: the program's own files, twice, and where they look for headers.

    ``whole`` and ``none``: files with the work and with every counted function empty; ``header`` of the replay;
    ``work``: number of the counted work; ``calls``: functions counted in it; ``flags`` and ``includes``.
    """

    whole: tuple[Path, ...]
    none: tuple[Path, ...]
    header: str
    work: int
    calls: int
    includes: tuple[Path, ...]
    flags: tuple[str, ...] = FAST


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
    own, build = folder / f"{unit.name}.c", folder / "build"
    build.mkdir(exist_ok=True)
    empty = build / f"{unit.name}_none.c"
    empty.write_text(_emptied(unit, own.read_text()))
    calls = len(unit.counted[work].calls)
    program = Program((own,), (empty,), f"{unit.name}_replay.h", work, calls, (folder,), tuple(flags))
    return count(program, core, build / f"{core}-{work}-{'-'.join(f.strip('-') for f in flags)}")


def _emptied(unit: Unit, text: str) -> str:
    """Return the filter's C with the functions that take readings empty."""
    for head in unit.heads:
        begin = text.index(head + "\n{\n") + len(head) + 1
        end = text.index("\n}\n", begin)
        names = [part.split("[")[0].split()[-1].lstrip("*") for part in head[head.index("(") + 1 : -1].split(",")]
        unused = "".join(f"    (void){n};\n" for n in names)
        text = f"{text[:begin]}{{\n{unused}    return 0;{text[end:]}"
    return text


def count(program: Program, core: str, out: Path) -> Cost:
    """Return what the counted work of a program costs on a core; ``out`` is a folder for what is built."""
    require_tools()
    board = BOARDS[core]
    out.mkdir(parents=True, exist_ok=True)
    start = _compile(board, kernel_folder() / "mcu" / "board" / "startup.c", out, program, EXACT)
    main = _main(board, out, program, "main")
    filter_objects = [_compile(board, file, out, program, program.flags) for file in program.whole]
    none_objects = [_compile(board, file, out, program, program.flags) for file in program.none]
    whole = _run(board, _link(board, out, "whole", [*filter_objects, main, start]))
    none = _run(board, _link(board, out, "none", [*none_objects, main, start]))
    _link(board, out, "probe", [*filter_objects, _main(board, out, program, "probe"), start])
    used = _bytes(out / "probe.map", {o.name for o in filter_objects})
    libraries = sum(used.get(k, 0) for k in ("libm", "libgcc", "libstdc++"))
    inside = _EMPTY * program.calls
    frame = _frame([o.with_suffix(".su") for o in filter_objects])
    return Cost(
        instructions=whole.mean - none.mean + inside,
        least=whole.least - none.most + inside,
        most=whole.most - none.least + inside,
        flash=used.get("filter", 0) + libraries,
        libraries=libraries,
        state=whole.state,
        stack=max(whole.stack - none.stack, frame or 0),
        frame=frame,
        digest=whole.digest,
        refused=whole.refused,
    )


@dataclass(frozen=True)
class _Counted:
    mean: float
    least: int
    most: int
    refused: int
    digest: str
    stack: int
    state: int


def _main(board: Board, out: Path, program: Program, name: str) -> Path:
    source = kernel_folder() / "mcu" / "board" / "main.c"
    flags = [*EXACT, f'-DRN_REPLAY="{program.header}"', f"-DRN_COUNT={program.work}"]
    return _compile(board, source, out, program, [*flags, *(["-DRN_PROBE"] if name == "probe" else [])], name)


def _compile(
    board: Board, source: Path, out: Path, program: Program, flags: Sequence[str], name: str | None = None
) -> Path:
    to = out / f"{name or source.stem}.o"
    tool, common = (GCC, _C) if source.suffix == ".c" else (GXX, _CXX)
    includes = [word for folder in program.includes for word in ("-I", str(folder))]
    _call([tool, *board.flags.split(), *_COMMON, *common, *flags, *includes, "-c", str(source), "-o", str(to)])
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


def _run(board: Board, elf: Path) -> _Counted:
    """Run to the semihosting exit under the counting plugin; a fault leaves with 99."""
    options = ["-nographic", "-monitor", "none", "-serial", "none", "-semihosting-config", "enable=on,target=native"]
    counts = elf.with_suffix(".count")
    plugin = ["-plugin", f"{_plugin(elf.parent.parent)},out={counts}"]
    said = _call([QEMU, "-M", board.machine, *options, *plugin, "-kernel", str(elf)])
    words = counts.read_text().split() + said.split()
    found = dict(zip(words[::2], words[1::2], strict=True))
    return _Counted(
        mean=float(found["mean"]),
        least=int(found["min"]),
        most=int(found["max"]),
        refused=int(found["refused"]),
        digest=found["hash"],
        stack=int(found["stack"]),
        state=int(found["state"]),
    )


def _plugin(build: Path) -> Path:
    """Compile the counting plugin for this emulator's plugin interface, once a folder."""
    found = re.search(r"version (\d+)\.(\d+)", _call([QEMU, "--version"]))
    major, minor = map(int, found.groups()) if found else (0, 0)
    api = 1 if major < 9 else 2 if (major, minor) < (9, 1) else 3
    to = build / f"count{api}.so"
    if not to.exists():
        source = kernel_folder() / "mcu" / "board" / "count.c"
        _call([*find_compiler(), "-O2", "-shared", "-fPIC", f"-DPLUGIN_API={api}", "-o", str(to), str(source)])
    return to


def _bytes(map_file: Path, own: set[str]) -> dict[str, int]:
    """Bytes kept by owner; flash includes the image of initialised data."""
    total: dict[str, int] = {}
    text = map_file.read_text().split("Linker script and memory map", 1)[1]
    text = re.sub(r"\n (\.\S+)\n +(0x)", r"\n \1 \2", text)  # long section names wrap
    for name, size, owner in re.findall(r"^ (\.\S+|COMMON) +0x[0-9a-f]+ +0x([0-9a-f]+) (\S.*)$", text, re.M):
        library = next((lib for lib in ("libm", "libgcc", "libstdc++") if f"{lib}.a" in owner), None)
        who = "filter" if Path(owner).name in own else library
        if who and name.startswith((".text", ".rodata", ".data", ".ARM.exidx", ".init_array")):
            total[who] = total.get(who, 0) + int(size, 16)
    return total


def _frame(usages: Sequence[Path]) -> int | None:
    rows = [line.split("\t") for usage in usages for line in usage.read_text().splitlines()]
    return max((int(n) for _, n, _ in rows), default=0) if all(kind == "static" for *_, kind in rows) else None


def _call(command: Sequence[str]) -> str:
    done = subprocess.run(command, capture_output=True, text=True, timeout=300, stdin=subprocess.DEVNULL, check=False)
    if done.returncode:
        got = f"exit code {done.returncode}: {(done.stdout + done.stderr).strip()[:800]}"
        raise RobustnavError("command failed", place=" ".join(command)[:400], got=got, expected="exit code 0")
    return done.stdout + done.stderr
