/* Takes over the content of the ground. */
#include <stdlib.h>
#include <string.h>

#include "ground.h"
#include "vc_math.h"

enum { TILES = 2, PADDED = (VC_TILE + 1) * VC_STRIDE, LARGEST = 16384 };

static void free_polygons(Polygons *polygons) {
    free(polygons->starts);
    free(polygons->points_m);
    free(polygons->ranges_m);
    free(polygons->circles_m);
    free(polygons->values);
}

static void free_level(Level *level) {
    for (int i = 0; i < VC_SLOTS; i++) free(level->slots[i].texels);
    free((void *)level->spec.band);
    free((void *)level->spec.weight);
    free((void *)level->spec.gain);
    free((void *)level->spec.fineness);
    free(level->paint.close);
    free(level->shadows.close);
}

static void free_scratch(Scratch *scratch) {
    void *all[] = {scratch->canvas,   scratch->values,      scratch->sums,     scratch->crossings, scratch->counts,
                   scratch->placed,   scratch->points,      scratch->grain[0], scratch->grain[1],  scratch->grain[2],
                   scratch->strength[0], scratch->strength[1], scratch->noise};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) free(all[i]);
    memset(scratch, 0, sizeof *scratch);
}

void vc_ground_free(vc_ground_part *ground) {
    if (ground == NULL) return;
    free_polygons(&ground->paint);
    free_polygons(&ground->shadows);
    for (int i = 0; i < ground->levels; i++) free_level(ground->level + i);
    free_scratch(&ground->scratch);
    free(ground->haze);
    free(ground->tiles);
    for (int i = 0; i < 3; i++) free(ground->row[i]);
    free(ground);
}

/* Middle of a polygon's corners and distance of the farthest one. */
static void circle_of(const double *points, int count, double *circle) {
    circle[0] = circle[1] = circle[2] = 0.0;
    for (int i = 0; i < count; i++) {
        circle[0] += points[2 * i] / count;
        circle[1] += points[2 * i + 1] / count;
    }
    for (int i = 0; i < count; i++) {
        double reach = vc_hypot(points[2 * i] - circle[0], points[2 * i + 1] - circle[1]);
        if (reach > circle[2]) circle[2] = reach;
    }
}

static vc_status take_polygons(Polygons *to, const vc_polygons *from) {
    size_t count = (size_t)from->count;
    for (size_t i = 0; i < count; i++) {
        int corners = from->starts[i + 1] - from->starts[i];
        if (corners < 1 || corners > VC_POLYGON) return VC_INVALID;
    }
    to->starts = vc_copied(from->starts, count + 1, sizeof *to->starts, 0);
    to->points_m = vc_copied(from->points_m, count > 0 ? (size_t)from->starts[count] : 0, 2 * sizeof(double), 0);
    to->ranges_m = vc_copied(from->ranges_m, count, sizeof(double), 0);
    to->values = vc_copied(from->values, count, 1, 0);
    to->circles_m = malloc((count + 1) * 3 * sizeof(double));
    if (!to->starts || !to->points_m || !to->ranges_m || !to->values || !to->circles_m) return VC_NO_MEMORY;
    to->count = from->count;
    for (int i = 0; i < to->count; i++)
        circle_of(to->points_m + 2 * to->starts[i], to->starts[i + 1] - to->starts[i], to->circles_m + 3 * i);
    return VC_OK;
}

/* Copies the tiles of noise with their first texels repeated beyond the end. */
static uint8_t *padded(const uint8_t *tiles) {
    uint8_t *copy = malloc((size_t)TILES * PADDED);
    if (copy == NULL) return NULL;
    for (int tile = 0; tile < TILES; tile++)
        for (int row = 0; row <= VC_TILE; row++) {
            const uint8_t *from = tiles + ((size_t)tile * VC_TILE + row % VC_TILE) * VC_TILE;
            uint8_t *to = copy + (size_t)tile * PADDED + (size_t)row * VC_STRIDE;
            memcpy(to, from, VC_TILE);
            memcpy(to + VC_TILE, from, VC_STRIDE - VC_TILE);
        }
    return copy;
}

vc_status vc_set_ground(vc_core *core, const vc_ground *from, const vc_polygons *paint, const vc_polygons *shadows) {
    if (core->ground != NULL || from->hazy_rows < 0 || from->shade < 0 || from->shade > 256) return VC_INVALID;
    if (from->hazy_rows > core->camera.height_px - core->camera.ground_top) return VC_INVALID;
    vc_ground_part *ground = core->ground = calloc(1, sizeof *ground);
    if (ground == NULL) return VC_NO_MEMORY;
    for (int i = 0; i < 256; i++) {
        const uint8_t *rgb = from->palette + 3 * i;
        ground->palette[i] = rgb[0] | (uint32_t)rgb[1] << 8 | (uint32_t)rgb[2] << 16;
        ground->grain_gain[i] = from->grain_gain[i];
        ground->blotch_gain[i] = from->blotch_gain[i];
    }
    ground->outside = from->outside & 255;
    ground->shade = from->shade;
    ground->hazy_rows = from->hazy_rows;
    ground->haze = vc_copied(from->haze, (size_t)from->hazy_rows, 4, 0);
    ground->tiles = padded(from->tiles);
    int memory = ground->haze != NULL && ground->tiles != NULL;
    for (int i = 0; i < 3; i++) memory &= (ground->row[i] = calloc((size_t)core->camera.width_px, 4)) != NULL;
    if (!memory) return VC_NO_MEMORY;
    vc_status status = take_polygons(&ground->paint, paint);
    return status == VC_OK ? take_polygons(&ground->shadows, shadows) : status;
}

static int makes_sense(const vc_core *core, const vc_level *spec) {
    int fine = (spec->fine_x == 2 || spec->fine_x == 4) && (spec->fine_y == 2 || spec->fine_y == 4);
    int size = spec->rows > 0 && spec->rows <= LARGEST && spec->columns > 0 && spec->columns <= LARGEST;
    int blocks = !spec->steep || (spec->step >= 1.0 && spec->rows % (int)spec->step == 0);
    if (!fine || !size || !blocks || spec->columns % 8 != 0 || spec->gains < 1 || spec->step <= 0.0) return 0;
    if (spec->sidestep <= 0.0 || spec->turn_rad <= 0.0) return 0;
    for (int i = 0; i < 3 * spec->gains; i++)
        if (spec->fineness[i] < 1) return 0;
    for (int i = 0; i < spec->bands; i++) {
        const vc_band *band = spec->band + i;
        int faded = band->last - spec->band[0].first;
        if (band->first < 0 || band->last > core->camera.height_px - core->camera.ground_top) return 0;
        if (band->fineness < 1 || band->fineness > 256 || (band->faded && faded > spec->weights)) return 0;
    }
    return 1;
}

static int nearby_of(Nearby *nearby, const Polygons *polygons) {
    nearby->polygons = polygons;
    nearby->reach_m = -1.0;
    nearby->close = malloc(((size_t)polygons->count + 1) * sizeof *nearby->close);
    return nearby->close != NULL;
}

/* Memory as large as the largest level so far needs. */
static int make_scratch(vc_ground_part *ground) {
    size_t texels = 0, columns = 0, samples = 0, polygons = (size_t)vc_max(ground->paint.count, ground->shadows.count) + 1;
    size_t points = 2 * (size_t)vc_max(ground->paint.count ? ground->paint.starts[ground->paint.count] : 0,
                                       ground->shadows.count ? ground->shadows.starts[ground->shadows.count] : 0) + 2;
    for (int i = 0; i < ground->levels; i++) {
        const vc_level *spec = &ground->level[i].spec;
        size_t wide = (size_t)spec->columns * spec->fine_x, own = (size_t)spec->rows * spec->columns;
        if (own > texels) texels = own;
        if (wide > samples) samples = wide;
        if ((size_t)spec->columns > columns) columns = (size_t)spec->columns;
    }
    Scratch *scratch = &ground->scratch;
    free_scratch(scratch);
    scratch->canvas = malloc(samples * 4 * VC_STRIP + samples * 2);
    scratch->values = malloc(texels);
    scratch->sums = malloc(samples * sizeof(uint16_t));
    scratch->crossings = malloc(sizeof(double) * 4 * VC_STRIP * VC_CROSSINGS);
    scratch->counts = malloc(4 * VC_STRIP);
    scratch->placed = malloc(polygons * sizeof(Placed));
    scratch->points = malloc(points * 2 * sizeof(double));
    int memory = scratch->canvas && scratch->values && scratch->sums && scratch->crossings && scratch->counts;
    for (int i = 0; i < 3; i++) memory &= (scratch->grain[i] = malloc((columns + 2) * sizeof(float))) != NULL;
    for (int i = 0; i < 2; i++) memory &= (scratch->strength[i] = malloc((columns + 2) * sizeof(float))) != NULL;
    scratch->noise = malloc((columns + 1) * sizeof(uint32_t));
    return memory && scratch->placed && scratch->points && scratch->noise;
}

vc_status vc_add_level(vc_core *core, const vc_level *spec) {
    vc_ground_part *ground = core->ground;
    if (ground == NULL || ground->levels == VC_LEVELS || !makes_sense(core, spec)) return VC_INVALID;
    Level *level = ground->level + ground->levels++;
    level->spec = *spec;
    level->spec.band = vc_copied(spec->band, (size_t)spec->bands, sizeof *spec->band, 0);
    level->spec.weight = vc_copied(spec->weight, (size_t)spec->weights, 1, 0);
    level->spec.gain = vc_copied(spec->gain, (size_t)spec->gains, 2 * sizeof *spec->gain, 0);
    level->spec.fineness = vc_copied(spec->fineness, (size_t)spec->gains, 3, 0);
    int memory = level->spec.band && level->spec.weight && level->spec.gain && level->spec.fineness;
    memory &= nearby_of(&level->paint, &ground->paint) && nearby_of(&level->shadows, &ground->shadows);
    for (int i = 0; i < VC_SLOTS; i++)
        memory &= (level->slots[i].texels = malloc((size_t)spec->rows * spec->columns * sizeof(uint32_t))) != NULL;
    return memory && make_scratch(ground) ? VC_OK : VC_NO_MEMORY;
}

int vc_raster_texels(const vc_core *core, int level) {
    const vc_ground_part *ground = core->ground;
    if (ground == NULL || level < 0 || level >= ground->levels) return 0;
    return ground->level[level].spec.rows * ground->level[level].spec.columns;
}

vc_status vc_read_raster(const vc_core *core, int level, uint32_t *texels) {
    int count = vc_raster_texels(core, level);
    if (count == 0 || core->ground->level[level].now == NULL) return VC_INVALID;
    memcpy(texels, core->ground->level[level].now->texels, (size_t)count * sizeof *texels);
    return VC_OK;
}
