/* Spray: soft puffs that leave the wheels of moving objects one after the other, move at half their speed, widen and
 * fade. The plume is as wide as the object and about half as high. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "rain/spray.h"
#include "scene.h"
#include "vc_math.h"
#include "vc_random.h"

#define SLOWEST_MPS 4.0 /* spray starts here, and is full at FULL_MPS */
#define FULL_MPS 11.0
#define LIFE_S 0.9 /* of a puff */
#define NEAREST_M 2.5
#define RANGE_M 70.0
enum { KEYS = 101 }; /* between the random numbers of two objects */

typedef struct {
    int object, picture;
    double depth_m, box[4]; /* left, top, width, height, px from the image's corner */
    int opacity;            /* of 256 */
} Puff;

struct vc_spray_part {
    double strength;
    int pictures, size;
    uint8_t *px; /* (pictures, size, size, 4) premultiplied colour and transparency */
    uint64_t seed;
    int room, count;
    Puff *puffs;
};

void vc_spray_free(vc_spray_part *spray) {
    if (spray == NULL) return;
    free(spray->px);
    free(spray->puffs);
    free(spray);
}

vc_status vc_set_spray(vc_core *core, const vc_spray *from) {
    if (core->spray != NULL || from->pictures < 1 || from->size < 2) return VC_INVALID;
    vc_spray_part *spray = core->spray = calloc(1, sizeof *spray);
    if (spray == NULL) return VC_NO_MEMORY;
    size_t pixels = (size_t)from->pictures * from->size * from->size;
    spray->strength = from->strength;
    spray->pictures = from->pictures;
    spray->size = from->size;
    spray->seed = from->seed;
    spray->px = malloc(pixels * 4);
    if (spray->px == NULL) return VC_NO_MEMORY;
    for (size_t i = 0; i < pixels; i++) {
        for (int k = 0; k < 3; k++) spray->px[4 * i + k] = (uint8_t)vc_by_255((uint32_t)from->opacity[i] * from->colour[k]);
        spray->px[4 * i + 3] = (uint8_t)(255 - from->opacity[i]);
    }
    return core->scene == NULL ? VC_OK : vc_make_room(core);
}

int vc_spray_room(vc_core *core, int objects) {
    vc_spray_part *spray = core->spray;
    if (spray == NULL) return 0;
    free(spray->puffs);
    spray->room = VC_PUFFS * objects;
    spray->count = 0;
    spray->puffs = malloc(((size_t)spray->room + 1) * sizeof *spray->puffs);
    return spray->puffs == NULL ? -1 : spray->room;
}

static double depth_of(const vc_view *view, const double *place) {
    double x = place[0] - view->centre[0], y = place[1] - view->centre[1];
    return view->axes[2][0] * x + view->axes[2][1] * y - view->axes[2][2] * view->centre[2];
}

/* Places a puff of a size on the road at a point of the world; returns whether it is in the image. */
static int place(const vc_core *core, const double *foot, double wide_m, double tall_m, double opacity, Puff *puff) {
    const vc_view *view = &core->frame.view;
    const vc_camera *c = &core->camera;
    double depth = depth_of(view, foot), x = foot[0] - view->centre[0], y = foot[1] - view->centre[1];
    if (!(depth > NEAREST_M && depth < RANGE_M)) return 0;
    double right = view->axes[0][0] * x + view->axes[0][1] * y;
    double down = view->axes[1][0] * x + view->axes[1][1] * y - view->axes[1][2] * view->centre[2];
    puff->depth_m = depth;
    puff->box[2] = c->fx_px * wide_m / depth;
    puff->box[3] = c->fy_px * tall_m / depth;
    puff->box[0] = c->cx_px + 0.5 + c->fx_px * right / depth - 0.5 * puff->box[2];
    puff->box[1] = c->cy_px + 0.5 + c->fy_px * down / depth - puff->box[3];
    puff->opacity = vc_round(256.0 * opacity * fmin(1.0, (depth - NEAREST_M) / NEAREST_M));
    return puff->box[0] < c->width_px && puff->box[1] < c->height_px && puff->box[0] + puff->box[2] > 0.0 &&
           puff->box[1] + puff->box[3] > 0.0;
}

/* x^0.7 for 0 <= x <= 1. */
static double fade(double x) { return x > 1e-9 ? vc_exp(0.7 * vc_log(x)) : 0.0; }

/* One of an object's puffs; returns whether it is in the image. */
static int make(const vc_core *core, int object, int number, double speed_mps, double strength, Puff *puff) {
    const vc_spray_part *spray = core->spray;
    const vc_object *at = core->frame.objects + object;
    const Mesh *mesh = core->scene->mesh + at->mesh;
    double lives = 1e-6 * (double)core->frame.pose.time_us / LIFE_S + (double)number / VC_PUFFS + 0.37 * object;
    double age = lives - floor(lives);
    vc_random random = vc_stream(spray->seed, ((int64_t)floor(lives) * VC_PUFFS + number) * KEYS + object);
    double tall = (0.5 * mesh->height_m + 0.3) * (0.6 + 0.8 * age) * (0.8 + 0.4 * vc_uniform(&random));
    double opacity = strength * fmin(1.0, 6.0 * age) * fade(1.0 - age) * (0.7 + 0.6 * vc_uniform(&random));
    double behind = 0.45 * mesh->length_m + 0.5 * speed_mps * LIFE_S * age;
    double foot[2] = {at->x_m - behind * vc_cos(at->heading_rad), at->y_m - behind * vc_sin(at->heading_rad)};
    puff->object = object;
    puff->picture = (int)(vc_next(&random) % (uint64_t)spray->pictures);
    return place(core, foot, mesh->width_m * (0.9 + 0.5 * age), tall, fmin(opacity, 1.0), puff);
}

static int is_farther(const Puff *one, const Puff *other) { return one->depth_m > other->depth_m; }

/* Adds the puffs of an object, the farthest first. */
static void make_all(vc_core *core, int object, double speed_mps) {
    vc_spray_part *spray = core->spray;
    double strength = spray->strength * fmin(1.0, (speed_mps - SLOWEST_MPS) / (FULL_MPS - SLOWEST_MPS));
    if (strength <= 0.0) return;
    int first = spray->count;
    for (int number = 0; number < VC_PUFFS; number++) {
        Puff puff;
        if (!make(core, object, number, speed_mps, strength, &puff)) continue;
        int at = spray->count++;
        VC_INDEX(at, spray->room);
        for (; at > first && is_farther(&puff, spray->puffs + at - 1); at--) spray->puffs[at] = spray->puffs[at - 1];
        spray->puffs[at] = puff;
    }
}

static vc_item item_of(const vc_core *core, int index) {
    const double *box = core->spray->puffs[index].box;
    int width = core->camera.width_px, height = core->camera.height_px;
    vc_item item = {VC_PUFF, -1, index, index, 0, 0, 0, 0, core->spray->puffs[index].depth_m};
    item.x0 = vc_floor(vc_limit(box[0], 0.0, width));
    item.y0 = vc_floor(vc_limit(box[1], 0.0, height));
    item.x1 = vc_ceil(vc_limit(box[0] + box[2], 0.0, width));
    item.y1 = vc_ceil(vc_limit(box[1] + box[3], 0.0, height));
    return item;
}

/* Inserts the puffs, which are in the order of their objects, before and behind these. */
static void insert(vc_core *core) {
    vc_frame *frame = &core->frame;
    const vc_spray_part *spray = core->spray;
    int left = spray->count, to = frame->item_count + left;
    for (int from = frame->item_count - 1; left > 0; from--) {
        vc_item item = frame->items[from];
        int object = item.instance - 1;
        if (object < 0 || spray->puffs[left - 1].object != object) {
            frame->items[--to] = item;
            continue;
        }
        double middle = depth_of(&frame->view, &frame->objects[object].x_m);
        while (left > 0 && spray->puffs[left - 1].object == object && spray->puffs[left - 1].depth_m <= middle)
            frame->items[--to] = item_of(core, --left);
        frame->items[--to] = item;
        while (left > 0 && spray->puffs[left - 1].object == object) frame->items[--to] = item_of(core, --left);
    }
    frame->item_count += spray->count;
}

vc_status vc_begin_spray(vc_core *core, const double *speeds_mps, int count) {
    vc_frame *frame = &core->frame;
    if (core->spray == NULL || core->spray->strength <= 0.0) return VC_OK;
    if (count != frame->object_count) return VC_INVALID;
    core->spray->count = 0;
    for (int i = 0; i < frame->item_count; i++) {
        int object = frame->items[i].instance - 1;
        if (object >= 0) make_all(core, object, speeds_mps[object]);
    }
    insert(core);
    return VC_OK;
}

void vc_paint_puff(const vc_core *core, const vc_item *item, vc_image image, vc_labels labels) {
    const vc_spray_part *spray = core->spray;
    VC_INDEX(item->first, spray->count);
    const Puff *puff = spray->puffs + item->first;
    const double *box = puff->box;
    vc_picture picture = {spray->px + (size_t)puff->picture * spray->size * spray->size * 4, spray->size, spray->size,
                          puff->opacity, puff->opacity, {0, 0, 0}, NULL, 0};
    vc_paint_picture(&picture, box[0], box[1], box[2], box[3], image, labels);
}
