/* What module.c and the files of its functions share. */
#ifndef VC_BINDING_H
#define VC_BINDING_H

#include <Python.h>

#include "core.h"

/* The buffers of one call, to be released at its end. */
enum { BUFFERS = 16 };
typedef struct {
    Py_buffer buffer[BUFFERS];
    int count;
} Buffers;

vc_core *core_of(PyObject *capsule); /* NULL with an error set */
/* The start of a tuple of objects with the buffer protocol; NULL with an error set. */
int take_buffers(Buffers *buffers, PyObject *const *objects, int count, int writable);
void release(Buffers *buffers);
/* The elements of a buffer if it holds `count` of `size` bytes, else NULL with an error set. */
void *elements(const Buffers *buffers, int index, Py_ssize_t count, Py_ssize_t size);
/* How many elements of `size` bytes a buffer holds. */
Py_ssize_t length(const Buffers *buffers, int index, Py_ssize_t size);
/* None, or NULL with the error of a status. */
PyObject *result(vc_status status);

#define FUNCTION(name) PyObject *name(PyObject *self, PyObject *arguments)
FUNCTION(bind_new);
FUNCTION(bind_set_ground);
FUNCTION(bind_add_level);
FUNCTION(bind_add_panorama);
FUNCTION(bind_set_light);
FUNCTION(bind_set_roadside);
FUNCTION(bind_add_mesh);
FUNCTION(bind_add_tree);
FUNCTION(bind_plant);
FUNCTION(bind_set_lamps);
FUNCTION(bind_add_glow);
FUNCTION(bind_set_wet_road);
FUNCTION(bind_set_puddles);
FUNCTION(bind_set_spray);
FUNCTION(bind_begin_spray);
FUNCTION(bind_draw_wet_road);
FUNCTION(bind_hidden_by_rain);
FUNCTION(bind_set_noise);
FUNCTION(bind_reserve);
FUNCTION(bind_begin);
FUNCTION(bind_draw_backdrop);
FUNCTION(bind_draw_scene);
FUNCTION(bind_draw_noise);
FUNCTION(bind_read_raster);
FUNCTION(bind_truth);
#endif
