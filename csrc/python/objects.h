/* The two Python types of the extension. */
#ifndef RN_OBJECTS_H
#define RN_OBJECTS_H

#include "arrays.h"
#include "rn_host.h"

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

/* Both return a new reference, or NULL with an exception set; the filter's constructor then accepts that model type. */
PyObject *rn_model_type(void);
PyObject *rn_filter_type(PyObject *model_type);

#endif
