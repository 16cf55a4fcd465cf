/* What the files of the ground share. */
#ifndef VC_GROUND_H
#define VC_GROUND_H

#include "internal.h"

enum {
    VC_LEVELS = 16,
    VC_SLOTS = 2,      /* rasters kept by level: a camera that sways between two anchors paints neither anew */
    VC_TILE = 1024,    /* texels of noise */
    VC_STRIDE = 1040,  /* of a stored row of noise: the first texels are repeated at its end */
    VC_SHADOW_SHIFT = 16,
    VC_POLYGON = 64    /* most corners of a polygon */
};

/* Polygons with their bounding circles. */
typedef struct {
    int count;
    int32_t *starts;
    double *points_m, *ranges_m, *circles_m; /* circles: (count, 3) middle and radius */
    uint8_t *values;
} Polygons;

/* The polygons that may touch rasters near a place. */
typedef struct {
    const Polygons *polygons;
    int32_t *close;
    int count;
    double x_m, y_m, reach_m;
} Nearby;

/* Texels of the ground: palette values, and shadow from VC_SHADOW_SHIFT on. */
typedef struct {
    int valid;
    int64_t heading, ahead, right; /* the anchor, in turns, steps and sidesteps */
    int64_t used;                  /* the frame that used it last */
    double from_world[9];          /* (3, 3) from points (x, y, 1) m to homogeneous (column, row) of texels */
    uint32_t *texels;
} Raster;

typedef struct {
    vc_level spec; /* with copies of its arrays */
    Raster slots[VC_SLOTS];
    const Raster *now;
    Nearby paint, shadows;
} Level;

/* A polygon in samples of a raster. */
typedef struct {
    int first, corners;
    double top, bottom;
    uint8_t value;
} Placed;

/* Memory to paint rasters, as large as the largest one needs. */
typedef struct {
    uint8_t *canvas;     /* VC_STRIP rows of texels */
    uint8_t *values;     /* (rows, columns) */
    uint16_t *sums;      /* a row of the canvas */
    double *crossings;   /* (rows of the canvas, VC_CROSSINGS) */
    uint8_t *counts;     /* (rows of the canvas,) */
    Placed *placed;
    double *points;      /* (n, 2) */
    float *grain[3], *strength[2]; /* with a sample before the first and one after the last */
    uint32_t *noise;
} Scratch;
enum { VC_STRIP = 32, VC_CROSSINGS = 16 };

struct vc_ground_part {
    uint32_t palette[256];
    int outside, shade, hazy_rows;
    uint8_t *haze, *tiles; /* tiles: (2, VC_TILE + 1, VC_STRIDE) */
    float grain_gain[256], blotch_gain[256];
    Polygons paint, shadows;
    int levels;
    Level level[VC_LEVELS];
    Scratch scratch;
    int64_t frame;
    uint32_t *row[3]; /* (width,) each: sampled texels */
};

/* Makes the rasters of all levels ready for the view. */
void vc_update_rasters(vc_core *core);
/* Paints `rows` rows of a raster from texels on. */
void vc_paint_raster(vc_ground_part *ground, Level *level, const double *from_world, int rows,
                     uint32_t *texels);
/* Adds the grain to (rows, columns) palette values. */
void vc_add_grain(vc_ground_part *ground, const vc_level *spec, const double *to_world, int rows,
                  uint8_t *values);
#endif
