/* NumPy arrays, and any other buffers, as pointers to contiguous numbers. */
#ifndef RN_ARRAYS_H
#define RN_ARRAYS_H

#define PY_SSIZE_T_CLEAN
#include <Python.h>

typedef struct {
    Py_buffer view;
    int held;
} array_t;

/* Borrow `count` contiguous numbers ('d', or 'B' for bytes); count < 0: any number.  NULL with an exception set. */
void *rn_borrow(PyObject *object, array_t *a, Py_ssize_t count, char format, int writable, const char *what);

void rn_give_back(array_t *a, int count);

/* Read `count` numbers from an array or any sequence into out; -1 with an exception set. */
int rn_read_numbers(PyObject *object, double *out, int count, const char *what);

#endif
