#include "bind.h"

#include "rain/streaks.h"

#define NAME "vpf_sim.streaks"

/* Falling rain, and the size of the frames that go with it. */
typedef struct {
    vc_streaks *streaks;
    int width, height;
} Bound;

static void delete(PyObject *capsule) {
    Bound *bound = PyCapsule_GetPointer(capsule, NAME);
    if (bound == NULL) return;
    vc_streaks_free(bound->streaks);
    PyMem_Free(bound);
}

static PyObject *streaks_new(PyObject *self, PyObject *arguments) {
    (void)self;
    vc_rainfall r = {0};
    vc_camera *c = &r.camera;
    unsigned long long seed;
    if (!PyArg_ParseTuple(arguments, "(iidddd)dddddK", &c->width_px, &c->height_px, &c->fx_px, &c->fy_px, &c->cx_px,
                          &c->cy_px, &c->pitch_rad, &r.rain_mmph, &r.exposure_s, &r.brightness, &r.gain, &seed))
        return NULL;
    r.seed = seed;
    Bound *bound = PyMem_Malloc(sizeof *bound);
    if (bound == NULL) return PyErr_NoMemory();
    Bound made = {vc_streaks_new(&r), c->width_px, c->height_px};
    *bound = made;
    PyObject *capsule = made.streaks == NULL ? PyErr_NoMemory() : PyCapsule_New(bound, NAME, delete);
    if (capsule == NULL) {
        vc_streaks_free(made.streaks);
        PyMem_Free(bound);
    }
    return capsule;
}

/* What both functions below take: a moment and a frame. */
typedef struct {
    Bound *bound;
    vc_air air;
    long long time_us;
    vc_image image;
} Moment;

/* Takes velocity, yaw, time and frame; -1 with an exception. */
static int unpack(PyObject *capsule, const double *velocity_mps, double yaw_rad, const Py_buffer *frame, Moment *moment) {
    Bound *bound = moment->bound = PyCapsule_GetPointer(capsule, NAME);
    if (bound == NULL) return -1;
    Py_ssize_t expected = (Py_ssize_t)bound->width * bound->height * 3;
    if (frame->len != expected) {
        vc_wrong_size(frame->len, expected);
        return -1;
    }
    vc_image image = {frame->buf, bound->width, bound->height};
    moment->image = image;
    moment->air = vc_streaks_air(bound->streaks, velocity_mps, yaw_rad);
    return 0;
}

static PyObject *streaks_draw(PyObject *self, PyObject *arguments) {
    (void)self;
    PyObject *capsule, *result = NULL;
    double velocity[3], yaw;
    Moment moment;
    Py_buffer frame;
    if (!PyArg_ParseTuple(arguments, "O(ddd)dLw*", &capsule, &velocity[0], &velocity[1], &velocity[2], &yaw,
                          &moment.time_us, &frame))
        return NULL;
    if (unpack(capsule, velocity, yaw, &frame, &moment) == 0) {
        vc_streaks_draw(moment.bound->streaks, &moment.air, moment.time_us, moment.image);
        result = Py_BuildValue("");
    }
    PyBuffer_Release(&frame);
    return result;
}

static PyObject *streaks_list(PyObject *self, PyObject *arguments) {
    (void)self;
    PyObject *capsule, *result = NULL;
    double velocity[3], yaw;
    Moment moment;
    Py_buffer frame, specks;
    if (!PyArg_ParseTuple(arguments, "O(ddd)dLw*w*", &capsule, &velocity[0], &velocity[1], &velocity[2], &yaw,
                          &moment.time_us, &frame, &specks))
        return NULL;
    if (unpack(capsule, velocity, yaw, &frame, &moment) == 0) {
        int most = (int)(specks.len / (Py_ssize_t)sizeof(vc_speck));
        int count = vc_streaks_list(moment.bound->streaks, &moment.air, moment.time_us, moment.image, specks.buf, most);
        result = Py_BuildValue("i", count);
    }
    PyBuffer_Release(&frame);
    PyBuffer_Release(&specks);
    return result;
}

static PyMethodDef METHODS[] = {
    {"streaks_new", streaks_new, METH_VARARGS, NULL},
    {"streaks_draw", streaks_draw, METH_VARARGS, NULL},
    {"streaks_list", streaks_list, METH_VARARGS, NULL},
    {NULL, NULL, 0, NULL},
};

int vc_bind_streaks(PyObject *module) { return PyModule_AddFunctions(module, METHODS); }
