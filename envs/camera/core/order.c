/* Drawing order of objects: one in front of another comes later, whatever their depths. */
#include <string.h>

#include "scene.h"
#include "vc_math.h"

#define RANGE_M 220.0
#define SHADOW_REACH 4.0 /* longest shadows, in heights */
#define ON_EDGE_M 1e-6
#define EYE_M 1e-9
#define ANYWHERE 1e9     /* bearing of what reaches beside the camera */

static Box box_of(const vc_core *core, int index) {
    const vc_object *object = core->scene->objects + index;
    const Mesh *mesh = core->scene->mesh + object->mesh;
    const vc_view *view = &core->frame.view;
    double c = vc_cos(object->heading_rad), s = vc_sin(object->heading_rad);
    double x = object->x_m - view->centre[0], y = object->y_m - view->centre[1];
    Box box = {.left = ANYWHERE, .right = -ANYWHERE};
    for (int i = 0; i < 4; i++) {
        double along = (i < 2 ? -0.5 : 0.5) * mesh->length_m, across = (i == 0 || i == 3 ? -0.5 : 0.5) * mesh->width_m;
        double *corner = box.corners[i];
        corner[0] = x + along * c - across * s;
        corner[1] = y + along * s + across * c;
        double depth = view->cos_yaw * corner[0] + view->sin_yaw * corner[1];
        double right = view->cos_yaw * corner[1] - view->sin_yaw * corner[0];
        double low = depth > VC_NEAR_M ? right / depth : -ANYWHERE, high = depth > VC_NEAR_M ? right / depth : ANYWHERE;
        if (low < box.left) box.left = low;
        if (high > box.right) box.right = high;
    }
    return box;
}

/* Whether another box lies wholly beyond an edge of a box, with the camera outside of that edge, or inside. */
static int is_beyond(const Box *of, const Box *other, int eye_outside) {
    double x = 0.25 * (of->corners[0][0] + of->corners[1][0] + of->corners[2][0] + of->corners[3][0]);
    double y = 0.25 * (of->corners[0][1] + of->corners[1][1] + of->corners[2][1] + of->corners[3][1]);
    for (int i = 0; i < 4; i++) {
        const double *a = of->corners[i], *b = of->corners[(i + 1) & 3];
        double nx = b[1] - a[1], ny = a[0] - b[0], offset = nx * a[0] + ny * a[1];
        if (nx * x + ny * y > offset) {
            nx = -nx;
            ny = -ny;
            offset = -offset;
        }
        if ((offset < -EYE_M) != eye_outside) continue; /* the camera is at (0, 0) */
        int beyond = 1;
        for (int k = 0; k < 4; k++) beyond &= nx * other->corners[k][0] + ny * other->corners[k][1] >= offset - ON_EDGE_M;
        if (beyond) return 1;
    }
    return 0;
}

/* Whether `a` may cover `b`: an edge of one separates them, and the one on the camera's side of it is in front. */
static int is_in_front(const Box *a, const Box *b) {
    if (a->left >= b->right || b->left >= a->right) return 0;
    return is_beyond(a, b, 0) || is_beyond(b, a, 1);
}

/* Whether an object or its shadow may show. */
static int may_show(const vc_core *core, const vc_object *object) {
    const vc_view *view = &core->frame.view;
    if (object->mesh < 0) return 0;
    const Mesh *mesh = core->scene->mesh + object->mesh;
    double x = object->x_m - view->centre[0], y = object->y_m - view->centre[1];
    double ahead = view->cos_yaw * x + view->sin_yaw * y, aside = view->cos_yaw * y - view->sin_yaw * x;
    double reach = mesh->length_m + mesh->width_m + SHADOW_REACH * mesh->height_m;
    double wide = 0.5 * core->camera.width_px / core->camera.fx_px * (ahead + reach) + reach;
    return mesh->faces.count > 0 && ahead < RANGE_M && ahead > -reach && aside < wide && aside > -wide;
}

/* Depth of the nearest corner of the footprint. */
static double nearest_of(const vc_core *core, const vc_object *object) {
    const double *axis = core->frame.view.axes[2], *eye = core->frame.view.centre;
    const Mesh *mesh = core->scene->mesh + object->mesh;
    double c = vc_cos(object->heading_rad), s = vc_sin(object->heading_rad);
    double along = axis[0] * c + axis[1] * s, across = axis[1] * c - axis[0] * s;
    double half = 0.5 * mesh->length_m * (along < 0.0 ? -along : along) + 0.5 * mesh->width_m * (across < 0.0 ? -across : across);
    return axis[0] * (object->x_m - eye[0]) + axis[1] * (object->y_m - eye[1]) - half;
}

/* Finds the objects in view, the farthest first. */
static void find(vc_core *core) {
    vc_scene_part *scene = core->scene;
    scene->order_count = 0;
    for (int i = 0; i < core->frame.object_count; i++) {
        const vc_object *object = scene->objects + i;
        if (!may_show(core, object)) continue;
        double x = object->x_m - core->frame.view.centre[0], y = object->y_m - core->frame.view.centre[1];
        double distance = vc_hypot(x, y);
        int at = scene->order_count++;
        for (; at > 0 && scene->distance_m[at - 1] < distance; at--) {
            scene->order[at] = scene->order[at - 1];
            scene->distance_m[at] = scene->distance_m[at - 1];
        }
        scene->order[at] = i;
        scene->distance_m[at] = distance;
        scene->nearest_m[i] = nearest_of(core, object);
    }
}

/* Notes which of n objects are in front of which; returns whether any are. */
static int compare(vc_core *core, const int *objects, int n, int *blockers) {
    vc_scene_part *scene = core->scene;
    Box *boxes = scene->boxes;
    int any = 0;
    for (int i = 0; i < n; i++) boxes[i] = box_of(core, objects[i]);
    for (int i = 0; i < n; i++) {
        blockers[i] = 0;
        for (int j = 0; j < n; j++) {
            int front = i != j && is_in_front(boxes + i, boxes + j);
            scene->in_front[i * VC_ORDERED + j] = (uint8_t)front;
            blockers[i] += front;
            any |= front;
        }
    }
    return any;
}

/* Sorts n objects, given the farthest first, so that none comes before one that it is in front of. */
static void sort(vc_core *core, int *objects, int n) {
    int blockers[VC_ORDERED], sorted[VC_ORDERED];
    if (!compare(core, objects, n, blockers)) return;
    for (int k = 0; k < n; k++) {
        int free = -1;
        for (int i = 0; i < n && (free < 0 || blockers[free] != 0); i++)
            if (objects[i] >= 0 && (free < 0 || blockers[i] == 0)) free = i;
        sorted[k] = objects[free];
        objects[free] = -1;
        for (int i = 0; i < n; i++) blockers[i] -= core->scene->in_front[i * VC_ORDERED + free];
    }
    memcpy(objects, sorted, (size_t)n * sizeof *objects);
}

void vc_order_objects(vc_core *core) {
    find(core);
    int exact = vc_min(core->scene->order_count, VC_ORDERED);
    sort(core, core->scene->order + core->scene->order_count - exact, exact);
}
