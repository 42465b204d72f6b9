/* Arrays cross the border through the buffer protocol; their type and size are checked here. */
#include "arrays.h"

#include <string.h>

void rn_give_back(array_t *a, int count)
{
    for (int i = 0; i < count; i++) {
        if (a[i].held) PyBuffer_Release(&a[i].view);
        a[i].held = 0;
    }
}

void *rn_borrow(PyObject *object, array_t *a, Py_ssize_t count, char format, int writable, const char *what)
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

int rn_read_numbers(PyObject *object, double *out, int count, const char *what)
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
