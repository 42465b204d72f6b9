/* What the module offers for going backwards through a recording. */
#ifndef RN_SMOOTH_CALL_H
#define RN_SMOOTH_CALL_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

/* Say which type the call accepts as a model; it is not kept alive. */
void rn_smooth_accept(PyObject *model_type);

PyObject *rn_smooth_call(PyObject *module, PyObject *args);

#endif
