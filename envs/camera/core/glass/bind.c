/* Python's calls for the windscreen. */
#include "binding.h"
#include "glass/glass.h"

#define NAME "vpf_sim.glass"

static void delete(PyObject *capsule) { vc_glass_free(PyCapsule_GetPointer(capsule, NAME)); }

FUNCTION(glass_new) {
    vc_windscreen w = {0};
    vc_camera *c = &w.camera;
    unsigned long long seed;
    if (!PyArg_ParseTuple(arguments, "(iidddd)ddd(bbb)K", &c->width_px, &c->height_px, &c->fx_px, &c->fy_px, &c->cx_px,
                          &c->cy_px, &w.rain_mmph, &w.wiper_period_s, &w.wiper_offset_s, &w.sky[0], &w.sky[1], &w.sky[2],
                          &seed))
        return NULL;
    w.seed = seed;
    vc_glass *glass = vc_glass_new(&w);
    if (glass == NULL) return PyErr_NoMemory();
    PyObject *capsule = PyCapsule_New(glass, NAME, delete);
    if (capsule == NULL) vc_glass_free(glass);
    return capsule;
}

/* glass, time_us, speed. */
FUNCTION(glass_advance) {
    Call call;
    long long time_us;
    double speed_mps;
    if (!vc_begin_call(&call, arguments, NAME, 0, VC_READ, "Ld", &time_us, &speed_mps)) return NULL;
    vc_glass_advance(call.object, time_us, speed_mps);
    return vc_end_call(&call, VC_OK);
}

/* Calls a function with an array of `channels` bytes a pixel. */
static PyObject *with_frame(PyObject *arguments, int channels, void (*function)(vc_glass *glass, vc_image image)) {
    Call call;
    if (!vc_begin_call(&call, arguments, NAME, 1, VC_WRITE, "")) return NULL;
    vc_image image = vc_frame_in(&call, 0, vc_glass_camera(call.object), channels);
    if (image.px != NULL) function(call.object, image);
    return vc_end_call(&call, image.px ? VC_OK : VC_INVALID);
}

static void hidden(vc_glass *glass, vc_image mask) { vc_glass_hidden(glass, mask.px); }
static void opacity(vc_glass *glass, vc_image mask) { vc_glass_opacity(glass, mask.px); }

FUNCTION(glass_draw) { return with_frame(arguments, 3, vc_glass_draw); }
FUNCTION(glass_hidden) { return with_frame(arguments, 1, hidden); }
FUNCTION(glass_opacity) { return with_frame(arguments, 1, opacity); }

/* glass, time_us. The angle. */
FUNCTION(glass_blade_rad) {
    Call call;
    long long time_us;
    if (!vc_begin_call(&call, arguments, NAME, 0, VC_READ, "L", &time_us)) return NULL;
    return Py_BuildValue("d", vc_glass_blade_rad(call.object, time_us));
}

/* glass, drops. Their number. */
FUNCTION(glass_drops) {
    Call call;
    if (!vc_begin_call(&call, arguments, NAME, 1, VC_WRITE, "")) return NULL;
    int most = vc_length(&call, 0, sizeof(vc_drop));
    return vc_end_with_number(&call, vc_glass_drops(call.object, call.buffer[0].buf, most));
}

/* glass, x, y, size, dies_tick, outline. */
FUNCTION(glass_put) {
    Call call;
    vc_drop drop = {.moved_tick = INT64_MIN};
    long long dies_tick;
    if (!vc_begin_call(&call, arguments, NAME, 0, VC_READ, "dddLi", &drop.x_px, &drop.y_px, &drop.size_mm, &dies_tick,
                       &drop.outline))
        return NULL;
    drop.dies_tick = dies_tick;
    return vc_end_call(&call, vc_glass_put(call.object, &drop));
}

static PyMethodDef METHODS[] = {
    METHOD(glass_new, "Return a windscreen before a camera."),
    METHOD(glass_advance, "Go to a time, at a speed since the time before."),
    METHOD(glass_draw, "Draw water and blade over a frame."),
    METHOD(glass_hidden, "Mark where water or blade hide the scene."),
    METHOD(glass_opacity, "Write the opacity of the water."),
    METHOD(glass_blade_rad, "Return the angle of the blade at a time."),
    METHOD(glass_drops, "List the drops and return their number."),
    METHOD(glass_put, "Add a drop."),
    {NULL, NULL, 0, NULL},
};

int vc_bind_glass(PyObject *module) { return PyModule_AddFunctions(module, METHODS); }
