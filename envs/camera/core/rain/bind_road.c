/* Python's calls for the wet road and its spray. */
#include "binding.h"
#include "internal.h"

/* core, rows, columns, level, smear, ripple, seed, reflectance, share. */
FUNCTION(set_wet_road) {
    Call call;
    vc_wet_road wet;
    unsigned long long seed;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 2, VC_READ, "iiiiiK", &wet.rows, &wet.columns, &wet.level, &wet.smear,
                       &wet.ripple, &seed))
        return NULL;
    wet.seed = seed;
    wet.reflectance = vc_elements(&call, 0, (Py_ssize_t)wet.rows * wet.columns, 1);
    wet.share = vc_elements(&call, 1, 256, 1);
    return vc_end_call(&call, wet.reflectance && wet.share ? vc_set_wet_road(call.object, &wet) : VC_INVALID);
}

/* core, cells, x, y, size of a cell, depths. */
FUNCTION(set_puddles) {
    Call call;
    vc_puddles p;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 1, VC_READ, "iddd", &p.cells, &p.x_m, &p.y_m, &p.cell_m)) return NULL;
    p.depths = vc_elements(&call, 0, (Py_ssize_t)p.cells * p.cells, 1);
    return vc_end_call(&call, p.depths ? vc_set_puddles(call.object, &p) : VC_INVALID);
}

/* core, strength, red, green, blue, pictures, size, seed, opacity. */
FUNCTION(set_spray) {
    Call call;
    vc_spray spray;
    unsigned long long seed;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 1, VC_READ, "dbbbiiK", &spray.strength, &spray.colour[0],
                       &spray.colour[1], &spray.colour[2], &spray.pictures, &spray.size, &seed))
        return NULL;
    spray.seed = seed;
    spray.opacity = vc_elements(&call, 0, (Py_ssize_t)spray.pictures * spray.size * spray.size, 1);
    return vc_end_call(&call, spray.opacity ? vc_set_spray(call.object, &spray) : VC_INVALID);
}

/* core, (n,) speeds of the objects. */
FUNCTION(begin_spray) {
    Call call;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 1, VC_READ, "")) return NULL;
    int count = vc_length(&call, 0, sizeof(double));
    const double *speeds = vc_elements(&call, 0, count, sizeof(double));
    return vc_end_call(&call, speeds ? vc_begin_spray(call.object, speeds, count) : VC_INVALID);
}

/* core, (height, width) int32. */
FUNCTION(hidden_by_rain) {
    Call call;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 1, VC_WRITE, "")) return NULL;
    vc_core *core = call.object;
    int32_t *hidden = vc_elements(&call, 0, (Py_ssize_t)core->camera.width_px * core->camera.height_px, sizeof *hidden);
    if (hidden) vc_hidden_by_rain(core, hidden);
    return vc_end_call(&call, hidden ? VC_OK : VC_INVALID);
}

static PyMethodDef METHODS[] = {
    METHOD(set_wet_road, "Set how the road reflects."),
    METHOD(set_puddles, "Set depths of water around a place."),
    METHOD(set_spray, "Set the spray behind moving objects."),
    METHOD(begin_spray, "Add spray to what the next frame shows."),
    METHOD(hidden_by_rain, "Mark where reflections and spray hide the scene."),
    {NULL, NULL, 0, NULL},
};

int vc_bind_road(PyObject *module) { return PyModule_AddFunctions(module, METHODS); }
