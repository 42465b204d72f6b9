/* CPython extension on the limited API (3.11): models, filters, batch runs with the interpreter lock released.
 *
 * The Python side (robustnav.engine) prepares the arrays, and everything is checked again here. */
#include "objects.h"
#include "align_call.h"
#include "snapshot_call.h"
#include "smooth_call.h"
#include "strapdown_call.h"

static PyMethodDef functions[] = {
    {"align_begin", rn_align_begin_call, METH_VARARGS, "State of an alignment that has seen nothing."},
    {"align_run", rn_align_run_call, METH_VARARGS, "Readings through an alignment, answers out."},
    {"align_one", rn_align_one_call, METH_VARARGS, "One filter of the alignment with a given wind."},
    {"align_lines", rn_align_lines_call, METH_VARARGS, "Lines in a window of reference velocity."},
    {"smooth", rn_smooth_call, METH_VARARGS, "smooth(model, dt, input, q, p, x, P): backwards over a filtered recording, in place."},
    {"snapshot", rn_snapshot_call, METH_VARARGS, "Positions from ranges or range differences, one an epoch."},
    {"window", rn_window_call_from, METH_VARARGS, "Positions a window of readings may come from."},
    {"preintegrate", rn_preintegrate_call, METH_VARARGS, "preintegrate(real, angle, velocity, history, every, dt, out)"},
    {"navigate", rn_navigate_call, METH_VARARGS, "navigate(real, start, angle, velocity, history, every, dt, out): intervals done"},
    {"carry", rn_carry_call, METH_VARARGS, "carry(real, start, rows, place, bias, T, out)"},
    {NULL, NULL, 0, NULL}};
static struct PyModuleDef definition = {PyModuleDef_HEAD_INIT, "_kernel", "Compiled filters.", -1, functions, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit__kernel(void);

PyMODINIT_FUNC PyInit__kernel(void)
{
    PyObject *module = PyModule_Create(&definition);
    PyObject *model = rn_model_type(), *filter = rn_filter_type(model);
    if (!module || !model || !filter || PyModule_AddObjectRef(module, "Model", model) ||
        PyModule_AddObjectRef(module, "Filter", filter) || PyModule_AddIntConstant(module, "ABI", rn_host_double()->abi)) {
        Py_XDECREF(module);
        Py_XDECREF(model);
        Py_XDECREF(filter);
        return NULL;
    }
    rn_smooth_accept(model);
    Py_DECREF(filter);
    return module;
}
