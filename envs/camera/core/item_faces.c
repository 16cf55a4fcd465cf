/* Projects the faces of an item into a frame, one after the other. */
#include "scene.h"

#define FARTHEST_PX 1e6 /* corners are limited to it */

int vc_project(const double *projection, const double *points, int count, double *px) {
    double corners[3 * VC_CORNERS], clipped[6 * VC_CORNERS];
    const double *kept = corners, *p = projection;
    int inside = 0;
    for (int i = 0; i < count; i++) {
        const double *at = points + 3 * i;
        for (int j = 0; j < 3; j++)
            corners[3 * i + j] = p[4 * j] * at[0] + p[4 * j + 1] * at[1] + p[4 * j + 2] * at[2] + p[4 * j + 3];
        inside += corners[3 * i + 2] > VC_NEAR_M;
    }
    if (inside == 0) return 0;
    if (inside < count) {
        count = vc_clip(corners, count, clipped);
        kept = clipped;
    }
    for (int i = 0; i < count; i++) {
        double scale = 1.0 / kept[3 * i + 2];
        px[2 * i] = vc_limit(kept[3 * i] * scale + 0.5, -FARTHEST_PX, FARTHEST_PX);
        px[2 * i + 1] = vc_limit(kept[3 * i + 1] * scale + 0.5, -FARTHEST_PX, FARTHEST_PX);
    }
    return count;
}

vc_growing vc_item_begin(const vc_core *core, int instance, double depth_m) {
    int faces = core->frame.face_count;
    vc_growing growing = {{VC_FACES, instance, faces, faces, 0, 0, 0, 0, depth_m},
                          FARTHEST_PX, FARTHEST_PX, -FARTHEST_PX, -FARTHEST_PX};
    return growing;
}

void vc_item_add(vc_core *core, vc_growing *growing, const double *projection, const double *points_m, int count,
                 vc_face face) {
    vc_frame *frame = &core->frame;
    VC_CHECK(frame->face_count < core->scene->face_room);
    VC_CHECK(frame->point_count + count + 2 <= core->scene->point_room);
    double *px = frame->points + 2 * frame->point_count;
    face.first = frame->point_count;
    face.corners = vc_project(projection, points_m, count, px);
    if (face.corners == 0) return;
    double left = px[0], right = px[0], top = px[1], bottom = px[1];
    for (int i = 1; i < face.corners; i++) {
        double x = px[2 * i], y = px[2 * i + 1];
        left = x < left ? x : left;
        right = x > right ? x : right;
        top = y < top ? y : top;
        bottom = y > bottom ? y : bottom;
    }
    if (right <= 0.0 || left >= core->camera.width_px || bottom <= 0.0 || top >= core->camera.height_px) return;
    growing->left = left < growing->left ? left : growing->left;
    growing->right = right > growing->right ? right : growing->right;
    growing->top = top < growing->top ? top : growing->top;
    growing->bottom = bottom > growing->bottom ? bottom : growing->bottom;
    frame->faces[frame->face_count++] = face;
    frame->point_count += face.corners;
}

int vc_item_end(const vc_core *core, vc_growing *growing) {
    vc_item *item = &growing->item;
    int width = core->camera.width_px, height = core->camera.height_px;
    item->last = core->frame.face_count;
    if (item->first == item->last) return 0;
    item->x0 = growing->left <= 0.0 ? 0 : vc_floor(growing->left);
    item->y0 = growing->top <= 0.0 ? 0 : vc_floor(growing->top);
    item->x1 = growing->right >= width ? width : vc_min(width, vc_floor(growing->right) + 1);
    item->y1 = growing->bottom >= height ? height : vc_min(height, vc_floor(growing->bottom) + 1);
    return 1;
}
