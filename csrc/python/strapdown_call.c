/* Functions of the extension: strapdown integration of whole arrays, the interpreter lock released. */
#include "strapdown_call.h"

#include <string.h>

#include "arrays.h"
#include "rn_strapdown.h"
#include "strapdown_host.h"

static const rn_strapdown_host *host_of(const char *real_type)
{
    if (strcmp(real_type, "double") == 0) return rn_strapdown_double();
    if (strcmp(real_type, "float") == 0) return rn_strapdown_float();
    PyErr_Format(PyExc_ValueError, "real: got '%s', expected 'double' or 'float'", real_type);
    return NULL;
}

/* angle, velocity and history into `samples`; -1 with an exception set */
static int borrow_samples(rn_samples *samples, PyObject *const objects[3], array_t held[3], Py_ssize_t every)
{
    if (every < 1) {
        PyErr_SetString(PyExc_ValueError, "every: expected a positive number of samples");
        return -1;
    }
    if (!(samples->angle = rn_borrow(objects[0], &held[0], -1, 'd', 0, "angle"))) return -1;
    const Py_ssize_t numbers = held[0].view.len / (Py_ssize_t)sizeof(double);
    if (numbers % 3 || (numbers / 3) % every) {
        PyErr_Format(PyExc_ValueError, "angle: got %zd numbers, expected three times a multiple of %zd", numbers, every);
        return -1;
    }
    if (!(samples->velocity = rn_borrow(objects[1], &held[1], numbers, 'd', 0, "velocity"))) return -1;
    if (!(samples->history = rn_borrow(objects[2], &held[2], 2 * RN_SAMPLE, 'd', 0, "history"))) return -1;
    samples->every = (size_t)every;
    samples->count = (size_t)(numbers / 3 / every);
    return 0;
}

/* preintegrate(real, angle, velocity, history, every, dt, out) */
PyObject *rn_preintegrate_call(PyObject *module, PyObject *args)
{
    (void)module;
    const char *real_type;
    PyObject *inputs[3], *out_object, *result = NULL;
    Py_ssize_t every;
    rn_samples samples;
    array_t held[4] = {{.held = 0}};
    if (!PyArg_ParseTuple(args, "sOOOndO", &real_type, &inputs[0], &inputs[1], &inputs[2], &every, &samples.dt, &out_object))
        return NULL;
    const rn_strapdown_host *host = host_of(real_type);
    if (!host || borrow_samples(&samples, inputs, held, every)) goto done;
    double *out = rn_borrow(out_object, &held[3], (Py_ssize_t)samples.count * RN_INCREMENTS, 'd', 1, "out");
    if (!out) goto done;
    Py_BEGIN_ALLOW_THREADS
    host->preintegrate(&samples, out);
    Py_END_ALLOW_THREADS
    Py_INCREF(Py_None);
    result = Py_None;
done:
    rn_give_back(held, 4);
    return result;
}

/* navigate(real, start, angle, velocity, history, every, dt, out) -> intervals that ended within the latitude limit */
PyObject *rn_navigate_call(PyObject *module, PyObject *args)
{
    (void)module;
    const char *real_type;
    PyObject *start_object, *inputs[3], *out_object, *result = NULL;
    Py_ssize_t every;
    rn_samples samples;
    array_t held[5] = {{.held = 0}};
    if (!PyArg_ParseTuple(args, "sOOOOndO", &real_type, &start_object, &inputs[0], &inputs[1], &inputs[2], &every,
                          &samples.dt, &out_object))
        return NULL;
    const rn_strapdown_host *host = host_of(real_type);
    if (!host || borrow_samples(&samples, inputs, held, every)) goto done;
    const double *start = rn_borrow(start_object, &held[3], RN_NAVIGATION, 'd', 0, "start");
    if (!start) goto done;
    double *out = rn_borrow(out_object, &held[4], (Py_ssize_t)samples.count * RN_NAVIGATION, 'd', 1, "out");
    if (!out) goto done;
    size_t done_intervals;
    Py_BEGIN_ALLOW_THREADS
    done_intervals = host->navigate(&samples, start, out);
    Py_END_ALLOW_THREADS
    result = PyLong_FromSize_t(done_intervals);
done:
    rn_give_back(held, 5);
    return result;
}

/* carry(real, start, rows, place, bias, T, out) */
PyObject *rn_carry_call(PyObject *module, PyObject *args)
{
    (void)module;
    const char *real_type;
    PyObject *objects[5], *result = NULL;
    double T;
    array_t held[5] = {{.held = 0}};
    if (!PyArg_ParseTuple(args, "sOOOOdO", &real_type, &objects[0], &objects[1], &objects[2], &objects[3], &T, &objects[4]))
        return NULL;
    const rn_strapdown_host *host = host_of(real_type);
    if (!host) return NULL;
    const double *start = rn_borrow(objects[0], &held[0], 7, 'd', 0, "start");
    const double *rows = start ? rn_borrow(objects[1], &held[1], -1, 'd', 0, "rows") : NULL;
    if (!rows) goto done;
    const Py_ssize_t numbers = held[1].view.len / (Py_ssize_t)sizeof(double), count = numbers / RN_INCREMENTS;
    if (numbers % RN_INCREMENTS) {
        PyErr_Format(PyExc_ValueError, "rows: got %zd numbers, expected a multiple of %d", numbers, RN_INCREMENTS);
        goto done;
    }
    const double *place = rn_borrow(objects[2], &held[2], 6, 'd', 0, "place");
    const double *bias = place ? rn_borrow(objects[3], &held[3], 6 * count, 'd', 0, "bias") : NULL;
    double *out = bias ? rn_borrow(objects[4], &held[4], 7 * count, 'd', 1, "out") : NULL;
    if (!out) goto done;
    Py_BEGIN_ALLOW_THREADS
    host->carry(start, rows, (size_t)count, place, bias, T, out);
    Py_END_ALLOW_THREADS
    Py_INCREF(Py_None);
    result = Py_None;
done:
    rn_give_back(held, 5);
    return result;
}
