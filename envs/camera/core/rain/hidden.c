/* Where rain hides the scene: reflections and spray, unless something stands before them. */
#include "rain/spray.h"
#include "rain/wet_road.h"
#include "scene.h"

/* Marks the pixels of an item with a label. */
static void mark(vc_core *core, const vc_item *item, uint32_t *labels, uint32_t label) {
    const vc_frame *frame = &core->frame;
    int width = core->camera.width_px, height = core->camera.height_px;
    vc_image size = {NULL, width, height};
    if (item->kind == VC_TREE) vc_paint_tree(core, item, size, (vc_labels){labels, label});
    if (item->kind == VC_PUFF) vc_paint_puff(core, item, size, (vc_labels){labels, label});
    for (int i = item->first; i < item->last && item->kind == VC_FACES; i++)
        vc_fill_convex(labels, width, height, frame->points + 2 * frame->faces[i].first, frame->faces[i].corners, label,
                       NULL);
}

void vc_hidden_by_rain(vc_core *core, int32_t *hidden) {
    vc_mark_reflections(core, hidden);
    for (int i = 0; i < core->frame.item_count; i++) {
        const vc_item *item = core->frame.items + i;
        mark(core, item, (uint32_t *)hidden, item->kind == VC_PUFF);
    }
}
