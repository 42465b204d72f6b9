/* Filter: a running filter, one step at a time or over whole recordings with the interpreter lock released. */
#include <math.h>

#include "objects.h"

#define MAX_NUMBERS 64 /* in one streamed argument */
#define CHUNK 100000   /* rows between two looks at signals */

static PyTypeObject *model_type; /* what the constructor accepts */

/* Filter(model, kind, x, P or None, p, q, variance, rules, limits, (alpha, beta, kappa), longest, times, gains, gamma, L) */
static PyObject *filter_new(PyTypeObject *type, PyObject *args, PyObject *kwargs)
{
    PyObject *model, *rules, *item[9];
    rn_config c = {.kind = 0};
    if (kwargs && PyDict_Size(kwargs)) return PyErr_Format(PyExc_TypeError, "Filter takes no keywords");
    if (!PyArg_ParseTuple(args, "O!iOOOOOO!O(ddd)dOOdO", model_type, &model, &c.kind, &item[0], &item[1], &item[2], &item[3],
                          &item[4], &PyTuple_Type, &rules, &item[5], &c.alpha, &c.beta, &c.kappa, &c.longest, &item[6], &item[7], &c.gamma, &item[8]))
        return NULL;
    if (!(c.longest > 0.0)) return PyErr_Format(PyExc_ValueError, "longest step: expected seconds above zero");
    if (c.kind < RN_KIND_EKF || c.kind > RN_KIND_HINF) return PyErr_Format(PyExc_ValueError, "no filter kind %d", c.kind);
    ModelObject *owner = (ModelObject *)model;
    const rn_info *m = &owner->info;
    array_t held[9] = {{.held = 0}};
    FilterObject *self = NULL;
    c.model = owner->model;
    if (!(c.x = rn_borrow(item[0], &held[0], m->nx, 'd', 0, "state"))) goto done;
    if (c.kind != RN_KIND_FIXED &&
        !(c.P = rn_borrow(item[1], &held[1], (Py_ssize_t)m->ne * (m->ne + 1) / 2, 'd', 0, "packed covariance")))
        goto done;
    if (!(c.p = rn_borrow(item[2], &held[2], m->np, 'd', 0, "parameters"))) goto done;
    if (!(c.q = rn_borrow(item[3], &held[3], m->nq, 'd', 0, "noise intensities"))) goto done;
    if (!(c.variance = rn_borrow(item[4], &held[4], m->nsensors, 'd', 0, "sensor variances"))) goto done;
    if (!(c.limit = rn_borrow(item[5], &held[5], m->nsensors, 'd', 0, "limits"))) goto done;
    if (PyTuple_Size(rules) != m->nsensors) {
        PyErr_Format(PyExc_ValueError, "expected %d rules", m->nsensors);
        goto done;
    }
    for (int j = 0; j < m->nsensors; j++) {
        c.rule[j] = (int)PyLong_AsLong(PyTuple_GetItem(rules, j));
        if (PyErr_Occurred()) goto done;
    }
    if (c.kind == RN_KIND_FIXED) {
        if (!(c.times = rn_borrow(item[6], &held[6], -1, 'd', 0, "gain times"))) goto done;
        c.sets = (int)(held[6].view.len / (Py_ssize_t)sizeof(double));
        if (c.sets < 1) {
            PyErr_SetString(PyExc_ValueError, "gain times: expected at least one set of gains");
            goto done;
        }
        const Py_ssize_t numbers = (Py_ssize_t)c.sets * (((Py_ssize_t)1 << m->nsensors) - 1) * m->ne * m->rows_total;
        if (!(c.gains = rn_borrow(item[7], &held[7], numbers, 'd', 0, "gains"))) goto done;
    }
    if (c.kind == RN_KIND_HINF) {
        if (!(c.L = rn_borrow(item[8], &held[8], -1, 'd', 0, "bounded rows"))) goto done;
        const Py_ssize_t numbers = held[8].view.len / (Py_ssize_t)sizeof(double);
        c.bounded = (int)(numbers / m->ne);
        if (numbers < m->ne || numbers % m->ne || numbers > (Py_ssize_t)m->ne * m->ne || !(c.gamma > 0.0)) {
            PyErr_Format(PyExc_ValueError, "H-infinity: expected gamma above zero and 1 to %d rows of %d numbers", m->ne, m->ne);
            goto done;
        }
    }
    allocfunc alloc = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
    self = (FilterObject *)alloc(type, 0);
    if (!self) goto done;
    self->filter = PyMem_Malloc(owner->host->bytes(&c));
    if (!self->filter) {
        Py_DECREF(self);
        self = NULL;
        PyErr_NoMemory();
        goto done;
    }
    Py_INCREF(model);
    self->model = owner;
    self->kind = c.kind;
    owner->host->init(self->filter, &c);
done:
    rn_give_back(held, 9);
    return (PyObject *)self;
}

static void filter_dealloc(PyObject *object)
{
    FilterObject *self = (FilterObject *)object;
    PyTypeObject *type = Py_TYPE(object);
    PyMem_Free(self->filter);
    Py_XDECREF((PyObject *)self->model);
    freefunc release = (freefunc)PyType_GetSlot(type, Py_tp_free);
    release(object);
    Py_DECREF(type);
}

/* update(input, reading of each sensor or None, dt): one step at one instant */
static PyObject *filter_update(PyObject *object, PyObject *const *args, Py_ssize_t count)
{
    FilterObject *self = (FilterObject *)object;
    const rn_info *m = &self->model->info;
    const rn_host *host = self->model->host;
    if (count != m->nsensors + 2)
        return PyErr_Format(PyExc_TypeError, "update takes the input, %d readings (None: no reading) and dt", m->nsensors);
    double numbers[RN_HOST_SENSORS + 1][MAX_NUMBERS];
    const double *z[RN_HOST_SENSORS] = {NULL};
    double *seen[RN_HOST_SENSORS] = {NULL};
    const double dt = PyFloat_AsDouble(args[count - 1]);
    if (dt == -1.0 && PyErr_Occurred()) return NULL;
    if (!(dt >= 0.0 && dt < 1e9)) return PyErr_Format(PyExc_ValueError, "dt: expected a finite number of seconds >= 0");
    if (args[0] != Py_None && rn_read_numbers(args[0], numbers[0], m->nu, "input")) return NULL;
    for (int j = 0; j < m->nsensors; j++) {
        if (args[j + 1] == Py_None) continue;
        if (rn_read_numbers(args[j + 1], numbers[j + 1], m->width[j], m->sensor[j])) return NULL;
        z[j] = numbers[j + 1];
    }
    if (dt > 0.0 && args[0] != Py_None) {
        for (int i = 0; i < m->nu; i++) {
            if (!isfinite(numbers[0][i])) return PyErr_Format(PyExc_ValueError, "input: number %d is not finite", i);
        }
        host->predict(self->filter, numbers[0], dt);
    } else if (dt > 0.0) {
        return PyErr_Format(PyExc_ValueError, "input: None with dt > 0; pass dt = 0 to fuse readings only");
    }
    host->correct(self->filter, z, seen);
    Py_INCREF(Py_None);
    return Py_None;
}

/* store(x, P or None) -> (time, elapsed) */
static PyObject *filter_store(PyObject *object, PyObject *args)
{
    FilterObject *self = (FilterObject *)object;
    const rn_info *m = &self->model->info;
    PyObject *x, *P;
    if (!PyArg_ParseTuple(args, "OO", &x, &P)) return NULL;
    array_t held[2] = {{.held = 0}};
    double *xs, *Ps = NULL, time, elapsed;
    PyObject *result = NULL;
    if (!(xs = rn_borrow(x, &held[0], m->nx, 'd', 1, "state"))) goto done;
    if (P != Py_None && !(Ps = rn_borrow(P, &held[1], (Py_ssize_t)m->ne * (m->ne + 1) / 2, 'd', 1, "packed covariance"))) goto done;
    self->model->host->store(self->filter, xs, Ps, &time, &elapsed);
    result = Py_BuildValue("dd", time, elapsed);
done:
    rn_give_back(held, 2);
    return result;
}

/* load(x, P or None, time, elapsed) */
static PyObject *filter_load(PyObject *object, PyObject *args)
{
    FilterObject *self = (FilterObject *)object;
    const rn_info *m = &self->model->info;
    PyObject *x, *P;
    double time, elapsed;
    if (!PyArg_ParseTuple(args, "OOdd", &x, &P, &time, &elapsed)) return NULL;
    array_t held[2] = {{.held = 0}};
    const double *xs, *Ps = NULL;
    PyObject *result = NULL;
    if (!(xs = rn_borrow(x, &held[0], m->nx, 'd', 0, "state"))) goto done;
    if (P != Py_None && !(Ps = rn_borrow(P, &held[1], (Py_ssize_t)m->ne * (m->ne + 1) / 2, 'd', 0, "packed covariance"))) goto done;
    self->model->host->load(self->filter, xs, Ps, time, elapsed);
    Py_INCREF(Py_None);
    result = Py_None;
done:
    rn_give_back(held, 2);
    return result;
}

/* run(t, u, ((ts, z, nu, s, nis, weight, margin) or None per sensor), x or None, sd or None, P or None) */
static PyObject *filter_run(PyObject *object, PyObject *args)
{
    FilterObject *self = (FilterObject *)object;
    const rn_info *m = &self->model->info;
    PyObject *t, *u, *sensors, *out[3];
    if (!PyArg_ParseTuple(args, "OOO!OOO", &t, &u, &PyTuple_Type, &sensors, &out[0], &out[1], &out[2])) return NULL;
    if (PyTuple_Size(sensors) != m->nsensors) return PyErr_Format(PyExc_ValueError, "expected %d sensors", m->nsensors);
    array_t held[5 + 7 * RN_HOST_SENSORS] = {{.held = 0}};
    rn_batch b = {.n = 0};
    PyObject *result = NULL;
    if (!(b.t = rn_borrow(t, &held[0], -1, 'd', 0, "t"))) goto done;
    const Py_ssize_t n = held[0].view.len / (Py_ssize_t)sizeof(double);
    b.n = (size_t)n;
    if (!(b.u = rn_borrow(u, &held[1], n * m->nu, 'd', 0, "input"))) goto done;
    const Py_ssize_t widths[3] = {m->nx, m->ne, (Py_ssize_t)m->ne * (m->ne + 1) / 2};
    double **const outputs[3] = {&b.x, &b.sd, &b.P};
    for (int i = 0; i < 3; i++) {
        if (out[i] == Py_None) continue;
        if (!(*outputs[i] = rn_borrow(out[i], &held[2 + i], n * widths[i], 'd', 1, "output"))) goto done;
    }
    for (int j = 0; j < m->nsensors; j++) {
        PyObject *one = PyTuple_GetItem(sensors, j);
        if (one == Py_None) continue;
        array_t *h = &held[5 + 7 * j];
        PyObject *part[7];
        if (!PyTuple_Check(one) || !PyArg_ParseTuple(one, "OOOOOOO", &part[0], &part[1], &part[2], &part[3], &part[4], &part[5],
                                                        &part[6])) {
            if (!PyErr_Occurred()) PyErr_SetString(PyExc_TypeError, "a sensor is (ts, z, nu, s, nis, weight, margin)");
            goto done;
        }
        if (!(b.ts[j] = rn_borrow(part[0], &h[0], -1, 'd', 0, "sensor times"))) goto done;
        const Py_ssize_t rows = h[0].view.len / (Py_ssize_t)sizeof(double);
        const int width = self->kind >= RN_KIND_UKF ? m->size[j] : m->rows[j];
        b.count[j] = (size_t)rows;
        if (!(b.z[j] = rn_borrow(part[1], &h[1], rows * m->width[j], 'd', 0, "readings"))) goto done;
        if (part[2] == Py_None) continue;
        if (!(b.nu[j] = rn_borrow(part[2], &h[2], rows * width, 'd', 1, "innovations"))) goto done;
        if (!(b.s[j] = rn_borrow(part[3], &h[3], rows * width, 'd', 1, "innovation variances"))) goto done;
        if (!(b.nis[j] = rn_borrow(part[4], &h[4], rows, 'd', 1, "nis"))) goto done;
        if (!(b.weight[j] = rn_borrow(part[5], &h[5], rows, 'd', 1, "weight"))) goto done;
        if (!(b.margin[j] = rn_borrow(part[6], &h[6], rows, 'd', 1, "margin"))) goto done;
    }
    for (size_t from = 0; from < b.n; from += CHUNK) {
        const size_t to = from + CHUNK < b.n ? from + CHUNK : b.n;
        Py_BEGIN_ALLOW_THREADS
        self->model->host->run(self->filter, &b, from, to);
        Py_END_ALLOW_THREADS
        if (PyErr_CheckSignals()) goto done;
    }
    Py_INCREF(Py_None);
    result = Py_None;
done:
    rn_give_back(held, 5 + 7 * RN_HOST_SENSORS);
    return result;
}

static PyMethodDef filter_methods[] = {
    {"update", (PyCFunction)(void (*)(void))filter_update, METH_FASTCALL, "update(input, *readings, dt): one step at one instant."},
    {"store", filter_store, METH_VARARGS, "store(x, P) -> (time, elapsed): copy the state out."},
    {"load", filter_load, METH_VARARGS, "load(x, P, time, elapsed): put a state back."},
    {"run", filter_run, METH_VARARGS, "run(t, input, sensors, x, sd, P): a whole recording."},
    {NULL, NULL, 0, NULL}};
static PyType_Slot filter_slots[] = {{Py_tp_new, filter_new},
                                     {Py_tp_dealloc, filter_dealloc},
                                     {Py_tp_methods, filter_methods},
                                     {Py_tp_doc, (void *)"A running filter over a compiled model."},
                                     {0, NULL}};
static PyType_Spec filter_spec = {"robustnav.engine._kernel.Filter", sizeof(FilterObject), 0, Py_TPFLAGS_DEFAULT, filter_slots};

PyObject *rn_filter_type(PyObject *accepted)
{
    model_type = (PyTypeObject *)accepted;
    return accepted ? PyType_FromSpec(&filter_spec) : NULL;
}
