/* Python's calls that make a core and set its content: core.h says what each array holds. */
#include "binding.h"

static void destroy(PyObject *capsule) { vc_free(PyCapsule_GetPointer(capsule, VC_CORE_NAME)); }

FUNCTION(new) {
    vc_camera c;
    if (!PyArg_ParseTuple(arguments, "iiiddddddd", &c.width_px, &c.height_px, &c.ground_top, &c.fx_px, &c.fy_px, &c.cx_px,
                          &c.cy_px, &c.height_m, &c.forward_m, &c.pitch_rad))
        return NULL;
    vc_core *core = vc_new(&c);
    if (core == NULL) return PyErr_Format(PyExc_ValueError, "the camera makes no sense, or there is no memory");
    PyObject *capsule = PyCapsule_New(core, VC_CORE_NAME, destroy);
    if (capsule == NULL) vc_free(core);
    return capsule;
}

FUNCTION(reserve) {
    Call call;
    int objects;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 0, VC_READ, "i", &objects)) return NULL;
    return vc_end_call(&call, vc_reserve(call.object, objects));
}

static int take_polygons(const Call *call, int first, vc_polygons *polygons) {
    polygons->count = vc_length(call, first + 2, 1);
    polygons->starts = vc_elements(call, first, polygons->count + 1, sizeof(int32_t));
    if (polygons->starts == NULL) return 0;
    polygons->points_m = vc_elements(call, first + 1, polygons->starts[polygons->count], 2 * sizeof(double));
    polygons->values = vc_elements(call, first + 2, polygons->count, 1);
    polygons->ranges_m = vc_elements(call, first + 3, polygons->count, sizeof(double));
    return polygons->points_m && polygons->values && polygons->ranges_m;
}

/* core, outside, shade, then: palette, tiles, gains of grain and blotches, haze; starts, points, values and ranges of the
 * paint, and of the shadows. */
FUNCTION(set_ground) {
    Call call;
    vc_ground ground;
    vc_polygons paint, shadows;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 13, VC_READ, "ii", &ground.outside, &ground.shade)) return NULL;
    ground.palette = vc_elements(&call, 0, 256 * 3, 1);
    ground.tiles = vc_elements(&call, 1, 2 * 1024 * 1024, 1);
    ground.grain_gain = vc_elements(&call, 2, 256, sizeof(float));
    ground.blotch_gain = vc_elements(&call, 3, 256, sizeof(float));
    ground.hazy_rows = vc_length(&call, 4, 4);
    ground.haze = vc_elements(&call, 4, ground.hazy_rows, 4);
    int fits = ground.palette && ground.tiles && ground.grain_gain && ground.blotch_gain && ground.haze;
    fits = fits && take_polygons(&call, 5, &paint) && take_polygons(&call, 9, &shadows);
    return vc_end_call(&call, fits ? vc_set_ground(call.object, &ground, &paint, &shadows) : VC_INVALID);
}

static void copy(double *to, const double *from, int count) {
    for (int i = 0; i < count; i++) to[i] = from[i];
}

static void take_numbers(vc_level *level, const int *whole, const double *real) {
    level->steep = whole[0];
    level->rows = whole[1];
    level->columns = whole[2];
    level->fine_x = whole[3];
    level->fine_y = whole[4];
    double *numbers[] = {&level->near_m,   &level->across_m, &level->along_m, &level->turn_rad, &level->step,
                         &level->sidestep, &level->ahead_m,  &level->right_m, &level->phase,    &level->depth_scale};
    for (int i = 0; i < 10; i++) *numbers[i] = real[i];
    copy(level->to_texels, real + 10, 9);
    copy(&level->grain_from_world[0][0], real + 19, 27);
}

/* core, then: (5,) int32, (46,) float64, bands, weights, gains, fineness. */
FUNCTION(add_level) {
    Call call;
    vc_level level;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 6, VC_READ, "")) return NULL;
    const int *whole = vc_elements(&call, 0, 5, sizeof(int32_t));
    const double *real = vc_elements(&call, 1, 46, sizeof(double));
    level.bands = vc_length(&call, 2, sizeof(vc_band));
    level.weights = vc_length(&call, 3, 1);
    level.gains = vc_length(&call, 4, 2 * sizeof(float));
    level.band = vc_elements(&call, 2, level.bands, sizeof(vc_band));
    level.weight = vc_elements(&call, 3, level.weights, 1);
    level.gain = vc_elements(&call, 4, level.gains, 2 * sizeof(float));
    level.fineness = vc_elements(&call, 5, level.gains, 3);
    int fits = whole && real && level.band && level.weight && level.gain && level.fineness;
    if (fits) take_numbers(&level, whole, real);
    return vc_end_call(&call, fits ? vc_add_level(call.object, &level) : VC_INVALID);
}

/* core, top, bottom, coarse, rows, columns, columns_per_rad, then: px, across, down of (h, w) samples. */
FUNCTION(add_panorama) {
    Call call;
    vc_panorama p;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 3, VC_READ, "iiiiiiid", &p.top, &p.bottom, &p.coarse, &p.rows,
                       &p.columns, &p.h, &p.w, &p.columns_per_rad))
        return NULL;
    p.px = vc_elements(&call, 0, (Py_ssize_t)p.rows * p.columns, 3);
    p.across = vc_elements(&call, 1, (Py_ssize_t)p.h * p.w, sizeof(int32_t));
    p.down = vc_elements(&call, 2, (Py_ssize_t)p.h * p.w, sizeof(int32_t));
    return vc_end_call(&call, p.px && p.across && p.down ? vc_add_panorama(call.object, &p) : VC_INVALID);
}

/* core, then: (16,) float64 horizon, sun, sky, direct, contact, shadow, fall; transmissions. */
FUNCTION(set_light) {
    Call call;
    vc_light light;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 2, VC_READ, "")) return NULL;
    const double *real = vc_elements(&call, 0, 16, sizeof(double));
    light.transmissions = vc_length(&call, 1, sizeof(double));
    light.transmission = vc_elements(&call, 1, light.transmissions, sizeof(double));
    if (real == NULL || light.transmission == NULL) return vc_end_call(&call, VC_INVALID);
    copy(light.horizon, real, 3);
    copy(light.sun, real + 3, 3);
    copy(light.sky, real + 6, 3);
    copy(light.direct, real + 9, 3);
    light.contact = real[12];
    light.shadow = real[13];
    light.fall_x = real[14];
    light.fall_y = real[15];
    return vc_end_call(&call, vc_set_light(call.object, &light));
}

/* Points, normals, colours and flags: the first four arrays. */
static int take_faces(const Call *call, int corners, vc_faces *faces) {
    faces->count = vc_length(call, 3, 1);
    faces->corners = corners;
    faces->points_m = vc_elements(call, 0, (Py_ssize_t)faces->count * corners, 3 * sizeof(double));
    faces->normals = vc_elements(call, 1, faces->count, 3 * sizeof(double));
    faces->colours = vc_elements(call, 2, faces->count, 3 * sizeof(double));
    faces->flags = vc_elements(call, 3, faces->count, 1);
    return faces->points_m && faces->normals && faces->colours && faces->flags;
}

/* core, corners, then: points, normals, colours, flags; first, middles, radii; from, until, fading. */
FUNCTION(set_roadside) {
    Call call;
    int corners;
    vc_faces faces;
    vc_roadside r;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 10, VC_READ, "i", &corners)) return NULL;
    if (!take_faces(&call, corners, &faces)) return vc_end_call(&call, VC_INVALID);
    r.items = vc_length(&call, 6, sizeof(double));
    r.first = vc_elements(&call, 4, r.items + 1, sizeof(int32_t));
    r.middles_m = vc_elements(&call, 5, r.items, 2 * sizeof(double));
    r.radii_m = vc_elements(&call, 6, r.items, sizeof(double));
    r.from_m = vc_elements(&call, 7, faces.count, sizeof(double));
    r.until_m = vc_elements(&call, 8, faces.count, sizeof(double));
    r.fading = vc_elements(&call, 9, faces.count, sizeof(double));
    int fits = r.first && r.middles_m && r.radii_m && r.from_m && r.until_m && r.fading;
    return vc_end_call(&call, fits ? vc_set_roadside(call.object, &r, &faces) : VC_INVALID);
}

/* core, corners, length, width, height, then: points, normals, colours, flags; parts, thickness, centres. The number. */
FUNCTION(add_mesh) {
    Call call;
    int corners;
    vc_faces faces;
    vc_mesh m;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 7, VC_READ, "iddd", &corners, &m.length_m, &m.width_m, &m.height_m))
        return NULL;
    if (!take_faces(&call, corners, &faces)) return vc_end_call(&call, VC_INVALID);
    m.centres = vc_length(&call, 6, 3 * sizeof(double));
    m.parts = vc_elements(&call, 4, faces.count, sizeof(int32_t));
    m.thickness_m = vc_elements(&call, 5, faces.count, sizeof(double));
    m.centres_m = vc_elements(&call, 6, m.centres, 3 * sizeof(double));
    int fits = m.parts && m.thickness_m && m.centres_m;
    return vc_end_with_number(&call, fits ? vc_add_mesh(call.object, &m, &faces) : VC_INVALID);
}

/* The levels of a picture lie one after the other in one array. */
static int take_levels(const Call *call, vc_tree *tree, const uint8_t **px) {
    const uint8_t *from = call->buffer[1].buf;
    Py_ssize_t total = 0;
    for (int i = 0; i < tree->levels; i++) {
        px[i] = from + total;
        total += (Py_ssize_t)tree->sizes[2 * i] * tree->sizes[2 * i + 1] * 4;
    }
    tree->px = px;
    return vc_elements(call, 1, total, 1) != NULL;
}

/* core, range, then: sizes, px of all levels, haze. */
FUNCTION(add_tree) {
    Call call;
    vc_tree tree;
    const uint8_t *px[VC_MIPS];
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 3, VC_READ, "d", &tree.range_m)) return NULL;
    tree.levels = vc_length(&call, 0, 2 * sizeof(int32_t));
    tree.hazes = vc_length(&call, 2, 5 * sizeof(double));
    tree.sizes = vc_elements(&call, 0, tree.levels, 2 * sizeof(int32_t));
    tree.haze = vc_elements(&call, 2, tree.hazes, 5 * sizeof(double));
    int fits = tree.sizes && tree.haze && tree.levels <= VC_MIPS && take_levels(&call, &tree, px);
    return vc_end_call(&call, fits ? vc_add_tree(call.object, &tree) : VC_INVALID);
}

/* core, (n, 7) float64 trees. */
FUNCTION(plant) {
    Call call;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 1, VC_READ, "")) return NULL;
    int count = vc_length(&call, 0, 7 * sizeof(double));
    const double *trees = vc_elements(&call, 0, count, 7 * sizeof(double));
    return vc_end_call(&call, trees ? vc_plant(call.object, count, trees) : VC_INVALID);
}

/* core, columns, then: (27,) float64, street lamps, factors, light of the ground. */
FUNCTION(set_lamps) {
    Call call;
    vc_lamps l;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 4, VC_READ, "i", &l.columns)) return NULL;
    double *numbers[] = {&l.ahead_m,   &l.aside_m,    &l.height_m,  &l.nearest_m, &l.peak_cd,    &l.above_cd, &l.above_wide,
                         &l.above_tall, &l.dip,       &l.rise,      &l.highest,   &l.soft,       &l.offset,   &l.narrow[0],
                         &l.narrow[1], &l.wide[0],    &l.wide[1],   &l.steep[0],  &l.steep[1],   &l.shallow[0],
                         &l.shallow[1], &l.street_cd, &l.street_range_m, &l.retro, &l.leaves,    &l.ground_gain,
                         &l.factor_scale};
    const double *real = vc_elements(&call, 0, 27, sizeof(double));
    l.lamps = vc_length(&call, 1, 3 * sizeof(double));
    l.lamps_m = vc_elements(&call, 1, l.lamps, 3 * sizeof(double));
    l.factors = vc_length(&call, 2, 3 * sizeof(double));
    l.factor = vc_elements(&call, 2, l.factors, 3 * sizeof(double));
    l.ground = vc_elements(&call, 3, (Py_ssize_t)vc_ground_rows(call.object) * l.columns, 3 * sizeof(double));
    int fits = real && l.lamps_m && l.factor && l.ground;
    for (int i = 0; fits && i < 27; i++) *numbers[i] = real[i];
    return vc_end_call(&call, fits ? vc_set_lamps(call.object, &l) : VC_INVALID);
}

/* core, size, (size, size, 4) picture. The number. */
FUNCTION(add_glow) {
    Call call;
    int size;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 1, VC_READ, "i", &size)) return NULL;
    const uint8_t *px = vc_elements(&call, 0, (Py_ssize_t)size * size, 4);
    return vc_end_with_number(&call, px ? vc_add_glow(call.object, size, px) : VC_INVALID);
}

/* core, rows, columns, seed, (rows, columns, 3) int8 levels. */
FUNCTION(set_noise) {
    Call call;
    int rows, columns;
    unsigned long long seed;
    if (!vc_begin_call(&call, arguments, VC_CORE_NAME, 1, VC_READ, "iiK", &rows, &columns, &seed)) return NULL;
    const int8_t *levels = vc_elements(&call, 0, (Py_ssize_t)rows * columns, 3);
    return vc_end_call(&call, levels ? vc_set_noise(call.object, rows, columns, levels, seed) : VC_INVALID);
}

static PyMethodDef METHODS[] = {
    METHOD(new, "Return a core for a camera."),
    METHOD(reserve, "Make room for frames with a number of objects."),
    METHOD(set_ground, "Set what the levels of the ground share."),
    METHOD(add_level, "Add a level of the ground."),
    METHOD(add_panorama, "Add a panorama at infinity."),
    METHOD(set_light, "Set light and haze."),
    METHOD(set_roadside, "Set the furniture beside the road."),
    METHOD(add_mesh, "Add a mesh and return its number."),
    METHOD(add_tree, "Add a kind of tree."),
    METHOD(plant, "Set the trees."),
    METHOD(set_lamps, "Set the light of lamps."),
    METHOD(add_glow, "Add the picture of a lamp and return its number."),
    METHOD(set_noise, "Set the noise of the sensor."),
    {NULL, NULL, 0, NULL},
};

int vc_bind_content(PyObject *module) { return PyModule_AddFunctions(module, METHODS); }
