/* What each pixel of a frame shows, from the items that were drawn. */
#include <string.h>

#include "scene.h"

/* Labels: 0 for ground and sky, then all faces, then all items that are pictures. */
static void label_item(vc_core *core, int index, uint32_t *labels) {
    const vc_frame *frame = &core->frame;
    const vc_item *item = frame->items + index;
    int width = core->camera.width_px, height = core->camera.height_px;
    if (item->kind == VC_GLOW) return; /* light hides nothing */
    if (item->kind == VC_PUFF) return; /* what it hides is still there */
    if (item->kind == VC_TREE) {
        vc_labels to = {labels, (uint32_t)(1 + frame->face_count + index)};
        vc_paint_tree(core, item, (vc_image){NULL, width, height}, to);
        return;
    }
    for (int i = item->first; i < item->last; i++) {
        const vc_face *face = frame->faces + i;
        vc_fill_convex(labels, width, height, frame->points + 2 * face->first, face->corners, (uint32_t)(1 + i),
                       NULL);
    }
}

/* The instance and the plane of a label. */
static int32_t resolve(const vc_core *core, uint32_t label, double *plane) {
    const vc_frame *frame = &core->frame;
    const vc_view *view = &frame->view;
    if (label == 0) {
        for (int i = 0; i < 3; i++) plane[i] = -view->axes[i][2] / view->centre[2];
        return 0;
    }
    int is_face = label <= (uint32_t)frame->face_count;
    const vc_item *item = frame->items + (is_face ? frame->faces[label - 1].item : (int)label - 1 - frame->face_count);
    if (is_face) {
        vc_plane(core, item, frame->faces + label - 1, plane);
    } else { /* pictures face the camera */
        plane[0] = plane[1] = 0.0;
        plane[2] = 1.0 / item->depth_m;
    }
    return item->instance;
}

void vc_truth(vc_core *core, int32_t *instance, double *planes) {
    size_t count = (size_t)core->camera.width_px * core->camera.height_px;
    uint32_t *labels = (uint32_t *)instance, last = 0;
    memset(labels, 0, count * sizeof *labels);
    for (int i = 0; i < core->frame.item_count; i++) label_item(core, i, labels);
    double plane[3];
    int32_t shown = resolve(core, 0, plane);
    for (size_t i = 0; i < count; i++) {
        if (labels[i] != last) {
            last = labels[i];
            shown = resolve(core, last, plane);
        }
        instance[i] = shown;
        memcpy(planes + 3 * i, plane, sizeof plane);
    }
}
