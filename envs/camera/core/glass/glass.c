#include "glass/glass.h"

#include <math.h>
#include <stdlib.h>
#include <string.h>

#include "glass/parts.h"

#define FASTEST_MPS 40.0 /* for which there is room; beyond, drops may be left out */

struct vc_glass {
    vc_windscreen windscreen;
    vc_pane pane;
    vc_wiper wiper;
    vc_drops drops;
    vc_film film;
    vc_discs discs;
    vc_small film_picture, drop_picture;
    vc_scratch scratch;
    uint8_t *opacity; /* (rows, width) */
    int64_t time_us;
    int64_t tick;
    int begun;
};

static int64_t tick_at(int64_t time_us) { return (time_us - (time_us % VC_TICK_US + VC_TICK_US) % VC_TICK_US) / VC_TICK_US; }

static double seconds(const vc_glass *glass) { return 1e-6 * (double)glass->time_us; }

static int is_wet(const vc_glass *glass) { return glass->windscreen.rain_mmph > 0.0; }

static int has_wiper(const vc_glass *glass) { return glass->wiper.period_s > 0.0; }

static int has_small(vc_small *small, int width, int height) {
    small->width = width;
    small->height = height;
    return (small->px = malloc((size_t)width * height * 3)) != NULL;
}

/* Memory of the water; returns whether there is enough. */
static int has_room(vc_glass *glass) {
    int width = glass->pane.camera->width_px, height = glass->pane.camera->height_px;
    vc_film *film = &glass->film;
    film->rows = (height + VC_PLANE_ROWS - 1) / VC_PLANE_ROWS;
    film->width = width;
    size_t pixels = (size_t)film->rows * width;
    int fits = has_small(&glass->film_picture, (width + 3) / 4, (height + 3) / 4);
    fits &= has_small(&glass->drop_picture, (width + 7) / 8, (height + 7) / 8);
    fits &= (film->old = malloc(pixels * 3)) != NULL;
    fits &= (film->fresh = malloc(pixels)) != NULL;
    fits &= (film->angle = malloc(pixels * sizeof *film->angle)) != NULL;
    fits &= (film->range = malloc((size_t)film->rows * 2 * sizeof *film->range)) != NULL;
    fits &= (film->row = malloc((size_t)width * 3)) != NULL;
    fits &= (film->shown = malloc((size_t)width * 3)) != NULL;
    fits &= (glass->opacity = malloc(pixels)) != NULL;
    const vc_small *picture = &glass->film_picture;
    fits &= (glass->scratch.copy = malloc((size_t)picture->width * picture->height * 3)) != NULL;
    fits &= (glass->scratch.padded = malloc((size_t)(picture->width + 2 * VC_BLUR_REACH) * 3)) != NULL;
    fits &= (glass->scratch.sums = malloc((size_t)picture->width * 3 * sizeof *glass->scratch.sums)) != NULL;
    double area_m2 = glass->pane.rows[height].above_m2, rate = vc_impacts_rate(&glass->drops.impacts, FASTEST_MPS);
    glass->drops.most = 1024 + (int)fmin(rate * area_m2 * VC_TICK_S * VC_GENERATION_TICKS, 65536.0);
    for (int i = 0; i < VC_GENERATIONS; i++) {
        vc_drop *drops = malloc((size_t)glass->drops.most * sizeof *drops);
        glass->drops.generations[i].drops = drops;
        fits &= drops != NULL;
    }
    return fits;
}

vc_glass *vc_glass_new(const vc_windscreen *windscreen) {
    vc_glass *glass = calloc(1, sizeof *glass);
    if (glass == NULL) return NULL;
    glass->windscreen = *windscreen;
    glass->pane.camera = &glass->windscreen.camera;
    double period_s = windscreen->wiper_period_s;
    vc_wiper wiper = {period_s, fmin(period_s, VC_CYCLE_S), windscreen->wiper_offset_s};
    glass->wiper = wiper;
    glass->pane.rows = malloc(((size_t)windscreen->camera.height_px + 1) * sizeof *glass->pane.rows);
    if (glass->pane.rows != NULL) {
        vc_pane_fill(&glass->pane);
        if (!is_wet(glass)) return glass;
        vc_impacts_fill(&glass->drops.impacts, windscreen->rain_mmph);
        glass->drops.seed = windscreen->seed;
        if (has_room(glass)) {
            vc_film_fill(&glass->film, &glass->pane, has_wiper(glass), windscreen->seed);
            vc_discs_fill(&glass->discs);
            return glass;
        }
    }
    vc_glass_free(glass);
    return NULL;
}

void vc_glass_free(vc_glass *glass) {
    if (glass == NULL) return;
    for (int i = 0; i < VC_GENERATIONS; i++) free(glass->drops.generations[i].drops);
    free(glass->scratch.sums);
    free(glass->scratch.padded);
    free(glass->scratch.copy);
    free(glass->opacity);
    free(glass->film.shown);
    free(glass->film.row);
    free(glass->film.range);
    free(glass->film.angle);
    free(glass->film.fresh);
    free(glass->film.old);
    free(glass->drop_picture.px);
    free(glass->film_picture.px);
    free(glass->pane.rows);
    free(glass);
}

const vc_camera *vc_glass_camera(const vc_glass *glass) { return &glass->windscreen.camera; }

void vc_glass_advance(vc_glass *glass, int64_t time_us, double speed_mps) {
    int64_t tick = tick_at(time_us);
    if (is_wet(glass)) {
        if (!glass->begun || tick < glass->tick || tick - glass->tick >= VC_HISTORY) vc_drops_begin(&glass->drops, speed_mps);
        else
            for (int64_t passed = glass->tick + 1; passed <= tick; passed++) vc_drops_note(&glass->drops, passed, speed_mps);
    }
    glass->begun = 1;
    glass->tick = tick;
    glass->time_us = time_us;
}

/* Draws the drops that the blade has left since the last tick; over `opacity` where there are no pixels. */
static void draw_drops(vc_glass *glass, vc_image image) {
    vc_drop_look look = {&glass->pane, &glass->discs, &glass->drop_picture};
    vc_swath swath = {0};
    int wiped = has_wiper(glass);
    if (wiped) swath = vc_wiper_swath(&glass->wiper, VC_TICK_S * (double)glass->tick, seconds(glass));
    vc_drops_simulate(&glass->drops, &glass->pane, &glass->wiper, glass->tick);
    for (int g = 0; g < VC_GENERATIONS; g++)
        for (int i = 0; i < glass->drops.generations[g].count; i++) {
            const vc_drop *drop = &glass->drops.generations[g].drops[i];
            double point[2];
            if (wiped) vc_pane_point(&glass->pane, drop->x_px, drop->y_px, point);
            if (wiped && vc_swath_holds(&swath, point)) continue;
            vc_drop_draw(&look, drop, image, glass->opacity);
        }
}

void vc_glass_draw(vc_glass *glass, vc_image image) {
    if (is_wet(glass)) {
        vc_capture(image, glass->windscreen.sky, &glass->film_picture, &glass->drop_picture, &glass->scratch);
        vc_film_draw(&glass->film, &glass->wiper, seconds(glass), &glass->film_picture, image);
        draw_drops(glass, image);
    }
    if (has_wiper(glass)) vc_blade_draw(&glass->pane, &glass->wiper, seconds(glass), image, NULL);
}

void vc_glass_opacity(vc_glass *glass, uint8_t *opacity) {
    int width = glass->pane.camera->width_px, height = glass->pane.camera->height_px;
    memset(opacity, 0, (size_t)width * height);
    if (!is_wet(glass)) return;
    vc_image none = {NULL, width, height};
    memset(glass->opacity, 0, (size_t)glass->film.rows * width);
    draw_drops(glass, none);
    for (int y = 0; y < height; y++)
        memcpy(opacity + (size_t)y * width, glass->opacity + (size_t)(y / VC_PLANE_ROWS) * width, (size_t)width);
}

void vc_glass_hidden(vc_glass *glass, uint8_t *hidden) {
    int width = glass->pane.camera->width_px, height = glass->pane.camera->height_px;
    vc_image none = {NULL, width, height};
    vc_glass_opacity(glass, hidden);
    if (has_wiper(glass)) vc_blade_draw(&glass->pane, &glass->wiper, seconds(glass), none, hidden);
    for (size_t i = 0; i < (size_t)width * height; i++) hidden[i] = hidden[i] > 127;
}

double vc_glass_blade_rad(const vc_glass *glass, int64_t time_us) {
    return has_wiper(glass) ? vc_wiper_angle(&glass->wiper, 1e-6 * (double)time_us) : 0.0;
}

int vc_glass_drops(vc_glass *glass, vc_drop *drops, int most) {
    int count = 0;
    if (!is_wet(glass)) return 0;
    vc_drops_simulate(&glass->drops, &glass->pane, &glass->wiper, glass->tick);
    for (int g = 0; g < VC_GENERATIONS; g++)
        for (int i = 0; i < glass->drops.generations[g].count; i++, count++)
            if (count < most) drops[count] = glass->drops.generations[g].drops[i];
    return count;
}

vc_status vc_glass_put(vc_glass *glass, const vc_drop *drop) {
    if (!is_wet(glass) || !glass->begun || drop->outline < 0 || drop->outline >= VC_OUTLINES) return VC_INVALID;
    vc_drops_simulate(&glass->drops, &glass->pane, &glass->wiper, glass->tick);
    return vc_drops_put(&glass->drops, glass->tick, drop);
}
