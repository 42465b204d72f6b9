/* The smoother over whole recordings with the interpreter lock released. */
#include "smooth_call.h"

#include "objects.h"
#include "rn_smooth_host.h"

#define CHUNK 10000 /* rows between two looks at signals */

static PyTypeObject *accepted; /* as a model */

void rn_smooth_accept(PyObject *model_type) { accepted = (PyTypeObject *)model_type; }

/* smooth(model, dt, u, q, p, x, P): x and P in place */
PyObject *rn_smooth_call(PyObject *module, PyObject *args)
{
    (void)module;
    PyObject *model, *item[6];
    if (!PyArg_ParseTuple(args, "O!OOOOOO", accepted, &model, &item[0], &item[1], &item[2], &item[3], &item[4], &item[5]))
        return NULL;
    const ModelObject *owner = (const ModelObject *)model;
    const rn_info *m = &owner->info;
    const int is_float = owner->host->real_bytes == (int)sizeof(float);
    rn_smooth_batch b = {.model = owner->model};
    array_t held[6] = {{.held = 0}};
    PyObject *result = NULL;
    void *scratch = NULL;
    if (!(b.dt = rn_borrow(item[0], &held[0], -1, 'd', 0, "dt"))) goto done;
    const Py_ssize_t n = held[0].view.len / (Py_ssize_t)sizeof(double);
    b.n = (size_t)n;
    if (!(b.u = rn_borrow(item[1], &held[1], n * m->nu, 'd', 0, "input"))) goto done;
    if (!(b.q = rn_borrow(item[2], &held[2], m->nq, 'd', 0, "noise intensities"))) goto done;
    if (!(b.p = rn_borrow(item[3], &held[3], m->np, 'd', 0, "parameters"))) goto done;
    if (!(b.x = rn_borrow(item[4], &held[4], n * m->nx, 'd', 1, "states"))) goto done;
    if (!(b.P = rn_borrow(item[5], &held[5], n * m->ne * (m->ne + 1) / 2, 'd', 1, "packed covariances"))) goto done;
    scratch = PyMem_Malloc((is_float ? rn_smooth_bytes_float : rn_smooth_bytes_double)(owner->model));
    if (!scratch) {
        PyErr_NoMemory();
        goto done;
    }
    for (size_t to = b.n > 0 ? b.n - 1 : 0; to > 0;) {
        const size_t from = to > CHUNK ? to - CHUNK : 0;
        Py_BEGIN_ALLOW_THREADS
        (is_float ? rn_smooth_rows_float : rn_smooth_rows_double)(&b, from, to, scratch);
        Py_END_ALLOW_THREADS
        if (PyErr_CheckSignals()) goto done;
        to = from;
    }
    Py_INCREF(Py_None);
    result = Py_None;
done:
    PyMem_Free(scratch);
    rn_give_back(held, 6);
    return result;
}
