/* Model: a compiled model and its functions, one call at a time. */
#include <string.h>

#include "objects.h"

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
    const int size = one ? m->size[sensor] : 0, width = one ? m->width[sensor] : 0, rows = one ? m->rows[sensor] : 0, n = m->ne;
    const int in_sizes[RN_CALL_COUNT][4] = {
        {m->nx, m->nu, m->np, -1},   {m->nx, m->nu, m->nq, m->np}, {m->nx, n, -1, -1},     {m->nx, n, -1, -1},
        {m->nx, m->nx, -1, -1},      {m->nx, width, m->np, -1},    {m->nx, width, m->np, -1}, {m->nx, width, m->np, -1},
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
        if (!item || !(in[i] = rn_borrow(item, &held[used], in_sizes[what][i], 'd', 0, "input"))) goto done;
    }
    for (int i = 0; i < 2 && out_sizes[what][i] >= 0; i++, used++) {
        PyObject *item = PyTuple_GetItem(outputs, i);
        if (!item || !(out[i] = rn_borrow(item, &held[used], out_sizes[what][i], 'd', 1, "output"))) goto done;
    }
    if (self->host->call(self->model, what, sensor, in, dt, out)) {
        PyErr_SetString(PyExc_IndexError, "no such sensor");
        goto done;
    }
    Py_INCREF(Py_None);
    result = Py_None;
done:
    rn_give_back(held, 6);
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

PyObject *rn_model_type(void) { return PyType_FromSpec(&model_spec); }
