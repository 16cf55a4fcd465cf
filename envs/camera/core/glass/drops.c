#include <math.h>

#include "glass/parts.h"

#define RUNS_FROM_MM 3.3 /* drops run from this size on; the spot is 6 mm wide */
#define LARGEST_MM 8.0
#define SMALLEST_PX 2.5         /* narrower spots are part of the film */
#define GRAVITY_BELOW_MPS 12.0  /* between these two speeds all drops stand still */
#define WIND_ABOVE_MPS 20.0
#define RUNS_S 0.35 /* mean durations of running and of resting */
#define RESTS_S 0.25
#define SLOWEST_RUN_MPS 0.02
#define FASTEST_RUN_MPS 0.1
#define SHED_EVERY 0.6 /* mean distance between shed drops, in widths of the spot */
#define SMALLEST_SHED 0.2 /* size of a shed drop over the running one's */
#define LARGEST_SHED 0.4
#define LIFE_TICKS VC_GENERATION_TICKS /* a drop lives once to twice this long without a wiper */

/* One step of one generation. */
typedef struct {
    vc_drops *all;
    vc_generation *own;
    const vc_pane *pane;
    int64_t tick;
    double speed_mps;
    vc_random random;
} Step;

static double between(vc_random *random, double low, double high) { return low + (high - low) * vc_uniform(random); }

static const vc_pane_row *row_of(const Step *step, const vc_drop *drop) {
    return &step->pane->rows[vc_pane_row_at(step->pane, drop->y_px)];
}

static double cube(double value) { return value * value * value; }

static double cube_root(double value) { return vc_exp(vc_log(value) / 3.0); }

static void take_away(vc_generation *own, int i) { own->drops[i] = own->drops[--own->count]; }

static void dry(Step *step) {
    vc_generation *own = step->own;
    int width = step->pane->camera->width_px, height = step->pane->camera->height_px;
    for (int i = own->count - 1; i >= 0; i--) {
        const vc_drop *drop = &own->drops[i];
        int outside = drop->y_px < -1.0 || drop->y_px > height || drop->x_px < -1.0 || drop->x_px > width;
        if (outside || drop->dies_tick <= step->tick) take_away(own, i);
    }
}

/* Drops touch if the centre of one lies in the spot of the other. */
static int touch(const vc_pane_row *row, const vc_drop *a, const vc_drop *b) {
    double dx = (a->x_px - b->x_px) / row->across, dy = (a->y_px - b->y_px) / row->along;
    double reach = 0.5 * VC_FOOTPRINT * fmax(a->size_mm, b->size_mm);
    return dx * dx + dy * dy < reach * reach;
}

/* The water of both, at their centre of mass, with the manners of the larger one. */
static vc_drop merged(const vc_drop *a, const vc_drop *b) {
    vc_drop drop = a->size_mm >= b->size_mm ? *a : *b;
    double volume = cube(a->size_mm) + cube(b->size_mm), share = cube(a->size_mm) / volume;
    drop.x_px = share * a->x_px + (1.0 - share) * b->x_px;
    drop.y_px = share * a->y_px + (1.0 - share) * b->y_px;
    drop.size_mm = fmin(cube_root(volume), LARGEST_MM);
    return drop;
}

/* Merges a drop with those before `count` that it touches; returns how many of these are left. */
static int merge(Step *step, vc_drop *drop, int count) {
    vc_generation *own = step->own;
    for (int i = count - 1; i >= 0; i--) {
        if (!touch(row_of(step, drop), drop, &own->drops[i])) continue;
        *drop = merged(drop, &own->drops[i]);
        own->drops[i] = own->drops[--count];
    }
    return count;
}

/* Adds a drop, which merges with those that it touches. */
static void add(Step *step, vc_drop drop) {
    vc_generation *own = step->own;
    own->count = merge(step, &drop, own->count);
    if (own->count < step->all->most) own->drops[own->count++] = drop;
}

static void land(Step *step) {
    const vc_pane *pane = step->pane;
    const vc_impacts *impacts = &step->all->impacts;
    double rate = vc_impacts_rate(impacts, step->speed_mps);
    double area_m2 = pane->rows[pane->camera->height_px].above_m2;
    int number = vc_poisson(&step->random, rate * area_m2 * VC_TICK_S);
    for (int i = 0; i < number; i++) {
        vc_drop drop = {0};
        drop.size_mm = vc_impacts_size(impacts, step->speed_mps, rate * vc_uniform(&step->random));
        drop.x_px = vc_uniform(&step->random) * pane->camera->width_px - 0.5;
        drop.y_px = vc_pane_spread(pane, vc_uniform(&step->random));
        uint64_t bits = vc_next(&step->random);
        drop.outline = (int)(bits % VC_OUTLINES);
        drop.dies_tick = step->tick + LIFE_TICKS + (int64_t)(bits / VC_OUTLINES % LIFE_TICKS);
        const vc_pane_row *row = row_of(step, &drop);
        double spot = VC_FOOTPRINT * drop.size_mm;
        if (spot * spot * row->across * row->along >= SMALLEST_PX * SMALLEST_PX) add(step, drop);
    }
}

/* Starts a resting drop, or stops a running one, by the mean durations. */
static void turn(Step *step, vc_drop *drop) {
    double chance = VC_TICK_S / (drop->run_mps > 0.0 ? RUNS_S : RESTS_S);
    if (vc_uniform(&step->random) >= chance) return;
    drop->run_mps = drop->run_mps > 0.0 ? 0.0 : between(&step->random, SLOWEST_RUN_MPS, FASTEST_RUN_MPS);
}

/* A small drop that a running one may leave behind; returns whether it does. */
static int shed(Step *step, vc_drop *drop, int blown, vc_drop *left) {
    double spots = drop->run_mps * 1e3 * VC_TICK_S / (SHED_EVERY * VC_FOOTPRINT * drop->size_mm);
    if (vc_uniform(&step->random) >= spots) return 0;
    *left = *drop;
    left->size_mm *= between(&step->random, SMALLEST_SHED, LARGEST_SHED);
    left->run_mps = 0.0;
    left->y_px += (blown ? 0.6 : -0.6) * VC_FOOTPRINT * drop->size_mm * row_of(step, drop)->along;
    drop->size_mm = cube_root(cube(drop->size_mm) - cube(left->size_mm));
    return 1;
}

/* Moves a drop down at low speed, up and outwards at high speed. */
static void move(Step *step, vc_drop *drop, int blown) {
    const vc_pane_row *row = row_of(step, drop);
    double way_mm = 1e3 * VC_TICK_S * drop->run_mps, sideways = 0.4 * vc_normal(&step->random);
    if (blown) sideways += drop->x_px > step->pane->camera->cx_px ? 0.7 : -0.7;
    drop->x_px += way_mm * row->across * sideways;
    drop->y_px += way_mm * row->along * (blown ? -0.7 : 1.0);
}

static void run(Step *step) {
    vc_generation *own = step->own;
    int blown = step->speed_mps > WIND_ABOVE_MPS, stands = !blown && step->speed_mps >= GRAVITY_BELOW_MPS;
    for (int i = own->count - 1; i >= 0; i--) {
        if (i >= own->count) continue; /* others have merged */
        if (own->drops[i].size_mm < RUNS_FROM_MM || own->drops[i].moved_tick == step->tick) continue;
        turn(step, &own->drops[i]);
        if (stands || own->drops[i].run_mps <= 0.0) continue;
        vc_drop drop = own->drops[i], left;
        drop.moved_tick = step->tick;
        take_away(own, i);
        int sheds = shed(step, &drop, blown, &left);
        move(step, &drop, blown);
        add(step, drop);
        if (sheds && own->count < step->all->most) own->drops[own->count++] = left;
    }
}

static void wipe(Step *step, const vc_wiper *wiper) {
    vc_generation *own = step->own;
    vc_swath swath = vc_wiper_swath(wiper, (double)(step->tick - 1) * VC_TICK_S, (double)step->tick * VC_TICK_S);
    if (swath.high_rad <= swath.low_rad) return;
    for (int i = own->count - 1; i >= 0; i--) {
        double point[2];
        vc_pane_point(step->pane, own->drops[i].x_px, own->drops[i].y_px, point);
        if (vc_swath_holds(&swath, point)) take_away(own, i);
    }
}

static int64_t modulo(int64_t value, int64_t divisor) { return (value % divisor + divisor) % divisor; }

void vc_drops_begin(vc_drops *drops, double speed_mps) {
    for (int i = 0; i < VC_HISTORY; i++) drops->speeds_mps[i] = (float)speed_mps;
    for (int i = 0; i < VC_GENERATIONS; i++) drops->generations[i].number = INT64_MIN;
}

void vc_drops_note(vc_drops *drops, int64_t tick, double speed_mps) {
    drops->speeds_mps[modulo(tick, VC_HISTORY)] = (float)speed_mps;
}

vc_status vc_drops_put(vc_drops *drops, int64_t tick, const vc_drop *drop) {
    int64_t newest = (tick - modulo(tick, VC_GENERATION_TICKS)) / VC_GENERATION_TICKS;
    vc_generation *own = &drops->generations[modulo(newest, VC_GENERATIONS)];
    if (own->count == drops->most) return VC_NO_MEMORY;
    own->drops[own->count++] = *drop;
    return VC_OK;
}

static void simulate(vc_drops *drops, vc_generation *own, const vc_pane *pane, const vc_wiper *wiper, int64_t until) {
    while (own->tick < until) {
        int64_t tick = ++own->tick;
        Step step = {drops, own, pane, tick, drops->speeds_mps[modulo(tick, VC_HISTORY)], {0}};
        step.random = vc_stream(drops->seed ^ (uint64_t)own->number, tick);
        dry(&step);
        run(&step);
        if (tick < (own->number + 1) * VC_GENERATION_TICKS) land(&step);
        if (wiper->period_s > 0.0) wipe(&step, wiper);
    }
}

void vc_drops_simulate(vc_drops *drops, const vc_pane *pane, const vc_wiper *wiper, int64_t tick) {
    int64_t newest = (tick - modulo(tick, VC_GENERATION_TICKS)) / VC_GENERATION_TICKS;
    for (int64_t number = newest - VC_GENERATIONS + 1; number <= newest; number++) {
        vc_generation *own = &drops->generations[modulo(number, VC_GENERATIONS)];
        if (own->number != number || own->tick > tick) {
            own->number = number;
            own->tick = number * VC_GENERATION_TICKS - 1;
            own->count = 0;
        }
        simulate(drops, own, pane, wiper, tick);
    }
}
