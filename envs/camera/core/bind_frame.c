/* Python's calls that draw frames. */
#include "binding.h"

#include "internal.h"

/* core, x, y, yaw, time_us, (n, 4) objects: x, y, heading as float64 and the mesh as int64; (n, 10) lamps: x, y,
 * depth, flux, size, colour as float64, glow and object as int64. */
FUNCTION(bind_begin) {
    (void)self;
    PyObject *capsule, *o[2];
    vc_pose pose;
    long long time_us;
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OdddLOO", &capsule, &pose.x_m, &pose.y_m, &pose.yaw_rad, &time_us, o, o + 1))
        return NULL;
    pose.time_us = time_us;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 2, 0)) return NULL;
    int count = (int)length(&buffers, 0, sizeof(vc_object)), lamp_count = (int)length(&buffers, 1, sizeof(vc_lamp));
    const vc_object *objects = elements(&buffers, 0, count, sizeof(vc_object));
    const vc_lamp *lamps = elements(&buffers, 1, lamp_count, sizeof(vc_lamp));
    vc_status status = objects && lamps ? vc_begin(core, &pose, objects, count, lamps, lamp_count) : VC_INVALID;
    release(&buffers);
    return result(status);
}

typedef void (*Draw)(vc_core *core, vc_image image);

/* Calls a function on a frame, (height, width, 3) uint8. */
static PyObject *draw_on(vc_core *core, PyObject *frame, Draw function) {
    Buffers buffers;
    if (core == NULL || !take_buffers(&buffers, &frame, 1, 1)) return NULL;
    int width = core->camera.width_px, height = core->camera.height_px;
    uint8_t *px = elements(&buffers, 0, (Py_ssize_t)height * width, 3);
    if (px != NULL) function(core, (vc_image){px, width, height});
    release(&buffers);
    return result(VC_OK);
}

/* core, frame. */
static PyObject *draw(PyObject *arguments, Draw function) {
    PyObject *capsule, *frame;
    if (!PyArg_ParseTuple(arguments, "OO", &capsule, &frame)) return NULL;
    return draw_on(core_of(capsule), frame, function);
}

FUNCTION(bind_draw_backdrop) { return (void)self, draw(arguments, vc_draw_backdrop); }
FUNCTION(bind_draw_wet_road) { return (void)self, draw(arguments, vc_draw_wet_road); }
FUNCTION(bind_draw_scene) { return (void)self, draw(arguments, vc_draw_scene); }

/* core, time_us, frame. */
FUNCTION(bind_draw_noise) {
    (void)self;
    PyObject *capsule, *frame;
    long long time_us;
    if (!PyArg_ParseTuple(arguments, "OLO", &capsule, &time_us, &frame)) return NULL;
    vc_core *core = core_of(capsule);
    if (core != NULL) core->frame.pose.time_us = time_us;
    return draw_on(core, frame, vc_draw_noise);
}

/* core, level, (rows, columns) uint32 texels. */
FUNCTION(bind_read_raster) {
    (void)self;
    PyObject *capsule, *o[1];
    int level;
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OiO", &capsule, &level, o)) return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 1, 1)) return NULL;
    vc_status status = VC_INVALID;
    uint32_t *texels = elements(&buffers, 0, vc_raster_texels(core, level), sizeof *texels);
    if (texels != NULL) status = vc_read_raster(core, level, texels);
    release(&buffers);
    return result(status);
}

/* core, (height, width) int32 instances, (height, width, 3) float64 planes. */
FUNCTION(bind_truth) {
    (void)self;
    PyObject *capsule, *o[2];
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OOO", &capsule, o, o + 1)) return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 2, 1)) return NULL;
    Py_ssize_t count = (Py_ssize_t)core->camera.width_px * core->camera.height_px;
    int32_t *instance = elements(&buffers, 0, count, sizeof *instance);
    double *planes = elements(&buffers, 1, count, 3 * sizeof *planes);
    if (instance && planes) vc_truth(core, instance, planes);
    release(&buffers);
    return result(VC_OK);
}
