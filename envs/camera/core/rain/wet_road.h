/* What the files of the wet road share.
 *
 * The reflection is worked out on a canvas of half the image's resolution, from the first row of the ground on.
 * A facet of the water that is tilted by s moves a distant reflection by 2 f s up or down, and hardly sideways: so it is
 * sharp in puddles, and smeared along the line of sight elsewhere. */
#ifndef VC_WET_ROAD_H
#define VC_WET_ROAD_H

#include "internal.h"
#include "layer.h"

enum {
    VC_HALF = 2,    /* image pixels per pixel of the canvas */
    VC_GAMMA = 1024 /* entries of a table of grey levels */
};

/* A row of the canvas as wide as the image, (3 width,) each, times 4. */
typedef struct {
    uint16_t *through, *light;
} vc_wide;

struct vc_wet_part {
    vc_wet_road spec; /* with copies of its arrays */
    double corner_m[2], cell_m;
    int cells;
    uint8_t *depths;             /* (cells, cells) of the puddles */
    uint8_t *sky;                /* (rows, columns, 3) the mirrored sky */
    uint8_t *sharp, *smeared;    /* the same with what stands before it, as in puddles, and smeared */
    uint8_t *light;              /* the same: the reflected light */
    uint8_t *kept;               /* the same, scratch */
    uint8_t *share, *through;    /* (rows, columns) reflected light, and the road's own that is left, of 255 */
    uint8_t *standing;           /* (rows, columns) whether water stands */
    vc_layer layer;              /* for mirrored faces */
    uint16_t *sums;              /* (3 columns,) */
    vc_wide wide[2];
    float *lamplight;            /* (rows, columns, 3) linear light of mirrored lamps */
    uint8_t gamma[VC_GAMMA];     /* grey levels by the root of linear light */
};

/* Fills `sky` from a picture of sky and ground. */
void vc_mirror_sky(vc_core *core, vc_image image);
/* Draws the largest items of the frame mirrored over `sharp`. */
void vc_mirror_items(vc_core *core);
/* Adds the mirror images of the frame's lamps to `light`, after vc_find_water. */
void vc_add_lamp_streaks(vc_core *core);
void vc_fill_gamma(uint8_t *levels); /* (VC_GAMMA,) */
/* Marks the pixels (height, width) where the last frame's reflections hide the road by 1, others by 0. */
void vc_mark_reflections(vc_core *core, int32_t *hidden);
/* Fills `share`, `through` and `standing`. */
void vc_find_water(vc_core *core);

#endif
