/* Draws items: their faces fill a finer layer without blending, and its means are laid over the image. */
#include "rain/spray.h"
#include "scene.h"

enum { SMALL_PX = 1200 }; /* items with fewer pixels get 4 x 4 samples a pixel, others 2 x 2 */
#define EMPTY 0xff000000u /* transparent */

/* The sums of each byte of a pixel's samples: red and blue in one word, green and transparency in the other. */
typedef struct {
    uint32_t red_blue, green_through;
} Sums;

static inline Sums sum(const uint32_t *samples, int stride, int fine) {
    Sums sums = {0, 0};
    for (int j = 0; j < fine; j++)
        for (int i = 0; i < fine; i++) {
            uint32_t sample = samples[(size_t)j * stride + i];
            sums.red_blue += sample & 0xff00ffu;
            sums.green_through += (sample >> 8) & 0xff00ffu;
        }
    return sums;
}

/* Lays the mean of each pixel's samples over a row of the image. */
static inline void blend_row(const uint32_t *samples, int wide, int fine, int shift, uint8_t *px) {
    uint32_t half = (1u << shift) / 2;
    for (int x = 0; x < wide; x++, px += 3) {
        Sums sums = sum(samples + x * fine, wide * fine, fine);
        uint32_t through = ((sums.green_through >> 16) + half) >> shift;
        if (through == 255) continue;
        uint32_t colour[3] = {sums.red_blue & 0xffffu, sums.green_through & 0xffffu, sums.red_blue >> 16};
        for (int c = 0; c < 3; c++) {
            uint32_t level = (colour[c] + half) >> shift;
            if (through > 0) level += vc_by_255(px[c] * through);
            px[c] = (uint8_t)(level > 255 ? 255 : level);
        }
    }
}

static void blend(const uint32_t *layer, int wide, int tall, int fine, uint8_t *px, int stride) {
    for (int y = 0; y < tall; y++, px += stride) {
        const uint32_t *samples = layer + (size_t)y * fine * wide * fine;
        if (fine == 2) /* each with constants, which the compiler unrolls */
            blend_row(samples, wide, 2, 2, px);
        else
            blend_row(samples, wide, 4, 4, px);
    }
}

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
        vc_fill_convex(core->scene->layer, wide * fine, tall * fine, moved, face->corners, face->colour);
    }
}

static void paint_faces(vc_core *core, const vc_item *item, vc_image image) {
    int wide = item->x1 - item->x0, height = item->y1 - item->y0;
    int fine = wide * height < SMALL_PX ? 4 : 2;
    int rows = vc_max(1, core->scene->layer_samples / (wide * fine * fine));
    for (int top = item->y0; top < item->y1; top += rows) {
        int tall = vc_min(rows, item->y1 - top);
        size_t samples = (size_t)wide * fine * tall * fine;
        VC_CHECK(samples <= (size_t)core->scene->layer_samples);
        for (size_t i = 0; i < samples; i++) core->scene->layer[i] = EMPTY;
        fill(core, item, top, wide, tall, fine);
        blend(core->scene->layer, wide, tall, fine, image.px + ((size_t)top * image.width + item->x0) * 3, image.width * 3);
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
