/* What module.c and the files of its functions share. */
#ifndef VC_BINDING_H
#define VC_BINDING_H

#include <Python.h>
#include <stdint.h>

#include "core.h"

/* Each adds its functions to the module; -1 with an exception set, else 0. */
int vc_bind_content(PyObject *module);
int vc_bind_frames(PyObject *module);
int vc_bind_road(PyObject *module);
int vc_bind_glass(PyObject *module);
int vc_bind_streaks(PyObject *module);

#define VC_CORE_NAME "vpf_sim.envs.camera.core" /* of the capsule of a core */

/* One call: the object of its first argument, a capsule, and the buffers of its last ones. */
enum { VC_ARRAYS = 16 };
typedef struct {
    void *object;
    Py_buffer buffer[VC_ARRAYS];
    int count;
} Call;

/* Takes the capsule of a name, then numbers by a format of PyArg_ParseTuple, then arrays that are written to or only
 * read; 0 with an exception. */
typedef enum { VC_READ, VC_WRITE } vc_access;
int vc_begin_call(Call *call, PyObject *arguments, const char *name, int arrays, vc_access access, const char *numbers, ...);
/* How many elements of `size` bytes an array holds. */
int vc_length(const Call *call, int index, size_t size);
/* The elements of an array that holds `count` of `size` bytes, else NULL with an exception. */
void *vc_elements(const Call *call, int index, Py_ssize_t count, size_t size);
/* Releases the arrays; None or a number from 0 on, or NULL with the exception of a status. */
PyObject *vc_end_call(Call *call, vc_status status);
PyObject *vc_end_with_number(Call *call, int number);
/* A frame of a camera's size in an array of `channels` bytes a pixel; without pixels and with an exception if it has another. */
vc_image vc_frame_in(const Call *call, int index, const vc_camera *camera, int channels);

#define FUNCTION(name) static PyObject *name(PyObject *Py_UNUSED(self), PyObject *arguments)
#define METHOD(name, text) {#name, name, METH_VARARGS, text}
#endif
