#include "rain/streaks.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "internal.h"
#include "rain/shower.h"
#include "vc_random.h"

#define FAINTEST 4.0        /* grey levels: fainter drops are noise of the sensor */
#define LEAST_CONTRAST 12.0 /* of a drop's brightness to what is behind it */
#define DARKEST 30.0        /* grey level of the darkest background */
enum { SHOWERS = 6 };       /* that are kept */

struct vc_streaks {
    vc_rainfall rain;
    double faintest, dimming, brightening;
    double speeds[VC_SPEEDS];
    vc_shower showers[SHOWERS];
    int next; /* the shower that is replaced next */
};

vc_streaks *vc_streaks_new(const vc_rainfall *rainfall) {
    vc_streaks *streaks = calloc(1, sizeof *streaks);
    if (streaks == NULL) return NULL;
    streaks->rain = *rainfall;
    streaks->dimming = fmin(rainfall->gain, 1.0);
    streaks->brightening = fmax(rainfall->gain, 1.0);
    streaks->faintest = FAINTEST / (streaks->dimming * (rainfall->brightness - DARKEST));
    vc_fall_speeds(streaks->speeds);
    return streaks;
}

void vc_streaks_free(vc_streaks *streaks) { free(streaks); }

const vc_camera *vc_streaks_camera(const vc_streaks *streaks) { return &streaks->rain.camera; }

vc_air vc_streaks_air(const vc_streaks *streaks, const double *velocity_mps, double yaw_rad) {
    vc_view view;
    vc_view_at(&streaks->rain.camera, 0.0, 0.0, yaw_rad, &view);
    vc_air air;
    for (int i = 0; i < 3; i++) {
        const double *axis = view.axes[i];
        air.drift_mps[i] = axis[0] * velocity_mps[0] + axis[1] * velocity_mps[1] + axis[2] * velocity_mps[2];
        air.down[i] = -axis[2];
    }
    return air;
}

/* The shower for a motion, from the kept ones if it is among them. */
static const vc_shower *shower_for(vc_streaks *streaks, const vc_air *air) {
    int drift[3];
    for (int i = 0; i < 3; i++) drift[i] = vc_round(air->drift_mps[i]);
    for (int i = 0; i < SHOWERS; i++)
        if (streaks->showers[i].used && memcmp(streaks->showers[i].drift, drift, sizeof drift) == 0) return &streaks->showers[i];
    vc_shower *shower = &streaks->showers[streaks->next];
    streaks->next = (streaks->next + 1) % SHOWERS;
    memcpy(shower->drift, drift, sizeof drift);
    vc_shower_fill(shower, &streaks->rain, streaks->speeds, air->down, streaks->faintest);
    return shower;
}

/* The depth of a drop that is evenly spread over a cone: the largest of three uniform numbers. */
static double depth(uint64_t bits, double range_m) {
    enum { MASK = (1 << 21) - 1 };
    int a = (int)(bits & MASK), b = (int)(bits >> 21 & MASK), c = (int)(bits >> 42 & MASK);
    return range_m * (vc_max(a, vc_max(b, c)) + 0.5) / (MASK + 1);
}

/* Draws one drop by lot; returns whether it is visible. */
static int next_speck(const vc_streaks *streaks, const vc_shower *shower, const vc_air *air, vc_random *random,
                      vc_image image, vc_speck *speck) {
    const vc_camera *c = &streaks->rain.camera;
    uint64_t place = vc_next(random), bits = vc_next(random);
    int stratum = vc_shower_stratum(shower, (uint32_t)place), cell = stratum % VC_CELLS;
    double z = depth(bits, shower->range_m[stratum]);
    if (z < VC_NEAREST_M) return 0;
    double x = (cell % VC_CELLS_X + (double)(place >> 32 & 0xffff) / 65536.0) * c->width_px / VC_CELLS_X;
    double y = (cell / VC_CELLS_X + (double)(place >> 48) / 65536.0) * c->height_px / VC_CELLS_Y;
    int green = image.px[((size_t)(int)y * image.width + (int)x) * 3 + 1];
    double contrast = streaks->dimming * (streaks->rain.brightness - green);
    if (contrast <= LEAST_CONTRAST) return 0;
    double diameter_mm = VC_SMALLEST_MM + (stratum / VC_CELLS + vc_uniform(random)) * VC_SIZE_MM;
    double fall = vc_fall_speed(streaks->speeds, diameter_mm), v[3];
    for (int i = 0; i < 3; i++) v[i] = air->drift_mps[i] + air->down[i] * fall;
    double travel = streaks->rain.exposure_s / z;
    double dx = travel * (c->fx_px * v[0] - (x - c->cx_px) * v[2]), dy = travel * (c->fy_px * v[1] - (y - c->cy_px) * v[2]);
    double width = 1e-3 * c->fx_px * diameter_mm / z;
    double level = 0.25 * VC_PI * width * width / fmax(vc_hypot(dx, dy), 1.0) * contrast;
    vc_speck found = {x, y, dx, dy, width, level};
    *speck = found;
    return level >= FAINTEST;
}

static void brighten(uint8_t *px, int levels) {
    for (int i = 0; i < 3; i++) px[i] = (uint8_t)vc_min(px[i] + levels, 255);
}

/* Adds a drop: points a pixel apart, each split between two columns. The few wider ones are drawn a pixel wide. */
static void add(vc_image image, const vc_speck *speck, double gain) {
    int count = (int)fmax(fabs(speck->dx_px), fabs(speck->dy_px)) + 2;
    double level = gain * speck->level / fmax(speck->width_px, 1.0);
    double step_x = speck->dx_px / (count - 1), step_y = speck->dy_px / (count - 1);
    double x = speck->x_px - 0.5 * speck->dx_px, y = speck->y_px - 0.5 * speck->dy_px;
    for (int i = 0; i < count; i++, x += step_x, y += step_y) {
        int left = vc_floor(x), row = vc_round(y);
        if (left < 0 || left >= image.width - 1 || row < 0 || row >= image.height) continue;
        double right = level * (x - left);
        uint8_t *px = image.px + ((size_t)row * image.width + left) * 3;
        brighten(px, (int)fmin(level - right + 0.5, 255.0));
        brighten(px + 3, (int)fmin(right + 0.5, 255.0));
    }
}

void vc_streaks_draw(vc_streaks *streaks, const vc_air *air, int64_t time_us, vc_image image) {
    const vc_shower *shower = shower_for(streaks, air);
    vc_random random = vc_stream(streaks->rain.seed, time_us);
    vc_speck speck;
    for (int left = vc_poisson(&random, shower->expected); left > 0; left--)
        if (next_speck(streaks, shower, air, &random, image, &speck)) add(image, &speck, streaks->brightening);
}

int vc_streaks_list(vc_streaks *streaks, const vc_air *air, int64_t time_us, vc_image image, vc_speck *specks, int most) {
    const vc_shower *shower = shower_for(streaks, air);
    vc_random random = vc_stream(streaks->rain.seed, time_us);
    int count = 0;
    vc_speck speck;
    for (int left = vc_poisson(&random, shower->expected); left > 0; left--) {
        if (!next_speck(streaks, shower, air, &random, image, &speck)) continue;
        if (count < most) specks[count] = speck;
        count++;
    }
    return count;
}
