/* Trees: upright pictures that face the camera. */
#include <stdlib.h>
#include <string.h>

#include "scene.h"

#define NEAREST_M 4.0
#define HAZE_M 0.5
enum { KINDS = 64, HAZE = 5, TREE = 7 };

typedef struct {
    double range_m;
    int levels, hazes;
    int rows[VC_MIPS], columns[VC_MIPS];
    uint8_t *px[VC_MIPS];
    double *haze;
} Kind;

struct vc_tree_part {
    int kinds, count;
    Kind kind[KINDS];
    double *trees; /* (count, TREE) */
};

void vc_tree_free(vc_tree_part *trees) {
    if (trees == NULL) return;
    for (int i = 0; i < trees->kinds; i++) {
        for (int level = 0; level < trees->kind[i].levels; level++) free(trees->kind[i].px[level]);
        free(trees->kind[i].haze);
    }
    free(trees->trees);
    free(trees);
}

vc_status vc_add_tree(vc_core *core, const vc_tree *from) {
    if (core->trees == NULL) core->trees = calloc(1, sizeof *core->trees);
    vc_tree_part *trees = core->trees;
    if (trees == NULL) return VC_NO_MEMORY;
    if (trees->kinds == KINDS || from->levels < 1 || from->levels > VC_MIPS || from->hazes < 1) return VC_INVALID;
    Kind *kind = trees->kind + trees->kinds++;
    kind->range_m = from->range_m;
    kind->hazes = from->hazes;
    kind->haze = vc_copied(from->haze, (size_t)from->hazes * HAZE, sizeof(double), 0);
    int memory = kind->haze != NULL;
    for (int i = 0; i < from->levels; i++) {
        kind->rows[i] = from->sizes[2 * i];
        kind->columns[i] = from->sizes[2 * i + 1];
        kind->px[i] = vc_copied(from->px[i], (size_t)kind->rows[i] * kind->columns[i], 4, 0);
        memory &= kind->px[i] != NULL;
        kind->levels = i + 1;
    }
    return memory ? VC_OK : VC_NO_MEMORY;
}

vc_status vc_plant(vc_core *core, int count, const double *trees) {
    vc_tree_part *part = core->trees;
    if (part == NULL || part->trees != NULL || core->scene == NULL || count < 0) return VC_INVALID;
    for (int i = 0; i < count; i++)
        if (trees[TREE * i + 6] < 0.0 || trees[TREE * i + 6] >= part->kinds) return VC_INVALID;
    part->trees = vc_copied(trees, (size_t)count * TREE, sizeof(double), 0);
    if (part->trees == NULL) return VC_NO_MEMORY;
    part->count = count;
    return vc_make_room(core);
}

int vc_tree_count(const vc_core *core) { return core->trees == NULL ? 0 : core->trees->count; }

static const Kind *kind_of(const vc_tree_part *trees, int index) {
    VC_INDEX(index, trees->count);
    return trees->kind + (int)trees->trees[TREE * index + 6];
}

int vc_find_trees(const vc_core *core, Candidate *candidates) {
    const vc_view *view = &core->frame.view;
    const double *ahead = view->axes[2], *right = view->axes[0];
    double slope = 0.5 * core->camera.width_px / core->camera.fx_px;
    int count = 0;
    for (int i = 0; i < vc_tree_count(core); i++) {
        const double *tree = core->trees->trees + TREE * i;
        double x = tree[0] - view->centre[0], y = tree[1] - view->centre[1];
        double depth = ahead[0] * x + ahead[1] * y - ahead[2] * view->centre[2];
        if (depth <= NEAREST_M || depth >= kind_of(core->trees, i)->range_m) continue;
        double left = right[0] * x + right[1] * y + tree[2], wide = slope * depth;
        if (left >= wide || left + tree[4] <= -wide) continue;
        Candidate found = {depth, VC_TREE, i};
        candidates[count++] = found;
    }
    return count;
}

/* Where a tree's picture lies: left, top, width, height in px from the image's corner. */
static void place(const vc_core *core, int index, double depth_m, double *box) {
    const vc_view *view = &core->frame.view;
    const double *tree = core->trees->trees + TREE * index, *down = view->axes[1], *right = view->axes[0];
    double x = tree[0] - view->centre[0], y = tree[1] - view->centre[1];
    double scale_x = core->camera.fx_px / depth_m, scale_y = core->camera.fy_px / depth_m;
    double foot = down[0] * x + down[1] * y - down[2] * view->centre[2];
    box[0] = core->camera.cx_px + 0.5 + scale_x * (right[0] * x + right[1] * y + tree[2]);
    box[1] = core->camera.cy_px + 0.5 + scale_y * (foot + tree[3]);
    box[2] = scale_x * tree[4];
    box[3] = scale_y * tree[5];
}

int vc_tree_box(const vc_core *core, int tree, double depth_m, vc_item *item) {
    double box[4];
    place(core, tree, depth_m, box);
    double right = box[0] + box[2], bottom = box[1] + box[3];
    int width = core->camera.width_px, height = core->camera.height_px;
    if (right <= 0.0 || bottom <= 0.0 || box[0] >= width || box[1] >= height) return 0;
    item->x0 = box[0] <= 0.0 ? 0 : vc_floor(box[0]);
    item->y0 = box[1] <= 0.0 ? 0 : vc_floor(box[1]);
    item->x1 = right >= width ? width : vc_ceil(right);
    item->y1 = bottom >= height ? height : vc_ceil(bottom);
    return item->x0 < item->x1 && item->y0 < item->y1;
}

/* The light of lamps on a tree, which falls off upwards: factors of 256 at even heights of its picture. */
static void light_heights(const vc_core *core, int index, double depth_m, const double *box, int light[VC_HEIGHTS][3]) {
    const double *tree = core->trees->trees + TREE * index;
    double down_up = core->frame.view.axes[1][2], depth_up = core->frame.view.axes[2][2]; /* of the camera's axes */
    for (int i = 0; i < VC_HEIGHTS; i++) {
        double y = box[1] + (i + 0.5) / VC_HEIGHTS * box[3] - 0.5 - core->camera.cy_px, factors[3];
        double up = core->camera.height_m + depth_m * (y / core->camera.fy_px * down_up + depth_up);
        double point[3] = {tree[0], tree[1], up};
        if (point[2] < 0.0) point[2] = 0.0;
        vc_lamplight(core, point, NULL, 0, factors);
        for (int j = 0; j < 3; j++) light[i][j] = vc_round(256.0 * factors[j]);
    }
}

void vc_tree_picture(const vc_core *core, const vc_item *item, vc_picture *picture, double *box, int light[VC_HEIGHTS][3]) {
    const Kind *kind = kind_of(core->trees, item->first);
    place(core, item->first, item->depth_m, box);
    int level = 0;
    while (level + 1 < kind->levels && kind->rows[level] >= 2.0 * box[3]) level++;
    const double *haze = kind->haze + HAZE * vc_min(kind->hazes - 1, vc_floor(item->depth_m / HAZE_M));
    *picture = (vc_picture){kind->px[level], kind->rows[level], kind->columns[level],
                            vc_round(256.0 * haze[0]), vc_round(256.0 * haze[1]),
                            {vc_round(haze[2]), vc_round(haze[3]), vc_round(haze[4])}, NULL, 0};
    if (core->lamps == NULL || light == NULL) return;
    light_heights(core, item->first, item->depth_m, box, light);
    picture->light = light;
}

void vc_paint_tree(const vc_core *core, const vc_item *item, vc_image image, vc_labels labels) {
    vc_picture picture;
    double box[4];
    int light[VC_HEIGHTS][3];
    vc_tree_picture(core, item, &picture, box, labels.px == NULL ? light : NULL);
    vc_paint_picture(&picture, box[0], box[1], box[2], box[3], image, labels);
}
