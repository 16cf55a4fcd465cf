/* Faces on a canvas that is finer than the image, where they hide each other without blending; its means are then laid
 * over the image. */
#include "layer.h"

#include <stdlib.h>

#define EMPTY 0xff000000u /* transparent */
static const vc_extent NOTHING = {1 << 30, 0};

int vc_layer_make(vc_layer *layer, size_t samples, size_t rows) {
    layer->room = samples;
    layer->rows = rows;
    layer->samples = malloc((samples + 1) * sizeof *layer->samples);
    layer->extents = malloc((rows + 1) * sizeof *layer->extents);
    if (layer->samples == NULL || layer->extents == NULL) return 0;
    for (size_t i = 0; i < samples; i++) layer->samples[i] = EMPTY;
    for (size_t i = 0; i < rows; i++) layer->extents[i] = NOTHING;
    return 1;
}

void vc_layer_free(vc_layer *layer) {
    free(layer->samples);
    free(layer->extents);
}

void vc_layer_fill(vc_layer *layer, int wide, int tall, const double *points, int count, uint32_t colour) {
    VC_CHECK((size_t)wide * tall <= layer->room && (size_t)tall <= layer->rows);
    vc_fill_convex(layer->samples, wide, tall, points, count, colour, layer->extents);
}

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

/* Lays the mean of a pixel's samples over it. */
static inline void lay(const uint32_t *samples, int stride, int fine, uint8_t *px) {
    uint32_t area = (uint32_t)(fine * fine), half = area / 2;
    Sums sums = sum(samples, stride, fine);
    uint32_t through = ((sums.green_through >> 16) + half) / area;
    if (through == 255) return;
    uint32_t colour[3] = {sums.red_blue & 0xffffu, sums.green_through & 0xffffu, sums.red_blue >> 16};
    for (int c = 0; c < 3; c++) {
        uint32_t level = (colour[c] + half) / area;
        if (through > 0) level += vc_by_255(px[c] * through);
        px[c] = (uint8_t)(level > 255 ? 255 : level);
    }
}

/* What is filled in any of some rows. */
static inline vc_extent union_of(const vc_extent *extents, int rows) {
    vc_extent all = extents[0];
    for (int i = 1; i < rows; i++) {
        all.first = vc_min(all.first, extents[i].first);
        all.last = vc_max(all.last, extents[i].last);
    }
    return all;
}

/* `fine` is a constant wherever it is called, so that the compiler unrolls what depends on it. */
static inline void lay_all(vc_layer *layer, int wide, int tall, int fine, uint8_t *px, size_t stride) {
    uint32_t *samples = layer->samples;
    vc_extent *extents = layer->extents;
    for (int y = 0; y < tall; y++, px += stride, samples += wide * fine * fine, extents += fine) {
        vc_extent filled = union_of(extents, fine);
        for (int x = filled.first / fine; x < (filled.last + fine - 1) / fine; x++)
            lay(samples + x * fine, wide * fine, fine, px + 3 * x);
        for (int row = 0; row < fine; row++) {
            for (int x = filled.first; x < filled.last; x++) samples[row * wide * fine + x] = EMPTY;
            extents[row] = NOTHING;
        }
    }
}

void vc_layer_lay(vc_layer *layer, int wide, int tall, int fine, uint8_t *px, size_t stride) {
    if (fine == 2)
        lay_all(layer, wide, tall, 2, px, stride);
    else
        lay_all(layer, wide, tall, 4, px, stride);
}
