/* Checks and unpacks what Python hands over. */
#include "binding.h"

#define CAPSULE "vpf_sim.envs.camera.core"

static void destroy(PyObject *capsule) { vc_free(PyCapsule_GetPointer(capsule, CAPSULE)); }

vc_core *core_of(PyObject *capsule) { return PyCapsule_GetPointer(capsule, CAPSULE); }

int take_buffers(Buffers *buffers, PyObject *const *objects, int count, int writable) {
    buffers->count = 0;
    for (int i = 0; i < count; i++) {
        int flags = PyBUF_C_CONTIGUOUS | (writable ? PyBUF_WRITABLE : 0);
        if (PyObject_GetBuffer(objects[i], buffers->buffer + i, flags) < 0) {
            release(buffers);
            return 0;
        }
        buffers->count = i + 1;
    }
    return 1;
}

void release(Buffers *buffers) {
    for (int i = 0; i < buffers->count; i++) PyBuffer_Release(buffers->buffer + i);
    buffers->count = 0;
}

Py_ssize_t length(const Buffers *buffers, int index, Py_ssize_t size) { return buffers->buffer[index].len / size; }

void *elements(const Buffers *buffers, int index, Py_ssize_t count, Py_ssize_t size) {
    const Py_buffer *buffer = buffers->buffer + index;
    if (buffer->len == count * size) return buffer->buf;
    PyErr_Format(PyExc_ValueError, "array %d: expected %zd bytes, got %zd", index, count * size, buffer->len);
    return NULL;
}

PyObject *result(vc_status status) {
    if (PyErr_Occurred()) return NULL;
    if (status == VC_OK) return Py_BuildValue("");
    if (status == VC_NO_MEMORY) return PyErr_NoMemory();
    PyErr_SetString(PyExc_ValueError, "a size or an index is out of its range");
    return NULL;
}

FUNCTION(bind_new) {
    (void)self;
    vc_camera c;
    if (!PyArg_ParseTuple(arguments, "iiiddddddd", &c.width_px, &c.height_px, &c.ground_top, &c.fx_px, &c.fy_px, &c.cx_px,
                          &c.cy_px, &c.height_m, &c.forward_m, &c.pitch_rad))
        return NULL;
    vc_core *core = vc_new(&c);
    if (core == NULL) return result(VC_INVALID);
    PyObject *capsule = PyCapsule_New(core, CAPSULE, destroy);
    if (capsule == NULL) vc_free(core);
    return capsule;
}

FUNCTION(bind_reserve) {
    (void)self;
    PyObject *capsule;
    int objects;
    if (!PyArg_ParseTuple(arguments, "Oi", &capsule, &objects)) return NULL;
    vc_core *core = core_of(capsule);
    return core == NULL ? NULL : result(vc_reserve(core, objects));
}
