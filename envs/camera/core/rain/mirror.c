/* The sky and what stands before it, mirrored about the road. */
#include <math.h>
#include <string.h>

#include "rain/wet_road.h"
#include "scene.h"

enum {
    FACES = 18, TREES = 5, /* most that are mirrored */
    FADED = 64,            /* of 255; more transparent faces are not mirrored */
    LARGE_PX = 150,        /* least area of the box of a mirrored item */
    TREE_TALL_PX = 30,
    FINE = 2               /* samples per pixel of the canvas, each way */
};
#define OBJECTS_FIRST 4.0  /* weight of the area of an object's face over scenery */
#define SMALLEST_PX 20.0   /* least area of a mirrored face */
#define FOOT_M 0.4         /* height of an object's foot */
#define FOOT_SHARE 0.3     /* share of the way from the foot to the horizon that the object covers for sure */

void vc_mirror_sky(vc_core *core, vc_image image) {
    const vc_wet_part *wet = core->wet;
    int top = core->camera.ground_top, tall = vc_min(wet->spec.rows, top / VC_HALF);
    size_t stride = (size_t)image.width * 3, row_bytes = (size_t)wet->spec.columns * 3;
    for (int row = 0; row < wet->spec.rows; row++) {
        uint8_t *to = wet->sky + row * row_bytes;
        if (row >= tall) {
            memcpy(to, to - row_bytes, row_bytes);
            continue;
        }
        const uint8_t *a = image.px + (size_t)(top - 2 - 2 * row) * stride, *b = a + stride;
        for (int x = 0; x < wet->spec.columns; x++, a += 6, b += 6)
            for (int i = 0; i < 3; i++) *to++ = (uint8_t)((a[i] + a[i + 3] + b[i] + b[i + 3] + 2) >> 2);
    }
}

/* ---- trees ---- */

static int is_tall(const vc_item *item) { return item->kind == VC_TREE && item->y1 - item->y0 >= TREE_TALL_PX; }

/* Whether a tree is among the tallest; of equal ones the nearest, which come last. */
static int is_among_tallest(const vc_frame *frame, int index) {
    int taller = 0;
    const vc_item *own = frame->items + index;
    for (int i = 0; i < frame->item_count; i++) {
        if (i == index || !is_tall(frame->items + i)) continue;
        int tall = frame->items[i].y1 - frame->items[i].y0, difference = tall - (own->y1 - own->y0);
        taller += difference > 0 || (difference == 0 && i > index);
    }
    return taller < TREES;
}

/* The image row of the horizon, px from the image's corner. */
static double horizon(const vc_core *core) {
    const vc_view *view = &core->frame.view;
    return core->camera.cy_px + 0.5 - core->camera.fy_px * view->axes[2][2] / view->axes[1][2];
}

static void mirror_tree(vc_core *core, const vc_item *item) {
    const vc_wet_part *wet = core->wet;
    vc_image canvas = {wet->sharp, wet->spec.columns, wet->spec.rows};
    vc_picture picture;
    double box[4];
    int light[VC_HEIGHTS][3];
    vc_tree_picture(core, item, &picture, box, light);
    double foot = horizon(core) + core->camera.fy_px * core->camera.height_m / item->depth_m; /* the pitch is small */
    double top = 2.0 * foot - (box[1] + box[3]) - core->camera.ground_top;
    picture.upside_down = 1;
    vc_paint_picture(&picture, box[0] / VC_HALF, top / VC_HALF, box[2] / VC_HALF, box[3] / VC_HALF, canvas, VC_DRAW);
}

/* ---- faces ---- */

/* A face that may be mirrored. */
typedef struct {
    double area;
    int face;
    double plane[3];
} Large;

/* The area of the parallelogram of a face's first three corners, weighted; 0 if it is not mirrored. */
static double weight(const vc_core *core, const vc_item *item, const vc_face *face, double *plane) {
    const double *p = core->frame.points + 2 * face->first;
    if (face->colour >> 24 > FADED) return 0.0;
    double area = fabs((p[2] - p[0]) * (p[5] - p[1]) - (p[3] - p[1]) * (p[4] - p[0]));
    area *= item->instance > 0 ? OBJECTS_FIRST : 1.0;
    if (area <= SMALLEST_PX) return 0.0;
    vc_plane(core, item, face, plane);
    const vc_view *view = &core->frame.view;
    double up = plane[0] * view->axes[0][2] + plane[1] * view->axes[1][2] + plane[2] * view->axes[2][2];
    return 1.0 + 2.0 * core->camera.height_m * up > 0.0 ? area : 0.0; /* else it turns away from the mirrored camera */
}

/* Keeps the largest faces in their order; returns how many. */
static int keep(Large *kept, int count, const Large *found) {
    int least = 0;
    for (int i = 1; i < count; i++)
        if (kept[i].area < kept[least].area) least = i;
    if (count == FACES) {
        if (found->area <= kept[least].area) return count;
        memmove(kept + least, kept + least + 1, (size_t)(count - 1 - least) * sizeof *kept);
        count--;
    }
    kept[count] = *found;
    return count + 1;
}

static int find_large(const vc_core *core, Large *kept) {
    const vc_frame *frame = &core->frame;
    int count = 0;
    for (int i = 0; i < frame->item_count; i++) {
        const vc_item *item = frame->items + i;
        if (item->kind != VC_FACES || (item->x1 - item->x0) * (item->y1 - item->y0) <= LARGE_PX) continue;
        for (int k = item->first; k < item->last; k++) {
            Large found = {0.0, k, {0.0, 0.0, 0.0}};
            found.area = weight(core, item, frame->faces + k, found.plane);
            if (found.area > 0.0) count = keep(kept, count, &found);
        }
    }
    return count;
}

/* The mirror image of a pixel of a plane. With the inverse depth w = plane . ray the point is ray / w in the camera's
 * axes; mirrored about the road it is ray / w - 2 z up, with its height z = camera height + ray . up / w. Feet are
 * extended upwards by up to `foot_px`, into what the object itself covers, so that a blurred reflection stays dark at the
 * foot, as on a real road. */
static void mirrored(const vc_core *core, const double *plane, const double *point, double foot_px, double *image) {
    const vc_camera *c = &core->camera;
    const vc_view *view = &core->frame.view;
    double right = (point[0] - 0.5 - c->cx_px) / c->fx_px, down = (point[1] - 0.5 - c->cy_px) / c->fy_px;
    double up[3] = {view->axes[0][2], view->axes[1][2], view->axes[2][2]};
    double inverse = plane[0] * right + plane[1] * down + plane[2];
    double lift = c->height_m * inverse + up[0] * right + up[1] * down + up[2]; /* z w */
    double depth = 1.0 - 2.0 * up[2] * lift;
    image[0] = c->cx_px + 0.5 + c->fx_px * (right - 2.0 * up[0] * lift) / depth;
    image[1] = c->cy_px + 0.5 + c->fy_px * (down - 2.0 * up[1] * lift) / depth;
    if (lift < FOOT_M * inverse) image[1] -= fmin(foot_px, FOOT_SHARE * (image[1] - horizon(core)));
}

static void mirror_face(const vc_core *core, const Large *large) {
    vc_wet_part *wet = core->wet;
    const vc_face *face = core->frame.faces + large->face;
    double points[2 * VC_CLIPPED];
    for (int i = 0; i < face->corners; i++) {
        mirrored(core, large->plane, core->frame.points + 2 * (face->first + i), 0.5 * wet->spec.smear * VC_HALF, points + 2 * i);
        points[2 * i] *= (double)FINE / VC_HALF;
        points[2 * i + 1] = (points[2 * i + 1] - core->camera.ground_top) * FINE / VC_HALF;
    }
    vc_layer_fill(&wet->layer, wet->spec.columns * FINE, wet->spec.rows * FINE, points, face->corners, face->colour);
}

void vc_mirror_items(vc_core *core) {
    const vc_frame *frame = &core->frame;
    vc_wet_part *wet = core->wet;
    for (int i = 0; i < frame->item_count; i++)
        if (is_tall(frame->items + i) && is_among_tallest(frame, i)) mirror_tree(core, frame->items + i);
    Large large[FACES];
    int count = find_large(core, large);
    for (int i = 0; i < count; i++) mirror_face(core, large + i);
    vc_layer_lay(&wet->layer, wet->spec.columns, wet->spec.rows, FINE, wet->sharp, (size_t)wet->spec.columns * 3);
}
