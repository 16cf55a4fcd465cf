/* Paints polygons of the ground into rasters: sampled on a finer canvas and averaged, so that edges get their coverage. */
#include <string.h>

#include "ground.h"
#include "vc_math.h"

#define TRAVEL_M 12.0 /* of a raster before the polygons near by are collected again */
#define FARTHEST 1e6  /* samples to which corners are limited */

/* The outline of a raster in the world: its corners, and for each side the outward normal and the offset along it. */
typedef struct {
    double x_m, y_m, reach_m;
    double sides[4][3];
} Outline;

static void corners_of(const double *to_world, int rows, int columns, double corners[4][2]) {
    double places[4][2] = {
        {-0.5, -0.5}, {-0.5, rows - 0.5}, {columns - 0.5, rows - 0.5}, {columns - 0.5, -0.5}};
    for (int i = 0; i < 4; i++) {
        double x = places[i][0], y = places[i][1], w = to_world[6] * x + to_world[7] * y + to_world[8];
        corners[i][0] = (to_world[0] * x + to_world[1] * y + to_world[2]) / w;
        corners[i][1] = (to_world[3] * x + to_world[4] * y + to_world[5]) / w;
    }
}

static Outline outline_of(const double *to_world, int rows, int columns) {
    double corners[4][2];
    corners_of(to_world, rows, columns, corners);
    Outline outline = {0};
    for (int i = 0; i < 4; i++) {
        outline.x_m += 0.25 * corners[i][0];
        outline.y_m += 0.25 * corners[i][1];
    }
    for (int i = 0; i < 4; i++) {
        const double *here = corners[i], *next = corners[(i + 1) & 3];
        double reach = vc_hypot(here[0] - outline.x_m, here[1] - outline.y_m);
        if (reach > outline.reach_m) outline.reach_m = reach;
        double length = vc_hypot(next[0] - here[0], next[1] - here[1]);
        double x = (next[1] - here[1]) / length, y = (here[0] - next[0]) / length;
        double sign = (here[0] - outline.x_m) * x + (here[1] - outline.y_m) * y < 0.0 ? -1.0 : 1.0;
        double *side = outline.sides[i];
        side[0] = sign * x;
        side[1] = sign * y;
        side[2] = side[0] * here[0] + side[1] * here[1];
    }
    return outline;
}

static void collect(Nearby *nearby, const Outline *outline, double near_m) {
    const Polygons *polygons = nearby->polygons;
    double apart = vc_hypot(outline->x_m - nearby->x_m, outline->y_m - nearby->y_m);
    if (apart + outline->reach_m <= nearby->reach_m) return;
    nearby->x_m = outline->x_m;
    nearby->y_m = outline->y_m;
    nearby->reach_m = outline->reach_m + TRAVEL_M;
    nearby->count = 0;
    for (int i = 0; i < polygons->count; i++) {
        const double *circle = polygons->circles_m + 3 * i;
        double x = circle[0] - nearby->x_m, y = circle[1] - nearby->y_m, reach = nearby->reach_m + circle[2];
        if (polygons->ranges_m[i] > near_m && x * x + y * y < reach * reach) nearby->close[nearby->count++] = i;
    }
}

static int touches(const Outline *outline, const double *circle) {
    for (int i = 0; i < 4; i++) {
        const double *side = outline->sides[i];
        if (side[0] * circle[0] + side[1] * circle[1] - side[2] >= circle[2]) return 0;
    }
    return 1;
}

/* Projects a polygon into samples; returns whether anything of it is before the camera. */
static int place(const Polygons *polygons, int index, const double *matrix, const vc_level *spec, double *points,
                 Placed *placed) {
    double corners[3 * VC_POLYGON], clipped[6 * VC_POLYGON];
    const double *from = polygons->points_m + 2 * polygons->starts[index], *kept = corners;
    int count = polygons->starts[index + 1] - polygons->starts[index], inside = 0;
    for (int i = 0; i < count; i++) {
        double x = from[2 * i], y = from[2 * i + 1], *corner = corners + 3 * i;
        for (int j = 0; j < 3; j++) corner[j] = matrix[3 * j] * x + matrix[3 * j + 1] * y + matrix[3 * j + 2];
        inside += corner[2] > VC_NEAR_M;
    }
    if (inside == 0) return 0;
    if (inside < count) {
        count = vc_clip(corners, count, clipped);
        kept = clipped;
    }
    placed->corners = count;
    placed->value = polygons->values[index];
    placed->top = FARTHEST;
    placed->bottom = -FARTHEST;
    for (int i = 0; i < count; i++) {
        double scale = 1.0 / kept[3 * i + 2];
        double x = vc_limit((kept[3 * i] * scale + 0.5) * spec->fine_x, -FARTHEST, FARTHEST);
        double y = vc_limit((kept[3 * i + 1] * scale + 0.5) * spec->fine_y, -FARTHEST, FARTHEST);
        points[2 * i] = x;
        points[2 * i + 1] = y;
        if (y < placed->top) placed->top = y;
        if (y > placed->bottom) placed->bottom = y;
    }
    return 1;
}

/* Projects all polygons that touch a raster; returns their number. */
static int place_all(Scratch *scratch, const Nearby *nearby, const Outline *outline, const double *matrix,
                     const vc_level *spec, int rows) {
    int count = 0, points = 0;
    for (int i = 0; i < nearby->count; i++) {
        int index = nearby->close[i];
        Placed *placed = scratch->placed + count;
        if (!touches(outline, nearby->polygons->circles_m + 3 * index)) continue;
        if (!place(nearby->polygons, index, matrix, spec, scratch->points + 2 * points, placed)) continue;
        if (placed->bottom <= 0.0 || placed->top >= rows * spec->fine_y) continue;
        placed->first = points;
        points += placed->corners;
        count++;
    }
    return count;
}

/* Adds the columns at which an edge crosses the middles of the rows `first` to `last` - 1, in order. */
static void cross(Scratch *scratch, const double *a, const double *b, double top, int first, int last) {
    if (a[1] > b[1]) {
        const double *swap = a;
        a = b;
        b = swap;
    }
    double above = a[1] - top, below = b[1] - top;
    int from = vc_max(first, vc_ceil(above - 0.5)), to = vc_min(last, vc_ceil(below - 0.5));
    if (from >= to) return;
    double slope = (b[0] - a[0]) / (below - above), x = a[0] + (from + 0.5 - above) * slope;
    for (int row = from; row < to; row++, x += slope) {
        if (scratch->counts[row] == VC_CROSSINGS) continue;
        double *columns = scratch->crossings + (size_t)row * VC_CROSSINGS;
        int place = scratch->counts[row]++;
        for (; place > 0 && columns[place - 1] > x; place--) columns[place] = columns[place - 1];
        columns[place] = x;
    }
}

static void fill(Scratch *scratch, const Placed *placed, double top, int width, int height) {
    int first = vc_max(0, vc_ceil(placed->top - top - 0.5)), last = vc_min(height, vc_ceil(placed->bottom - top - 0.5));
    if (first >= last) return;
    memset(scratch->counts + first, 0, last - first);
    const double *points = scratch->points + 2 * placed->first;
    for (int i = 0; i < placed->corners; i++)
        cross(scratch, points + 2 * i, points + 2 * (i + 1 < placed->corners ? i + 1 : 0), top, first, last);
    for (int row = first; row < last; row++) {
        const double *columns = scratch->crossings + (size_t)row * VC_CROSSINGS;
        for (int i = 0; i + 1 < scratch->counts[row]; i += 2) {
            int left = columns[i] <= 0.0 ? 0 : columns[i] >= width ? width : vc_ceil(columns[i] - 0.5);
            int right = columns[i + 1] <= 0.0 ? 0 : columns[i + 1] >= width ? width : vc_ceil(columns[i + 1] - 0.5);
            if (right > left) memset(scratch->canvas + (size_t)row * width + left, placed->value, right - left);
        }
    }
}

/* Averages rows of samples to a row of values. */
static void average(const uint8_t *samples, int width, const vc_level *spec, uint16_t *sums, uint8_t *values) {
    const uint8_t *a = samples, *b = a + width, *c = b + width, *d = c + width;
    if (spec->fine_y == 2)
        for (int i = 0; i < width; i++) sums[i] = (uint16_t)(a[i] + b[i]);
    else
        for (int i = 0; i < width; i++) sums[i] = (uint16_t)(a[i] + b[i] + c[i] + d[i]);
    int shift = spec->fine_y == 2 ? 1 : 2;
    if (spec->fine_x == 2)
        for (int i = 0; i < spec->columns; i++)
            values[i] = (uint8_t)((sums[2 * i] + sums[2 * i + 1] + (1 << shift)) >> (shift + 1));
    else
        for (int i = 0; i < spec->columns; i++)
            values[i] = (uint8_t)((sums[4 * i] + sums[4 * i + 1] + sums[4 * i + 2] + sums[4 * i + 3] + (2 << shift)) >>
                                  (shift + 2));
}

/* (rows, columns) values of all polygons of one kind, in scratch->values. */
static void paint(Scratch *scratch, Nearby *nearby, const Outline *outline, const double *matrix, const vc_level *spec,
                  int rows, int outside) {
    collect(nearby, outline, spec->near_m);
    int count = place_all(scratch, nearby, outline, matrix, spec, rows), width = spec->columns * spec->fine_x;
    if (count == 0) {
        memset(scratch->values, outside, (size_t)rows * spec->columns);
        return;
    }
    for (int top = 0; top < rows; top += VC_STRIP) {
        int tall = vc_min(VC_STRIP, rows - top), height = tall * spec->fine_y;
        memset(scratch->canvas, outside, (size_t)height * width);
        for (int i = 0; i < count; i++) fill(scratch, scratch->placed + i, top * spec->fine_y, width, height);
        for (int row = 0; row < tall; row++)
            average(scratch->canvas + (size_t)row * spec->fine_y * width, width, spec, scratch->sums,
                    scratch->values + (size_t)(top + row) * spec->columns);
    }
}

void vc_paint_raster(vc_ground_part *ground, Level *level, const double *from_world, int rows,
                     uint32_t *texels) {
    const vc_level *spec = &level->spec;
    Scratch *scratch = &ground->scratch;
    VC_CHECK(rows <= spec->rows);
    size_t count = (size_t)rows * spec->columns;
    double to_world[9];
    vc_invert(from_world, to_world);
    Outline outline = outline_of(to_world, rows, spec->columns);
    paint(scratch, &level->paint, &outline, from_world, spec, rows, ground->outside);
    vc_add_grain(ground, spec, to_world, rows, scratch->values);
    for (size_t i = 0; i < count; i++) texels[i] = scratch->values[i];
    if (ground->shadows.count == 0) return;
    paint(scratch, &level->shadows, &outline, from_world, spec, rows, 0);
    for (size_t i = 0; i < count; i++) texels[i] |= (uint32_t)scratch->values[i] << VC_SHADOW_SHIFT;
}
