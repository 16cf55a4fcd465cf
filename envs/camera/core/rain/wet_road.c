/* Reflections on the wet road. */
#include "rain/wet_road.h"

#include <stdlib.h>
#include <string.h>

#include "vc_random.h"

/* A reflection hides the road where it makes up a quarter of the light, or differs by so much from the mirrored sky. */
enum { HIDDEN_SHARE = 64, HIDDEN_LEVELS = 12 };

void vc_wet_free(vc_wet_part *wet) {
    if (wet == NULL) return;
    void *all[] = {(void *)wet->spec.reflectance, (void *)wet->spec.share, wet->depths, wet->sky, wet->sharp,
                   wet->smeared, wet->light, wet->kept, wet->share, wet->through, wet->standing, wet->sums,
                   wet->wide[0].through, wet->wide[0].light, wet->wide[1].through, wet->wide[1].light,
                   wet->lamplight};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) free(all[i]);
    vc_layer_free(&wet->layer);
    free(wet);
}

static int has_room(vc_wet_part *wet) {
    size_t columns = (size_t)wet->spec.columns, pixels = columns * (size_t)wet->spec.rows;
    uint8_t **planes[] = {&wet->share, &wet->through, &wet->standing};
    uint8_t **pictures[] = {&wet->sky, &wet->sharp, &wet->smeared, &wet->light, &wet->kept};
    int fits = 1;
    for (size_t i = 0; i < sizeof planes / sizeof *planes; i++) fits &= (*planes[i] = calloc(pixels, 1)) != NULL;
    for (size_t i = 0; i < sizeof pictures / sizeof *pictures; i++) fits &= (*pictures[i] = calloc(pixels, 3)) != NULL;
    fits &= vc_layer_make(&wet->layer, 4 * pixels, 2 * (size_t)wet->spec.rows);
    fits &= (wet->lamplight = malloc(pixels * 3 * sizeof *wet->lamplight)) != NULL;
    fits &= (wet->sums = malloc(columns * 3 * sizeof *wet->sums)) != NULL;
    for (int i = 0; i < 2; i++) {
        fits &= (wet->wide[i].through = malloc((2 * columns + 1) * 3 * sizeof(uint16_t))) != NULL;
        fits &= (wet->wide[i].light = malloc((2 * columns + 1) * 3 * sizeof(uint16_t))) != NULL;
    }
    return fits;
}

vc_status vc_set_wet_road(vc_core *core, const vc_wet_road *from) {
    const vc_camera *c = &core->camera;
    if (core->wet != NULL || from->rows < 1 || from->rows > (c->height_px - c->ground_top + 1) / VC_HALF ||
        from->columns != c->width_px / VC_HALF || from->columns < 1 || c->ground_top < VC_HALF || from->smear < 1 ||
        from->smear > 255 || from->ripple < 0)
        return VC_INVALID;
    vc_wet_part *wet = core->wet = calloc(1, sizeof *wet);
    if (wet == NULL) return VC_NO_MEMORY;
    wet->spec = *from;
    vc_fill_gamma(wet->gamma);
    wet->spec.reflectance = vc_copied(from->reflectance, (size_t)from->rows * from->columns, 1, 0);
    wet->spec.share = vc_copied(from->share, 256, 1, 0);
    return wet->spec.reflectance && wet->spec.share && has_room(wet) ? VC_OK : VC_NO_MEMORY;
}

vc_status vc_set_puddles(vc_core *core, const vc_puddles *from) {
    vc_wet_part *wet = core->wet;
    if (wet == NULL || from->cells < 2 || from->cells > 4096 || from->cell_m <= 0.0) return VC_INVALID;
    size_t count = (size_t)from->cells * from->cells;
    if (from->cells != wet->cells) {
        free(wet->depths);
        wet->depths = malloc(count);
        wet->cells = wet->depths == NULL ? 0 : from->cells;
        if (wet->depths == NULL) return VC_NO_MEMORY;
    }
    memcpy(wet->depths, from->depths, count);
    wet->corner_m[0] = from->x_m;
    wet->corner_m[1] = from->y_m;
    wet->cell_m = from->cell_m;
    return VC_OK;
}

/* ---- the reflected light ---- */

static void add_row(uint16_t *restrict sums, const uint8_t *restrict plus, const uint8_t *restrict minus, int count) {
    for (int i = 0; i < count; i++) sums[i] = (uint16_t)(sums[i] + plus[i] - minus[i]);
}

static void divide_row(uint8_t *restrict to, const uint16_t *restrict sums, int count, uint32_t scale) {
    for (int i = 0; i < count; i++) to[i] = (uint8_t)((sums[i] * scale + 32768) >> 16);
}

/* A row mirrored at the ends of the canvas. */
static const uint8_t *row_of(const vc_wet_part *wet, const uint8_t *picture, int row) {
    int last = wet->spec.rows - 1, period = 2 * last;
    if (period == 0) return picture;
    row = (row % period + period) % period;
    return picture + (size_t)(row <= last ? row : period - row) * wet->spec.columns * 3;
}

/* Means over `smear` rows. */
static void smear(vc_wet_part *wet) {
    int bytes = 3 * wet->spec.columns, half = wet->spec.smear / 2;
    uint32_t scale = 65536u / (uint32_t)(2 * half + 1);
    memset(wet->sums, 0, (size_t)bytes * sizeof *wet->sums);
    memset(wet->kept, 0, (size_t)bytes);
    for (int i = -half; i <= half; i++) add_row(wet->sums, row_of(wet, wet->sharp, i), wet->kept, bytes);
    for (int row = 0; row < wet->spec.rows; row++) {
        divide_row(wet->smeared + (size_t)row * bytes, wet->sums, bytes, scale);
        add_row(wet->sums, row_of(wet, wet->sharp, row + half + 1), row_of(wet, wet->sharp, row - half), bytes);
    }
}

/* Sharp light where water stands, with rows that drops shake, else smeared; times the reflected share. */
static void reflect(const vc_core *core, uint8_t *light) {
    const vc_wet_part *wet = core->wet;
    int columns = wet->spec.columns, ripple = wet->spec.ripple;
    vc_random random = vc_stream(wet->spec.seed, core->frame.pose.time_us);
    for (int row = 0; row < wet->spec.rows; row++) {
        int shaken = row + (int)(vc_next(&random) % (uint64_t)(2 * ripple + 1)) - ripple;
        const uint8_t *sharp = wet->sharp + (size_t)vc_clamp(shaken, 0, wet->spec.rows - 1) * columns * 3;
        const uint8_t *smeared = wet->smeared + (size_t)row * columns * 3;
        size_t i = (size_t)row * columns;
        for (int x = 0; x < columns; x++, i++) {
            const uint8_t *from = (wet->standing[i] ? sharp : smeared) + 3 * x;
            for (int k = 0; k < 3; k++) light[3 * i + k] = (uint8_t)vc_by_255((uint32_t)from[k] * wet->share[i]);
        }
    }
}

/* The light of `sharp` with or without what stands before the sky. */
static void find_light(vc_core *core, const uint8_t *sky, int with_items, uint8_t *light) {
    vc_wet_part *wet = core->wet;
    if (sky != wet->sharp) memcpy(wet->sharp, sky, (size_t)wet->spec.rows * wet->spec.columns * 3);
    if (with_items) vc_mirror_items(core);
    smear(wet);
    reflect(core, light);
}

/* ---- over the image ---- */

/* One pixel of a wide row from the canvas's pixels at its side: three quarters of one and a quarter of the other, times 4. */
static void between(uint16_t *to, const uint8_t *near, const uint8_t *far) {
    for (int k = 0; k < 3; k++) to[k] = (uint16_t)(3 * near[k] + far[k]);
}

static void fill(uint16_t *to, int value) { to[0] = to[1] = to[2] = (uint16_t)value; }

/* Widens a row of the canvas to the image's width. */
static void widen(const vc_wet_part *wet, int row, int width) {
    const vc_wide *to = &wet->wide[row % 2];
    int columns = wet->spec.columns, last = columns - 1;
    const uint8_t *through = wet->through + (size_t)row * columns, *light = wet->light + (size_t)row * columns * 3;
    for (int x = 0; x <= last; x++) {
        int left = vc_max(x - 1, 0), right = vc_min(x + 1, last);
        fill(to->through + 6 * x, 3 * through[x] + through[left]);
        fill(to->through + 6 * x + 3, 3 * through[x] + through[right]);
        between(to->light + 6 * x, light + 3 * x, light + 3 * left);
        between(to->light + 6 * x + 3, light + 3 * x, light + 3 * right);
    }
    if (width == 2 * columns) return;
    fill(to->through + 6 * columns, 4 * through[last]);
    between(to->light + 6 * columns, light + 3 * last, light + 3 * last);
}

/* Dims a row of the image, and adds the reflected light. */
static void lay_row(uint8_t *restrict px, const vc_wide *near, const vc_wide *far, int bytes) {
    const uint16_t *restrict through = near->through, *restrict far_through = far->through;
    const uint16_t *restrict light = near->light, *restrict far_light = far->light;
    for (int i = 0; i < bytes; i++) {
        uint16_t left = (uint16_t)((uint16_t)(3 * through[i] + far_through[i] + 8) >> 4);
        uint16_t product = (uint16_t)(px[i] * left + 128);
        uint16_t own = (uint16_t)((uint16_t)(product + (product >> 8)) >> 8);
        uint16_t level = (uint16_t)(own + ((uint16_t)(3 * light[i] + far_light[i] + 8) >> 4));
        px[i] = (uint8_t)(level > 255 ? 255 : level);
    }
}

static void blend(const vc_core *core, vc_image image) {
    const vc_wet_part *wet = core->wet;
    int top = core->camera.ground_top, last = wet->spec.rows - 1;
    int rows = vc_min(VC_HALF * wet->spec.rows, image.height - top);
    widen(wet, 0, image.width);
    for (int y = 0; y < rows; y++) {
        int near = y / 2, far = vc_clamp(y % 2 == 0 ? near - 1 : near + 1, 0, last);
        if (far > near) widen(wet, far, image.width);
        lay_row(image.px + (size_t)(top + y) * image.width * 3, &wet->wide[near % 2], &wet->wide[far % 2], 3 * image.width);
    }
}

void vc_draw_wet_road(vc_core *core, vc_image image) {
    vc_wet_part *wet = core->wet;
    if (wet == NULL || wet->cells == 0) return;
    vc_mirror_sky(core, image);
    vc_find_water(core);
    find_light(core, wet->sky, 1, wet->light);
    vc_add_lamp_streaks(core);
    blend(core, image);
}

/* ---- what it hides ---- */

static void mark(const vc_core *core, size_t i, int32_t *hidden) {
    int columns = core->wet->spec.columns, width = core->camera.width_px;
    int y = core->camera.ground_top + VC_HALF * (int)(i / columns), x = VC_HALF * (int)(i % columns);
    for (int k = 0; k < VC_HALF * VC_HALF; k++) {
        int row = y + k / VC_HALF, column = x + k % VC_HALF;
        if (row < core->camera.height_px && column < width) hidden[(size_t)row * width + column] = 1;
    }
}

void vc_mark_reflections(vc_core *core, int32_t *hidden) {
    vc_wet_part *wet = core->wet;
    memset(hidden, 0, (size_t)core->camera.width_px * core->camera.height_px * sizeof *hidden);
    if (wet == NULL || wet->cells == 0) return;
    size_t count = (size_t)wet->spec.rows * wet->spec.columns * 3;
    find_light(core, wet->sky, 1, wet->light);
    find_light(core, wet->sky, 0, wet->kept);
    for (size_t i = 0; i < count; i++)
        if (abs(wet->light[i] - wet->kept[i]) > HIDDEN_LEVELS) mark(core, i / 3, hidden);
    memset(wet->sharp, 255, count); /* the share of the light that comes from the sky: white less black */
    find_light(core, wet->sharp, 1, wet->light);
    memset(wet->sharp, 0, count);
    find_light(core, wet->sharp, 1, wet->kept);
    for (size_t i = 0; i < count; i++)
        if (wet->share[i / 3] - (wet->light[i] - wet->kept[i]) > HIDDEN_SHARE) mark(core, i / 3, hidden);
}
