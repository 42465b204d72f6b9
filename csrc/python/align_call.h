/* What the module offers for alignment. */
#ifndef RN_ALIGN_CALL_H
#define RN_ALIGN_CALL_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

PyObject *rn_align_begin_call(PyObject *module, PyObject *args);
PyObject *rn_align_run_call(PyObject *module, PyObject *args);
PyObject *rn_align_one_call(PyObject *module, PyObject *args);
PyObject *rn_align_lines_call(PyObject *module, PyObject *args);

#endif
