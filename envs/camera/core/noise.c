/* Temporal noise of the sensor: each strip of the image takes another part of one bank. */
#include <stdlib.h>

#include "internal.h"
#include "vc_random.h"

enum { STRIPS = 4 };

struct vc_noise_part {
    int rows, columns;
    int8_t *levels; /* (rows, 3 columns) */
    uint64_t seed;
};

void vc_noise_free(vc_noise_part *noise) {
    if (noise == NULL) return;
    free(noise->levels);
    free(noise);
}

vc_status vc_set_noise(vc_core *core, int rows, int columns, const int8_t *levels, uint64_t seed) {
    int strip = (core->camera.height_px + STRIPS - 1) / STRIPS;
    if (core->noise != NULL || rows < strip || columns < core->camera.width_px) return VC_INVALID;
    vc_noise_part *noise = core->noise = calloc(1, sizeof *noise);
    if (noise == NULL) return VC_NO_MEMORY;
    noise->rows = rows;
    noise->columns = columns;
    noise->seed = seed;
    noise->levels = vc_copied(levels, (size_t)rows * columns, 3, 0);
    return noise->levels == NULL ? VC_NO_MEMORY : VC_OK;
}

void vc_draw_noise(vc_core *core, vc_image image) {
    const vc_noise_part *noise = core->noise;
    if (noise == NULL) return;
    int strip = (image.height + STRIPS - 1) / STRIPS, bytes = 3 * image.width;
    uint64_t tick = vc_mix(noise->seed ^ vc_mix((uint64_t)core->frame.pose.time_us));
    for (int y = 0; y < image.height; y++) {
        uint64_t chance = vc_mix(tick + (uint64_t)(y / strip));
        int down = (int)(chance % (uint64_t)(noise->rows - strip + 1)) + y % strip;
        int across = (int)((chance >> 32) % (uint64_t)(noise->columns - image.width + 1));
        VC_INDEX(down, noise->rows);
        const int8_t *levels = noise->levels + ((size_t)down * noise->columns + across) * 3;
        uint8_t *px = image.px + (size_t)y * bytes;
        for (int i = 0; i < bytes; i++) {
            int16_t level = (int16_t)(px[i] + levels[i]);
            level = level > 0 ? level : 0;
            px[i] = (uint8_t)(level < 255 ? level : 255);
        }
    }
}
