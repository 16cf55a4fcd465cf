/* Panoramas at infinity, which turn with the yaw. */
#include <stdlib.h>
#include <string.h>

#include "internal.h"

enum { PANORAMAS = 2 };

typedef struct {
    vc_panorama spec; /* with copies of its arrays */
    int h, w;         /* sampled pixels */
} Panorama;

struct vc_sky_part {
    int count;
    Panorama panorama[PANORAMAS];
    uint8_t *rows[2]; /* sampled rows, stretched to the image's width */
    uint8_t *row;     /* a sampled row */
};

void vc_sky_free(vc_sky_part *sky) {
    if (sky == NULL) return;
    for (int i = 0; i < sky->count; i++) {
        free((void *)sky->panorama[i].spec.px);
        free((void *)sky->panorama[i].spec.across);
        free((void *)sky->panorama[i].spec.down);
    }
    free(sky->rows[0]);
    free(sky->rows[1]);
    free(sky->row);
    free(sky);
}

static vc_sky_part *new_sky(int width) {
    vc_sky_part *sky = calloc(1, sizeof *sky);
    if (sky == NULL) return NULL;
    for (int i = 0; i < 2; i++) sky->rows[i] = malloc((size_t)width * 3);
    sky->row = malloc((size_t)width * 3);
    if (sky->rows[0] && sky->rows[1] && sky->row) return sky;
    vc_sky_free(sky);
    return NULL;
}

static int makes_sense(const vc_camera *camera, const vc_panorama *spec, int h, int w) {
    if (spec->top < 0 || spec->bottom <= spec->top || spec->bottom > camera->height_px) return 0;
    if (spec->coarse < 1 || spec->rows < 2 || spec->columns < 2 || spec->columns > 1 << 20) return 0;
    for (int i = 0; i < h * w; i++) {
        if (spec->down[i] < 0 || spec->down[i] > (spec->rows - 1) * VC_TEXEL) return 0;
        if (abs(spec->across[i]) > spec->columns * VC_TEXEL) return 0;
    }
    return 1;
}

vc_status vc_add_panorama(vc_core *core, const vc_panorama *spec) {
    if (spec->coarse < 1 || spec->bottom <= spec->top) return VC_INVALID;
    int h = (spec->bottom - spec->top + spec->coarse - 1) / spec->coarse;
    int w = (core->camera.width_px + spec->coarse - 1) / spec->coarse;
    if (!makes_sense(&core->camera, spec, h, w)) return VC_INVALID;
    if (core->sky == NULL) core->sky = new_sky(core->camera.width_px);
    if (core->sky == NULL) return VC_NO_MEMORY;
    if (core->sky->count == PANORAMAS) return VC_INVALID;
    Panorama *panorama = core->sky->panorama + core->sky->count++;
    size_t samples = (size_t)h * w, size = (size_t)spec->rows * spec->columns * 3;
    *panorama = (Panorama){*spec, h, w};
    panorama->spec.px = vc_copied(spec->px, size, 1, (size_t)spec->columns * 3);
    panorama->spec.across = vc_copied(spec->across, samples, sizeof(int32_t), 0);
    panorama->spec.down = vc_copied(spec->down, samples, sizeof(int32_t), 0);
    int memory = panorama->spec.px && panorama->spec.across && panorama->spec.down;
    return memory ? VC_OK : VC_NO_MEMORY;
}

/* Samples a row of pixels at a yaw, in 1 / VC_TEXEL columns. */
static void sample(const Panorama *panorama, int row, int64_t turned, uint8_t *out) {
    const vc_panorama *spec = &panorama->spec;
    const int32_t *across = spec->across + (size_t)row * panorama->w, *down = spec->down + (size_t)row * panorama->w;
    int around = spec->columns * VC_TEXEL, stride = spec->columns * 3;
    for (int x = 0; x < panorama->w; x++, out += 3) {
        int u = across[x] + (int)turned, v = down[x];
        if (u < 0) u += around;
        if (u >= around) u -= around;
        int column = u / VC_TEXEL, next = column + 1 < spec->columns ? 3 : 3 - stride;
        int fx = u % VC_TEXEL, fy = v % VC_TEXEL;
        const uint8_t *px = spec->px + (size_t)(v / VC_TEXEL) * stride + 3 * column;
        for (int i = 0; i < 3; i++, px++) {
            int above = px[0] * (VC_TEXEL - fx) + px[next] * fx;
            int below = px[stride] * (VC_TEXEL - fx) + px[stride + next] * fx;
            out[i] = (uint8_t)((above * (VC_TEXEL - fy) + below * fy + VC_TEXEL * VC_TEXEL / 2) / (VC_TEXEL * VC_TEXEL));
        }
    }
}

/* Stretches a row of every `coarse`-th pixel to all. */
static void stretch(const uint8_t *row, int count, int coarse, int width, uint8_t *out) {
    for (int x = 0; x < width; x++, out += 3) {
        int place = 2 * x + 1 - coarse; /* from the middle of the first sample, in half pixels */
        int left = place < 0 ? 0 : vc_min(place / (2 * coarse), count - 1), right = vc_min(left + 1, count - 1);
        int share = place < 0 ? 0 : place % (2 * coarse);
        for (int i = 0; i < 3; i++)
            out[i] = (uint8_t)((row[3 * left + i] * (2 * coarse - share) + row[3 * right + i] * share + coarse) / (2 * coarse));
    }
}

/* One stretched row of samples. */
static void coarse_row(vc_core *core, const Panorama *panorama, int row, int64_t turned, uint8_t *out) {
    sample(panorama, row, turned, core->sky->row);
    stretch(core->sky->row, panorama->w, panorama->spec.coarse, core->camera.width_px, out);
}

static void draw_coarse(vc_core *core, const Panorama *panorama, int64_t turned, vc_image image) {
    const vc_panorama *spec = &panorama->spec;
    int coarse = spec->coarse, next = 0, bytes = 3 * image.width;
    uint8_t *above = core->sky->rows[0], *below = core->sky->rows[1];
    coarse_row(core, panorama, next, turned, below);
    memcpy(above, below, (size_t)bytes);
    for (int y = 0; y < spec->bottom - spec->top; y++) {
        int place = 2 * y + 1 - coarse, share = place < 0 ? 0 : place % (2 * coarse);
        if (place >= 0 && place / (2 * coarse) == next) {
            uint8_t *swap = above;
            above = below;
            below = swap;
            next++;
            if (next < panorama->h)
                coarse_row(core, panorama, next, turned, below);
            else
                memcpy(below, above, (size_t)bytes);
        }
        uint8_t *out = image.px + (size_t)(spec->top + y) * bytes;
        int over = 256 - 128 * share / coarse, under = 128 * share / coarse;
        for (int i = 0; i < bytes; i++) out[i] = (uint8_t)((above[i] * over + below[i] * under + 128) >> 8);
    }
}

void vc_draw_sky(vc_core *core, vc_image image) {
    vc_sky_part *sky = core->sky;
    for (int i = 0; sky != NULL && i < sky->count; i++) {
        const Panorama *panorama = sky->panorama + i;
        const vc_panorama *spec = &panorama->spec;
        double turns = core->frame.view.yaw_rad * spec->columns_per_rad / spec->columns;
        int64_t turned = vc_round((turns - vc_floor(turns)) * spec->columns * VC_TEXEL) % (spec->columns * VC_TEXEL);
        if (spec->coarse > 1)
            draw_coarse(core, panorama, turned, image);
        else
            for (int y = 0; y < panorama->h; y++)
                sample(panorama, y, turned, image.px + (size_t)(spec->top + y) * image.width * 3);
    }
}
