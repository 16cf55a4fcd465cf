/* Draws items. */
#include "rain/spray.h"
#include "scene.h"

enum { SMALL_PX = 1200 }; /* items with fewer pixels get 4 x 4 samples a pixel, others 2 x 2 */

static void fill(vc_core *core, const vc_item *item, int top, int wide, int tall, int fine) {
    const vc_frame *frame = &core->frame;
    for (int i = item->first; i < item->last; i++) {
        const vc_face *face = frame->faces + i;
        const double *points = frame->points + 2 * face->first;
        double moved[2 * VC_CLIPPED];
        for (int k = 0; k < face->corners; k++) {
            moved[2 * k] = (points[2 * k] - item->x0) * fine;
            moved[2 * k + 1] = (points[2 * k + 1] - top) * fine;
        }
        vc_layer_fill(&core->scene->layer, wide * fine, tall * fine, moved, face->corners, face->colour);
    }
}

static void paint_faces(vc_core *core, const vc_item *item, vc_image image) {
    int wide = item->x1 - item->x0, height = item->y1 - item->y0;
    int fine = wide * height < SMALL_PX ? 4 : 2;
    int rows = vc_max(1, (int)core->scene->layer.room / (wide * fine * fine));
    for (int top = item->y0; top < item->y1; top += rows) {
        int tall = vc_min(rows, item->y1 - top);
        fill(core, item, top, wide, tall, fine);
        uint8_t *px = image.px + ((size_t)top * image.width + item->x0) * 3;
        vc_layer_lay(&core->scene->layer, wide, tall, fine, px, (size_t)image.width * 3);
    }
}

void vc_paint_item(vc_core *core, const vc_item *item, vc_image image) {
    if (item->x0 >= item->x1 || item->y0 >= item->y1) return;
    if (item->kind == VC_TREE)
        vc_paint_tree(core, item, image, VC_DRAW);
    else if (item->kind == VC_GLOW)
        vc_paint_glow(core, item, image);
    else if (item->kind == VC_PUFF)
        vc_paint_puff(core, item, image, VC_DRAW);
    else
        paint_faces(core, item, image);
}

void vc_draw_scene(vc_core *core, vc_image image) {
    if (core->scene == NULL) return;
    vc_draw_shadows(core, image);
    for (int i = 0; i < core->frame.item_count; i++) vc_paint_item(core, core->frame.items + i, image);
}
