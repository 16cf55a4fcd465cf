/* Python's calls that draw frames. */
#include "binding.h"
#include "internal.h"

/* core, x, y, yaw, time_us, (n, 4) objects: x, y, heading as float64 and the mesh as int64; (n, 10) lamps: x, y,
 * depth, flux, size, colour as float64, glow and object as int64. */
FUNCTION(begin) {
    Call call;
    vc_pose pose;
    long long time_us;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 2, VC_READ, "dddL", &pose.x_m, &pose.y_m, &pose.yaw_rad, &time_us))
        return NULL;
    pose.time_us = time_us;
    int count = vc_length(&call, 0, sizeof(vc_object)), lamp_count = vc_length(&call, 1, sizeof(vc_lamp));
    const vc_object *objects = vc_elements(&call, 0, count, sizeof(vc_object));
    const vc_lamp *lamps = vc_elements(&call, 1, lamp_count, sizeof(vc_lamp));
    int fits = objects && lamps;
    return vc_end_call(&call, fits ? vc_begin(call.object, &pose, objects, count, lamps, lamp_count) : VC_INVALID);
}

/* Calls a function on a frame, (height, width, 3) uint8. */
static PyObject *draw_on(Call *call, void (*function)(vc_core *core, vc_image image)) {
    vc_core *core = call->object;
    vc_image image = vc_frame_in(call, 0, &core->camera, 3);
    if (image.px != NULL) function(core, image);
    return vc_end_call(call, image.px ? VC_OK : VC_INVALID);
}

/* core, frame. */
static PyObject *draw(PyObject *arguments, void (*function)(vc_core *core, vc_image image)) {
    Call call;
    return vc_begin_call(&call, arguments, VC_CORE_NAME, 1, VC_WRITE, "") ? draw_on(&call, function) : NULL;
}

FUNCTION(draw_backdrop) { return draw(arguments, vc_draw_backdrop); }
FUNCTION(draw_wet_road) { return draw(arguments, vc_draw_wet_road); }
FUNCTION(draw_scene) { return draw(arguments, vc_draw_scene); }

/* core, time_us, frame. */
FUNCTION(draw_noise) {
    Call call;
    long long time_us;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 1, VC_WRITE, "L", &time_us)) return NULL;
    ((vc_core *)call.object)->frame.pose.time_us = time_us;
    return draw_on(&call, vc_draw_noise);
}

/* core, shift_px, two frames: as it was, and as it is read. */
FUNCTION(read_out) {
    Call call;
    double shift_px;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 2, VC_WRITE, "d", &shift_px)) return NULL;
    vc_core *core = call.object;
    vc_image from = vc_frame_in(&call, 0, &core->camera, 3), to = vc_frame_in(&call, 1, &core->camera, 3);
    int fits = from.px != NULL && to.px != NULL;
    if (fits) vc_read_out(core, shift_px, from, to);
    return vc_end_call(&call, fits ? VC_OK : VC_INVALID);
}

/* core, level, (rows, columns) uint32 texels. */
FUNCTION(read_raster) {
    Call call;
    int level;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 1, VC_WRITE, "i", &level)) return NULL;
    uint32_t *texels = vc_elements(&call, 0, vc_raster_texels(call.object, level), sizeof *texels);
    return vc_end_call(&call, texels ? vc_read_raster(call.object, level, texels) : VC_INVALID);
}

/* core, (height, width) int32 instances, (height, width, 3) float64 planes. */
FUNCTION(truth) {
    Call call;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 2, VC_WRITE, "")) return NULL;
    vc_core *core = call.object;
    Py_ssize_t count = (Py_ssize_t)core->camera.width_px * core->camera.height_px;
    int32_t *instance = vc_elements(&call, 0, count, sizeof *instance);
    double *planes = vc_elements(&call, 1, count, 3 * sizeof *planes);
    if (instance && planes) vc_truth(core, instance, planes);
    return vc_end_call(&call, instance && planes ? VC_OK : VC_INVALID);
}

static PyMethodDef METHODS[] = {
    METHOD(begin, "Set the pose of the next frame and find what it shows."),
    METHOD(draw_backdrop, "Draw sky, ground and haze."),
    METHOD(draw_wet_road, "Draw reflections on the road."),
    METHOD(draw_scene, "Draw what rises from the ground, and its shadows."),
    METHOD(draw_noise, "Add the noise of the sensor."),
    METHOD(read_out, "Shift the rows as a rolling shutter does."),
    METHOD(read_raster, "Copy the raster of a level."),
    METHOD(truth, "Write instance and plane of each pixel."),
    {NULL, NULL, 0, NULL},
};

int vc_bind_frames(PyObject *module) { return PyModule_AddFunctions(module, METHODS); }
