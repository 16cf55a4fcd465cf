/* Checks and unpacks what Python hands over. */
#include "binding.h"

#include <stdarg.h>

static void release(Call *call) {
    for (int i = 0; i < call->count; i++) PyBuffer_Release(call->buffer + i);
    call->count = 0;
}

/* Takes the arrays from an argument on. */
static int take_arrays(Call *call, PyObject *arguments, Py_ssize_t first, int arrays, int flags) {
    for (int i = 0; i < arrays; i++) {
        PyObject *array = PyTuple_GetItem(arguments, first + i);
        if (array == NULL || PyObject_GetBuffer(array, call->buffer + i, PyBUF_C_CONTIGUOUS | flags) < 0) {
            release(call);
            return 0;
        }
        call->count = i + 1;
    }
    return 1;
}

int vc_begin_call(Call *call, PyObject *arguments, const char *name, int arrays, vc_access access, const char *numbers, ...) {
    Py_ssize_t first = PyTuple_Size(arguments) - arrays;
    call->count = 0;
    if (first < 1) return PyErr_SetString(PyExc_ValueError, "too few arguments"), 0;
    call->object = PyCapsule_GetPointer(PyTuple_GetItem(arguments, 0), name);
    if (call->object == NULL) return 0;
    PyObject *between = PyTuple_GetSlice(arguments, 1, first);
    if (between == NULL) return 0;
    va_list to;
    va_start(to, numbers);
    int taken = PyArg_VaParse(between, numbers, to);
    va_end(to);
    Py_DecRef(between);
    return taken && take_arrays(call, arguments, first, arrays, access == VC_WRITE ? PyBUF_WRITABLE : 0);
}

int vc_length(const Call *call, int index, size_t size) { return (int)(call->buffer[index].len / (Py_ssize_t)size); }

void *vc_elements(const Call *call, int index, Py_ssize_t count, size_t size) {
    const Py_buffer *buffer = call->buffer + index;
    Py_ssize_t expected = count * (Py_ssize_t)size;
    if (buffer->len == expected) return buffer->buf;
    PyErr_Format(PyExc_ValueError, "array %d: expected %zd bytes, got %zd", index, expected, buffer->len);
    return NULL;
}

static PyObject *raised(vc_status status) {
    if (PyErr_Occurred()) return NULL;
    if (status == VC_NO_MEMORY) return PyErr_NoMemory();
    PyErr_SetString(PyExc_ValueError, "a size or an index is out of its range");
    return NULL;
}

PyObject *vc_end_call(Call *call, vc_status status) {
    release(call);
    return status == VC_OK ? Py_BuildValue("") : raised(status);
}

PyObject *vc_end_with_number(Call *call, int number) {
    release(call);
    return number >= 0 ? Py_BuildValue("i", number) : raised((vc_status)number);
}

vc_image vc_frame_in(const Call *call, int index, const vc_camera *camera, int channels) {
    Py_ssize_t pixels = (Py_ssize_t)camera->width_px * camera->height_px;
    return (vc_image){vc_elements(call, index, pixels, (size_t)channels), camera->width_px, camera->height_px};
}
