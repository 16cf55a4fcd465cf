/* The grain of road and verge: three sizes of one noise, fixed to the world, averaged along each texel. */
#include <string.h>

#include "ground.h"

#define FIXED 4194304.0 /* 2^22: 10 bits of a 32-bit number are left for the texel, so that it wraps as the tile does */
enum { SHIFT = 22, SIZES = 3 };

static const int EVERY[SIZES] = {2, 4, 8}; /* columns of the raster by sample of the noise */
static const float WEIGHTS[SIZES] = {0.8f, 0.4f, 1.0f};

static uint32_t fixed(double texels) {
    double whole = vc_limit(texels, -1e6, 1e6) * FIXED;
    return (uint32_t)(int64_t)whole;
}

static uint32_t bilinear(const uint8_t *tile, uint32_t u, uint32_t v) {
    const uint8_t *at = tile + (size_t)(v >> SHIFT) * VC_STRIDE + (u >> SHIFT);
    uint32_t fx = (u >> (SHIFT - 8)) & 255, fy = (v >> (SHIFT - 8)) & 255;
    uint32_t above = at[0] * (256 - fx) + at[1] * fx, below = at[VC_STRIDE] * (256 - fx) + at[VC_STRIDE + 1] * fx;
    return (above * (256 - fy) + below * fy + 32768) >> 16;
}

/* One size of noise about 0 for a row of a raster; `matrix` maps texels of the raster to those of the noise. */
static void sample(const uint8_t *tile, const double *matrix, int row, int columns, int every, int fineness,
                   uint32_t *sums, float *noise) {
    int count = columns / every;
    double middle = 0.5 * (every - 1);
    memset(sums, 0, sizeof *sums * count);
    for (int k = 0; k < fineness; k++) {
        double y = row - 0.5 + (k + 0.5) / fineness; /* a raster's rows have one depth each */
        double scale = 1.0 / (matrix[6] * 0.5 * columns + matrix[7] * y + matrix[8]);
        uint32_t u = fixed((matrix[0] * middle + matrix[1] * y + matrix[2]) * scale);
        uint32_t v = fixed((matrix[3] * middle + matrix[4] * y + matrix[5]) * scale);
        uint32_t du = fixed(matrix[0] * every * scale), dv = fixed(matrix[3] * every * scale);
        if (fineness < 4)
            for (int i = 0; i < count; i++, u += du, v += dv) sums[i] += bilinear(tile, u, v);
        else
            for (int i = 0; i < count; i++, u += du, v += dv)
                sums[i] += tile[(size_t)(v >> SHIFT) * VC_STRIDE + (u >> SHIFT)];
    }
    float share = 1.0f / (float)fineness;
    for (int i = 0; i < count; i++) noise[i] = (float)sums[i] * share - 128.0f;
    noise[-1] = noise[0];
    noise[count] = noise[count - 1];
}

/* Adds noise of every `every`-th column to all columns, linear between them. */
static void stretch(const float *noise, int columns, int every, float weight, float *out) {
    for (int k = 0; k < every; k++) {
        float place = ((float)k + 0.5f) / (float)every - 0.5f;
        const float *beside = place < 0.0f ? noise - 1 : noise + 1;
        float far = weight * (place < 0.0f ? -place : place), near = weight - far;
        for (int i = 0; i < columns / every; i++) out[every * i + k] += near * noise[i] + far * beside[i];
    }
}

/* Adds fine and coarse noise, and blotches, to a row. */
static void add(vc_ground_part *ground, int columns, const float *gain, uint8_t *values) {
    float *steps = ground->scratch.strength[0], *shift = ground->scratch.strength[1];
    memset(steps, 0, sizeof *steps * columns);
    memset(shift, 0, sizeof *shift * columns);
    for (int i = 0; i < SIZES; i++)
        stretch(ground->scratch.grain[i] + 1, columns, EVERY[i], WEIGHTS[i] * gain[i / 2], i < 2 ? steps : shift);
    for (int i = 0; i < columns; i++) {
        float value = values[i] + steps[i] * ground->grain_gain[values[i]] + shift[i] * ground->blotch_gain[values[i]];
        value += 0.5f;
        values[i] = value <= 0.0f ? 0 : value >= 255.0f ? 255 : (uint8_t)value;
    }
}

void vc_add_grain(vc_ground_part *ground, const vc_level *spec, const double *to_world, int rows,
                  uint8_t *values) {
    Scratch *scratch = &ground->scratch;
    double matrices[SIZES][9];
    for (int i = 0; i < SIZES; i++) vc_multiply(spec->grain_from_world[i], to_world, matrices[i]);
    for (int row = 0; row < rows; row++) {
        const float *gain = spec->gain + 2 * vc_min(row, spec->gains - 1);
        if (gain[0] == 0.0f && gain[1] == 0.0f) continue;
        for (int i = 0; i < SIZES; i++) {
            const uint8_t *tile = ground->tiles + (i < 2 ? 0 : (size_t)(VC_TILE + 1) * VC_STRIDE);
            sample(tile, matrices[i], row, spec->columns, EVERY[i], spec->grain_fineness[i], scratch->noise,
                   scratch->grain[i] + 1);
        }
        add(ground, spec->columns, gain, values + (size_t)row * spec->columns);
    }
}
