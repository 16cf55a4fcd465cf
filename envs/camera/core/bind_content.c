/* Python's calls that set the content: core.h says what each array holds. */
#include "binding.h"

static int take_polygons(const Buffers *buffers, int first, vc_polygons *polygons) {
    Py_ssize_t count = length(buffers, first + 2, 1);
    polygons->count = (int)count;
    polygons->starts = elements(buffers, first, count + 1, sizeof(int32_t));
    if (polygons->starts == NULL) return 0;
    Py_ssize_t corners = polygons->starts[count];
    polygons->points_m = elements(buffers, first + 1, corners, 2 * sizeof(double));
    polygons->values = elements(buffers, first + 2, count, 1);
    polygons->ranges_m = elements(buffers, first + 3, count, sizeof(double));
    return polygons->points_m && polygons->values && polygons->ranges_m;
}

static vc_status set_ground(vc_core *core, const Buffers *b, vc_ground *ground) {
    vc_polygons paint, shadows;
    ground->palette = elements(b, 0, 256 * 3, 1);
    ground->tiles = elements(b, 1, 2 * 1024 * 1024, 1);
    ground->grain_gain = elements(b, 2, 256, sizeof(float));
    ground->blotch_gain = elements(b, 3, 256, sizeof(float));
    ground->hazy_rows = (int)length(b, 4, 4);
    ground->haze = elements(b, 4, ground->hazy_rows, 4);
    if (!ground->palette || !ground->tiles || !ground->grain_gain || !ground->blotch_gain || !ground->haze)
        return VC_INVALID;
    if (!take_polygons(b, 5, &paint) || !take_polygons(b, 9, &shadows)) return VC_INVALID;
    return vc_set_ground(core, ground, &paint, &shadows);
}

/* core, outside, shade, then: palette, tiles, gains of grain and blotches, haze; starts, points, values and ranges of the
 * paint, and of the shadows. */
FUNCTION(bind_set_ground) {
    (void)self;
    PyObject *capsule, *o[13];
    vc_ground ground;
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OiiOOOOOOOOOOOOO", &capsule, &ground.outside, &ground.shade, o, o + 1, o + 2, o + 3,
                          o + 4, o + 5, o + 6, o + 7, o + 8, o + 9, o + 10, o + 11, o + 12))
        return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 13, 0)) return NULL;
    vc_status status = set_ground(core, &buffers, &ground);
    release(&buffers);
    return result(status);
}

static void copy(double *to, const double *from, int count) {
    for (int i = 0; i < count; i++) to[i] = from[i];
}

static vc_status add_level(vc_core *core, const Buffers *b) {
    const int *whole = elements(b, 0, 5, sizeof(int32_t));
    const double *real = elements(b, 1, 46, sizeof(double));
    Py_ssize_t bands = length(b, 2, 4 * sizeof(int32_t)), gains = length(b, 4, 2 * sizeof(float));
    vc_level level;
    level.band = elements(b, 2, bands, sizeof(vc_band));
    level.weight = elements(b, 3, length(b, 3, 1), 1);
    level.gain = elements(b, 4, gains, 2 * sizeof(float));
    level.fineness = elements(b, 5, gains, 3);
    if (!whole || !real || !level.band || !level.weight || !level.gain || !level.fineness) return VC_INVALID;
    level.steep = whole[0];
    level.rows = whole[1];
    level.columns = whole[2];
    level.fine_x = whole[3];
    level.fine_y = whole[4];
    level.bands = (int)bands;
    level.weights = (int)length(b, 3, 1);
    level.gains = (int)gains;
    double *numbers[] = {&level.near_m,   &level.across_m, &level.along_m, &level.turn_rad, &level.step,
                         &level.sidestep, &level.ahead_m,  &level.right_m, &level.phase,    &level.depth_scale};
    for (int i = 0; i < 10; i++) *numbers[i] = real[i];
    copy(level.to_texels, real + 10, 9);
    copy(&level.grain_from_world[0][0], real + 19, 27);
    return vc_add_level(core, &level);
}

/* core, then: (5,) int32, (46,) float64, bands, weights, gains, fineness. */
FUNCTION(bind_add_level) {
    (void)self;
    PyObject *capsule, *o[6];
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OOOOOOO", &capsule, o, o + 1, o + 2, o + 3, o + 4, o + 5)) return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 6, 0)) return NULL;
    vc_status status = add_level(core, &buffers);
    release(&buffers);
    return result(status);
}

/* core, top, bottom, coarse, rows, columns, columns_per_rad, then: px, across, down. */
FUNCTION(bind_add_panorama) {
    (void)self;
    PyObject *capsule, *o[3];
    vc_panorama p;
    int width;
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OiiiiiidOOO", &capsule, &p.top, &p.bottom, &p.coarse, &p.rows, &p.columns, &width,
                          &p.columns_per_rad, o, o + 1, o + 2))
        return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || p.coarse < 1 || !take_buffers(&buffers, o, 3, 0)) return core == NULL ? NULL : result(VC_INVALID);
    Py_ssize_t samples = (Py_ssize_t)((p.bottom - p.top + p.coarse - 1) / p.coarse) * ((width + p.coarse - 1) / p.coarse);
    p.px = elements(&buffers, 0, (Py_ssize_t)p.rows * p.columns, 3);
    p.across = elements(&buffers, 1, samples, sizeof(int32_t));
    p.down = elements(&buffers, 2, samples, sizeof(int32_t));
    vc_status status = p.px && p.across && p.down ? vc_add_panorama(core, &p) : VC_INVALID;
    release(&buffers);
    return result(status);
}

/* core, then: (16,) float64 horizon, sun, sky, direct, contact, shadow, fall; transmissions. */
FUNCTION(bind_set_light) {
    (void)self;
    PyObject *capsule, *o[2];
    vc_light light;
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OOO", &capsule, o, o + 1)) return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 2, 0)) return NULL;
    const double *real = elements(&buffers, 0, 16, sizeof(double));
    light.transmissions = (int)length(&buffers, 1, sizeof(double));
    light.transmission = elements(&buffers, 1, light.transmissions, sizeof(double));
    vc_status status = VC_INVALID;
    if (real && light.transmission) {
        copy(light.horizon, real, 3);
        copy(light.sun, real + 3, 3);
        copy(light.sky, real + 6, 3);
        copy(light.direct, real + 9, 3);
        light.contact = real[12];
        light.shadow = real[13];
        light.fall_x = real[14];
        light.fall_y = real[15];
        status = vc_set_light(core, &light);
    }
    release(&buffers);
    return result(status);
}

/* Points, normals, colours and flags from a buffer on. */
static int take_faces(const Buffers *b, int first, int corners, vc_faces *faces) {
    faces->count = (int)length(b, first + 3, 1);
    faces->corners = corners;
    faces->points_m = elements(b, first, (Py_ssize_t)faces->count * corners, 3 * sizeof(double));
    faces->normals = elements(b, first + 1, faces->count, 3 * sizeof(double));
    faces->colours = elements(b, first + 2, faces->count, 3 * sizeof(double));
    faces->flags = elements(b, first + 3, faces->count, 1);
    return faces->points_m && faces->normals && faces->colours && faces->flags;
}

static vc_status set_roadside(vc_core *core, const Buffers *b, int corners) {
    vc_faces faces;
    vc_roadside r;
    if (!take_faces(b, 0, corners, &faces)) return VC_INVALID;
    r.items = (int)length(b, 6, sizeof(double));
    r.first = elements(b, 4, r.items + 1, sizeof(int32_t));
    r.middles_m = elements(b, 5, r.items, 2 * sizeof(double));
    r.radii_m = elements(b, 6, r.items, sizeof(double));
    r.from_m = elements(b, 7, faces.count, sizeof(double));
    r.until_m = elements(b, 8, faces.count, sizeof(double));
    r.fading = elements(b, 9, faces.count, sizeof(double));
    if (!r.first || !r.middles_m || !r.radii_m || !r.from_m || !r.until_m || !r.fading) return VC_INVALID;
    return vc_set_roadside(core, &r, &faces);
}

/* core, corners, then: points, normals, colours, flags; first, middles, radii; from, until, fading. */
FUNCTION(bind_set_roadside) {
    (void)self;
    PyObject *capsule, *o[10];
    int corners;
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OiOOOOOOOOOO", &capsule, &corners, o, o + 1, o + 2, o + 3, o + 4, o + 5, o + 6,
                          o + 7, o + 8, o + 9))
        return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 10, 0)) return NULL;
    vc_status status = set_roadside(core, &buffers, corners);
    release(&buffers);
    return result(status);
}

/* core, corners, length, width, height, then: points, normals, colours, flags; parts, thickness, centres. The number. */
FUNCTION(bind_add_mesh) {
    (void)self;
    PyObject *capsule, *o[7];
    int corners;
    vc_faces faces;
    vc_mesh m;
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OidddOOOOOOO", &capsule, &corners, &m.length_m, &m.width_m, &m.height_m, o, o + 1,
                          o + 2, o + 3, o + 4, o + 5, o + 6))
        return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 7, 0)) return NULL;
    int number = VC_INVALID;
    if (take_faces(&buffers, 0, corners, &faces)) {
        m.centres = (int)length(&buffers, 6, 3 * sizeof(double));
        m.parts = elements(&buffers, 4, faces.count, sizeof(int32_t));
        m.thickness_m = elements(&buffers, 5, faces.count, sizeof(double));
        m.centres_m = elements(&buffers, 6, m.centres, 3 * sizeof(double));
        if (m.parts && m.thickness_m && m.centres_m) number = vc_add_mesh(core, &m, &faces);
    }
    release(&buffers);
    return number < 0 ? result((vc_status)number) : Py_BuildValue("i", number);
}

/* The levels of a picture lie one after the other in one buffer. */
static vc_status add_tree(vc_core *core, const Buffers *b, double range_m) {
    const uint8_t *px[VC_MIPS];
    vc_tree tree = {range_m, (int)length(b, 0, 2 * sizeof(int32_t)), NULL, px, (int)length(b, 2, 5 * sizeof(double)), NULL};
    tree.sizes = elements(b, 0, tree.levels, 2 * sizeof(int32_t));
    tree.haze = elements(b, 2, tree.hazes, 5 * sizeof(double));
    if (!tree.sizes || !tree.haze || tree.levels > VC_MIPS) return VC_INVALID;
    Py_ssize_t total = 0;
    for (int i = 0; i < tree.levels; i++) {
        px[i] = (const uint8_t *)b->buffer[1].buf + total;
        total += (Py_ssize_t)tree.sizes[2 * i] * tree.sizes[2 * i + 1] * 4;
    }
    return elements(b, 1, total, 1) ? vc_add_tree(core, &tree) : VC_INVALID;
}

/* core, range, then: sizes, px of all levels, haze. */
FUNCTION(bind_add_tree) {
    (void)self;
    PyObject *capsule, *o[3];
    double range_m;
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OdOOO", &capsule, &range_m, o, o + 1, o + 2)) return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 3, 0)) return NULL;
    vc_status status = add_tree(core, &buffers, range_m);
    release(&buffers);
    return result(status);
}

/* core, (n, 7) float64 trees. */
FUNCTION(bind_plant) {
    (void)self;
    PyObject *capsule, *o[1];
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OO", &capsule, o)) return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 1, 0)) return NULL;
    int count = (int)length(&buffers, 0, 7 * sizeof(double));
    const double *trees = elements(&buffers, 0, count, 7 * sizeof(double));
    vc_status status = trees ? vc_plant(core, count, trees) : VC_INVALID;
    release(&buffers);
    return result(status);
}

static vc_status set_lamps(vc_core *core, const Buffers *b, int columns) {
    vc_lamps l;
    const double *real = elements(b, 0, 27, sizeof(double));
    double *numbers[] = {&l.ahead_m,   &l.aside_m,    &l.height_m,  &l.nearest_m, &l.peak_cd,    &l.above_cd, &l.above_wide,
                         &l.above_tall, &l.dip,       &l.rise,      &l.highest,   &l.soft,       &l.offset,   &l.narrow[0],
                         &l.narrow[1], &l.wide[0],    &l.wide[1],   &l.steep[0],  &l.steep[1],   &l.shallow[0],
                         &l.shallow[1], &l.street_cd, &l.street_range_m, &l.retro, &l.leaves,    &l.ground_gain,
                         &l.factor_scale};
    l.lamps = (int)length(b, 1, 3 * sizeof(double));
    l.lamps_m = elements(b, 1, l.lamps, 3 * sizeof(double));
    l.factors = (int)length(b, 2, 3 * sizeof(double));
    l.factor = elements(b, 2, l.factors, 3 * sizeof(double));
    l.columns = columns;
    l.ground = elements(b, 3, (Py_ssize_t)vc_ground_rows(core) * columns, 3 * sizeof(double));
    if (!real || !l.lamps_m || !l.factor || !l.ground) return VC_INVALID;
    for (int i = 0; i < 27; i++) *numbers[i] = real[i];
    return vc_set_lamps(core, &l);
}

/* core, columns, then: (27,) float64, street lamps, factors, light of the ground. */
FUNCTION(bind_set_lamps) {
    (void)self;
    PyObject *capsule, *o[4];
    int columns;
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OiOOOO", &capsule, &columns, o, o + 1, o + 2, o + 3)) return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 4, 0)) return NULL;
    vc_status status = set_lamps(core, &buffers, columns);
    release(&buffers);
    return result(status);
}

/* core, size, (size, size, 4) picture. The number. */
FUNCTION(bind_add_glow) {
    (void)self;
    PyObject *capsule, *o[1];
    int size;
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OiO", &capsule, &size, o)) return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 1, 0)) return NULL;
    const uint8_t *px = elements(&buffers, 0, (Py_ssize_t)size * size, 4);
    int number = px ? vc_add_glow(core, size, px) : VC_INVALID;
    release(&buffers);
    return number < 0 ? result((vc_status)number) : Py_BuildValue("i", number);
}

/* core, rows, columns, seed, (rows, columns, 3) int8 levels. */
FUNCTION(bind_set_noise) {
    (void)self;
    PyObject *capsule, *o[1];
    int rows, columns;
    unsigned long long seed;
    Buffers buffers;
    if (!PyArg_ParseTuple(arguments, "OiiKO", &capsule, &rows, &columns, &seed, o)) return NULL;
    vc_core *core = core_of(capsule);
    if (core == NULL || !take_buffers(&buffers, o, 1, 0)) return NULL;
    const int8_t *levels = elements(&buffers, 0, (Py_ssize_t)rows * columns, 3);
    vc_status status = levels ? vc_set_noise(core, rows, columns, levels, seed) : VC_INVALID;
    release(&buffers);
    return result(status);
}
