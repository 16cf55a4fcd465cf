/* Python's calls for the wet road and its spray. */
#include "binding.h"

#include "internal.h"

/* core, rows, columns, level, smear, ripple, seed, reflectance, share. */
FUNCTION(bind_set_wet_road) {
    (void)self;
    PyObject *capsule, *o[2];
    vc_wet_road wet;
    unsigned long long seed;
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OiiiiiKOO", &capsule, &wet.rows, &wet.columns, &wet.level, &wet.smear, &wet.ripple,
                          &seed, o, o + 1))
        return NULL;
    wet.seed = seed;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 2, 0)) return NULL;
    wet.reflectance = elements(&buffers, 0, (Py_ssize_t)wet.rows * wet.columns, 1);
    wet.share = elements(&buffers, 1, 256, 1);
    vc_status status = wet.reflectance && wet.share ? vc_set_wet_road(core, &wet) : VC_INVALID;
    release(&buffers);
    return result(status);
}

/* core, cells, x, y, size of a cell, depths. */
FUNCTION(bind_set_puddles) {
    (void)self;
    PyObject *capsule, *o[1];
    vc_puddles puddles;
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OidddO", &capsule, &puddles.cells, &puddles.x_m, &puddles.y_m, &puddles.cell_m, o))
        return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 1, 0)) return NULL;
    puddles.depths = elements(&buffers, 0, (Py_ssize_t)puddles.cells * puddles.cells, 1);
    vc_status status = puddles.depths ? vc_set_puddles(core, &puddles) : VC_INVALID;
    release(&buffers);
    return result(status);
}

/* core, strength, red, green, blue, pictures, size, seed, opacity. */
FUNCTION(bind_set_spray) {
    (void)self;
    PyObject *capsule, *o[1];
    vc_spray spray;
    unsigned long long seed;
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OdbbbiiKO", &capsule, &spray.strength, &spray.colour[0], &spray.colour[1],
                          &spray.colour[2], &spray.pictures, &spray.size, &seed, o))
        return NULL;
    spray.seed = seed;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 1, 0)) return NULL;
    spray.opacity = elements(&buffers, 0, (Py_ssize_t)spray.pictures * spray.size * spray.size, 1);
    vc_status status = spray.opacity ? vc_set_spray(core, &spray) : VC_INVALID;
    release(&buffers);
    return result(status);
}

/* core, (n,) speeds of the objects. */
FUNCTION(bind_begin_spray) {
    (void)self;
    PyObject *capsule, *o[1];
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OO", &capsule, o)) return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 1, 0)) return NULL;
    int count = (int)length(&buffers, 0, sizeof(double));
    const double *speeds = elements(&buffers, 0, count, sizeof(double));
    vc_status status = speeds ? vc_begin_spray(core, speeds, count) : VC_INVALID;
    release(&buffers);
    return result(status);
}

/* core, (height, width) int32. */
FUNCTION(bind_hidden_by_rain) {
    (void)self;
    PyObject *capsule, *o[1];
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OO", &capsule, o)) return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 1, 1)) return NULL;
    Py_ssize_t count = (Py_ssize_t)core->camera.width_px * core->camera.height_px;
    int32_t *hidden = elements(&buffers, 0, count, sizeof *hidden);
    if (hidden) vc_hidden_by_rain(core, hidden);
    release(&buffers);
    return result(VC_OK);
}
