/* Alignment over arrays of readings, with the interpreter lock released.  The state lives in a capsule. */
#include "align_call.h"

#include "arrays.h"
#include "rn_align_host.h"

#define CHUNK 500 /* readings between two looks at signals */

static Py_ssize_t count_of(const array_t *a) { return a->view.len / (Py_ssize_t)sizeof(double); }

static int is_float(const char *real) { return real[0] == 'f'; }

/* The name of a capsule says which build made the state in it. */
static const char *const NAMES[2] = {"robustnav.align.double", "robustnav.align.float"};

static void forget(PyObject *capsule)
{
    const char *name = PyCapsule_GetName(capsule);
    PyMem_Free(PyCapsule_GetPointer(capsule, name));
}

/* align_begin(real, setup) -> state */
PyObject *rn_align_begin_call(PyObject *module, PyObject *args)
{
    (void)module;
    const char *real;
    PyObject *given;
    double setup[RN_ALIGN_HOST_SETUP];
    if (!PyArg_ParseTuple(args, "sO", &real, &given)) return NULL;
    if (rn_read_numbers(given, setup, RN_ALIGN_HOST_SETUP, "setup")) return NULL;
    const int single = is_float(real);
    void *state = PyMem_Malloc(single ? rn_align_bytes_float() : rn_align_bytes_double());
    if (!state) return PyErr_NoMemory();
    PyObject *capsule = NULL;
    if ((single ? rn_align_begin_float : rn_align_begin_double)(state, setup)) {
        PyErr_SetString(PyExc_ValueError, "setup: expected 2 to 10 readings a second, a whole number");
    } else {
        capsule = PyCapsule_New(state, NAMES[single], forget);
    }
    if (!capsule) PyMem_Free(state);
    return capsule;
}

/* align_run(state, readings, every, answers) */
PyObject *rn_align_run_call(PyObject *module, PyObject *args)
{
    (void)module;
    PyObject *item[3], *result = NULL;
    Py_ssize_t every;
    array_t held[2] = {{.held = 0}};
    rn_align_batch b;
    if (!PyArg_ParseTuple(args, "OOnO", &item[0], &item[1], &every, &item[2])) return NULL;
    const int single = PyCapsule_IsValid(item[0], NAMES[1]);
    if (!(b.state = PyCapsule_GetPointer(item[0], NAMES[single]))) return NULL;
    if (!(b.readings = rn_borrow(item[1], &held[0], -1, 'd', 0, "readings"))) goto done;
    const Py_ssize_t n = count_of(&held[0]) / RN_ALIGN_HOST_READING;
    if (every < 1 || n * RN_ALIGN_HOST_READING != count_of(&held[0])) {
        PyErr_Format(PyExc_ValueError, "readings: got %zd numbers and every %zd, expected a multiple of %d and 1 or more",
                     count_of(&held[0]), every, RN_ALIGN_HOST_READING);
        goto done;
    }
    b.every = (size_t)every;
    if (!(b.answer = rn_borrow(item[2], &held[1], n / every * RN_ALIGN_HOST_ANSWER, 'd', 1, "answers"))) goto done;
    for (Py_ssize_t from = 0; from < n; from += CHUNK) {
        const Py_ssize_t to = n - from > CHUNK ? from + CHUNK : n;
        Py_BEGIN_ALLOW_THREADS
        (single ? rn_align_run_float : rn_align_run_double)(&b, (size_t)from, (size_t)to);
        Py_END_ALLOW_THREADS
        if (PyErr_CheckSignals()) goto done;
    }
    Py_INCREF(Py_None);
    result = Py_None;
done:
    rn_give_back(held, 2);
    return result;
}

/* align_one(real, setup, wind, q0, v0, readings, answers, log_likelihoods, state, P): one filter with a given wind */
PyObject *rn_align_one_call(PyObject *module, PyObject *args)
{
    (void)module;
    const char *real;
    PyObject *item[9], *result = NULL;
    array_t held[5] = {{.held = 0}};
    double setup[RN_ALIGN_HOST_SETUP], wind[RN_ALIGN_HOST_WIND], q0[4], v0[2];
    rn_align_one one = {.setup = setup, .wind = wind, .q0 = q0, .v0 = v0};
    if (!PyArg_ParseTuple(args, "sOOOOOOOOO", &real, &item[0], &item[1], &item[2], &item[3], &item[4], &item[5], &item[6],
                          &item[7], &item[8]))
        return NULL;
    if (rn_read_numbers(item[0], setup, RN_ALIGN_HOST_SETUP, "setup")) return NULL;
    if (rn_read_numbers(item[1], wind, RN_ALIGN_HOST_WIND, "wind")) return NULL;
    if (rn_read_numbers(item[2], q0, 4, "q0") || rn_read_numbers(item[3], v0, 2, "v0")) return NULL;
    if (!(one.log_likelihood = rn_borrow(item[6], &held[0], -1, 'd', 1, "log_likelihoods"))) goto done;
    const Py_ssize_t n = count_of(&held[0]);
    one.n = (size_t)n;
    if (!(one.readings = rn_borrow(item[4], &held[1], n * RN_ALIGN_HOST_READING, 'd', 0, "readings"))) goto done;
    if (!(one.answer = rn_borrow(item[5], &held[2], n * RN_ALIGN_HOST_ANSWER, 'd', 1, "answers"))) goto done;
    if (!(one.state = rn_borrow(item[7], &held[3], RN_ALIGN_HOST_STATES + 1, 'd', 1, "state"))) goto done;
    if (!(one.P = rn_borrow(item[8], &held[4], RN_ALIGN_HOST_STATES * RN_ALIGN_HOST_STATES, 'd', 1, "P"))) goto done;
    Py_BEGIN_ALLOW_THREADS
    (is_float(real) ? rn_align_one_float : rn_align_one_double)(&one);
    Py_END_ALLOW_THREADS
    Py_INCREF(Py_None);
    result = Py_None;
done:
    rn_give_back(held, 5);
    return result;
}

/* align_lines(real, r, weight, (period, noise_sd, markov_sd, markov_time, goal), poly_sd, omega, omega_sd)
 * -> (log density without lines, evidence, lines) */
PyObject *rn_align_lines_call(PyObject *module, PyObject *args)
{
    (void)module;
    const char *real;
    PyObject *item[5], *result = NULL;
    array_t held[4] = {{.held = 0}};
    double poly_sd[5];
    rn_align_lines call = {.poly_sd = poly_sd};
    if (!PyArg_ParseTuple(args, "sOO(ddddd)OOO", &real, &item[0], &item[1], &call.period, &call.noise_sd, &call.markov_sd,
                          &call.markov_time, &call.goal, &item[2], &item[3], &item[4]))
        return NULL;
    if (rn_read_numbers(item[2], poly_sd, 5, "poly_sd")) return NULL;
    if (!(call.weight = rn_borrow(item[1], &held[0], -1, 'd', 0, "weight"))) goto done;
    call.n = (size_t)count_of(&held[0]);
    if (!(call.r = rn_borrow(item[0], &held[1], 2 * count_of(&held[0]), 'd', 0, "r"))) goto done;
    if (!(call.omega = rn_borrow(item[3], &held[2], RN_ALIGN_HOST_LINES, 'd', 1, "omega"))) goto done;
    if (!(call.omega_sd = rn_borrow(item[4], &held[3], RN_ALIGN_HOST_LINES, 'd', 1, "omega_sd"))) goto done;
    if ((is_float(real) ? rn_align_lines_float : rn_align_lines_double)(&call)) {
        PyErr_Format(PyExc_ValueError, "weight: got %zd rows, expected 1 to %d", (Py_ssize_t)call.n, RN_ALIGN_HOST_SAMPLES);
        goto done;
    }
    result = Py_BuildValue("(ddi)", call.alone, call.evidence, call.lines);
done:
    rn_give_back(held, 4);
    return result;
}
