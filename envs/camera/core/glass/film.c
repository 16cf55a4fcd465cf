#include <math.h>
#include <string.h>

#include "glass/parts.h"

#define OLD 0.04 /* share of blurred light between sweeps, and right behind the blade */
#define FRESH 0.12
#define ARCS 0.4 /* variation of thickness by distance from the pivot */
#define ARC_M 0.002
#define DRIES_S 0.2 /* from fresh to old */
enum { AGES = 16 }; /* steps in which it is followed */

/* Thickness by distance from the pivot in steps of ARC_M, up to 2 m. */
typedef struct {
    double at[1001];
} Arcs;

static void fill_arcs(Arcs *arcs, uint64_t seed) {
    vc_random random = vc_stream(seed, 0);
    for (int i = 0; i <= 1000; i++) arcs->at[i] = 1.0 + ARCS * (2.0 * vc_uniform(&random) - 1.0);
}

static double thickness(const Arcs *arcs, double radius_m) {
    double steps = fmin(radius_m / ARC_M, 999.0), share = steps - (int)steps;
    const double *at = arcs->at + (int)steps;
    return (1.0 - share) * at[0] + share * at[1];
}

/* The place of a direction in the quarter turn that the blade sweeps; it grows with the angle, from 0 to
 * VC_FILM_ANGLES - 1. */
static int place_of(const double *direction) {
    return (int)(direction[1] / (direction[0] + direction[1]) * (VC_FILM_ANGLES - 1));
}

/* Notes the angles that a row shows. */
static void measure(vc_film *film, int row) {
    uint16_t low = VC_FILM_ANGLES, high = 0;
    for (int x = 0; x < film->width; x++) {
        uint16_t angle = film->angle[(size_t)row * film->width + x];
        if (angle == VC_FILM_ANGLES) continue;
        if (angle < low) low = angle;
        if (angle > high) high = angle;
    }
    film->range[2 * row] = low;
    film->range[2 * row + 1] = high;
}

static void fill_pixel(vc_film *film, const vc_pane *pane, const Arcs *arcs, int row, int x) {
    size_t i = (size_t)row * film->width + x;
    double point[2], arm[2];
    vc_pane_point(pane, x, VC_PLANE_ROWS * row + 0.5 * (VC_PLANE_ROWS - 1), point);
    vc_from_pivot(point, arm);
    double radius = vc_hypot(arm[0], arm[1]), thick = arcs == NULL ? 1.0 : thickness(arcs, radius);
    int reached = radius >= VC_BLADE_FROM_M && radius <= VC_BLADE_UNTIL_M && arm[0] >= 0.0 && arm[1] >= 0.0;
    memset(film->old + 3 * i, vc_round(255.0 * OLD * thick), 3);
    film->fresh[i] = (uint8_t)vc_round(255.0 * FRESH * thick);
    film->angle[i] = (uint16_t)(reached && arcs != NULL ? place_of(arm) : VC_FILM_ANGLES);
}

void vc_film_fill(vc_film *film, const vc_pane *pane, int wiped, uint64_t seed) {
    Arcs arcs;
    if (wiped) fill_arcs(&arcs, seed);
    for (int row = 0; row < film->rows; row++) {
        for (int x = 0; x < film->width; x++) fill_pixel(film, pane, wiped ? &arcs : NULL, row, x);
        measure(film, row);
    }
}

/* Freshness by angle, of 256, and the angles between which there is any. */
typedef struct {
    int low, high;
    uint16_t share[VC_FILM_ANGLES + 1];
} Fresh;

static Fresh freshness(const vc_wiper *wiper, double time_s) {
    Fresh fresh = {VC_FILM_ANGLES, -1, {0}};
    for (int age = AGES - 1; age >= 0 && wiper->period_s > 0.0; age--) {
        double from_s = time_s - DRIES_S * (age + 1) / AGES, until_s = time_s - DRIES_S * age / AGES;
        vc_swath swath = vc_wiper_swath(wiper, from_s, until_s);
        if (swath.high_rad <= swath.low_rad) continue;
        int first = place_of(swath.low), last = place_of(swath.high);
        for (int i = first; i <= last; i++) fresh.share[i] = (uint16_t)(256 - (256 * age + 128) / AGES);
        fresh.low = vc_min(fresh.low, first);
        fresh.high = vc_max(fresh.high, last);
    }
    return fresh;
}

/* The opacity of a row, each value three times. */
static void spread_fresh(const vc_film *film, const Fresh *fresh, int row) {
    const uint8_t *old = film->old + (size_t)row * film->width * 3, *new = film->fresh + (size_t)row * film->width;
    const uint16_t *angle = film->angle + (size_t)row * film->width;
    uint8_t *opacity = film->row;
    for (int x = 0; x < film->width; x++, opacity += 3)
        opacity[0] = opacity[1] = opacity[2] = (uint8_t)(old[3 * x] + ((new[x] - old[3 * x]) * fresh->share[angle[x]] >> 8));
}

/* A row of the small picture as wide as the image. */
static void widen(uint8_t *shown, const vc_small *picture, int row, int width) {
    const uint8_t *px = picture->px + (size_t)row * picture->width * 3;
    for (int i = 0, x = 0; i < picture->width; i++, px += 3)
        for (int end = (int)((int64_t)(i + 1) * width / picture->width); x < end; x++) memcpy(shown + 3 * x, px, 3);
}

static void blend(uint8_t *restrict px, const uint8_t *restrict shown, const uint8_t *restrict opacity, int bytes) {
    for (int i = 0; i < bytes; i++) {
        uint16_t sum = (uint16_t)(px[i] * (uint8_t)(255 - opacity[i]) + shown[i] * opacity[i] + 128);
        px[i] = (uint8_t)((uint16_t)(sum + (sum >> 8)) >> 8);
    }
}

void vc_film_draw(const vc_film *film, const vc_wiper *wiper, double time_s, const vc_small *picture, vc_image image) {
    Fresh fresh = freshness(wiper, time_s);
    int widened = -1;
    for (int row = 0; row < film->rows; row++) {
        int any = film->range[2 * row] <= fresh.high && film->range[2 * row + 1] >= fresh.low;
        const uint8_t *opacity = any ? film->row : film->old + (size_t)row * film->width * 3;
        if (any) spread_fresh(film, &fresh, row);
        int shown = (int)((int64_t)row * picture->height / film->rows);
        if (shown != widened) widen(film->shown, picture, widened = shown, film->width);
        for (int y = VC_PLANE_ROWS * row; y < vc_min(VC_PLANE_ROWS * (row + 1), image.height); y++)
            blend(image.px + (size_t)y * image.width * 3, film->shown, opacity, 3 * film->width);
    }
}
