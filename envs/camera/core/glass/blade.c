#include <math.h>

#include "glass/parts.h"

#define WIDTH_M 0.016 /* of blade and arm */
#define BLUR_M 0.005  /* so near to the lens */
#define EXPOSURE_S 0.004
#define GREY 22     /* grey level of the blade */
#define COVER 0.94  /* its opacity */

/* The blade of one moment: its direction, and the distance over which its sides fade. */
typedef struct {
    double along[2]; /* cosine, sine */
    double speed;    /* rad during the exposure */
} Blade;

/* Share of the light that the blade takes at a point of the glass. */
static double cover(const Blade *blade, const double *point) {
    double arm[2];
    vc_from_pivot(point, arm);
    double along = arm[0] * blade->along[0] + arm[1] * blade->along[1];
    double across = fabs(arm[1] * blade->along[0] - arm[0] * blade->along[1]);
    double soft = vc_hypot(BLUR_M, along * blade->speed);
    double beside = (0.5 * (WIDTH_M + soft) - across) / soft;
    double end = fmin(along - VC_BLADE_FROM_M, VC_BLADE_UNTIL_M - along) / BLUR_M + 0.5;
    return vc_limit(beside, 0.0, fmin(1.0, WIDTH_M / soft)) * vc_limit(end, 0.0, 1.0);
}

/* Corners of the blade in the image, px, with its soft sides. */
static void corners(const vc_pane *pane, double angle, double margin_m, double quad[4][2]) {
    double c = vc_cos(angle), s = vc_sin(angle), half = 0.5 * WIDTH_M + margin_m;
    for (int i = 0; i < 4; i++) {
        double along = i < 2 ? VC_BLADE_FROM_M - BLUR_M : VC_BLADE_UNTIL_M + BLUR_M, across = i == 0 || i == 3 ? -half : half;
        double arm[2] = {along * c - across * s, along * s + across * c}, point[2];
        vc_to_point(arm, point);
        vc_pane_pixel(pane, point[0], point[1], quad[i]);
    }
}

/* The columns between which a convex quad crosses the rows `top` to `bottom`; returns whether it does. */
static int columns(double quad[4][2], double top, double bottom, double *left, double *right) {
    *left = INFINITY;
    *right = -INFINITY;
    for (int i = 0; i < 4; i++) {
        const double *a = quad[i], *b = quad[(i + 1) % 4];
        double low = fmin(a[1], b[1]), high = fmax(a[1], b[1]);
        if (high < top || low > bottom) continue;
        for (int side = 0; side < 2; side++) {
            double y = vc_limit(side ? bottom : top, low, high);
            double x = high > low ? a[0] + (b[0] - a[0]) * (y - a[1]) / (b[1] - a[1]) : side ? b[0] : a[0];
            *left = fmin(*left, x);
            *right = fmax(*right, x);
        }
    }
    return *left <= *right;
}

static void darken(vc_image image, int x, int y, int opacity) {
    if (y >= image.height) return;
    uint8_t *px = image.px + ((size_t)y * image.width + x) * 3;
    for (int i = 0; i < 3; i++) px[i] = (uint8_t)vc_by_255((uint32_t)(px[i] * (255 - opacity) + GREY * opacity));
}

static void draw_row(const vc_pane *pane, const Blade *blade, int y, int first, int last, vc_image image, uint8_t *opacity) {
    int width = pane->camera->width_px, height = pane->camera->height_px;
    for (int x = first; x < last; x++) {
        double point[2];
        vc_pane_point(pane, x, y + 0.5 * (VC_PLANE_ROWS - 1), point);
        int alpha = vc_round(255.0 * COVER * cover(blade, point));
        for (int i = 0; alpha > 0 && i < VC_PLANE_ROWS && y + i < height; i++) {
            if (image.px != NULL) darken(image, x, y + i, alpha);
            else opacity[(size_t)(y + i) * width + x] = (uint8_t)alpha;
        }
    }
}

void vc_blade_draw(const vc_pane *pane, const vc_wiper *wiper, double time_s, vc_image image, uint8_t *opacity) {
    double angle = vc_wiper_angle(wiper, time_s), quad[4][2];
    double earlier = vc_wiper_angle(wiper, time_s - 0.5 * EXPOSURE_S);
    double later = vc_wiper_angle(wiper, time_s + 0.5 * EXPOSURE_S);
    Blade blade = {{vc_cos(angle), vc_sin(angle)}, fabs(later - earlier)};
    corners(pane, angle, 0.5 * (BLUR_M + VC_BLADE_UNTIL_M * blade.speed), quad);
    for (int y = 0; y < pane->camera->height_px; y += VC_PLANE_ROWS) {
        double left, right;
        if (!columns(quad, y - 1.0, y + VC_PLANE_ROWS, &left, &right)) continue;
        int first = (int)vc_limit(left, 0.0, pane->camera->width_px);
        int last = (int)vc_limit(right + 2.0, 0.0, pane->camera->width_px);
        draw_row(pane, &blade, y, first, last, image, opacity);
    }
}
