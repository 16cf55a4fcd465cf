/* Where the road is wet, and how much of the light it reflects. */
#include "rain/wet_road.h"

enum { DARK = 77 }; /* darkening of the asphalt by depth, of 256 */

/* The homography (3, 3) from pixels of the canvas to cells of the puddles. */
static void to_cells(const vc_core *core, double *matrix) {
    const vc_wet_part *wet = core->wet;
    double middle = 0.5 * (VC_HALF - 1);
    double to_pixels[9] = {VC_HALF, 0.0, middle, 0.0, VC_HALF, middle + core->camera.ground_top, 0.0, 0.0, 1.0};
    double from_world[9] = {1.0 / wet->cell_m, 0.0, -wet->corner_m[0] / wet->cell_m,
                            0.0, 1.0 / wet->cell_m, -wet->corner_m[1] / wet->cell_m, 0.0, 0.0, 1.0};
    vc_ground_homography(&core->camera, &core->frame.view, matrix);
    vc_multiply(matrix, to_pixels, matrix);
    vc_multiply(from_world, matrix, matrix);
}

/* The depth at a place in 1/65536 cells, between four cells; 0 beyond the map. */
static int depth_at(const vc_wet_part *wet, int64_t u, int64_t v) {
    int64_t end = (int64_t)(wet->cells - 1) << 16;
    if (u < 0 || v < 0 || u >= end || v >= end) return 0;
    const uint8_t *at = wet->depths + (v >> 16) * wet->cells + (u >> 16);
    int across = (int)(u >> 8 & 255), down = (int)(v >> 8 & 255);
    int above = at[0] * (256 - across) + at[1] * across;
    int below = at[wet->cells] * (256 - across) + at[wet->cells + 1] * across;
    return (above * (256 - down) + below * down + 32768) >> 16;
}

static void find_pixel(const vc_wet_part *wet, size_t i, int depth) {
    int dark = depth > wet->spec.level ? (depth - wet->spec.level) * DARK >> 8 : 0;
    int share = (int)vc_by_255((uint32_t)wet->spec.share[depth] * wet->spec.reflectance[i]);
    wet->share[i] = (uint8_t)share;
    wet->through[i] = (uint8_t)vc_max(255 - share - dark, 0);
    wet->standing[i] = depth > wet->spec.level;
}

static int64_t fixed(double cells) { return (int64_t)(vc_limit(cells, -1e6, 1e6) * 65536.0); }

void vc_find_water(vc_core *core) {
    const vc_wet_part *wet = core->wet;
    double m[9];
    to_cells(core, m);
    for (int row = 0; row < wet->spec.rows; row++) {
        int last = wet->spec.columns - 1;
        double w0 = m[7] * row + m[8], w1 = w0 + m[6] * last; /* equal: the camera does not roll */
        int64_t u = fixed((m[1] * row + m[2]) / w0), v = fixed((m[4] * row + m[5]) / w0);
        int64_t du = last > 0 ? (fixed((m[0] * last + m[1] * row + m[2]) / w1) - u) / last : 0;
        int64_t dv = last > 0 ? (fixed((m[3] * last + m[4] * row + m[5]) / w1) - v) / last : 0;
        size_t i = (size_t)row * wet->spec.columns;
        for (int x = 0; x <= last; x++, i++, u += du, v += dv) find_pixel(wet, i, depth_at(wet, u, v));
    }
}
