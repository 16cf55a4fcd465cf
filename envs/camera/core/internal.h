/* What the files of the core share: the view of a frame, what is visible in it, and the core itself. */
#ifndef VC_INTERNAL_H
#define VC_INTERNAL_H

#include <stddef.h>
#include <stdint.h>

#include "core.h"

/* In a debug build a failed check stops the program; otherwise checks cost nothing. */
#ifdef VC_DEBUG
#include <stdio.h>
#include <stdlib.h>
#define VC_CHECK(condition) \
    ((condition) ? (void)0 : (fprintf(stderr, "%s:%d: %s\n", __FILE__, __LINE__, #condition), abort()))
#else
#define VC_CHECK(condition) ((void)0)
#endif
#define VC_INDEX(index, count) VC_CHECK((index) >= 0 && (index) < (count))

#define VC_NEAR_M 0.5 /* near plane */

static inline int vc_min(int a, int b) { return a < b ? a : b; }
static inline int vc_max(int a, int b) { return a > b ? a : b; }
static inline int vc_clamp(int value, int low, int high) { return value < low ? low : value > high ? high : value; }
static inline double vc_limit(double value, double low, double high) {
    return value < low ? low : value > high ? high : value;
}

/* Whole numbers next to values between -2e9 and 2e9. */
static inline int vc_floor(double value) {
    int whole = (int)value;
    return whole - (whole > value);
}
static inline int vc_ceil(double value) {
    int whole = (int)value;
    return whole + (whole < value);
}
static inline int vc_round(double value) { return vc_floor(value + 0.5); }

/* value / 255 rounded, for 0 <= value <= 65535. */
static inline uint32_t vc_by_255(uint32_t value) { return ((value + 128) * 257) >> 16; }

/* The camera at a pose. */
typedef struct {
    double centre[3];      /* in the world */
    double axes[3][3];     /* right, down, depth */
    double projection[12]; /* (3, 4) from (x, y, up, 1) to (column, row, 1) times the depth */
    double yaw_rad, cos_yaw, sin_yaw;
} vc_view;

void vc_view_at(const vc_camera *camera, double x_m, double y_m, double yaw_rad, vc_view *view);
/* (3, 3) from pixels (x, y, 1) to homogeneous points of the road; the last is the camera's height over the depth. */
void vc_ground_homography(const vc_camera *camera, const vc_view *view, double *matrix);
void vc_multiply(const double *a, const double *b, double *product); /* (3, 3) each; product may be a or b */
void vc_invert(const double *matrix, double *inverse);               /* (3, 3) each; may be the same */
/* Clips a polygon (n, 3) to a last coordinate above VC_NEAR_M; returns the corners written, at most 2 n. */
int vc_clip(const double *corners, int count, double *clipped);

/* ---- what a frame shows ---- */

/* A projected face. */
typedef struct {
    int item;              /* in vc_frame.items */
    int first, corners;    /* in vc_frame.points */
    uint32_t colour;       /* R, G, B from the lowest byte on, times the opacity, and the transparency of 255 */
    const double *normal;  /* (3,) in the axes of its item */
    double distance_m;     /* of the camera from its plane */
} vc_face;

typedef enum { VC_FACES, VC_TREE, VC_GLOW, VC_PUFF } vc_kind;

/* Something that is drawn as one, in its box. */
typedef struct {
    vc_kind kind;
    int instance;            /* -1 scenery, i + 1 object i */
    int first, last;         /* faces in vc_frame.faces; of a tree, lamp or puff, `first` is its number */
    int x0, y0, x1, y1;      /* box in px, within the image */
    double depth_m;          /* of its middle; of an object, of its nearest corner */
} vc_item;

typedef struct {
    vc_pose pose;
    vc_view view;
    const vc_object *objects; /* copied */
    int object_count;
    const vc_lamp *lamps; /* copied */
    int lamp_count;
    vc_item *items; /* in drawing order after vc_begin, the farthest first */
    int item_count;
    vc_face *faces;
    int face_count;
    double *points; /* (n, 2) px, (0, 0) the upper left CORNER of the image */
    int point_count;
} vc_frame;

/* The plane of a face: its inverse depth is plane . (x, y, 1) at a pixel's ray. */
void vc_plane(const vc_core *core, const vc_item *item, const vc_face *face, double *plane);
/* Draws an item over a picture. */
void vc_paint_item(vc_core *core, const vc_item *item, vc_image image);

/* ---- the core ---- */

/* The parts of a core, each private to the file of its name; NULL until its content is set. */
typedef struct vc_ground_part vc_ground_part;
typedef struct vc_sky_part vc_sky_part;
typedef struct vc_scene_part vc_scene_part;
typedef struct vc_tree_part vc_tree_part;
typedef struct vc_lamps_part vc_lamps_part;
typedef struct vc_wet_part vc_wet_part;
typedef struct vc_spray_part vc_spray_part;
typedef struct vc_noise_part vc_noise_part;

struct vc_core {
    vc_camera camera;
    vc_frame frame;
    vc_ground_part *ground;
    vc_sky_part *sky;
    vc_scene_part *scene;
    vc_tree_part *trees;
    vc_lamps_part *lamps;
    vc_wet_part *wet;
    vc_spray_part *spray;
    vc_noise_part *noise;
};

void vc_ground_free(vc_ground_part *part);
void vc_sky_free(vc_sky_part *part);
void vc_scene_free(vc_scene_part *part);
void vc_tree_free(vc_tree_part *part);
void vc_lamps_free(vc_lamps_part *part);
void vc_wet_free(vc_wet_part *part);
void vc_spray_free(vc_spray_part *part);
void vc_noise_free(vc_noise_part *part);

/* A copy of `count` elements of `size` bytes each, with room for `spare` bytes more; NULL without memory. */
void *vc_copied(const void *from, size_t count, size_t size, size_t spare);

/* ---- drawing ---- */

/* Columns of a row, `last` excluded. */
typedef struct {
    int first, last;
} vc_extent;

/* Fills a convex polygon (n, 2): the pixels whose middles lie inside; (0, 0) is the corner of the canvas. Widens the
 * extents of the rows by what is filled, unless they are NULL. */
void vc_fill_convex(uint32_t *canvas, int width, int height, const double *points, int count, uint32_t value,
                    vc_extent *extents);

/* Draws a picture (rows, columns, 4) of premultiplied RGB and transparency over the image, in the box of real numbers
 * that begins at `left`, `top` (px from the image's corner) and is `wide`, `tall`, with bilinear samples. The picture is
 * changed before: colours times `factor` (of 256) plus `air`, and opacity times `opacity` (of 256). */
typedef struct {
    const uint8_t *px;
    int rows, columns;
    int factor, opacity;
    int air[3];
    const int (*light)[3]; /* (VC_HEIGHTS,) RGB factors of 256 before, from the top down; NULL for none */
    int upside_down;
} vc_picture;
enum { VC_HEIGHTS = 8 };

/* Where pixels are marked that a picture hides by more than half, instead of drawing it; NULL to draw. */
typedef struct {
    uint32_t *px, label;
} vc_labels;
#define VC_DRAW ((vc_labels){NULL, 0})

void vc_paint_picture(const vc_picture *picture, double left, double top, double wide, double tall, vc_image image,
                      vc_labels labels);

/* Applies the light of lamps to a row of the ground. */
void vc_light_row(vc_core *core, int row, uint8_t *px);

void vc_draw_sky(vc_core *core, vc_image image);
void vc_draw_ground(vc_core *core, vc_image image);

#endif
