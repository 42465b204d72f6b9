/* CPython extension on the limited API (3.11): models, filters, batch runs with the interpreter lock released.
 *
 * Arrays cross the border through the buffer protocol as contiguous float64; the Python side (robustnav.engine)
 * prepares them, and everything is checked again here. */
#define PY_SSIZE_T_CLEAN
#include <Python.h>

#include <math.h>
#include <string.h>

#include "rn_host.h"

#define MAX_NUMBERS 64 /* in one streamed argument */
#define CHUNK 100000   /* rows between two looks at signals */

typedef struct {
    PyObject_HEAD
    const rn_host *host;
    const void *model;
    PyObject *owner; /* keeps a loaded library alive */
    rn_info info;
} ModelObject;

typedef struct {
    PyObject_HEAD
    ModelObject *model;
    void *filter;
    int kind;
} FilterObject;

static PyTypeObject *model_type;

/* ---- borrowing arrays ------------------------------------------------------------------------------------------ */

typedef struct {
    Py_buffer view;
    int held;
} array_t;

static void give_back(array_t *a, int count)
{
    for (int i = 0; i < count; i++) {
        if (a[i].held) PyBuffer_Release(&a[i].view);
        a[i].held = 0;
    }
}

/* Borrow `count` contiguous numbers ('d', or 'B' for bytes); count < 0: any number.  NULL with an exception set. */
static void *borrow(PyObject *object, array_t *a, Py_ssize_t count, char format, int writable, const char *what)
{
    const Py_ssize_t width = format == 'd' ? (Py_ssize_t)sizeof(double) : 1;
    if (PyObject_GetBuffer(object, &a->view, PyBUF_FORMAT | PyBUF_C_CONTIGUOUS | (writable ? PyBUF_WRITABLE : 0))) {
        PyErr_Clear();
        PyErr_Format(PyExc_TypeError, "%s: expected a contiguous array of '%c'", what, format);
        return NULL;
    }
    a->held = 1;
    const char *given = a->view.format ? a->view.format : "B";
    if (given[0] != format || given[1] != '\0') {
        PyErr_Format(PyExc_TypeError, "%s: got numbers of type '%s', expected '%c'", what, given, format);
        return NULL;
    }
    if (count >= 0 && a->view.len != count * width) {
        PyErr_Format(PyExc_ValueError, "%s: got %zd numbers, expected %zd", what, a->view.len / width, count);
        return NULL;
    }
    return a->view.buf;
}

/* Read `count` numbers from an array or any sequence into out; -1 with an exception set. */
static int read_numbers(PyObject *object, double *out, int count, const char *what)
{
    Py_buffer view;
    if (PyObject_CheckBuffer(object) && PyObject_GetBuffer(object, &view, PyBUF_FORMAT | PyBUF_STRIDES) == 0) {
        const int fits = view.ndim == 1 && view.shape[0] == count && view.format && view.format[0] == 'd' && !view.format[1];
        if (fits) {
            const char *at = view.buf;
            for (int i = 0; i < count; i++, at += view.strides[0]) memcpy(out + i, at, sizeof(double));
        }
        PyBuffer_Release(&view);
        if (fits) return 0;
    }
    PyErr_Clear();
    const Py_ssize_t length = PySequence_Check(object) ? PySequence_Size(object) : -1;
    if (length != count) {
        PyErr_Clear();
        PyErr_Format(PyExc_ValueError, "%s: expected %d numbers", what, count);
        return -1;
    }
    for (int i = 0; i < count; i++) {
        PyObject *item = PySequence_GetItem(object, i);
        out[i] = item ? PyFloat_AsDouble(item) : -1.0;
        Py_XDECREF(item);
        if (PyErr_Occurred()) return -1;
    }
    return 0;
}

/* ---- Model ----------------------------------------------------------------------------------------------------- */

static PyObject *model_new(PyTypeObject *type, PyObject *args, PyObject *kwargs)
{
    const char *name, *real_type = "double";
    PyObject *address = NULL, *owner = Py_None;
    static char *keys[] = {"name", "real", "address", "owner", NULL};
    if (!PyArg_ParseTupleAndKeywords(args, kwargs, "s|sOO", keys, &name, &real_type, &address, &owner)) return NULL;
    const int single = strcmp(real_type, "float") == 0;
    if (!single && strcmp(real_type, "double") != 0)
        return PyErr_Format(PyExc_ValueError, "real: got '%s', expected 'double' or 'float'", real_type);
    const rn_host *host = single ? rn_host_float() : rn_host_double();
    const void *model = NULL;
    rn_info info;
    if (address && address != Py_None) {
        model = PyLong_AsVoidPtr(address);
        if (!model) return PyErr_Occurred() ? NULL : PyErr_Format(PyExc_ValueError, "address is zero");
        const int fault = host->info(model, &info);
        if (fault) {
            const char *const why[] = {"", "another kernel version", "another number type", "sizes beyond the kernel's"};
            return PyErr_Format(PyExc_ValueError, "compiled model '%s' has %s", name, why[fault]);
        }
    } else {
        for (int i = 0; (model = host->built_in(i)) != NULL; i++) {
            if (host->info(model, &info) == 0 && strcmp(info.name, name) == 0) break;
        }
        if (!model) return PyErr_Format(PyExc_KeyError, "no built-in model '%s'", name);
    }
    allocfunc alloc = (allocfunc)PyType_GetSlot(type, Py_tp_alloc);
    ModelObject *self = (ModelObject *)alloc(type, 0);
    if (!self) return NULL;
    self->host = host;
    self->model = model;
    self->info = info;
    Py_INCREF(owner);
    self->owner = owner;
    return (PyObject *)self;
}

static void model_dealloc(PyObject *object)
{
    PyTypeObject *type = Py_TYPE(object);
    Py_XDECREF(((ModelObject *)object)->owner);
    freefunc release = (freefunc)PyType_GetSlot(type, Py_tp_free);
    release(object);
    Py_DECREF(type);
}

/* call(what, sensor, inputs, dt, outputs): one of the functions of rn_model.h on arrays */
static PyObject *model_call(PyObject *object, PyObject *args)
{
    ModelObject *self = (ModelObject *)object;
    const rn_info *m = &self->info;
    int what, sensor;
    double dt;
    PyObject *inputs, *outputs;
    if (!PyArg_ParseTuple(args, "iiO!dO!", &what, &sensor, &PyTuple_Type, &inputs, &dt, &PyTuple_Type, &outputs)) return NULL;
    const int one = sensor >= 0 && sensor < m->nsensors;
    const int size = one ? m->size[sensor] : 0, rows = one ? m->rows[sensor] : 0, n = m->ne;
    const int in_sizes[RN_CALL_COUNT][4] = {
        {m->nx, m->nu, m->np, -1},   {m->nx, m->nu, m->nq, m->np}, {m->nx, n, -1, -1},     {m->nx, n, -1, -1},
        {m->nx, m->nx, -1, -1},      {m->nx, m->np, -1, -1},       {m->nx, size, m->np, -1}, {m->nx, m->np, -1, -1},
        {n * m->rows_total, m->rows_total, -1, -1}};
    const int out_sizes[RN_CALL_COUNT][2] = {{m->nx, -1}, {n * n, n * n}, {m->nx, -1}, {m->nx, -1},      {n, -1},
                                             {size, -1},  {rows, -1},     {rows * n, -1}, {n, -1}};
    if (what < 0 || what >= RN_CALL_COUNT) return PyErr_Format(PyExc_ValueError, "no function %d", what);
    array_t held[6] = {{.held = 0}};
    const double *in[4] = {NULL};
    double *out[2] = {NULL};
    PyObject *result = NULL;
    int used = 0;
    for (int i = 0; i < 4 && in_sizes[what][i] >= 0; i++, used++) {
        PyObject *item = PyTuple_GetItem(inputs, i);
        if (!item || !(in[i] = borrow(item, &held[used], in_sizes[what][i], 'd', 0, "input"))) goto done;
    }
    for (int i = 0; i < 2 && out_sizes[what][i] >= 0; i++, used++) {
        PyObject *item = PyTuple_GetItem(outputs, i);
        if (!item || !(out[i] = borrow(item, &held[used], out_sizes[what][i], 'd', 1, "output"))) goto done;
    }
    if (self->host->call(self->model, what, sensor, in, dt, out)) {
        PyErr_SetString(PyExc_IndexError, "no such sensor");
        goto done;
    }
    Py_INCREF(Py_None);
    result = Py_None;
done:
    give_back(held, 6);
    return result;
}

static PyObject *model_sizes(PyObject *object, void *closure)
{
    (void)closure;
    const rn_info *m = &((ModelObject *)object)->info;
    PyObject *rows = PyTuple_New(m->nsensors);
    for (int j = 0; rows && j < m->nsensors; j++) {
        PyObject *value = PyLong_FromLong(m->rows[j]);
        if (!value || PyTuple_SetItem(rows, j, value)) {
            Py_DECREF(rows);
            return NULL;
        }
    }
    return rows ? Py_BuildValue("(iiiiiN)", m->nx, m->ne, m->nu, m->nq, m->np, rows) : NULL;
}

static PyMethodDef model_methods[] = {
    {"call", model_call, METH_VARARGS, "call(what, sensor, inputs, dt, outputs): one model function on arrays."},
    {NULL, NULL, 0, NULL}};
static PyGetSetDef model_getters[] = {
    {"sizes", model_sizes, NULL, "(nx, ne, nu, noises, parameters, rows by sensor)", NULL}, {NULL, NULL, NULL, NULL, NULL}};
static PyType_Slot model_slots[] = {{Py_tp_new, model_new},
                                    {Py_tp_dealloc, model_dealloc},
                                    {Py_tp_methods, model_methods},
                                    {Py_tp_getset, model_getters},
                                    {Py_tp_doc, (void *)"A compiled model: Model(name, real='double', address=None, owner=None)."},
                                    {0, NULL}};
static PyType_Spec model_spec = {"robustnav.engine._kernel.Model", sizeof(ModelObject), 0, Py_TPFLAGS_DEFAULT, model_slots};

/* ---- Filter ---------------------------------------------------------------------------------------------------- */

/* Filter(model, kind, x, P or None, p, q, variance, gate, (alpha, beta, kappa), times, gains) */
static PyObject *filter_new(PyTypeObject *type, PyObject *args, PyObject *kwargs)
{
    PyObject *model, *item[8];
    rn_config c = {.kind = 0};
    if (kwargs && PyDict_Size(kwargs)) return PyErr_Format(PyExc_TypeError, "Filter takes no keywords");
    if (!PyArg_ParseTuple(args, "O!iOOOOOO(ddd)OO", model_type, &model, &c.kind, &item[0], &item[1], &item[2], &item[3],
                          &item[4], &item[5], &c.alpha, &c.beta, &c.kappa, &item[6], &item[7]))
        return NULL;
    if (c.kind < RN_KIND_EKF || c.kind > RN_KIND_UKF) return PyErr_Format(PyExc_ValueError, "no filter kind %d", c.kind);
    ModelObject *owner = (ModelObject *)model;
    const rn_info *m = &owner->info;
    array_t held[8] = {{.held = 0}};
    FilterObject *self = NULL;
    c.model = owner->model;
    if (!(c.x = borrow(item[0], &held[0], m->nx, 'd', 0, "state"))) goto done;
    if (c.kind != RN_KIND_FIXED &&
        !(c.P = borrow(item[1], &held[1], (Py_ssize_t)m->ne * (m->ne + 1) / 2, 'd', 0, "packed covariance")))
        goto done;
    if (!(c.p = borrow(item[2], &held[2], m->np, 'd', 0, "parameters"))) goto done;
    if (!(c.q = borrow(item[3], &held[3], m->nq, 'd', 0, "noise intensities"))) goto done;
    if (!(c.variance = borrow(item[4], &held[4], m->nsensors, 'd', 0, "sensor variances"))) goto done;
    if (!(c.gate = borrow(item[5], &held[5], m->nsensors, 'd', 0, "gates"))) goto done;
    if (c.kind == RN_KIND_FIXED) {
        if (!(c.times = borrow(item[6], &held[6], -1, 'd', 0, "gain times"))) goto done;
        c.sets = (int)(held[6].view.len / (Py_ssize_t)sizeof(double));
        const Py_ssize_t numbers = (Py_ssize_t)c.sets * (((Py_ssize_t)1 << m->nsensors) - 1) * m->ne * m->rows_total;
        if (!(c.gains = borrow(item[7], &held[7], numbers, 'd', 0, "gains"))) goto done;
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
    give_back(held, 8);
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
    if (args[0] != Py_None && read_numbers(args[0], numbers[0], m->nu, "input")) return NULL;
    for (int j = 0; j < m->nsensors; j++) {
        if (args[j + 1] == Py_None) continue;
        if (read_numbers(args[j + 1], numbers[j + 1], m->size[j], m->sensor[j])) return NULL;
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
    if (!(xs = borrow(x, &held[0], m->nx, 'd', 1, "state"))) goto done;
    if (P != Py_None && !(Ps = borrow(P, &held[1], (Py_ssize_t)m->ne * (m->ne + 1) / 2, 'd', 1, "packed covariance"))) goto done;
    self->model->host->store(self->filter, xs, Ps, &time, &elapsed);
    result = Py_BuildValue("dd", time, elapsed);
done:
    give_back(held, 2);
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
    if (!(xs = borrow(x, &held[0], m->nx, 'd', 0, "state"))) goto done;
    if (P != Py_None && !(Ps = borrow(P, &held[1], (Py_ssize_t)m->ne * (m->ne + 1) / 2, 'd', 0, "packed covariance"))) goto done;
    self->model->host->load(self->filter, xs, Ps, time, elapsed);
    Py_INCREF(Py_None);
    result = Py_None;
done:
    give_back(held, 2);
    return result;
}

/* run(t, u, ((ts, z, nu, s, nis, used) or None per sensor), x or None, sd or None, P or None) */
static PyObject *filter_run(PyObject *object, PyObject *args)
{
    FilterObject *self = (FilterObject *)object;
    const rn_info *m = &self->model->info;
    PyObject *t, *u, *sensors, *out[3];
    if (!PyArg_ParseTuple(args, "OOO!OOO", &t, &u, &PyTuple_Type, &sensors, &out[0], &out[1], &out[2])) return NULL;
    if (PyTuple_Size(sensors) != m->nsensors) return PyErr_Format(PyExc_ValueError, "expected %d sensors", m->nsensors);
    array_t held[5 + 6 * RN_HOST_SENSORS] = {{.held = 0}};
    rn_batch b = {.n = 0};
    PyObject *result = NULL;
    if (!(b.t = borrow(t, &held[0], -1, 'd', 0, "t"))) goto done;
    const Py_ssize_t n = held[0].view.len / (Py_ssize_t)sizeof(double);
    b.n = (size_t)n;
    if (!(b.u = borrow(u, &held[1], n * m->nu, 'd', 0, "input"))) goto done;
    const Py_ssize_t widths[3] = {m->nx, m->ne, (Py_ssize_t)m->ne * (m->ne + 1) / 2};
    double **const outputs[3] = {&b.x, &b.sd, &b.P};
    for (int i = 0; i < 3; i++) {
        if (out[i] == Py_None) continue;
        if (!(*outputs[i] = borrow(out[i], &held[2 + i], n * widths[i], 'd', 1, "output"))) goto done;
    }
    for (int j = 0; j < m->nsensors; j++) {
        PyObject *one = PyTuple_GetItem(sensors, j);
        if (one == Py_None) continue;
        array_t *h = &held[5 + 6 * j];
        PyObject *part[6];
        if (!PyTuple_Check(one) || !PyArg_ParseTuple(one, "OOOOOO", &part[0], &part[1], &part[2], &part[3], &part[4], &part[5])) {
            if (!PyErr_Occurred()) PyErr_SetString(PyExc_TypeError, "a sensor is (ts, z, nu, s, nis, used)");
            goto done;
        }
        if (!(b.ts[j] = borrow(part[0], &h[0], -1, 'd', 0, "sensor times"))) goto done;
        const Py_ssize_t rows = h[0].view.len / (Py_ssize_t)sizeof(double);
        b.count[j] = (size_t)rows;
        if (!(b.z[j] = borrow(part[1], &h[1], rows * m->size[j], 'd', 0, "readings"))) goto done;
        if (part[2] == Py_None) continue;
        if (!(b.nu[j] = borrow(part[2], &h[2], rows * m->rows[j], 'd', 1, "innovations"))) goto done;
        if (!(b.s[j] = borrow(part[3], &h[3], rows * m->rows[j], 'd', 1, "innovation variances"))) goto done;
        if (!(b.nis[j] = borrow(part[4], &h[4], rows, 'd', 1, "nis"))) goto done;
        if (!(b.used[j] = borrow(part[5], &h[5], rows, 'B', 1, "used"))) goto done;
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
    give_back(held, 5 + 6 * RN_HOST_SENSORS);
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

static struct PyModuleDef definition = {PyModuleDef_HEAD_INIT, "_kernel", "Compiled filters.", -1, NULL, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit__kernel(void)
{
    PyObject *module = PyModule_Create(&definition);
    PyObject *model = PyType_FromSpec(&model_spec), *filter = PyType_FromSpec(&filter_spec);
    if (!module || !model || !filter || PyModule_AddObjectRef(module, "Model", model) ||
        PyModule_AddObjectRef(module, "Filter", filter) || PyModule_AddIntConstant(module, "ABI", rn_host_double()->abi)) {
        Py_XDECREF(module);
        Py_XDECREF(model);
        Py_XDECREF(filter);
        return NULL;
    }
    model_type = (PyTypeObject *)model;
    Py_DECREF(filter);
    return module;
}
