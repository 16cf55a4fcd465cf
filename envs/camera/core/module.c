/* The Python module `_core`: checks and unpacks arguments, then calls the core. Nothing is computed here. */
#include <Python.h>

#include "binding.h"
#include "vc_math.h"

#define TEXT(token) TEXT_OF(token)
#define TEXT_OF(token) #token

typedef double (*Function)(double);

/* Fill the second array with a function of the first; both hold doubles. */
static PyObject *map(PyObject *arguments, Function function) {
    Py_buffer from, to;
    if (!PyArg_ParseTuple(arguments, "y*w*", &from, &to)) return NULL;
    Py_ssize_t bytes = from.len;
    if (bytes == to.len && bytes % (Py_ssize_t)sizeof(double) == 0) {
        const double *value = from.buf;
        double *result = to.buf;
        for (Py_ssize_t i = 0; i < bytes / (Py_ssize_t)sizeof(double); i++) result[i] = function(value[i]);
    } else {
        PyErr_SetString(PyExc_ValueError, "expected two arrays of doubles of one size");
    }
    PyBuffer_Release(&from);
    PyBuffer_Release(&to);
    return PyErr_Occurred() ? NULL : Py_BuildValue("");
}

FUNCTION(sines) { return map(arguments, vc_sin); }
FUNCTION(cosines) { return map(arguments, vc_cos); }

FUNCTION(length) {
    double x, y;
    return PyArg_ParseTuple(arguments, "dd", &x, &y) ? Py_BuildValue("d", vc_hypot(x, y)) : NULL;
}

static PyMethodDef METHODS[] = {
    {"sin", sines, METH_VARARGS, "Fill the second array with the sines of the first."},
    {"cos", cosines, METH_VARARGS, "Fill the second array with the cosines of the first."},
    {"hypot", length, METH_VARARGS, "Return the length of (x, y)."},
    {NULL, NULL, 0, NULL},
};

static struct PyModuleDef MODULE = {PyModuleDef_HEAD_INIT, "_core", NULL, 0, METHODS, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit__core(void) {
    PyObject *module = PyModule_Create(&MODULE);
    if (module == NULL) return NULL;
    int failed = PyModule_AddStringConstant(module, "SOURCES", TEXT(VC_SOURCES)) < 0 || vc_bind_content(module) < 0 ||
                 vc_bind_frames(module) < 0 || vc_bind_road(module) < 0 || vc_bind_glass(module) < 0 ||
                 vc_bind_streaks(module) < 0;
    if (!failed) return module;
    Py_DecRef(module);
    return NULL;
}
