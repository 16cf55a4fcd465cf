/* Panoramas at infinity, which turn with the yaw. */
#include <stdlib.h>
#include <string.h>

#include "internal.h"

enum { PANORAMAS = 2 };

typedef struct {
    vc_panorama spec; /* with copies of its arrays */
    uint32_t *texels; /* (rows + 1, columns) R, G, B from the lowest byte on */
} Panorama;

struct vc_sky_part {
    int count;
    Panorama panorama[PANORAMAS];
    uint16_t *rows[2]; /* sampled rows, stretched to the image's width, times 2 `coarse` */
    uint8_t *row;     /* a sampled row */
};

void vc_sky_free(vc_sky_part *sky) {
    if (sky == NULL) return;
    for (int i = 0; i < sky->count; i++) {
        free(sky->panorama[i].texels);
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
    for (int i = 0; i < 2; i++) sky->rows[i] = malloc((size_t)width * 3 * sizeof(uint16_t));
    sky->row = malloc((size_t)width * 3);
    if (sky->rows[0] && sky->rows[1] && sky->row) return sky;
    vc_sky_free(sky);
    return NULL;
}

static int makes_sense(const vc_camera *camera, const vc_panorama *spec) {
    if (spec->top < 0 || spec->bottom <= spec->top || spec->bottom > camera->height_px) return 0;
    if (spec->coarse < 1 || spec->coarse > 8 || (spec->coarse & (spec->coarse - 1)) != 0) return 0;
    if (spec->h != (spec->bottom - spec->top + spec->coarse - 1) / spec->coarse) return 0;
    if (spec->w != (camera->width_px + spec->coarse - 1) / spec->coarse) return 0;
    if (spec->rows < 2 || spec->columns < 2 || spec->columns > 1 << 20) return 0;
    for (int i = 0; i < spec->h * spec->w; i++) {
        if (spec->down[i] < 0 || spec->down[i] > (spec->rows - 1) * VC_TEXEL) return 0;
        if (abs(spec->across[i]) > spec->columns * VC_TEXEL) return 0;
    }
    return 1;
}

/* Texels in a word each, with the last row twice. */
static uint32_t *packed(const vc_panorama *spec) {
    size_t count = (size_t)spec->rows * spec->columns;
    uint32_t *texels = malloc((count + spec->columns) * sizeof *texels);
    if (texels == NULL) return NULL;
    for (size_t i = 0; i < count; i++) {
        const uint8_t *px = spec->px + 3 * i;
        texels[i] = px[0] | (uint32_t)px[1] << 8 | (uint32_t)px[2] << 16;
    }
    memcpy(texels + count, texels + count - spec->columns, (size_t)spec->columns * sizeof *texels);
    return texels;
}

vc_status vc_add_panorama(vc_core *core, const vc_panorama *spec) {
    if (!makes_sense(&core->camera, spec)) return VC_INVALID;
    if (core->sky == NULL) core->sky = new_sky(core->camera.width_px);
    if (core->sky == NULL) return VC_NO_MEMORY;
    if (core->sky->count == PANORAMAS) return VC_INVALID;
    Panorama *panorama = core->sky->panorama + core->sky->count++;
    size_t samples = (size_t)spec->h * spec->w;
    *panorama = (Panorama){*spec, packed(spec)};
    panorama->spec.across = vc_copied(spec->across, samples, sizeof(int32_t), 0);
    panorama->spec.down = vc_copied(spec->down, samples, sizeof(int32_t), 0);
    int memory = panorama->texels && panorama->spec.across && panorama->spec.down;
    return memory ? VC_OK : VC_NO_MEMORY;
}

/* a + (b - a) share / VC_TEXEL in each byte. */
static inline uint32_t between(uint32_t a, uint32_t b, uint32_t share) {
    uint32_t rest = VC_TEXEL - share, half = VC_TEXEL / 2;
    uint32_t red_blue = ((a & 0xff00ffu) * rest + (b & 0xff00ffu) * share + half * 0x10001u) / VC_TEXEL & 0xff00ffu;
    return red_blue | (((a & 0xff00u) * rest + (b & 0xff00u) * share + half * 0x100u) / VC_TEXEL & 0xff00u);
}

/* Samples a row of pixels at a yaw, in 1 / VC_TEXEL columns. */
static void sample(const Panorama *panorama, int row, int64_t turned, uint8_t *out) {
    const vc_panorama *spec = &panorama->spec;
    const int32_t *across = spec->across + (size_t)row * panorama->spec.w, *down = spec->down + (size_t)row * panorama->spec.w;
    int around = spec->columns * VC_TEXEL;
    for (int x = 0; x < panorama->spec.w; x++, out += 3) {
        int place = across[x] + (int)turned;
        place += place < 0 ? around : place >= around ? -around : 0;
        uint32_t u = (uint32_t)place, v = (uint32_t)down[x], column = u / VC_TEXEL;
        const uint32_t *texel = panorama->texels + (size_t)(v / VC_TEXEL) * spec->columns + column;
        const uint32_t *next = texel + ((int)column + 1 < spec->columns ? 1 : 1 - spec->columns);
        uint32_t above = between(texel[0], next[0], u % VC_TEXEL);
        uint32_t below = between(texel[spec->columns], next[spec->columns], u % VC_TEXEL);
        uint32_t colour = between(above, below, v % VC_TEXEL);
        out[0] = (uint8_t)colour;
        out[1] = (uint8_t)(colour >> 8);
        out[2] = (uint8_t)(colour >> 16);
    }
}

/* Stretches a row of every `coarse`-th pixel to all, each between the middles of two samples; times 2 `coarse`. */
static void stretch(const uint8_t *row, int count, int coarse, int width, uint16_t *out) {
    int left = -1, share = coarse + 1, whole = 2 * coarse; /* from the left sample, in halves of a pixel */
    for (int x = 0; x < width; x++, out += 3, share += 2) {
        if (share >= whole) {
            share -= whole;
            left++;
        }
        const uint8_t *a = row + 3 * vc_max(left, 0), *b = row + 3 * vc_min(left + 1, count - 1);
        for (int i = 0; i < 3; i++) out[i] = (uint16_t)(a[i] * (whole - share) + b[i] * share);
    }
}

/* One stretched row of samples. */
static void coarse_row(vc_core *core, const Panorama *panorama, int row, int64_t turned, uint16_t *out) {
    sample(panorama, row, turned, core->sky->row);
    stretch(core->sky->row, panorama->spec.w, panorama->spec.coarse, core->camera.width_px, out);
}

static void blend_rows(const uint16_t *above, const uint16_t *below, int share, int whole, int count, uint8_t *out) {
    uint16_t over = (uint16_t)(whole - share), under = (uint16_t)share, half = (uint16_t)(whole * whole / 2);
    int shift = 0;
    while (1 << shift < whole * whole) shift++;
    for (int i = 0; i < count; i++) out[i] = (uint8_t)((uint16_t)(above[i] * over + below[i] * under + half) >> shift);
}

static void draw_coarse(vc_core *core, const Panorama *panorama, int64_t turned, vc_image image) {
    const vc_panorama *spec = &panorama->spec;
    int whole = 2 * spec->coarse, share = spec->coarse + 1, next = 0, bytes = 3 * image.width;
    uint16_t *above = core->sky->rows[0], *below = core->sky->rows[1];
    coarse_row(core, panorama, next, turned, below);
    memcpy(above, below, (size_t)bytes * sizeof *above);
    for (int y = spec->top; y < spec->bottom; y++, share += 2) {
        if (share >= whole) {
            uint16_t *swap = above;
            above = below;
            below = swap;
            share -= whole;
            next = vc_min(next + 1, panorama->spec.h - 1);
            coarse_row(core, panorama, next, turned, below);
        }
        blend_rows(above, below, share, whole, bytes, image.px + (size_t)y * bytes);
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
            for (int y = 0; y < panorama->spec.h; y++)
                sample(panorama, y, turned, image.px + (size_t)(spec->top + y) * image.width * 3);
    }
}
