/* The camera's core: draws frames of one road, as one camera on a car sees it in one weather.
 *
 * Life: vc_new, then the content, each part once (vc_set_..., vc_add_...), then any number of frames, then vc_free.
 * A frame is a function of the content, the pose, the objects and the time. What is kept between frames is anchored to
 * the world, so that frames may be drawn in any order, and alone.
 *
 * Content is copied; the caller keeps its arrays. Only content calls and vc_reserve allocate; no call that draws does.
 * There is no global state: two cores may draw at once in two threads.
 *
 * Axes: world x, y, and up from the road; camera axes right, down, depth; image columns to the right, rows downwards,
 * (0, 0) is the middle of the first pixel. Yaw and headings grow from x to y. Lengths in m, angles in rad.
 * Geometry is computed in doubles without fused operations, pixels in integers: equal content gives equal frames with any
 * compiler and on any processor.
 */
#ifndef VC_CORE_H
#define VC_CORE_H

#include <stdint.h>

typedef enum {
    VC_OK = 0,
    VC_NO_MEMORY = -1,
    VC_INVALID = -2, /* a size or an index is out of its range */
} vc_status;

/* Everything that is drawn, and the memory to draw it. */
typedef struct vc_core vc_core;

/* (height, width, 3) RGB, rows without gaps. */
typedef struct {
    uint8_t *px;
    int width, height;
} vc_image;

typedef struct {
    int width_px, height_px;
    double fx_px, fy_px, cx_px, cy_px;
    double height_m;  /* above the road */
    double forward_m; /* ahead of the car's place */
    double pitch_rad; /* > 0 looks down */
    int ground_top;   /* the first row that shows the road */
} vc_camera;

/* Place of the car that carries the camera, and the time. */
typedef struct {
    double x_m, y_m, yaw_rad;
    int64_t time_us;
} vc_pose;

/* An object of a mesh, as vc_add_mesh numbers them, at a place; mesh -1 is not drawn. */
typedef struct {
    double x_m, y_m, heading_rad;
    int64_t mesh;
} vc_object;

/* ---- content ---- */

vc_core *vc_new(const vc_camera *camera); /* NULL without memory, or if the camera makes no sense */
void vc_free(vc_core *core);              /* also of NULL */

/* Polygons on the ground, in drawing order; even-odd inside. */
typedef struct {
    int count;
    const int32_t *starts;  /* (count + 1,) first point of each polygon, and the end */
    const double *points_m; /* (starts[count], 2) */
    const uint8_t *values;  /* (count,) palette value, or 255 for full shadow */
    const double *ranges_m; /* (count,) drawn up to this distance */
} vc_polygons;

/* Rows of the ground that a level draws, counted from `ground_top`. */
typedef struct {
    int first, last; /* `last` is excluded */
    int fineness;    /* sampled rows per image row, a power of 2 */
    int faded;       /* whether they are blended over the level before */
} vc_band;

/* A level of detail of the ground, and the raster of it that is kept.
 *
 * A steep level has an even lattice from above, in whole blocks of rows; any other one the image of a camera at an anchor
 * near by. Anchors and blocks are fixed to the world. */
typedef struct {
    int steep;
    int rows, columns;             /* of the raster; columns are a multiple of 8 */
    double near_m;                 /* polygons with a shorter range are left out */
    double across_m, along_m;      /* steep: size of a texel */
    double turn_rad;               /* between headings of anchors */
    double step, sidestep;         /* between anchors, ahead and aside: texels of a steep level, else m */
    double ahead_m, right_m;       /* steep: from the camera to the raster's nearest, leftmost texel */
    double phase;                  /* not steep: of the anchors, in steps */
    double to_texels[9];           /* not steep: from the anchor's pixels to texels */
    double depth_scale;            /* not steep: puts the near plane before the visible range */
    int fine_x, fine_y;            /* samples across and along a texel, 2 or 4 */
    int bands, weights;
    const vc_band *band;           /* (bands,) from the farthest row on */
    const uint8_t *weight;         /* (weights,) opacity of the faded rows from the first on, of 255 */
    double grain_from_world[3][9]; /* from the world to texels of the noise: fine, coarse, blotches */
    int gains;                     /* 1, or the raster's rows */
    const uint8_t *fineness;       /* (gains, 3) samples of each noise along a texel, by row */
    const float *gain;             /* (gains, 2) gains of grain and blotches, by row; 0 for none */
} vc_level;

/* What all levels share. */
typedef struct {
    const uint8_t *palette;   /* (256, 3) RGB of the palette values */
    int outside;              /* palette value beside all polygons */
    int shade;                /* brightness in full shadow, of 256 */
    const uint8_t *tiles;     /* (2, 1024, 1024) noise about 128, periodic: grain, blotches */
    const float *grain_gain;  /* (256,) strength of the grain by palette value */
    const float *blotch_gain; /* (256,) */
    int hazy_rows;            /* rows from the top of the ground that show haze */
    const uint8_t *haze;      /* (hazy_rows, 4) transmission of 255, and RGB of the air's light */
} vc_ground;

vc_status vc_set_ground(vc_core *core, const vc_ground *ground, const vc_polygons *paint, const vc_polygons *shadows);
vc_status vc_add_level(vc_core *core, const vc_level *level); /* the farthest first, after vc_set_ground */

/* Copies the texels of a level that the last frame used: (rows, columns) palette values, with shadow in the high half. */
int vc_raster_texels(const vc_core *core, int level); /* rows x columns, 0 without such a level */
vc_status vc_read_raster(const vc_core *core, int level, uint32_t *texels);

/* A panorama at infinity: columns by azimuth, rows by elevation. Texels in units of 1 / VC_TEXEL. */
enum { VC_TEXEL = 128 };
typedef struct {
    int top, bottom;          /* rows of the image that it fills */
    int coarse;               /* sampled on every `coarse`-th pixel each way and smoothed, a power of 2; 1 for all */
    int rows, columns;        /* of the panorama */
    const uint8_t *px;        /* (rows, columns, 3) RGB */
    double columns_per_rad;
    int h, w;                 /* sampled pixels */
    const int32_t *across;    /* (h, w) texels right of the yaw, of each of them */
    const int32_t *down;      /* (h, w) texels from the top */
} vc_panorama;

vc_status vc_add_panorama(vc_core *core, const vc_panorama *panorama); /* at most 2: the sky and its hills */

/* Light and haze of everything that rises from the ground.
 *
 * A face has the colour c (sky + direct max(0, n . sun)), then the haze of its distance. */
typedef struct {
    double horizon[3], sun[3], sky[3], direct[3];
    double contact;              /* brightness of the road right under an object, of 1 */
    double shadow;               /* the same in the sun's shadow; 1 for none */
    double fall_x, fall_y;       /* of the shadow of a point 1 m up */
    int transmissions;
    const double *transmission;  /* (transmissions,) at every VC_HAZE_STEP_M */
} vc_light;
#define VC_HAZE_STEP_M 0.25

vc_status vc_set_light(vc_core *core, const vc_light *light);

/* Flat convex faces in painter's order; corners that repeat the one before are left out. */
typedef struct {
    int count, corners;       /* corners per face, at most VC_CORNERS */
    const double *points_m;   /* (count, corners, 3) */
    const double *normals;    /* (count, 3) outwards */
    const double *colours;    /* (count, 3) RGB in full light */
    const uint8_t *flags;     /* (count,) of vc_flag */
} vc_faces;
enum { VC_CORNERS = 20 };
typedef enum { VC_LIT = 1, VC_RETRO = 2 } vc_flag; /* shaded by light; throws light back to where it comes from */

/* Furniture beside the road, in world axes. */
typedef struct {
    int items;
    const int32_t *first;    /* (items + 1,) first face of each item, and the end */
    const double *middles_m; /* (items, 2) */
    const double *radii_m;   /* (items,) */
    const double *from_m;    /* (faces,) depths at which a face is drawn */
    const double *until_m;   /* (faces,) */
    const double *fading;    /* (faces,) 1/m: opacity min(1, 1 / 0.15 - depth fading) */
} vc_roadside;

vc_status vc_set_roadside(vc_core *core, const vc_roadside *roadside, const vc_faces *faces);

/* A mesh in its object's axes: ahead, right, up. Returns its number, or a vc_status below 0. */
typedef struct {
    double length_m, width_m, height_m;
    const int32_t *parts;        /* (faces,) the convex part of each; the farthest part is drawn first */
    const double *thickness_m;   /* (faces,) extent across the longest side */
    int centres;
    const double *centres_m;     /* (centres, 3) of the parts */
} vc_mesh;

int vc_add_mesh(vc_core *core, const vc_mesh *mesh, const vc_faces *faces);

/* The picture of one kind of tree: premultiplied RGB and transparency, and ever smaller copies. */
typedef struct {
    double range_m;
    int levels;                /* at most VC_MIPS */
    const int32_t *sizes;      /* (levels, 2) rows, columns */
    const uint8_t *const *px;  /* (levels,) of (rows, columns, 4) */
    int hazes;                 /* by steps of 0.5 m */
    const double *haze;        /* (hazes, 5) factor of the colour, opacity, and RGB of the air's light */
} vc_tree;
enum { VC_MIPS = 8 };

vc_status vc_add_tree(vc_core *core, const vc_tree *tree);
/* (count, 7): x, y of the foot; left, top from it, width, height of the picture, m; kind of tree. */
vc_status vc_plant(vc_core *core, int count, const double *trees);

/* Light of lamps in the dark; by day there is none. Lux on a surface become an RGB factor by a table, at (i / scale)^2 lx.
 *
 * The two headlamps shine from `ahead_m` before the car's middle. The intensity of each by direction is that of
 * night/low_beam.py; street lamps shine straight down. */
typedef struct {
    double ahead_m, aside_m, height_m, nearest_m; /* of the headlamps; nothing nearer before them is lit */
    double peak_cd, above_cd, above_wide, above_tall;
    double dip, rise, highest, soft, offset;      /* of the cut-off */
    double narrow[2], wide[2], steep[2], shallow[2]; /* share and extent of the light, across and below the cut-off */
    double street_cd, street_range_m;
    double retro, leaves;        /* light thrown back by retroreflective faces, and by leaves, over a facing surface */
    double ground_gain;          /* the brightest palette colour over that of the palette */
    int lamps;
    const double *lamps_m;       /* (lamps, 3) street lamps */
    int factors;
    double factor_scale;
    const double *factor;        /* (factors, 3) */
    int columns;                 /* of the ground's light, evenly over the image's width */
    const double *ground;        /* (rows of the ground, columns, 3) ahead and right of the car's middle, and headlamps' lx */
} vc_lamps;

int vc_ground_rows(const vc_core *core); /* rows of the image that show the ground */
vc_status vc_set_lamps(vc_core *core, const vc_lamps *lamps); /* before the roadside */
/* The picture of a lamp, (size, size, 4), to be added around a point. Returns its number, or a vc_status below 0. */
int vc_add_glow(vc_core *core, int size, const uint8_t *px);

/* A lamp that shines into the camera, at a place of the image; drawn after an object, or with the scenery for -1. */
typedef struct {
    double x_px, y_px, depth_m;
    double flux, size_px, colour[3]; /* light in pixels of full brightness, diameter, linear RGB: for its mirror image */
    int64_t glow, object;
} vc_lamp;

/* Noise of the sensor, from which each frame takes another part: (rows, 3 columns) grey levels, larger than the image. */
vc_status vc_set_noise(vc_core *core, int rows, int columns, const int8_t *levels, uint64_t seed);

/* Reflections of the sky, and of what stands before it, on a wet road by day. They are worked out on a canvas of half the
 * image's resolution, from `ground_top` down to where they fade. */
typedef struct {
    int rows, columns;          /* of the canvas */
    const uint8_t *reflectance; /* (rows, columns) of a wet road, of 255 */
    const uint8_t *share;       /* (256,) wet share of the road by depth of the water, of 255 */
    int level;                  /* depth beyond which water stands; 255 for none */
    int smear;                  /* rows over which the facets of wet asphalt spread reflections, at most 255 */
    int ripple;                 /* rows by which drops move reflections in puddles */
    uint64_t seed;
} vc_wet_road;

vc_status vc_set_wet_road(vc_core *core, const vc_wet_road *wet);

/* Depths of water around a place, by cells; beside them the road is dry. They may be set again before any frame. */
typedef struct {
    int cells;
    const uint8_t *depths; /* (cells, cells), rows along y; 0 beside the road */
    double x_m, y_m;       /* middle of the first cell */
    double cell_m;
} vc_puddles;

vc_status vc_set_puddles(vc_core *core, const vc_puddles *puddles);

/* Spray behind moving objects on a wet road. */
typedef struct {
    double strength;        /* opacity of a dense puff in its middle */
    uint8_t colour[3];      /* RGB */
    int pictures, size;
    const uint8_t *opacity; /* (pictures, size, size) of puffs, of 255, with a transparent rim */
    uint64_t seed;
} vc_spray;

vc_status vc_set_spray(vc_core *core, const vc_spray *spray); /* after vc_set_light */

/* Makes room for frames with up to `objects` objects. */
vc_status vc_reserve(vc_core *core, int objects);

/* ---- frames ---- */

/* Sets the pose and finds what is visible; the calls below draw it. VC_INVALID beyond the objects of vc_reserve, and
 * beyond two lamps for each and all street lamps. */
vc_status vc_begin(vc_core *core, const vc_pose *pose, const vc_object *objects, int count, const vc_lamp *lamps,
                   int lamp_count);

/* Adds spray to what is visible; `speeds_mps` (count,) are those of the objects. After vc_begin. */
vc_status vc_begin_spray(vc_core *core, const double *speeds_mps, int count);

void vc_draw_backdrop(vc_core *core, vc_image image); /* sky, ground and haze: every pixel */
void vc_draw_wet_road(vc_core *core, vc_image image); /* reflections, between backdrop and scene */
void vc_draw_scene(vc_core *core, vc_image image);    /* shadows of the objects, and all that rises from the ground */
void vc_draw_noise(vc_core *core, vc_image image);

/* What a rolling shutter makes of a frame: from row to row the scene moves `shift_px` further to the left. */
void vc_read_out(const vc_core *core, double shift_px, vc_image from, vc_image to);

/* Writes what each pixel shows: 0 ground or sky, -1 scenery, i + 1 object i; and (height, width, 3) the plane there:
 * the inverse depth is its product with the ray (x, y, 1). */
void vc_truth(vc_core *core, int32_t *instance, double *planes);

/* (height, width) 1 where reflections or spray hide the scene of the last frame, else 0. */
void vc_hidden_by_rain(vc_core *core, int32_t *hidden);

#endif
