/* What the files that bind the core to Python share. Each adds its functions to the module. */
#ifndef VC_BIND_H
#define VC_BIND_H

#include <Python.h>
#include <stdint.h>

/* -1 with an exception, else 0 */
int vc_bind_glass(PyObject *module);
int vc_bind_streaks(PyObject *module);

/* Reports an array of the wrong size. */
static inline PyObject *vc_wrong_size(Py_ssize_t found, Py_ssize_t expected) {
    return PyErr_Format(PyExc_ValueError, "expected an array of %zd bytes, got %zd", expected, found);
}

#endif
