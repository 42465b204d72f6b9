"""One smoother, however it runs: NumPy, C, float, whole, in parts; whatever it is handed, it answers or refuses."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from robustnav.engine import CompiledModel, _kernel, compile_model
from robustnav.engine.backends import running_filter
from robustnav.engine.smoothing import intervals, smooth
from robustnav.errors import EstimatorError, InputError
from robustnav.filter.steps import unpack
from robustnav.model import NumericModel


def forward(case, kind="ekf"):
    """Every instant the filter stopped at, one of them twice, one input missing, and what it said there."""
    whole = np.isfinite(case.u).all(axis=1)
    stops = [d.t[(d.t >= case.t[whole][0]) & (d.t <= case.t[-1])] for d in case.sensors]
    t = np.unique(np.concatenate([case.t[whole], *stops]))
    t = np.insert(t, 20, t[20])
    u = case.u[whole][np.searchsorted(case.t[whole], t)].copy()
    if case.model.input_size:
        u[[0, 31], 0] = np.nan
    out = running_filter(case.model, case.setup, "c").run(t, u, case.sensors)
    return t, u, out.x, out.P


def close(one, other, tolerance):
    for a, b in zip(one, other, strict=True):
        scale = np.maximum(np.abs(b).max(axis=0), 1e-3 * np.abs(b).max())
        assert (np.abs(a - b) / scale).max() < tolerance


def test_c_is_numpy(case):
    if case.setup.kind == "fixed":
        pytest.skip("a constant gain has no covariance to go back over")
    given_in = forward(case)
    kept = [a.copy() for a in given_in]
    expected = smooth(NumericModel(case.model), *given_in, breaks=(50,))
    wide = case.model.name.startswith("alignment")  # sizes far apart in one state
    close(smooth(compile_model(case.model), *given_in, breaks=(50,)), expected, 1e-10 if wide else 1e-11)
    if case.model.prebuilt:
        single = CompiledModel(case.model, real="float")
        close(smooth(single, *given_in, breaks=(50,)), expected, 3e-2 if wide else 2e-4)
    for a, b in zip(given_in, kept, strict=True):
        np.testing.assert_array_equal(a, b)  # not written over
    assert np.abs(expected[0] - given_in[2]).max() > 1e-3
    less = unpack(given_in[3]) - unpack(expected[1])
    turned = case.model.rotation is not None and case.model.rotation.transported
    if case.setup.kind == "ekf" and not turned:  # else covariances are not those of the transition, only near them
        assert np.linalg.eigvalsh(less).min() > -(1e-8 if wide else 1e-12) * np.abs(less).max()


def test_breaks_cut_and_the_last_row_stays(plain):
    for functions in (CompiledModel(plain().model), NumericModel(plain().model)):
        t, u, x, P = forward(plain())
        whole = smooth(functions, t, u, x, P, breaks=[40])
        for part in (slice(0, 40), slice(40, None)):
            alone = smooth(functions, t[part], u[part], x[part], P[part])
            for a, b in zip(alone, whole, strict=True):
                np.testing.assert_array_equal(a, b[part])
        for a, b in zip(whole, (x, P), strict=True):
            np.testing.assert_array_equal(a[[39, -1]], b[[39, -1]])
            assert np.abs(a[:39] - b[:39]).max() > 0


def test_a_long_recording_in_parts(plain):
    """More rows than the kernel goes through between two looks at signals."""
    case = plain("ekf", "uwb_2d")
    functions, n = CompiledModel(case.model), 10_500
    t = 0.01 * np.arange(n)
    out = running_filter(case.model, case.setup, "c").run(t, np.zeros((n, 0)), [None] * 3)
    x = out.x + np.random.default_rng(0).normal(size=out.x.shape)
    u = np.zeros((n, 0))
    x_whole, P_whole = smooth(functions, t, u, x, out.P)
    x_late, P_late = smooth(functions, t[5000:], u[5000:], x[5000:], out.P[5000:])
    x[5000], P = x_late[0], out.P.copy()
    P[5000] = P_late[0]
    x_early, P_early = smooth(functions, t[:5001], u[:5001], x[:5001], P[:5001])
    np.testing.assert_array_equal(x_whole, np.r_[x_early[:-1], x_late])
    np.testing.assert_array_equal(P_whole, np.r_[P_early[:-1], P_late])


def test_a_filter_moves_from_whole_input_to_whole_input():
    t = np.array([0.0, 1.0, 3.0, 6.0, 10.0, 15.0, 15.0, 21.0])
    u = np.array([np.nan, np.nan, 1, np.nan, 1, 1, 1, np.nan])[:, None]
    np.testing.assert_array_equal(intervals(t, u), [np.nan, 0, 0, 0, 7, 5, 0, 0])
    np.testing.assert_array_equal(intervals(t, u, [3, 0]), [np.nan, 0, 0, np.nan, 4, 5, 0, 0])
    np.testing.assert_array_equal(intervals(t, u, [1]), [np.nan, np.nan, 2, 0, 7, 5, 0, 0])
    np.testing.assert_array_equal(intervals(t, np.zeros((8, 0))), np.diff(t, prepend=np.nan))
    np.testing.assert_array_equal(intervals(t, u * np.nan), [np.nan, *np.zeros(7)])
    assert intervals(np.zeros(0), np.zeros((0, 3))).size == 0


def test_rows_where_the_filter_stayed_are_the_next_one(plain):
    t, u, x, P = forward(plain())
    for functions in (CompiledModel(plain().model), NumericModel(plain().model)):
        x_smooth, P_smooth = smooth(functions, t, u, x, P)
        for k in (0, 20, 30):  # before the first input, twice at one time, before a missing input
            np.testing.assert_array_equal(x_smooth[k], x_smooth[k + 1])
            np.testing.assert_array_equal(P_smooth[k], P_smooth[k + 1])


@pytest.mark.parametrize("real", ["c", "numpy"])
@pytest.mark.parametrize("rows", [0, 1])
def test_nothing_to_go_back_over(plain, real, rows):
    model = plain().model
    functions = CompiledModel(model) if real == "c" else NumericModel(model)
    x, P = np.tile([1.0, 0, 0, 0, 0, 0, 0], (rows, 1)), np.ones((rows, 21))
    out = smooth(functions, np.zeros(rows), np.zeros((rows, 3)), x, P)
    np.testing.assert_array_equal(out[0], x)
    np.testing.assert_array_equal(out[1], P)


def changed(arrays, which, row=None, value=np.nan):
    out = list(arrays)
    out[which] = out[which][:-1] if row is None else out[which].copy()
    if row is not None:
        out[which][row] = value
    return out


def test_what_cannot_be_smoothed_is_named(plain):
    arrays = forward(plain())
    n = len(arrays[0])
    functions = CompiledModel(plain().model)
    for which, name in ((1, "inputs"), (2, "states"), (3, "covariances")):
        with pytest.raises(InputError, match=f"smoother {name}(.|\n)*expected"):
            smooth(functions, *changed(arrays, which))
    with pytest.raises(InputError, match=r"backwards(.|\n)*row 6"):
        smooth(functions, *changed(arrays, 0, 5, 1e9))
    with pytest.raises(InputError, match=r"row 7(.|\n)*nan"):
        smooth(functions, *changed(arrays, 0, 7))
    with pytest.raises(InputError, match=r"row 4(.|\n)*infinity"):
        smooth(functions, *changed(arrays, 1, 4, np.inf))
    for which, name in ((2, "state"), (3, "covariance")):
        with pytest.raises(EstimatorError, match=f"{name} is not finite, row 9"):
            smooth(functions, *changed(arrays, which, 9))
    for breaks in ([n], [-1], [0.5], [[1]]):
        with pytest.raises(InputError, match="breaks"):
            smooth(functions, *arrays, breaks=breaks)


ANYTHING = st.one_of(
    st.none(),
    st.floats(allow_nan=True, allow_infinity=True),
    st.text(max_size=2),
    st.builds(np.zeros, st.integers(0, 30)),
    st.builds(lambda n: np.zeros(n, np.float32), st.integers(0, 9)),
    st.builds(lambda n: np.full((n, 6), np.nan), st.integers(0, 4)),
)


@given(st.lists(ANYTHING, min_size=6, max_size=6))
def test_the_kernel_answers_or_refuses(arguments):
    try:
        _kernel.smooth(_kernel.Model("uwb_3d"), *arguments)
    except (TypeError, ValueError):
        return
    assert all(isinstance(a, np.ndarray) for a in arguments)


@pytest.mark.parametrize("which", range(1, 7))
@pytest.mark.parametrize("by", [-1, 1])
def test_each_array_of_the_kernel_has_its_size(which, by):
    sizes = [4, 4 * 6, 4, 1, 4 * 15, 4 * 120]
    sizes[which - 1] += by
    with pytest.raises(ValueError, match="expected"):
        _kernel.smooth(_kernel.Model("inertial"), *(np.zeros(n) for n in sizes))
    with pytest.raises(TypeError):
        _kernel.smooth("inertial", *(np.zeros(n) for n in sizes))


def test_outputs_of_the_kernel_are_writable_and_hostile_numbers_stay_inside():
    rng = np.random.default_rng(0)
    for real in ("double", "float"):
        model = _kernel.Model("inertial", real)
        nx, ne, nu, noises, parameters, _ = model.sizes
        dt = np.array([np.nan, 1e300, -1.0, np.inf, 1e-300, 0.1])
        sizes = (6 * nu, noises, parameters, 6 * nx, 6 * ne * (ne + 1) // 2)
        arrays = [rng.choice([1e300, -1e300, np.nan, np.inf, 0.0, 1.0], n) for n in sizes]
        _kernel.smooth(model, dt, *arrays)
        arrays[3].flags.writeable = False
        with pytest.raises(TypeError, match="states"):
            _kernel.smooth(model, dt, *arrays)
