/* What the files of the scene share: everything that rises from the ground. */
#ifndef VC_SCENE_H
#define VC_SCENE_H

#include "internal.h"
#include "layer.h"

enum {
    VC_CLIPPED = 2 * VC_CORNERS, /* most corners of a face that the near plane cuts */
    VC_ORDERED = 256,            /* nearest objects whose order is exact */
    VC_SHADOW_FACES = 8,
    VC_LAYER = 1 << 16           /* samples of a layer, at least 4 rows */
};

/* Faces with their repeated corners left out. */
typedef struct {
    int count;
    int32_t *starts;   /* (count + 1,) */
    double *points_m;  /* (n, 3) */
    double *normals;   /* (count, 3) */
    double *offsets_m; /* (count,) of the planes */
    double *colours;   /* (count, 3) RGB in full light; of the roadside by day, contrasts with the horizon */
    double *middles_m; /* (count, 3) of the bounding boxes */
    uint8_t *flags;
} Faces;

typedef struct {
    double length_m, width_m, height_m, reach_m;
    Faces faces;         /* part by part */
    double *thickness_m; /* (faces,) */
    int parts;
    int32_t *part_first; /* (parts + 1,) */
    double *centres_m;   /* (parts, 3) */
} Mesh;

typedef struct {
    int items;
    int32_t *first;
    double *circles_m; /* (items, 3) middle and radius */
    double *from_m, *until_m, *fading;
    Faces faces;
} Roadside;

/* Something in view, before the order is known. */
typedef struct {
    double depth_m; /* of its middle; of an object, of its nearest corner */
    vc_kind kind;
    int index;
} Candidate;

/* The footprint of an object from the camera: its corners in order, and the bearings (right over depth) that it spans. */
typedef struct {
    double corners[4][2];
    double left, right;
} Box;

struct vc_scene_part {
    vc_light light;
    Roadside roadside;
    int meshes;
    Mesh *mesh;
    int reserved; /* objects */
    vc_object *objects;
    vc_lamp *lamps;
    int lamp_room;
    Candidate *candidates;  /* of scenery */
    int *order, order_count; /* objects in view, in drawing order */
    double *distance_m;      /* (order_count,) */
    double *nearest_m;       /* (objects,) depths of the nearest corners of those in view */
    Box *boxes;              /* (VC_ORDERED,) */
    uint8_t *in_front;      /* (VC_ORDERED, VC_ORDERED) */
    int face_room, point_room, item_room;
    double *part_distance; /* (most parts of a mesh,) */
    int *part_order;
    vc_layer layer; /* VC_LAYER samples, or 4 rows of the image */
};

/* Makes the pools of a frame large enough for all content. */
vc_status vc_make_room(vc_core *core);
/* Finds the objects in view and their drawing order. */
void vc_order_objects(vc_core *core);
/* Finds the trees in view; returns how many candidates were written. */
int vc_find_trees(const vc_core *core, Candidate *candidates);
int vc_tree_count(const vc_core *core);
/* The box of a tree in the image; 0 if it is empty. */
int vc_tree_box(const vc_core *core, int tree, double depth_m, vc_item *item);
/* The picture of a tree, and where it lies: left, top, width, height in px from the corner; `light` is room for its light
 * by lamps, NULL for none. */
void vc_tree_picture(const vc_core *core, const vc_item *item, vc_picture *picture, double *box, int light[VC_HEIGHTS][3]);
void vc_paint_tree(const vc_core *core, const vc_item *item, vc_image image, vc_labels labels);
void vc_draw_shadows(vc_core *core, vc_image image);

/* Finds the street lamps near the view. */
void vc_begin_lamps(vc_core *core);
int vc_lamp_room(const vc_core *core); /* most lamps that shine into the camera from street lamps */
/* The RGB factors in the light of lamps of a face with a normal at a point, in world axes, or of leaves (normal NULL). */
void vc_lamplight(const vc_core *core, const double *point, const double *normal, int flags, double *factors);
int vc_glow_count(const vc_core *core);
int vc_glow_box(const vc_core *core, int lamp, vc_item *item);
void vc_paint_glow(const vc_core *core, const vc_item *item, vc_image image);

/* Contrast with the horizon of a face by day; the sun in the axes of the face. May be written over its colour. */
void vc_shade(const vc_light *light, const double *sun, const Faces *faces, int index, double *contrast);
/* Premultiplied colour and transparency of a face: contrast with the horizon, through the haze at a depth. */
uint32_t vc_hazed(const vc_light *light, const double *contrast, double depth_m, double opacity);
/* An item while its faces are added, and their bounds. */
typedef struct {
    vc_item item;
    double left, top, right, bottom;
} vc_growing;

vc_growing vc_item_begin(const vc_core *core, int instance, double depth_m);
/* Projects a face (n, 3) by a (3, 4) matrix and adds it, unless it lies beside the image or behind the camera. */
void vc_item_add(vc_core *core, vc_growing *growing, const double *projection, const double *points_m, int count,
                 vc_face face);
int vc_item_end(const vc_core *core, vc_growing *growing); /* completes growing->item; 0 if it has no faces */

/* Projects a polygon (n, 3) by a (3, 4) matrix to px from the image's corner; returns the corners, 0 behind the camera. */
int vc_project(const double *projection, const double *points, int count, double *px);
#endif
