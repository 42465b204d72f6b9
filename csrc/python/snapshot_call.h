/* What the module offers for one instant. */
#ifndef RN_SNAPSHOT_CALL_H
#define RN_SNAPSHOT_CALL_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

PyObject *rn_snapshot_call(PyObject *module, PyObject *args);
PyObject *rn_window_call_from(PyObject *module, PyObject *args);

#endif
