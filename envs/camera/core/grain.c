/* The grain of road and verge: three sizes of one noise, fixed to the world, averaged along each texel. */
#include <string.h>

#include "ground.h"

#define FIXED 4194304.0 /* 2^22: 10 bits of a 32-bit number are left for the texel, so that it wraps as the tile does */
enum { SHIFT = 22, SIZES = 3 };

static const int EVERY[SIZES] = {2, 4, 8}; /* columns of the raster by sample of the noise */
static const float FINE = 0.8f, COARSE = 0.4f; /* amplitudes */

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

/* Doubles the samples of noise, linear between them: a quarter is that of the neighbour. Both rows have a sample beyond
 * each end. */
static void doubled(const float *noise, int count, float *out) {
    for (int i = 0; i < count; i++) {
        out[2 * i] = 0.75f * noise[i] + 0.25f * noise[i - 1];
        out[2 * i + 1] = 0.75f * noise[i] + 0.25f * noise[i + 1];
    }
    out[-1] = out[0];
    out[2 * count] = out[2 * count - 1];
}

/* Adds noise to a run of texels of one palette value. */
static void add_run(const vc_ground_part *ground, const float *grain, const float *blotches, float blotch_gain, int count,
                    uint8_t *values) {
    float value = values[0], strength = ground->grain_gain[values[0]], blotch_strength = ground->blotch_gain[values[0]];
    for (int i = 0; i < count; i++) {
        float level = value + grain[i] * strength + blotch_gain * blotches[i] * blotch_strength + 0.5f;
        level = level > 0.0f ? level : 0.0f;
        values[i] = (uint8_t)(int)(level < 255.0f ? level : 255.0f);
    }
}

/* Adds fine and coarse noise, and blotches, to a row. */
static void add(vc_ground_part *ground, int columns, const float *gain, uint8_t *values) {
    float *const *grain = ground->scratch.grain, *steps = ground->scratch.strength[0] + 1;
    float *shift = ground->scratch.strength[1] + 1;
    doubled(grain[1] + 1, columns / 4, steps);
    for (int i = -1; i <= columns / 2; i++) shift[i] = gain[0] * (FINE * grain[0][i + 1] + COARSE * steps[i]);
    doubled(shift, columns / 2, steps);
    float *const quarter = grain[0] + 1, *const half = grain[1] + 1; /* no longer needed for grain */
    doubled(grain[2] + 1, columns / 8, half);
    doubled(half, columns / 4, quarter);
    doubled(quarter, columns / 2, shift);
    for (int first = 0, next; first < columns; first = next) {
        for (next = first + 1; next < columns && values[next] == values[first];) next++;
        add_run(ground, steps + first, shift + first, gain[1], next - first, values + first);
    }
}

void vc_add_grain(vc_ground_part *ground, const vc_level *spec, const double *to_world, int rows,
                  uint8_t *values) {
    Scratch *scratch = &ground->scratch;
    double matrices[SIZES][9];
    for (int i = 0; i < SIZES; i++) vc_multiply(spec->grain_from_world[i], to_world, matrices[i]);
    for (int row = 0; row < rows; row++) {
        int entry = vc_min(row, spec->gains - 1);
        const float *gain = spec->gain + 2 * entry;
        if (gain[0] == 0.0f && gain[1] == 0.0f) continue;
        for (int i = 0; i < SIZES; i++) {
            const uint8_t *tile = ground->tiles + (i < 2 ? 0 : (size_t)(VC_TILE + 1) * VC_STRIDE);
            sample(tile, matrices[i], row, spec->columns, EVERY[i], spec->fineness[3 * entry + i], scratch->noise,
                   scratch->grain[i] + 1);
        }
        add(ground, spec->columns, gain, values + (size_t)row * spec->columns);
    }
}
