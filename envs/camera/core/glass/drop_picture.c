#include <math.h>
#include <string.h>

#include "glass/parts.h"

/* A drop on the glass is far out of focus. A spot of width w with a blur disc of b is constant over |w - b| and fades
 * out at w + b; a spot smaller than the pupil covers only (w / b)^2 of the light. A drop is a lens of a few mm focal
 * length: it shows the whole scene small and upside down, with a darker rim. */
#define PUPIL_MM 1.5 /* diameter of the entrance pupil: 3 mm at f/2 */
#define REACH 0.85   /* share of the scene shown to either side of its middle */
#define RIM_FROM 102 /* of 255, distance from the middle from which on the shade grows */

enum { SHADES = 4 };
static const int SHADE[SHADES] = {256, 230, 200, 164}; /* brightness from the middle to the rim, of 256 */

/* Radius of an outline in the direction (x, y) of length 1, 0.8 to 1, by two turned waves: their cosines and sines. */
static double outline(const double *waves, double x, double y) {
    double twice[2] = {x * x - y * y, 2.0 * x * y};
    double thrice[2] = {twice[0] * x - twice[1] * y, twice[1] * x + twice[0] * y};
    return 0.9 + 0.06 * (twice[0] * waves[0] - twice[1] * waves[1]) +
           0.04 * (thrice[0] * waves[2] + thrice[1] * waves[3]);
}

static void fill_disc(uint8_t *disc, const double *waves) {
    for (int row = 0; row < VC_DISC; row++)
        for (int column = 0; column < VC_DISC; column++) {
            double x = (2.0 * column + 1.0) / VC_DISC - 1.0, y = (2.0 * row + 1.0) / VC_DISC - 1.0;
            double radius = vc_hypot(x, y), edge = waves == NULL ? 1.0 : outline(waves, x / radius, y / radius);
            disc[row * VC_DISC + column] = (uint8_t)vc_round(fmin(255.0 * radius / edge, 255.0));
        }
}

void vc_discs_fill(vc_discs *discs) {
    fill_disc(discs->discs[0], NULL);
    for (int i = 0; i < VC_OUTLINES; i++) {
        double turn = 1.7 * i, waves[4] = {vc_cos(turn), vc_sin(turn), vc_cos(2.3 * turn), vc_sin(2.3 * turn)};
        fill_disc(discs->discs[1 + i], waves);
    }
}

/* A drop's box on the planes, and how to walk through its disc and through the scene, in 1/65536. */
typedef struct {
    const uint8_t *disc;
    int x0, y0, x1, y1;           /* planes, within the image */
    int32_t u0, v0, du, dv;       /* disc at (x0, y0), and its steps */
    int32_t sx0, sy0, dsx, dsy;   /* the same in the scene */
    int thick;                    /* whether it shades */
    uint8_t alpha[256];           /* opacity by distance from the middle */
} Look;

static void fill_alpha(Look *look, double w, double h, double bx, double by) {
    double level = (fabs(w - bx) + fabs(h - by)) / (w + h + bx + by);
    double cover = 65280.0 * fmin(1.0, w / bx) * fmin(1.0, h / by); /* of 255 x 256 */
    int most = vc_round(cover), slope = vc_round(cover / 255.0 / fmax(1.0 - level, 1e-3));
    for (int i = 0; i < 256; i++) look->alpha[i] = (uint8_t)((vc_min(most, (255 - i) * slope) + 128) >> 8);
}

static int32_t fixed(double value) { return (int32_t)vc_round(value * 65536.0); }

/* The scene at a place of the planes, from middle - REACH to middle + REACH of a drop upside down. */
static void fill_scene(Look *look, const vc_small *scene, double x, double y, double wide, double tall, int rows,
                       int width) {
    double middle_x = 0.5 * (scene->width - 1), middle_y = 0.5 * (scene->height - 1);
    double anchor_x = middle_x * (1.0 + (1.0 - REACH) * (2.0 * x / width - 1.0));
    double anchor_y = middle_y * (1.0 + (1.0 - REACH) * (2.0 * y / rows - 1.0));
    double by_x = -2.0 / wide * REACH * (0.5 * scene->width - 1.0);
    double by_y = -2.0 / tall * REACH * (0.5 * scene->height - 1.0);
    look->dsx = fixed(by_x);
    look->dsy = fixed(by_y);
    look->sx0 = fixed(anchor_x + (look->x0 - x) * by_x + 0.5);
    look->sy0 = fixed(anchor_y + (look->y0 - y) * by_y + 0.5);
}

/* Fills in how a drop is drawn; returns whether any of it is in the image. */
static int look_at(const vc_drop_look *how, const vc_drop *drop, int rows, Look *look) {
    const vc_pane *pane = how->pane;
    const vc_pane_row *row = &pane->rows[vc_pane_row_at(pane, drop->y_px)];
    double spot = VC_FOOTPRINT * drop->size_mm, blur = PUPIL_MM * row->across;
    double w = spot * row->across, h = spot * row->along / VC_PLANE_ROWS, by = blur / VC_PLANE_ROWS;
    double x = drop->x_px, y = (drop->y_px - 0.5 * (VC_PLANE_ROWS - 1)) / VC_PLANE_ROWS;
    double wide = w + blur, tall = h + by;
    int width = pane->camera->width_px;
    look->x0 = vc_max(vc_ceil(x - 0.5 * wide), 0);
    look->y0 = vc_max(vc_ceil(y - 0.5 * tall), 0);
    look->x1 = vc_min(vc_floor(x + 0.5 * wide) + 1, width);
    look->y1 = vc_min(vc_floor(y + 0.5 * tall) + 1, rows);
    if (look->x0 >= look->x1 || look->y0 >= look->y1) return 0;
    look->thick = w > 2.0 * blur;
    look->disc = how->discs->discs[look->thick ? 1 + drop->outline : 0];
    look->du = fixed(VC_DISC / wide);
    look->dv = fixed(VC_DISC / tall);
    look->u0 = fixed((look->x0 - x + 0.5 * wide) * VC_DISC / wide);
    look->v0 = fixed((look->y0 - y + 0.5 * tall) * VC_DISC / tall);
    fill_alpha(look, w, h, blur, by);
    fill_scene(look, how->scene, x, y, wide, tall, rows, width);
    return 1;
}

static const uint8_t *disc_row(const Look *look, int y) {
    return look->disc + vc_min((look->v0 + (y - look->y0) * look->dv) >> 16, VC_DISC - 1) * VC_DISC;
}

static void cover_row(const Look *look, int y, uint8_t *opacity) {
    const uint8_t *disc = disc_row(look, y);
    int32_t u = look->u0;
    for (int x = look->x0; x < look->x1; x++, u += look->du) {
        uint8_t alpha = look->alpha[disc[vc_min(u >> 16, VC_DISC - 1)]];
        if (alpha > opacity[x]) opacity[x] = alpha;
    }
}

static void blend(uint8_t *px, const uint8_t *shown, int alpha, int shade) {
    int left = 255 - alpha;
    alpha = alpha * shade >> 8;
    for (int i = 0; i < 3; i++) px[i] = (uint8_t)vc_by_255((uint32_t)(px[i] * left + shown[i] * alpha));
}

static void blend_row(const Look *look, const vc_small *scene, int y, uint8_t *upper, uint8_t *lower) {
    const uint8_t *disc = disc_row(look, y);
    int row = vc_clamp((look->sy0 + (y - look->y0) * look->dsy) >> 16, 0, scene->height - 1);
    const uint8_t *shown = scene->px + (size_t)row * scene->width * 3;
    int32_t u = look->u0, sx = look->sx0;
    for (int x = look->x0; x < look->x1; x++, u += look->du, sx += look->dsx) {
        int distance = disc[vc_min(u >> 16, VC_DISC - 1)], alpha = look->alpha[distance];
        if (alpha == 0) continue;
        const uint8_t *from = shown + 3 * vc_clamp(sx >> 16, 0, scene->width - 1);
        int rim = distance <= RIM_FROM || !look->thick ? 0 : (distance - RIM_FROM) * SHADES / (256 - RIM_FROM);
        blend(upper + 3 * x, from, alpha, SHADE[rim]);
        if (lower != NULL) blend(lower + 3 * x, from, alpha, SHADE[rim]);
    }
}

void vc_drop_draw(const vc_drop_look *how, const vc_drop *drop, vc_image image, uint8_t *opacity) {
    int width = how->pane->camera->width_px, height = how->pane->camera->height_px;
    int rows = (height + VC_PLANE_ROWS - 1) / VC_PLANE_ROWS;
    Look look;
    if (!look_at(how, drop, rows, &look)) return;
    for (int y = look.y0; y < look.y1; y++) {
        if (image.px == NULL) {
            cover_row(&look, y, opacity + (size_t)y * width);
            continue;
        }
        uint8_t *upper = image.px + (size_t)(VC_PLANE_ROWS * y) * width * 3;
        blend_row(&look, how->scene, y, upper, VC_PLANE_ROWS * y + 1 < height ? upper + 3 * width : NULL);
    }
}
