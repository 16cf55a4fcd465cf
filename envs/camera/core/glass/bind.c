#include "bind.h"

#include "glass/glass.h"

#define NAME "vpf_sim.glass"

/* A windscreen, and the size that goes with its arrays. */
typedef struct {
    vc_glass *glass;
    int width, height;
} Bound;

static void delete(PyObject *capsule) {
    Bound *bound = PyCapsule_GetPointer(capsule, NAME);
    if (bound == NULL) return;
    vc_glass_free(bound->glass);
    PyMem_Free(bound);
}

static PyObject *glass_new(PyObject *self, PyObject *arguments) {
    (void)self;
    vc_windscreen w = {0};
    vc_camera *c = &w.camera;
    unsigned long long seed;
    if (!PyArg_ParseTuple(arguments, "(iidddd)ddd(bbb)K", &c->width_px, &c->height_px, &c->fx_px, &c->fy_px, &c->cx_px,
                          &c->cy_px, &w.rain_mmph, &w.wiper_period_s, &w.wiper_offset_s, &w.sky[0], &w.sky[1], &w.sky[2],
                          &seed))
        return NULL;
    w.seed = seed;
    Bound *bound = PyMem_Malloc(sizeof *bound);
    if (bound == NULL) return PyErr_NoMemory();
    Bound made = {vc_glass_new(&w), c->width_px, c->height_px};
    *bound = made;
    PyObject *capsule = made.glass == NULL ? PyErr_NoMemory() : PyCapsule_New(bound, NAME, delete);
    if (capsule == NULL) {
        vc_glass_free(made.glass);
        PyMem_Free(bound);
    }
    return capsule;
}

static PyObject *glass_advance(PyObject *self, PyObject *arguments) {
    (void)self;
    PyObject *capsule;
    long long time_us;
    double speed_mps;
    if (!PyArg_ParseTuple(arguments, "OLd", &capsule, &time_us, &speed_mps)) return NULL;
    Bound *bound = PyCapsule_GetPointer(capsule, NAME);
    if (bound == NULL) return NULL;
    vc_glass_advance(bound->glass, time_us, speed_mps);
    return Py_BuildValue("");
}

/* Calls a function with an array of `channels` bytes a pixel. */
static PyObject *with_array(PyObject *arguments, int channels, void (*call)(Bound *, uint8_t *)) {
    PyObject *capsule;
    Py_buffer array;
    if (!PyArg_ParseTuple(arguments, "Ow*", &capsule, &array)) return NULL;
    Bound *bound = PyCapsule_GetPointer(capsule, NAME);
    PyObject *result = NULL;
    if (bound != NULL) {
        Py_ssize_t expected = (Py_ssize_t)bound->width * bound->height * channels;
        if (array.len != expected) {
            vc_wrong_size(array.len, expected);
        } else {
            call(bound, array.buf);
            result = Py_BuildValue("");
        }
    }
    PyBuffer_Release(&array);
    return result;
}

static void draw(Bound *bound, uint8_t *px) {
    vc_image image = {px, bound->width, bound->height};
    vc_glass_draw(bound->glass, image);
}

static void hidden(Bound *bound, uint8_t *mask) { vc_glass_hidden(bound->glass, mask); }

static void opacity(Bound *bound, uint8_t *mask) { vc_glass_opacity(bound->glass, mask); }

static PyObject *glass_draw(PyObject *self, PyObject *arguments) {
    (void)self;
    return with_array(arguments, 3, draw);
}

static PyObject *glass_hidden(PyObject *self, PyObject *arguments) {
    (void)self;
    return with_array(arguments, 1, hidden);
}

static PyObject *glass_opacity(PyObject *self, PyObject *arguments) {
    (void)self;
    return with_array(arguments, 1, opacity);
}

static PyObject *glass_blade_rad(PyObject *self, PyObject *arguments) {
    (void)self;
    PyObject *capsule;
    long long time_us;
    if (!PyArg_ParseTuple(arguments, "OL", &capsule, &time_us)) return NULL;
    Bound *bound = PyCapsule_GetPointer(capsule, NAME);
    return bound == NULL ? NULL : Py_BuildValue("d", vc_glass_blade_rad(bound->glass, time_us));
}

static PyObject *glass_drops(PyObject *self, PyObject *arguments) {
    (void)self;
    PyObject *capsule;
    Py_buffer array;
    if (!PyArg_ParseTuple(arguments, "Ow*", &capsule, &array)) return NULL;
    Bound *bound = PyCapsule_GetPointer(capsule, NAME);
    PyObject *result = NULL;
    if (bound != NULL) {
        int most = (int)(array.len / (Py_ssize_t)sizeof(vc_drop));
        result = Py_BuildValue("i", vc_glass_drops(bound->glass, array.buf, most));
    }
    PyBuffer_Release(&array);
    return result;
}

static PyObject *glass_put(PyObject *self, PyObject *arguments) {
    (void)self;
    PyObject *capsule;
    vc_drop drop = {0};
    long long dies_tick;
    if (!PyArg_ParseTuple(arguments, "OdddLi", &capsule, &drop.x_px, &drop.y_px, &drop.size_mm, &dies_tick, &drop.outline))
        return NULL;
    drop.dies_tick = dies_tick;
    drop.moved_tick = INT64_MIN;
    Bound *bound = PyCapsule_GetPointer(capsule, NAME);
    if (bound == NULL) return NULL;
    if (drop.outline < 0 || drop.outline >= VC_OUTLINES || vc_glass_put(bound->glass, &drop) != VC_OK)
        return PyErr_Format(PyExc_ValueError, "no room for the drop, or an outline beyond %d", VC_OUTLINES - 1);
    return Py_BuildValue("");
}

static PyMethodDef METHODS[] = {
    {"glass_new", glass_new, METH_VARARGS, NULL},
    {"glass_advance", glass_advance, METH_VARARGS, NULL},
    {"glass_draw", glass_draw, METH_VARARGS, NULL},
    {"glass_hidden", glass_hidden, METH_VARARGS, NULL},
    {"glass_opacity", glass_opacity, METH_VARARGS, NULL},
    {"glass_blade_rad", glass_blade_rad, METH_VARARGS, NULL},
    {"glass_drops", glass_drops, METH_VARARGS, NULL},
    {"glass_put", glass_put, METH_VARARGS, NULL},
    {NULL, NULL, 0, NULL},
};

int vc_bind_glass(PyObject *module) { return PyModule_AddFunctions(module, METHODS); }
