/* Python's calls for falling rain. */
#include "binding.h"
#include "rain/streaks.h"

#define NAME "vpf_sim.streaks"

static void delete(PyObject *capsule) { vc_streaks_free(PyCapsule_GetPointer(capsule, NAME)); }

FUNCTION(streaks_new) {
    vc_rainfall r = {0};
    vc_camera *c = &r.camera;
    unsigned long long seed;
    if (!PyArg_ParseTuple(arguments, "(iidddd)dddddK", &c->width_px, &c->height_px, &c->fx_px, &c->fy_px, &c->cx_px,
                          &c->cy_px, &c->pitch_rad, &r.rain_mmph, &r.exposure_s, &r.brightness, &r.gain, &seed))
        return NULL;
    r.seed = seed;
    vc_streaks *streaks = vc_streaks_new(&r);
    if (streaks == NULL) return PyErr_NoMemory();
    PyObject *capsule = PyCapsule_New(streaks, NAME, delete);
    if (capsule == NULL) vc_streaks_free(streaks);
    return capsule;
}

/* What both functions below take: velocity, yaw, time and a frame, before `arrays` - 1 other arrays. */
typedef struct {
    vc_air air;
    long long time_us;
    vc_image image;
} Moment;

static int begin(Call *call, PyObject *arguments, int arrays, Moment *moment) {
    double velocity[3], yaw;
    if (!vc_begin_call(call, arguments, NAME, arrays, VC_WRITE, "(ddd)dL", velocity, velocity + 1, velocity + 2, &yaw,
                       &moment->time_us))
        return 0;
    moment->air = vc_streaks_air(call->object, velocity, yaw);
    moment->image = vc_frame_in(call, 0, vc_streaks_camera(call->object), 3);
    return 1;
}

FUNCTION(streaks_draw) {
    Call call;
    Moment moment;
    if (!begin(&call, arguments, 1, &moment)) return NULL;
    if (moment.image.px != NULL) vc_streaks_draw(call.object, &moment.air, moment.time_us, moment.image);
    return vc_end_call(&call, moment.image.px ? VC_OK : VC_INVALID);
}

/* The number of specks. */
FUNCTION(streaks_list) {
    Call call;
    Moment moment;
    int count = VC_INVALID;
    if (!begin(&call, arguments, 2, &moment)) return NULL;
    if (moment.image.px != NULL)
        count = vc_streaks_list(call.object, &moment.air, moment.time_us, moment.image, call.buffer[1].buf,
                                vc_length(&call, 1, sizeof(vc_speck)));
    return vc_end_with_number(&call, count);
}

static PyMethodDef METHODS[] = {
    METHOD(streaks_new, "Return the rain before a camera."),
    METHOD(streaks_draw, "Draw the drops of a moment."),
    METHOD(streaks_list, "List the drops of a moment and return their number."),
    {NULL, NULL, 0, NULL},
};

int vc_bind_streaks(PyObject *module) { return PyModule_AddFunctions(module, METHODS); }
