/* The Python module `_core`: checks and unpacks arguments, then calls the core. Nothing is computed here. */
#include <Python.h>

#include "bind.h"
#include "binding.h"
#include "vc_math.h"

#define TEXT(token) TEXT_OF(token)
#define TEXT_OF(token) #token

typedef double (*Function)(double);

/* Fill the second array with a function of the first; both hold doubles. */
static PyObject *map(PyObject *arguments, Function function) {
    Py_buffer from, to;
    if (!PyArg_ParseTuple(arguments, "y*w*", &from, &to)) return NULL;
    Py_ssize_t bytes = from.len;
    if (bytes == to.len && bytes % (Py_ssize_t)sizeof(double) == 0) {
        const double *value = from.buf;
        double *result = to.buf;
        for (Py_ssize_t i = 0; i < bytes / (Py_ssize_t)sizeof(double); i++) result[i] = function(value[i]);
    } else {
        PyErr_SetString(PyExc_ValueError, "expected two arrays of doubles of one size");
    }
    PyBuffer_Release(&from);
    PyBuffer_Release(&to);
    if (PyErr_Occurred()) return NULL;
    return Py_BuildValue("");
}

static PyObject *core_sin(PyObject *self, PyObject *arguments) {
    (void)self;
    return map(arguments, vc_sin);
}

static PyObject *core_cos(PyObject *self, PyObject *arguments) {
    (void)self;
    return map(arguments, vc_cos);
}

static PyObject *core_hypot(PyObject *self, PyObject *arguments) {
    (void)self;
    double x, y;
    if (!PyArg_ParseTuple(arguments, "dd", &x, &y)) return NULL;
    return Py_BuildValue("d", vc_hypot(x, y));
}

static PyMethodDef METHODS[] = {
    {"sin", core_sin, METH_VARARGS, "Fill the second array with the sines of the first."},
    {"cos", core_cos, METH_VARARGS, "Fill the second array with the cosines of the first."},
    {"hypot", core_hypot, METH_VARARGS, "Return the length of (x, y)."},
    {"new", bind_new, METH_VARARGS, "Return a core for a camera."},
    {"set_ground", bind_set_ground, METH_VARARGS, "Set what the levels of the ground share."},
    {"add_level", bind_add_level, METH_VARARGS, "Add a level of the ground."},
    {"add_panorama", bind_add_panorama, METH_VARARGS, "Add a panorama at infinity."},
    {"set_light", bind_set_light, METH_VARARGS, "Set light and haze."},
    {"set_roadside", bind_set_roadside, METH_VARARGS, "Set the furniture beside the road."},
    {"add_mesh", bind_add_mesh, METH_VARARGS, "Add a mesh and return its number."},
    {"add_tree", bind_add_tree, METH_VARARGS, "Add a kind of tree."},
    {"plant", bind_plant, METH_VARARGS, "Set the trees."},
    {"set_lamps", bind_set_lamps, METH_VARARGS, "Set the light of lamps."},
    {"add_glow", bind_add_glow, METH_VARARGS, "Add the picture of a lamp and return its number."},
    {"set_wet_road", bind_set_wet_road, METH_VARARGS, "Set how the road reflects."},
    {"set_puddles", bind_set_puddles, METH_VARARGS, "Set depths of water around a place."},
    {"set_spray", bind_set_spray, METH_VARARGS, "Set the spray behind moving objects."},
    {"set_noise", bind_set_noise, METH_VARARGS, "Set the noise of the sensor."},
    {"reserve", bind_reserve, METH_VARARGS, "Make room for frames with a number of objects."},
    {"begin", bind_begin, METH_VARARGS, "Set the pose of the next frame and find what it shows."},
    {"draw_backdrop", bind_draw_backdrop, METH_VARARGS, "Draw sky, ground and haze."},
    {"begin_spray", bind_begin_spray, METH_VARARGS, "Add spray to what the next frame shows."},
    {"draw_wet_road", bind_draw_wet_road, METH_VARARGS, "Draw reflections on the road."},
    {"draw_scene", bind_draw_scene, METH_VARARGS, "Draw what rises from the ground, and its shadows."},
    {"draw_noise", bind_draw_noise, METH_VARARGS, "Add the noise of the sensor."},
    {"read_raster", bind_read_raster, METH_VARARGS, "Copy the raster of a level."},
    {"hidden_by_rain", bind_hidden_by_rain, METH_VARARGS, "Mark where reflections and spray hide the scene."},
    {"truth", bind_truth, METH_VARARGS, "Write instance and plane of each pixel."},
    {NULL, NULL, 0, NULL},
};

static struct PyModuleDef MODULE = {PyModuleDef_HEAD_INIT, "_core", NULL, 0, METHODS, NULL, NULL, NULL, NULL};

PyMODINIT_FUNC PyInit__core(void) {
    PyObject *module = PyModule_Create(&MODULE);
    if (module == NULL) return NULL;
    int failed = PyModule_AddStringConstant(module, "SOURCES", TEXT(VC_SOURCES));
    if (failed < 0 || vc_bind_glass(module) < 0 || vc_bind_streaks(module) < 0) {
        Py_DecRef(module);
        return NULL;
    }
    return module;
}
