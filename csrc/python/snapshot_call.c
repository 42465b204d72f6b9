/* The snapshot solver over many epochs, or over one window, with the interpreter lock released. */
#include "arrays.h"
#include "rn_snapshot_host.h"
#include "snapshot_call.h"

#define CHUNK 200  /* epochs between two looks at signals */

static Py_ssize_t count_of(const array_t *a) { return a->view.len / (Py_ssize_t)sizeof(double); }

/* An output of `width` numbers an epoch, or None. */
static int borrow_output(PyObject *object, array_t *held, size_t n, Py_ssize_t width, double **out, const char *what)
{
    *out = NULL;
    if (object == Py_None) return 0;
    *out = rn_borrow(object, held, (Py_ssize_t)n * width, 'd', 1, what);
    return *out ? 0 : -1;
}

/* snapshot(real, differences, anchors, readings, sd, (z, z_sd), quantiles, (max_gdop, repair, max_faults, judge),
 *          rows, weights or None, others or None, suspects or None) */
PyObject *rn_snapshot_call(PyObject *module, PyObject *args)
{
    (void)module;
    PyObject *item[8];
    const char *real;
    rn_fix_batch b = {.n = 0};
    if (!PyArg_ParseTuple(args, "siOOO(dd)O(diii)OOOO", &real, &b.differences, &item[0], &item[1], &item[2], &b.z, &b.z_sd,
                          &item[3], &b.max_gdop, &b.repair, &b.max_faults, &b.judge, &item[4], &item[5], &item[6], &item[7]))
        return NULL;
    const int is_float = real[0] == 'f';
    array_t held[8] = {{.held = 0}};
    PyObject *result = NULL;
    b.differences = b.differences != 0;
    if (!(b.anchors = rn_borrow(item[0], &held[0], -1, 'd', 0, "anchors"))) goto done;
    if (!(b.sd = rn_borrow(item[2], &held[2], -1, 'd', 0, "sd"))) goto done;
    if (!(b.row = rn_borrow(item[4], &held[4], -1, 'd', 1, "rows"))) goto done;
    const Py_ssize_t k = count_of(&held[2]), numbers = count_of(&held[0]), rows = count_of(&held[4]);
    if (k < 1 || k > RN_FIX_HOST_ANCHORS || (numbers != 2 * k && numbers != 3 * k) || rows % RN_FIX_ROW) {
        PyErr_Format(PyExc_ValueError, "got %zd sds, %zd coordinates of anchors, %zd numbers of rows; expected 1 to %d anchors",
                     k, numbers, rows, RN_FIX_HOST_ANCHORS);
        goto done;
    }
    b.k = (int)k;
    b.d = (int)(numbers / k);
    b.n = (size_t)(rows / RN_FIX_ROW);
    if (b.d == 2 && b.z_sd > 0.0) {
        PyErr_SetString(PyExc_ValueError, "a known height needs anchors in 3D");
        goto done;
    }
    if (!(b.readings = rn_borrow(item[1], &held[1], (Py_ssize_t)b.n * (k - b.differences), 'd', 0, "readings"))) goto done;
    if (!(b.quantile = rn_borrow(item[3], &held[3], RN_FIX_QUANTILES, 'd', 0, "quantiles"))) goto done;
    if (borrow_output(item[5], &held[5], b.n, k, &b.weights, "weights")) goto done;
    if (borrow_output(item[6], &held[6], b.n, RN_FIX_HOST_OTHERS * RN_FIX_OTHER_ROW, &b.others, "others")) goto done;
    if (borrow_output(item[7], &held[7], b.n, RN_FIX_HOST_ANCHORS * RN_FIX_SUSPECT_ROW, &b.suspects, "suspects")) goto done;
    for (size_t from = 0; from < b.n; from += CHUNK) {
        const size_t to = from + CHUNK < b.n ? from + CHUNK : b.n;
        Py_BEGIN_ALLOW_THREADS
        (is_float ? rn_fix_run_float : rn_fix_run_double)(&b, from, to);
        Py_END_ALLOW_THREADS
        if (PyErr_CheckSignals()) goto done;
    }
    Py_INCREF(Py_None);
    result = Py_None;
done:
    rn_give_back(held, 8);
    return result;
}

/* window(real, value, sd, first, second, pair, (known, down, down_sd), guesses, track or None, minima) -> (count, cost) */
PyObject *rn_window_call_from(PyObject *module, PyObject *args)
{
    (void)module;
    PyObject *item[8];
    const char *real;
    rn_window_call c = {.m = 0};
    if (!PyArg_ParseTuple(args, "sOOOOO(idd)OOO", &real, &item[0], &item[1], &item[2], &item[3], &item[4], &c.down_known,
                          &c.down, &c.down_sd, &item[5], &item[6], &item[7]))
        return NULL;
    const int is_float = real[0] == 'f';
    array_t held[8] = {{.held = 0}};
    PyObject *result = NULL;
    if (!(c.value = rn_borrow(item[0], &held[0], -1, 'd', 0, "values"))) goto done;
    if (!(c.guess = rn_borrow(item[5], &held[5], -1, 'd', 0, "guesses"))) goto done;
    const Py_ssize_t m = count_of(&held[0]), guesses = count_of(&held[5]);
    if (m < 1 || m > RN_WINDOW_READINGS || guesses % 3 || guesses > 3 * RN_WINDOW_HOST_GUESSES || c.down_known < 0 ||
        c.down_known > 2) {
        PyErr_Format(PyExc_ValueError, "got %zd readings, %zd coordinates of guesses; expected 1 to %d, (0 to %d, 3)", m,
                     guesses, RN_WINDOW_READINGS, RN_WINDOW_HOST_GUESSES);
        goto done;
    }
    c.m = (int)m;
    c.guesses = (int)(guesses / 3);
    if (!(c.sd = rn_borrow(item[1], &held[1], m, 'd', 0, "sds"))) goto done;
    if (!(c.first = rn_borrow(item[2], &held[2], 3 * m, 'd', 0, "first anchors"))) goto done;
    if (!(c.second = rn_borrow(item[3], &held[3], 3 * m, 'd', 0, "second anchors"))) goto done;
    if (!(c.pair = rn_borrow(item[4], &held[4], m, 'B', 0, "pairs"))) goto done;
    if (item[6] != Py_None && !(c.track = rn_borrow(item[6], &held[6], 3 * m, 'd', 0, "track"))) goto done;
    if (!(c.minima = rn_borrow(item[7], &held[7], RN_WINDOW_HOST_MINIMA * RN_FIX_OTHER_ROW, 'd', 1, "minima"))) goto done;
    int count;
    Py_BEGIN_ALLOW_THREADS
    count = (is_float ? rn_window_run_float : rn_window_run_double)(&c);
    Py_END_ALLOW_THREADS
    result = count < 0 ? PyErr_Format(PyExc_ValueError, "anchors: more than %d, or not numbers", RN_FIX_HOST_ANCHORS)
                       : Py_BuildValue("id", count, c.track_cost);
done:
    rn_give_back(held, 8);
    return result;
}
