/* Draws pictures with transparency into the image. */
#include <string.h>

#include "internal.h"

enum { SHIFT = 16 };
#define NOTHING 0xff000000u /* transparent */

/* Samples along one axis: pixels from `first` to `last`, and texels of 1 / 2^SHIFT. */
typedef struct {
    int first, last;
    int32_t from, step;
} Axis;

/* Only pixels whose four texels exist are drawn: pictures have a transparent rim. */
static Axis axis_of(double start, double extent, int texels, int limit) {
    double scale = texels / extent;
    Axis axis = {vc_clamp(start <= 0.0 ? 0 : vc_floor(vc_limit(start, 0.0, limit)), 0, limit),
                 vc_clamp(vc_ceil(vc_limit(start + extent, 0.0, limit)), 0, limit), 0, 0};
    axis.step = (int32_t)(vc_limit(scale, 0.0, 4096.0) * (1 << SHIFT));
    double place = ((axis.first + 0.5 - start) * scale - 0.5) * (1 << SHIFT);
    axis.from = (int32_t)vc_limit(place, -1e9, 1e9);
    for (; axis.first < axis.last && axis.from < 0; axis.first++) axis.from += axis.step;
    int64_t end = (int64_t)(texels - 1) << SHIFT;
    while (axis.last > axis.first && axis.from + (int64_t)axis.step * (axis.last - 1 - axis.first) >= end) axis.last--;
    return axis;
}

static uint32_t load(const uint8_t *px) {
    return px[0] | (uint32_t)px[1] << 8 | (uint32_t)px[2] << 16 | (uint32_t)px[3] << 24;
}

static uint32_t between(uint32_t a, uint32_t b, uint32_t share) {
    uint32_t even = (((a & 0xff00ffu) * (256 - share) + (b & 0xff00ffu) * share + 0x800080u) >> 8) & 0xff00ffu;
    uint32_t odd = ((a >> 8 & 0xff00ffu) * (256 - share) + (b >> 8 & 0xff00ffu) * share + 0x800080u) & 0xff00ff00u;
    return even | odd;
}

/* Changes a sample as the picture asks for. */
static uint32_t changed(const vc_picture *picture, uint32_t sample) {
    uint32_t cover = 255 - (sample >> 24);
    uint32_t colour = (255 - ((cover * (uint32_t)picture->opacity + 128) >> 8)) << 24;
    for (int i = 0; i < 3; i++) {
        uint32_t level = (((sample >> (8 * i)) & 255) * (uint32_t)picture->factor + 128) >> 8;
        level += vc_by_255((uint32_t)picture->air[i] * cover);
        colour |= (level > 255 ? 255 : level) << (8 * i);
    }
    return colour;
}

/* The factors of a row, between those of the heights. */
static void light_of(const vc_picture *picture, int32_t v, int *factors) {
    int place = (int)(((int64_t)v * VC_HEIGHTS * 256 / picture->rows) >> SHIFT) - 128; /* of 256, from the first height */
    int above = vc_clamp(place >> 8, 0, VC_HEIGHTS - 1), below = vc_min(above + 1, VC_HEIGHTS - 1);
    int share = place < 0 ? 0 : place & 255;
    for (int i = 0; i < 3; i++)
        factors[i] = (picture->light[above][i] * (256 - share) + picture->light[below][i] * share) >> 8;
}

static uint32_t lit(uint32_t sample, const int *factors) {
    uint32_t colour = sample & 0xff000000u;
    for (int i = 0; i < 3; i++) {
        uint32_t level = (((sample >> (8 * i)) & 255) * (uint32_t)factors[i]) >> 8;
        colour |= (level > 255 ? 255 : level) << (8 * i);
    }
    return colour;
}

/* Lays a premultiplied sample over a pixel. */
static inline void lay(uint32_t sample, uint8_t *px) {
    uint32_t through = sample >> 24;
    for (int i = 0; i < 3; i++, sample >>= 8) {
        uint32_t level = (sample & 255) + (through > 0 ? vc_by_255(px[i] * through) : 0);
        px[i] = (uint8_t)(level > 255 ? 255 : level);
    }
}

/* The bilinear sample at a texel and its fractions of 1 / 256. */
static uint32_t sample(const uint8_t *at, size_t stride, uint32_t share_x, uint32_t share_y) {
    uint32_t a = load(at), b = load(at + 4), c = load(at + stride), d = load(at + stride + 4);
    if ((a & b & c & d) == NOTHING && ((a | b | c | d) & ~NOTHING) == 0) return NOTHING;
    return between(between(a, b, share_x), between(c, d, share_x), share_y);
}

void vc_paint_picture(const vc_picture *picture, double left, double top, double wide, double tall, vc_image image,
                      vc_labels labels) {
    int is_plain = picture->factor == 256 && picture->opacity == 256 && !(picture->air[0] | picture->air[1] | picture->air[2]);
    Axis across = axis_of(left, wide, picture->columns, image.width), down = axis_of(top, tall, picture->rows, image.height);
    size_t stride = (size_t)picture->columns * 4;
    int32_t v = down.from;
    for (int y = down.first; y < down.last; y++, v += down.step) {
        int32_t texel = picture->upside_down ? ((picture->rows - 1) << SHIFT) - v : v;
        const uint8_t *row = picture->px + (size_t)(texel >> SHIFT) * stride;
        size_t at = (size_t)y * image.width + across.first;
        int32_t u = across.from;
        int factors[3] = {256, 256, 256};
        if (picture->light != NULL) light_of(picture, texel, factors);
        for (int x = across.first; x < across.last; x++, u += across.step, at++) {
            uint32_t share_x = (uint32_t)(u >> (SHIFT - 8)) & 255, share_y = (uint32_t)(texel >> (SHIFT - 8)) & 255;
            uint32_t found = sample(row + 4 * (u >> SHIFT), stride, share_x, share_y);
            if (labels.px != NULL) {
                if (changed(picture, found) >> 24 < 128) labels.px[at] = labels.label;
            } else if (found != NOTHING) {
                if (picture->light != NULL) found = lit(found, factors);
                lay(is_plain ? found : changed(picture, found), image.px + 3 * at);
            }
        }
    }
}
