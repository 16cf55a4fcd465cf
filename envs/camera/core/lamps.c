/* The light of the car's own headlamps and of street lamps, and lamps that shine into the camera. */
#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "scene.h"
#include "vc_math.h"

enum { NEAR_LAMPS = 64, GLOWS = 4096, LARGEST_GLOW = 4096 };
#define AHEAD_M 130.0    /* street lamps farther ahead light less of the ground than a few rows */
#define LOWEST_M 0.1     /* least height of a street lamp above what it lights */
#define SMALLEST -600.0  /* exponents below it are limited */

typedef struct {
    int size;
    uint8_t *px;
} Glow;

struct vc_lamps_part {
    vc_lamps spec; /* with copies of its arrays */
    double *grey;  /* (factors,) mean of the RGB factors */
    int near_count;
    double near_m[NEAR_LAMPS][3]; /* street lamps near the view, in the world */
    double beside_m[NEAR_LAMPS][3]; /* the same, ahead and right of the car's middle */
    double *lux;   /* (columns,) of a row of the ground */
    int glows;
    Glow *glow;
};

void vc_lamps_free(vc_lamps_part *lamps) {
    if (lamps == NULL) return;
    for (int i = 0; i < lamps->glows; i++) free(lamps->glow[i].px);
    free(lamps->glow);
    free((void *)lamps->spec.lamps_m);
    free((void *)lamps->spec.factor);
    free((void *)lamps->spec.ground);
    free(lamps->grey);
    free(lamps->lux);
    free(lamps);
}

vc_status vc_set_lamps(vc_core *core, const vc_lamps *from) {
    if (core->lamps != NULL || core->scene == NULL || from->factors < 2 || from->columns < 2 || from->lamps < 0)
        return VC_INVALID;
    vc_lamps_part *lamps = core->lamps = calloc(1, sizeof *lamps);
    if (lamps == NULL) return VC_NO_MEMORY;
    size_t rows = (size_t)(core->camera.height_px - core->camera.ground_top), factors = (size_t)from->factors;
    lamps->spec = *from;
    lamps->spec.lamps_m = vc_copied(from->lamps_m, (size_t)from->lamps, 3 * sizeof(double), 0);
    lamps->spec.factor = vc_copied(from->factor, factors, 3 * sizeof(double), 0);
    lamps->spec.ground = vc_copied(from->ground, rows * from->columns, 3 * sizeof(double), 0);
    lamps->grey = malloc(factors * sizeof(double));
    lamps->lux = malloc((size_t)from->columns * sizeof(double));
    lamps->glow = calloc(GLOWS, sizeof *lamps->glow);
    if (!lamps->spec.lamps_m || !lamps->spec.factor || !lamps->spec.ground || !lamps->grey || !lamps->lux || !lamps->glow)
        return VC_NO_MEMORY;
    for (size_t i = 0; i < factors; i++)
        lamps->grey[i] = (from->factor[3 * i] + from->factor[3 * i + 1] + from->factor[3 * i + 2]) / 3.0;
    return vc_make_room(core);
}

int vc_add_glow(vc_core *core, int size, const uint8_t *px) {
    vc_lamps_part *lamps = core->lamps;
    if (lamps == NULL || lamps->glows == GLOWS || size < 2 || size > LARGEST_GLOW) return VC_INVALID;
    uint8_t *copy = vc_copied(px, (size_t)size * size, 4, 0);
    if (copy == NULL) return VC_NO_MEMORY;
    lamps->glow[lamps->glows] = (Glow){size, copy};
    return lamps->glows++;
}

int vc_lamp_room(const vc_core *core) { return core->lamps->spec.lamps; }
int vc_glow_count(const vc_core *core) { return core->lamps == NULL ? 0 : core->lamps->glows; }

void vc_begin_lamps(vc_core *core) {
    vc_lamps_part *lamps = core->lamps;
    if (lamps == NULL) return;
    const vc_view *view = &core->frame.view;
    lamps->near_count = 0;
    for (int i = 0; i < lamps->spec.lamps && lamps->near_count < NEAR_LAMPS; i++) {
        const double *lamp = lamps->spec.lamps_m + 3 * i;
        double x = lamp[0] - view->centre[0], y = lamp[1] - view->centre[1];
        double ahead = view->cos_yaw * x + view->sin_yaw * y, right = view->cos_yaw * y - view->sin_yaw * x;
        if (ahead < -lamps->spec.street_range_m || x * x + y * y > 4.0 * AHEAD_M * AHEAD_M) continue;
        double beside[3] = {ahead + core->camera.forward_m, right, lamp[2]};
        memcpy(lamps->near_m[lamps->near_count], lamp, 3 * sizeof *lamp);
        memcpy(lamps->beside_m[lamps->near_count++], beside, sizeof beside);
    }
}

static double falling(double exponent) { return vc_exp(exponent < SMALLEST ? SMALLEST : exponent); }

/* Light of one headlamp towards a direction, by its slopes: right, and up, over ahead. */
static double intensity_cd(const vc_lamps *lamp, double across, double up) {
    double rising = lamp->rise * (across > 0.0 ? across : 0.0) - lamp->dip;
    double below = (rising < lamp->highest ? rising : lamp->highest) - up, depth = below > 0.0 ? below : 0.0;
    double cut = 1.0 / (1.0 + vc_exp(vc_limit((lamp->offset - below) / lamp->soft, -60.0, 60.0)));
    double a = across / lamp->narrow[1], b = across / lamp->wide[1], c = across / lamp->above_wide;
    double high = (up > 0.0 ? up : 0.0) / lamp->above_tall;
    double wide = lamp->narrow[0] * falling(-a * a) + lamp->wide[0] * falling(-b * b);
    double deep = lamp->steep[0] * falling(-depth / lamp->steep[1]) + lamp->shallow[0] * falling(-depth / lamp->shallow[1]);
    return lamp->above_cd * falling(-c * c - high * high) + lamp->peak_cd * cut * wide * deep;
}

/* Light of both headlamps at a point of the world, on a plane that faces them. */
static double beam_lx(const vc_core *core, const double *point) {
    const vc_lamps *lamp = &core->lamps->spec;
    const vc_view *view = &core->frame.view;
    double x = point[0] - view->centre[0], y = point[1] - view->centre[1], up = point[2] - lamp->height_m, total = 0.0;
    double ahead = view->cos_yaw * x + view->sin_yaw * y - (lamp->ahead_m - core->camera.forward_m);
    double right = view->cos_yaw * y - view->sin_yaw * x;
    if (ahead <= lamp->nearest_m) return 0.0;
    for (int side = -1; side <= 1; side += 2) {
        double aside = right + side * lamp->aside_m;
        total += intensity_cd(lamp, aside / ahead, up / ahead) / (ahead * ahead + aside * aside + up * up);
    }
    return total;
}

/* Light of one street lamp on a level plane, from `x`, `y` beside it and below. */
static double street_lx(const vc_lamps *lamp, double x, double y, double height) {
    if (height < LOWEST_M) height = LOWEST_M;
    double squared = x * x + y * y + height * height;
    if (squared > 16.0 * height * height) return 0.0; /* dark from 76 deg on */
    double distance = sqrt(squared);
    return lamp->street_cd * vc_limit(4.0 - distance / height, 0.0, 1.0) * height / (squared * distance);
}

/* Where lux lie in the table of factors: the entry before, and the share of the next one. */
static int place_of(const vc_lamps *lamp, double lux, double *share) {
    double place = sqrt(lux) * lamp->factor_scale;
    if (place >= lamp->factors - 1) {
        *share = 1.0;
        return lamp->factors - 2;
    }
    int whole = (int)place;
    *share = place - whole;
    return whole;
}

void vc_lamplight(const vc_core *core, const double *point, const double *normal, int flags, double *factors) {
    const vc_lamps *lamp = &core->lamps->spec;
    const vc_view *view = &core->frame.view;
    double beam = beam_lx(core, point), street = 0.0, share;
    for (int i = 0; i < core->lamps->near_count; i++) {
        const double *at = core->lamps->near_m[i];
        street += street_lx(lamp, point[0] - at[0], point[1] - at[1], at[2] - point[2]);
    }
    if (normal == NULL) {
        beam *= lamp->leaves;
        street *= lamp->leaves;
    } else {
        double ahead = lamp->ahead_m - core->camera.forward_m;
        double ray[3] = {view->centre[0] + ahead * view->cos_yaw - point[0], view->centre[1] + ahead * view->sin_yaw - point[1],
                         lamp->height_m - point[2]};
        double facing = normal[0] * ray[0] + normal[1] * ray[1] + normal[2] * ray[2];
        double length = sqrt(ray[0] * ray[0] + ray[1] * ray[1] + ray[2] * ray[2]);
        beam *= flags & VC_RETRO ? lamp->retro : facing > 0.0 ? facing / length : 0.0;
        street *= 0.5 + 0.5 * normal[2];
    }
    const double *factor = lamp->factor + 3 * place_of(lamp, beam + street, &share);
    for (int i = 0; i < 3; i++) factors[i] = factor[i] + share * (factor[3 + i] - factor[i]);
}

/* Factor of the ground's colours at a point, of 256. */
static int ground_factor(const vc_lamps_part *lamps, const double *point) {
    double lux = point[2], share;
    for (int i = 0; i < lamps->near_count; i++) {
        const double *at = lamps->beside_m[i];
        if (at[0] < AHEAD_M) lux += street_lx(&lamps->spec, point[0] - at[0], point[1] - at[1], at[2]);
    }
    int place = place_of(&lamps->spec, lux, &share);
    double factor = lamps->grey[place] + share * (lamps->grey[place + 1] - lamps->grey[place]);
    return vc_round(256.0 * lamps->spec.ground_gain * vc_limit(factor, 0.0, 2.0));
}

void vc_light_row(vc_core *core, int row, uint8_t *px) {
    const vc_lamps_part *lamps = core->lamps;
    int columns = lamps->spec.columns, width = core->camera.width_px, next = 0, left = 0, right = 0;
    const double *points = lamps->spec.ground + (size_t)row * columns * 3;
    for (int x = 0, place = width - 1; x < width; x++, px += 3, place += columns - 1) {
        if (place >= width - 1 && next < columns) { /* beyond the next column of the light */
            place -= width - 1;
            left = next == 0 ? ground_factor(lamps, points) : right;
            next++;
            right = next < columns ? ground_factor(lamps, points + 3 * next) : left;
        }
        int factor = left + (right - left) * place / (width - 1);
        for (int i = 0; i < 3; i++) px[i] = (uint8_t)vc_min(255, (px[i] * factor + 128) >> 8);
    }
}

int vc_glow_box(const vc_core *core, int index, vc_item *item) {
    const vc_lamp *lamp = core->frame.lamps + index;
    int radius = core->lamps->glow[lamp->glow].size / 2;
    double x = vc_limit(lamp->x_px, -1e6, 1e6), y = vc_limit(lamp->y_px, -1e6, 1e6);
    item->x0 = vc_max(0, vc_floor(x) - radius);
    item->y0 = vc_max(0, vc_floor(y) - radius);
    item->x1 = vc_min(core->camera.width_px, vc_floor(x) + radius + 2);
    item->y1 = vc_min(core->camera.height_px, vc_floor(y) + radius + 2);
    return item->x0 < item->x1 && item->y0 < item->y1;
}

void vc_paint_glow(const vc_core *core, const vc_item *item, vc_image image) {
    const vc_lamp *lamp = core->frame.lamps + item->first;
    const Glow *glow = core->lamps->glow + lamp->glow;
    vc_picture picture = {glow->px, glow->size, glow->size, 256, 256, {0, 0, 0}, NULL, 0};
    int radius = glow->size / 2;
    vc_paint_picture(&picture, lamp->x_px - radius, lamp->y_px - radius, glow->size, glow->size, image, VC_DRAW);
}
