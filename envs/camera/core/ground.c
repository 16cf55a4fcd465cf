/* The ground in an image: rows sampled from the rasters of the levels, then coloured, shaded and hazed. */
#include "ground.h"

#include <string.h>

enum { SPAN = 32, WHOLE = 16, ONE = 1 << WHOLE }; /* pixels between exact places; bits of a fraction of a texel */
enum { PIXELS = 48 }; /* bytes of whole pixels that fill whole registers */

/* a + (b - a) share / 256, rounded, in both halves. */
static inline uint32_t between(uint32_t a, uint32_t b, uint32_t share) {
    return (((a << 8) + (b - a) * share + 0x00800080u) >> 8) & 0x00ff00ffu;
}

static inline uint64_t two(const uint32_t *texel) { return texel[0] | (uint64_t)texel[1] << 32; }

/* The texel at a place between four. */
static inline uint32_t bilinear(const uint32_t *texel, int columns, uint32_t fx, uint32_t fy) {
    uint64_t above = two(texel), below = two(texel + columns);
    uint64_t both = (((above << 8) + (below - above) * fy + 0x0080008000800080u) >> 8) & 0x00ff00ff00ff00ffu;
    return between((uint32_t)both, (uint32_t)(both >> 32), fx);
}

/* A run of pixels along a row, linear in texels; u and v count 1 / ONE. */
typedef struct {
    int64_t u, v, du, dv;
    int count;
} Run;

static int is_inside(const Run *run, int columns, int rows) {
    int64_t u = run->u + run->du * (run->count - 1), v = run->v + run->dv * (run->count - 1);
    int64_t wide = (int64_t)(columns - 1) << WHOLE, tall = (int64_t)(rows - 1) << WHOLE;
    return run->u >= 0 && u >= 0 && run->v >= 0 && v >= 0 && run->u < wide && u < wide && run->v < tall && v < tall;
}

static void sample_run(const uint32_t *texels, int columns, int rows, const Run *run, uint32_t outside, uint32_t *out) {
    if (is_inside(run, columns, rows)) {
        uint32_t u = (uint32_t)run->u, v = (uint32_t)run->v, du = (uint32_t)run->du, dv = (uint32_t)run->dv;
        for (int i = 0; i < run->count; i++, u += du, v += dv)
            out[i] = bilinear(texels + (size_t)(v >> WHOLE) * columns + (u >> WHOLE), columns, (u >> 8) & 255,
                              (v >> 8) & 255);
        return;
    }
    for (int i = 0; i < run->count; i++) {
        int64_t u = run->u + run->du * i, v = run->v + run->dv * i;
        int64_t column = u >> WHOLE, row = v >> WHOLE;
        int inside = column >= 0 && row >= 0 && column < columns - 1 && row < rows - 1;
        out[i] = inside ? bilinear(texels + row * columns + column, columns, (u >> 8) & 255, (v >> 8) & 255) : outside;
    }
}

/* Texels along an image row; `matrix` maps pixels to texels. */
static void sample_row(const Raster *raster, const vc_level *spec, const double *matrix, double y, int width,
                       uint32_t outside, uint32_t *out) {
    double a = matrix[1] * y + matrix[2], b = matrix[4] * y + matrix[5], w = matrix[7] * y + matrix[8];
    double x0 = vc_limit(a / w, -1e6, 1e6), y0 = vc_limit(b / w, -1e6, 1e6);
    for (int start = 0; start < width; start += SPAN) {
        int count = vc_min(SPAN, width - start), end = start + count;
        double scale = 1.0 / (matrix[6] * end + w);
        double x1 = vc_limit((matrix[0] * end + a) * scale, -1e6, 1e6);
        double y1 = vc_limit((matrix[3] * end + b) * scale, -1e6, 1e6);
        Run run = {(int64_t)(x0 * ONE), (int64_t)(y0 * ONE), (int64_t)((x1 - x0) * ONE / count),
                   (int64_t)((y1 - y0) * ONE / count), count};
        sample_run(raster->texels, spec->columns, spec->rows, &run, outside, out + start);
        x0 = x1;
        y0 = y1;
    }
}

/* The mean of `fineness` sampled rows for an image row. */
static void sample_fine(vc_ground_part *ground, const Level *level, const double *matrix, int y, int fineness, int width,
                        uint32_t *out) {
    if (fineness == 1) {
        sample_row(level->now, &level->spec, matrix, y, width, ground->outside, out);
        return;
    }
    uint32_t *row = ground->row[2];
    int shift = 0;
    while (1 << shift < fineness) shift++;
    memset(out, 0, sizeof *out * width);
    for (int k = 0; k < fineness; k++) {
        sample_row(level->now, &level->spec, matrix, y - 0.5 + (k + 0.5) / fineness, width, ground->outside, row);
        for (int x = 0; x < width; x++) out[x] += row[x]; /* up to 256 rows fit */
    }
    uint32_t half = (uint32_t)(fineness / 2) * 0x10001u;
    for (int x = 0; x < width; x++) out[x] = ((out[x] + half) >> shift) & 0x00ff00ffu;
}

static void fade(uint32_t *under, const uint32_t *over, int width, uint32_t weight) {
    uint32_t share = weight + (weight >> 7);
    for (int x = 0; x < width; x++) under[x] = between(under[x], over[x], share);
}

/* Colour of a sampled texel: the palette's, darkened by `dark` of 256 in full shadow. */
static inline uint32_t coloured(const uint32_t *palette, uint32_t texel, uint32_t dark) {
    uint32_t colour = palette[texel & 255], shadow = texel >> 16;
    if (shadow == 0) return colour;
    uint32_t left = 256 - ((shadow * dark + 128) >> 8);
    uint32_t red_blue = (((colour & 0xff00ffu) * left + 0x800080u) >> 8) & 0xff00ffu;
    return red_blue | ((((colour & 0x00ff00u) * left + 0x8000u) >> 8) & 0x00ff00u);
}

static inline void put(uint32_t colour, uint8_t *px) {
    px[0] = (uint8_t)colour;
    px[1] = (uint8_t)(colour >> 8);
    px[2] = (uint8_t)(colour >> 16);
}

static void colour_row(const vc_ground_part *ground, const uint32_t *texels, int width, uint8_t *px) {
    uint32_t dark = (uint32_t)(256 - ground->shade);
    for (int x = 0; x < width; x++) put(coloured(ground->palette, texels[x], dark), px + 3 * x);
}

static inline void haze_bytes(uint8_t *restrict px, const uint8_t *restrict air, uint16_t transmission, int count) {
    for (int i = 0; i < count; i++) {
        uint16_t product = (uint16_t)(px[i] * transmission + 128);
        px[i] = (uint8_t)(((uint16_t)(product + (product >> 8)) >> 8) + air[i]); /* over 255, rounded, as vc_by_255 */
    }
}

/* The haze of a row: a transmission, and light of the air. */
static void haze_row(const uint8_t *haze, int width, uint8_t *px) {
    uint8_t air[PIXELS];
    for (int i = 0; i < PIXELS; i++) air[i] = haze[1 + i % 3];
    int left = 3 * width;
    for (; left >= PIXELS; left -= PIXELS, px += PIXELS) haze_bytes(px, air, haze[0], PIXELS);
    haze_bytes(px, air, haze[0], left);
}

/* Samples a level's rows that are shown at row `y` of the ground. */
static void sample_level(vc_core *core, const Level *level, const double *matrix, int row) {
    vc_ground_part *ground = core->ground;
    int width = core->camera.width_px, y = core->camera.ground_top + row;
    for (int i = 0; i < level->spec.bands; i++) {
        const vc_band *band = level->spec.band + i;
        if (row < band->first || row >= band->last) continue;
        uint32_t *out = ground->row[band->faded ? 1 : 0];
        sample_fine(ground, level, matrix, y, band->fineness, width, out);
        if (band->faded) fade(ground->row[0], out, width, level->spec.weight[row - level->spec.band[0].first]);
    }
}

void vc_draw_ground(vc_core *core, vc_image image) {
    vc_ground_part *ground = core->ground;
    if (ground == NULL || ground->levels == 0) return;
    vc_update_rasters(core);
    double to_world[9], matrices[VC_LEVELS][9];
    vc_ground_homography(&core->camera, &core->frame.view, to_world);
    for (int i = 0; i < ground->levels; i++) vc_multiply(ground->level[i].now->from_world, to_world, matrices[i]);
    for (int row = 0; row < image.height - core->camera.ground_top; row++) {
        for (int i = 0; i < ground->levels; i++) sample_level(core, ground->level + i, matrices[i], row);
        uint8_t *px = image.px + (size_t)(core->camera.ground_top + row) * image.width * 3;
        colour_row(ground, ground->row[0], image.width, px);
        if (core->lamps != NULL) vc_light_row(core, row, px);
        if (row < ground->hazy_rows) haze_row(ground->haze + 4 * row, image.width, px);
    }
}
