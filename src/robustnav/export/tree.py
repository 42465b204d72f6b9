"""An exported filter as a folder: sources, test vectors, host programs, CMake, README."""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

from robustnav.engine.user import kernel_folder
from robustnav.export.unit import Unit
from robustnav.files import write_whole


@dataclass(frozen=True)
class Exported:
    """What ``export`` wrote.

    ``folder``; ``name``, the prefix of every symbol; ``files`` (names in the folder); ``cost``: rows by core, as
    ``emulator.cost`` gives them, empty where they were not measured.
    """

    folder: Path
    name: str
    files: tuple[str, ...]
    cost: tuple[Mapping[str, object], ...] = ()


def kernel_text(path: str) -> str:
    """Return a file of the package's C sources."""
    return (kernel_folder() / path).read_text(encoding="utf-8")


def sources(unit: Unit, replay: str) -> dict[str, str]:
    """Return the C of an export by file name: filter, kernel headers, test vectors, host programs."""
    own = {f"{unit.name}.h": unit.header, f"{unit.name}.c": unit.source, f"{unit.name}_replay.h": replay}
    kernel = {Path(path).name: kernel_text(path) for path in unit.kernel}
    return own | kernel | {"replay.c": kernel_text("mcu/replay.c"), "example.c": _example(unit)}


def write(folder: str | os.PathLike[str], files: Mapping[str, str]) -> Path:
    """Write files, each whole or not at all."""
    out = Path(folder)
    for name, text in files.items():
        write_whole(out / name, text)
    return out


def _example(unit: Unit) -> str:
    name, upper = unit.name, unit.name.upper()
    return (
        f"/* A bare loop on a host: the filter is fed the test vectors' rows as a driver would hand them over.\n"
        f" * cc -std=c99 -O2 example.c {name}.c -o example */\n"
        f'#include <stdio.h>\n\n#include "{name}_replay.h"\n\nint main(void)\n{{\n    {name}_state state;\n'
        f"    if (replay_reset(&state) != {upper}_OK) return 1;\n"
        "    for (int k = 0; k < RN_ROWS; k++) { /* on a target: wait for the sensor's interrupt, read, then */\n"
        "        real out[RN_OUTPUTS];\n"
        "        const int said = replay_step(&state, replay_row[k], replay_present[k]);\n"
        f'        if (said != {upper}_OK) printf("row %d refused\\n", k);\n'
        "        replay_output(&state, out);\n        if (((k + 1) % 80) == 0) {\n"
        '            for (int i = 0; i < RN_OUTPUTS; i++) printf(" % .6f", (double)out[i]);\n'
        '            printf("\\n");\n        }\n    }\n    return 0;\n}\n'
    )


def cmake(unit: Unit) -> str:
    """Return CMakeLists.txt: a static library without the maths library, and the two host programs as tests."""
    name = unit.name
    return (
        f"cmake_minimum_required(VERSION 3.13)\nproject({name} C)\n\n"
        f"add_library({name} STATIC {name}.c)\n"
        f"target_include_directories({name} PUBLIC ${{CMAKE_CURRENT_SOURCE_DIR}})\n"
        f"set_target_properties({name} PROPERTIES C_STANDARD 99 C_STANDARD_REQUIRED ON C_EXTENSIONS OFF)\n\n"
        "# On the host: cmake -B build && cmake --build build && ctest --test-dir build\n"
        "if(NOT CMAKE_CROSSCOMPILING)\n  enable_testing()\n  foreach(program replay example)\n"
        f"    add_executable(${{program}} ${{program}}.c)\n    target_link_libraries(${{program}} {name} m)\n"
        f'    target_compile_definitions(${{program}} PRIVATE RN_REPLAY="{name}_replay.h")\n'
        "    add_test(NAME ${program} COMMAND ${program})\n  endforeach()\nendif()\n"
    )


def readme(unit: Unit, cost: Sequence[Mapping[str, object]]) -> str:
    """Return the README: what it is, how to use it, what it costs."""
    lines = [f"# {unit.name}", "", unit.title, "", *(p + "\n" for p in unit.notes)]
    lines += ["## Use", "", f"Add `{unit.name}.c` and the headers to the project, or this folder with CMake:", ""]
    lines += ["```c", *(head.replace("const ", "") + ";" for head in unit.heads), "```", ""]
    lines += [
        f"Units, frames and shapes are in `{unit.name}.h`. The state is the caller's: one struct a filter.",
        "",
    ]
    lines += [
        "## Check",
        "",
        "```",
        f"cc -std=c99 -O2 -ffp-contract=off -DRN_REPLAY='\"{unit.name}_replay.h\"' replay.c ",
    ]
    lines[-1] += f"{unit.name}.c -lm -o replay && ./replay"
    lines += [
        "```",
        "",
        "prints the largest difference from the Python filter as a share of its bound, and a hash of all",
    ]
    lines += ["states. With floating-point contraction off the hash is the same on every core.", "", "## Cost", ""]
    return "\n".join(lines) + "\n" + _cost_table(cost)


def _cost_table(cost: Sequence[Mapping[str, object]]) -> str:
    if not cost:
        return "Not measured here: `robustnav benchmark mcu` needs arm-none-eabi-gcc and qemu-system-arm.\n"
    columns = ("core", "work", "instructions", "flash", "ram", "stack")
    head = "| " + " | ".join(columns) + " |\n|" + "---|" * len(columns) + "\n"
    body = "".join("| " + " | ".join(str(row[c]) for c in columns) + " |\n" for row in cost)
    about = (
        "Instructions executed inside the functions, exact; flash with what it pulls from libm and libgcc, RAM as "
        "state and stack, bytes; -O2, counted under an emulator. Instructions are not cycles.\n\n"
    )
    return about + head + body
