/* The functions of the extension that integrate whole arrays of inertial samples. */
#ifndef RN_STRAPDOWN_CALL_H
#define RN_STRAPDOWN_CALL_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

PyObject *rn_preintegrate_call(PyObject *module, PyObject *args);
PyObject *rn_navigate_call(PyObject *module, PyObject *args);
PyObject *rn_carry_call(PyObject *module, PyObject *args);

#endif
