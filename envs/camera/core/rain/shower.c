#include "rain/shower.h"

#include <math.h>

#include "internal.h"
#include "vc_math.h"

void vc_fall_speeds(double *speeds) {
    for (int i = 0; i < VC_SPEEDS; i++) speeds[i] = fmax(9.65 - 10.3 * vc_exp(-0.006 * i), 0.1);
}

/* A lower bound of image speed times depth, px m/s, for a stratum. */
static double slowest(const vc_rainfall *rain, const double *speeds, const vc_shower *shower, const double *down, int stratum) {
    const vc_camera *c = &rain->camera;
    double wide = (double)c->width_px / VC_CELLS_X, tall = (double)c->height_px / VC_CELLS_Y;
    int cell = stratum % VC_CELLS;
    double x = (cell % VC_CELLS_X + 0.5) * wide - c->cx_px, y = (cell / VC_CELLS_X + 0.5) * tall - c->cy_px;
    double least = INFINITY, fastest = 0.0;
    for (int i = 0; i < 3; i++) {
        double fall = vc_fall_speed(speeds, VC_SMALLEST_MM + (stratum / VC_CELLS + 0.5 * i) * VC_SIZE_MM), v[3];
        for (int k = 0; k < 3; k++) v[k] = shower->drift[k] + fall * down[k];
        least = fmin(least, vc_hypot(c->fx_px * v[0] - x * v[2], c->fy_px * v[1] - y * v[2]));
        fastest = fmax(fastest, fabs(v[2]));
    }
    return fmax(least - 0.5 * vc_hypot(wide, tall) * fastest, 0.0);
}

/* A drop of diameter D at depth z is w = f D / z wide; its image moves by l = g T / z during the exposure. Its opacity,
 * (pi / 4) w^2 / max(1, l), falls to `faintest` at
 * z = min(f D sqrt(pi / 4 / faintest), (pi / 4) f^2 D^2 / (g T faintest)). */
static double range(const vc_rainfall *rain, int size, double image_speed, double faintest) {
    double width = 1e-3 * (VC_SMALLEST_MM + (size + 1) * VC_SIZE_MM) * rain->camera.fx_px; /* at a depth of 1 m */
    double seen = width * sqrt(0.25 * VC_PI / faintest);
    return fmin(seen, 0.25 * VC_PI * width * width / fmax(image_speed * rain->exposure_s * faintest, 1e-9));
}

/* N(D) = 8000 exp(-4.1 R^-0.21 D), drops per m^3 and mm of diameter (Marshall and Palmer 1948, J. Meteor. 5:165). */
static void densities(double rain_mmph, double *per_m3) {
    double slope = 4.1 * vc_exp(-0.21 * vc_log(rain_mmph));
    for (int i = 0; i < VC_SIZES; i++) per_m3[i] = 8000.0 * vc_exp(-slope * (VC_SMALLEST_MM + (i + 0.5) * VC_SIZE_MM)) * VC_SIZE_MM;
}

void vc_shower_fill(vc_shower *shower, const vc_rainfall *rain, const double *speeds, const double *down, double faintest) {
    const vc_camera *c = &rain->camera;
    double per_m3[VC_SIZES], sums[VC_STRATA];
    densities(rain->rain_mmph, per_m3);
    double share = (double)c->width_px * c->height_px / VC_CELLS / (c->fx_px * c->fy_px) / 3.0, sum = 0.0;
    for (int i = 0; i < VC_STRATA; i++) {
        double reach = range(rain, i / VC_CELLS, slowest(rain, speeds, shower, down, i), faintest);
        if (reach > VC_NEAREST_M) sum += per_m3[i / VC_CELLS] * share * reach * reach * reach;
        shower->range_m[i] = (float)reach;
        sums[i] = sum;
    }
    shower->expected = sum;
    shower->used = 1;
    for (int i = 0; i < VC_STRATA; i++) shower->until[i] = sum > 0.0 ? (uint32_t)(sums[i] / sum * 4294967295.0) : UINT32_MAX;
    for (int i = 0, stratum = 0; i < VC_GUIDES; i++) {
        while (stratum < VC_STRATA - 1 && shower->until[stratum] < (uint32_t)i << 20) stratum++;
        shower->guides[i] = (uint16_t)stratum;
    }
}

int vc_shower_stratum(const vc_shower *shower, uint32_t share) {
    int stratum = shower->guides[share >> 20];
    while (stratum < VC_STRATA - 1 && shower->until[stratum] < share) stratum++;
    return stratum;
}
