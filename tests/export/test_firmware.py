"""What firmware needs: any input leaves a usable state, sanitizers are silent, state is saved and restored exactly."""

import subprocess
from pathlib import Path

import numpy as np
import pytest

from robustnav.errors import InputError
from robustnav.export.budget import Budget
from robustnav.export.fixed import fixed_point
from robustnav.export.observer import Terms, split_gain
from robustnav.export.scaling import FULL, WIDTH, Counts, Scaling
from robustnav.export.schedule import Schedule

from .conftest import MAKE

FUZZED = [("nine", "float"), ("level_staged", "float"), ("mekf", "float"), ("robust", "float"), ("nine", "int32")]
SANITIZE = ["-g", "-O1", "-fsanitize=address,undefined", "-fno-sanitize-recover=all"]


@pytest.mark.parametrize(("name", "real"), FUZZED)
def test_anything_may_come_in(name, real, exported, compiler):
    one = exported(name, real)
    unit, upper = one.unit, one.unit.name.upper()
    number = "int32_t" if real == "int32" else "real"
    saved = (
        f"{number} kept[{upper}_SAVED]; {unit.name}_save(&state, kept); memset(&before, 0, sizeof before); "
        f"if ({unit.name}_restore(&before, kept) != 0) return 4; "
        f"if (memcmp(&before, &state, sizeof state) != 0) return 5;"
    )
    whole = 0 if unit.counted[0].calls[1:] else 1  # a row of a Kalman filter is several calls, each all or nothing
    defines = [f'-DRN_REPLAY="{unit.name}_replay.h"', f"-DSAVED(state, before)={saved}", f"-DRN_WHOLE={whole}"]
    defines += ["-DRN_INTEGER"] if real == "int32" else []
    program = one.folder / "fuzz"
    source = Path(__file__).parent / "fuzz.c"
    command = [*compiler, "-std=c99", *SANITIZE, "-I", str(one.folder), *defines, str(source)]
    command += [str(one.folder / f"{unit.name}.c"), "-lm", "-o", str(program)]
    subprocess.run(command, check=True)
    done = subprocess.run([str(program)], capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stdout + done.stderr
    assert done.stdout.startswith("refused")


def test_a_bad_reading_changes_nothing(loaded):
    c = loaded("nine")
    assert c.call("reset", [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0]) == 0
    assert c.call("reset", [2.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0]) == 1
    assert c.call("reset", [1.0, 0.0, 0.0, 0.0], [np.nan, 0.0, 0.0]) == 1
    gyro, accel, mag = [0.1, 0.2, -0.1], [0.0, 0.0, -9.8], [24e-6, 0.0, 41e-6]
    assert c.call("update", 0.01, gyro, accel, mag) == 0
    kept = bytes(c.state)
    for bad in (np.nan, np.inf, -np.inf, 1e20):
        assert c.call("update", 0.01, [bad, 0, 0], accel, mag) == 1
        assert c.call("update", 0.01, gyro, [0, bad, 0], mag) == 1
        assert c.call("update", 0.01, gyro, accel, [0, 0, bad]) == 1
        assert c.call("update_mag", 0.01, gyro, [bad, 0, 0]) == 1
        assert c.call("propagate", 0.01, [0, bad, 0]) == 1
        assert bytes(c.state) == kept
    assert c.call("update", 0.01, gyro, accel, mag) == 0


def test_sensors_at_their_own_rates_are_the_whole_update_s_parts(loaded):
    """With the magnetometer's gain gone, the update with both is the update with the accelerometer."""
    c = loaded("nine")
    c.call("reset", [1.0, 0.0, 0.0, 0.0], [0.0, 0.0, 0.0])
    for _ in range(300):  # turn by the gyro alone
        assert c.call("propagate", 0.01, [0.3, 0.0, 0.0]) == 0
    np.testing.assert_allclose(2 * np.arctan2(c.state[1], c.state[0]), 0.9, atol=2e-6)
    assert abs(np.linalg.norm(c.state[:4]) - 1) < 1e-5


def test_bias_gain_is_a_matrix_times_attitude_gain():
    for gains in MAKE["nine_staged"]().table.gains:
        for K in gains:
            attitude, M = split_gain(K)
            np.testing.assert_allclose(M @ attitude, K[3:], atol=1e-9 * np.abs(K[3:]).max())
    broken = MAKE["nine"]().table.gains[-1, -1].copy()
    broken[4, 0] *= 2.0
    with pytest.raises(InputError, match="Kalman gain"):
        split_gain(broken)


def test_structure_drops_what_is_zero():
    part = Terms.of(MAKE["nine"]().table.gains[:, 2], [0, 1, 2, 3, 4])
    assert sum(len(row) for row in part.turn) == 7
    assert sum(len(row) for row in part.bias) == 5


@pytest.mark.parametrize("rate", [100.0, 400.0])
def test_no_integer_sum_can_overflow(rate):
    """The bounds of docs/firmware.md, section 4, with every sensor at the end of its range."""
    from robustnav.run import H2
    from robustnav.studies.attitude_setting import noise, quaternion_model

    h2 = H2(quaternion_model(noise(rate)), rate, start_sd="steady")
    setup = h2.setup(h2.model.nominal_state())
    counts = Counts()
    scaling = Scaling.of(Schedule.of(setup, rate), counts, 1 / rate, 48e-6)
    end = {"accel": FULL, "mag": 2.0 ** (scaling.field_bits - 1)}
    for part in scaling.sets.values():
        reach = np.array([end[s] * np.sqrt(3) * 2 ** WIDTH[s] for s, _ in _rows(part)])
        sums = np.abs(part.gains) @ reach
        assert sums.max() < 2**31 - 2**part.gains_down
        t = np.linalg.norm(sums) / 2**part.gains_down
        assert t * 2**15 < 2**31
        v = np.abs(part.rest) @ np.full(3, t) / 2**part.rest_down
        assert abs(part.level) * t * 2**5 + np.linalg.norm(v) * 2**15 < 2**31
        waiting = scaling.rate * FULL + t * 2.0 ** (scaling.fine - part.turn) + 2 ** (30 - scaling.bias + scaling.fine)
        assert waiting < 2**31
        half = np.sqrt(3) * waiting / 2 ** (scaling.fine - scaling.coarse)
        assert half * 2**15 < 2**31


def _rows(part):
    from robustnav.export.observer import ROWS

    return [ROWS[r] for r in part.rows]


def test_the_integer_filter_keeps_its_budget(replayed):
    h2 = MAKE["nine"]()
    unit, scaling = fixed_point("x", h2.model, h2.setup(h2.model.nominal_state()), 100.0, Counts())
    budget = Budget.of(scaling, h2.table.gains[-1, -1], h2.model)
    assert budget.whole < np.radians(0.03)
    assert unit.blocks[0].bound == budget.whole / 2
    assert replayed("nine", "int32").worst < 0.7
    assert scaling.resolution["bias"] < 1e-9
