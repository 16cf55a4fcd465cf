/* Lamps mirrored in a wet road: bright streaks towards the camera.
 *
 * A lamp's mirror image is as far below the road as the lamp is above. Tilted facets spread its light along the line of
 * sight, with long tails, and hardly across. Light adds up before the gamma. */
#include <math.h>
#include <string.h>

#include "rain/wet_road.h"
#include "vc_math.h"

#define NARROW_PX 0.9 /* least standard deviation across, pixels of the canvas */
#define ACROSS 3.0    /* extents that are drawn, in standard deviations across and smears along */
#define ALONG 9.0
#define PI 3.14159265358979323846
#define GAMMA 2.2

void vc_fill_gamma(uint8_t *levels) {
    for (int i = 0; i < VC_GAMMA; i++) {
        double root = (double)i / (VC_GAMMA - 1); /* of the light */
        levels[i] = i == 0 ? 0 : (uint8_t)vc_round(255.0 * vc_exp(2.0 / GAMMA * vc_log(root)));
    }
}

/* The image row of the road at a depth. */
static double foot_px(const vc_camera *camera, double depth_m) {
    double c = vc_cos(camera->pitch_rad), s = vc_sin(camera->pitch_rad);
    return camera->cy_px + camera->fy_px * (camera->height_m / depth_m - s) / c;
}

/* Adds the streak of one lamp. */
static void add(const vc_core *core, const vc_lamp *lamp) {
    vc_wet_part *wet = core->wet;
    int columns = wet->spec.columns;
    double smear = 0.4 * wet->spec.smear, x = lamp->x_px / VC_HALF, wide = NARROW_PX + 0.25 * lamp->size_px / VC_HALF;
    double y = (2.0 * foot_px(&core->camera, lamp->depth_m) - lamp->y_px - core->camera.ground_top) / VC_HALF;
    int x0 = (int)vc_limit(x - ACROSS * wide, 0.0, columns), x1 = (int)vc_limit(x + ACROSS * wide, 0.0, columns);
    int y0 = (int)vc_limit(y - ALONG * smear, 0.0, wet->spec.rows), y1 = (int)vc_limit(y + ALONG * smear, 0.0, wet->spec.rows);
    double flux = lamp->flux / (sqrt(2.0 * PI) * wide * 0.5 * PI * smear * VC_HALF * VC_HALF);
    for (int row = y0; row < y1; row++) {
        double away = (row - y) / smear, tail = 1.0 + away * away, end = 1.0 - away * away / (ALONG * ALONG);
        double along = end > 0.0 ? flux * end / (tail * tail) : 0.0;
        for (int column = x0; column < x1; column++) {
            double aside = (column - x) / wide, light = along * vc_exp(-0.5 * aside * aside);
            float *to = wet->lamplight + ((size_t)row * columns + column) * 3;
            for (int k = 0; k < 3; k++) to[k] += (float)(light * lamp->colour[k]);
        }
    }
}

void vc_add_lamp_streaks(vc_core *core) {
    vc_wet_part *wet = core->wet;
    size_t count = (size_t)wet->spec.rows * wet->spec.columns;
    if (core->frame.lamp_count == 0) return;
    memset(wet->lamplight, 0, count * 3 * sizeof *wet->lamplight);
    for (int i = 0; i < core->frame.lamp_count; i++) add(core, core->frame.lamps + i);
    for (size_t i = 0; i < 3 * count; i++) {
        if (wet->lamplight[i] <= 0.0f) continue;
        double light = vc_limit(wet->lamplight[i] * wet->share[i / 3] / 255.0, 0.0, 1.0);
        int level = wet->light[i] + wet->gamma[(int)(sqrt(light) * (VC_GAMMA - 1))];
        wet->light[i] = (uint8_t)vc_min(level, 255);
    }
}
