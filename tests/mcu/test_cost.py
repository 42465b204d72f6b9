"""Bits and costs of exported filters on emulated Cortex-M cores."""

import re
import subprocess

import pytest

from robustnav.benchmark.mcu import FILTERS, benchmark_mcu, plan
from robustnav.engine.user import find_compiler
from robustnav.errors import InputError
from robustnav.export.boards import BOARDS
from robustnav.export.emulator import EXACT, GCC, Program, cost, count

# core, then largest instructions an update, flash and RAM [B]; what the README promises
PROMISED = {
    ("h2-6axis", "m4f"): (90, 520, 40),
    ("h2-9axis", "m4f"): (150, 850, 80),
    ("h2-9axis-int32", "m4f"): (270, 1300, 150),
    ("h2-9axis-int32", "m0+"): (500, 1300, 150),
    ("mekf-9axis", "m4f"): (1000, 3300, 320),
    ("uwb-3d-range", "m4f"): (350, 1000, 320),
}


def host_digest(unit, folder):
    command = [*find_compiler(), "-std=c99", "-O2", "-ffp-contract=off", f'-DRN_REPLAY="{unit.name}_replay.h"']
    program = folder / "host"
    subprocess.run([*command, "replay.c", f"{unit.name}.c", "-lm", "-o", str(program)], cwd=folder, check=True)
    said = subprocess.run([str(program)], capture_output=True, text=True, check=True).stdout
    assert float(re.search(r"worst (\S+)", said)[1]) <= 1.0
    return re.search(r"hash (\w+)", said)[1]


@pytest.mark.parametrize("core", BOARDS)
def test_the_counter_counts_a_loop_of_known_length(core, tmp_path):
    """movs, then 1000 times (subs, bne): 2001 instructions by construction, and a return."""
    (tmp_path / "loop_replay.h").write_text(
        "typedef float real;\ntypedef float rn_row_number;\ntypedef struct { int n; } rn_replay_state;\n"
        "#define RN_ROWS 4\n#define RN_COLUMNS 1\n#define RN_OUTPUTS 1\nint loop(int n);\n"
        "static const float replay_row[4][1];\nstatic const unsigned char replay_present[4];\n"
        "static int replay_reset(rn_replay_state *s) { s->n = 0; return 0; }\n"
        "static void replay_output(const rn_replay_state *s, float *o) { *o = (float)s->n; }\n"
        "static int replay_step(rn_replay_state *s, const float *r, int p) { (void)s; (void)r; (void)p; return 0; }\n"
        "static int replay_counted(rn_replay_state *s, const float *r) { (void)r; s->n++; return loop(250); }\n"
    )
    body = '__asm__ volatile(".syntax unified\\n lsls %0, %0, #2\\n1: subs %0, %0, #1\\n bne 1b" : "+l"(n)::"cc");'
    (tmp_path / "whole.c").write_text(f"int loop(int n);\nint loop(int n)\n{{\n    {body}\n    return 0;\n}}\n")
    (tmp_path / "none.c").write_text("int loop(int n);\nint loop(int n)\n{\n    (void)n;\n    return 0;\n}\n")
    program = Program((tmp_path / "whole.c",), (tmp_path / "none.c",), "loop_replay.h", 0, 1, (tmp_path,), EXACT)
    found = count(program, core, tmp_path / core)
    assert (found.instructions, found.least, found.most) == (2003, 2003, 2003)
    assert found.stack <= 8


@pytest.mark.parametrize("name", [n for n in FILTERS if n != "h2-9axis-schedule"])
def test_every_core_computes_the_host_s_bits(name, exported):
    unit, folder = exported(name)
    expected = host_digest(unit, folder)
    for core in BOARDS:
        found = cost(unit, folder, core, flags=EXACT)
        assert (found.digest, found.refused) == (expected, 0), core
        assert found.frame is not None, "a stack that is not bounded"


@pytest.mark.parametrize(("name", "core"), PROMISED)
def test_costs_keep_what_is_promised(name, core, exported):
    unit, folder = exported(name)
    found = cost(unit, folder, core, [c.label for c in unit.counted].index(FILTERS[name].work))
    instructions, flash, ram = PROMISED[name, core]
    assert found.most <= instructions
    assert found.flash <= flash
    assert found.ram <= ram
    assert found.refused == 0


def test_nothing_of_double_of_the_heap_or_static_is_linked(exported):
    for name in FILTERS:
        unit, folder = exported(name)
        if not (folder / "build").exists():
            cost(unit, folder, "m4f")
        (elf, *_) = sorted((folder / "build").glob("m4f-*/probe.elf"))
        size = subprocess.run(
            [GCC.replace("gcc", "size"), str(elf.with_name(f"{unit.name}.o"))],
            capture_output=True,
            text=True,
            check=True,
        ).stdout.splitlines()[1]
        assert size.split()[1:3] == ["0", "0"], "static data"
        symbols = subprocess.run(
            [GCC.replace("gcc", "nm"), str(elf)], capture_output=True, text=True, check=True
        ).stdout
        assert not re.findall(r" [TtWw] (malloc|free|_sbrk|printf|__aeabi_d\w+|__aeabi_f2d)$", symbols, re.M), name


def test_the_benchmark_says_each_row_once():
    results = benchmark_mcu(plan(["h2-6axis"], ["m4f"]))
    (row,) = results["rows"]
    assert (row["filter"], row["type"], row["core"]) == ("h2-6axis", "float", "m4f")
    assert row["ram"] == row["state"] + row["stack"]


@pytest.mark.parametrize(("filters", "cores"), [(["h3"], None), (None, ["m9"])])
def test_unknown_names_are_named(filters, cores):
    with pytest.raises(InputError, match=r"h3|m9"):
        plan(filters, cores)
