#include "internal.h"

#include <string.h>

#include "vc_math.h"

void vc_multiply(const double *a, const double *b, double *product) {
    double result[9];
    for (int i = 0; i < 3; i++)
        for (int j = 0; j < 3; j++)
            result[3 * i + j] = a[3 * i] * b[j] + a[3 * i + 1] * b[3 + j] + a[3 * i + 2] * b[6 + j];
    memcpy(product, result, sizeof result);
}

void vc_invert(const double *m, double *inverse) {
    double a = m[4] * m[8] - m[5] * m[7], b = m[5] * m[6] - m[3] * m[8], c = m[3] * m[7] - m[4] * m[6];
    double scale = 1.0 / (m[0] * a + m[1] * b + m[2] * c);
    double result[9] = {
        a * scale, (m[2] * m[7] - m[1] * m[8]) * scale, (m[1] * m[5] - m[2] * m[4]) * scale,
        b * scale, (m[0] * m[8] - m[2] * m[6]) * scale, (m[2] * m[3] - m[0] * m[5]) * scale,
        c * scale, (m[1] * m[6] - m[0] * m[7]) * scale, (m[0] * m[4] - m[1] * m[3]) * scale,
    };
    memcpy(inverse, result, sizeof result);
}

static void project_axes(const vc_camera *camera, vc_view *view) {
    double *p = view->projection;
    for (int j = 0; j < 3; j++) {
        p[j] = camera->fx_px * view->axes[0][j] + camera->cx_px * view->axes[2][j];
        p[4 + j] = camera->fy_px * view->axes[1][j] + camera->cy_px * view->axes[2][j];
        p[8 + j] = view->axes[2][j];
    }
    for (int i = 0; i < 12; i += 4)
        p[i + 3] = -(p[i] * view->centre[0] + p[i + 1] * view->centre[1] + p[i + 2] * view->centre[2]);
}

void vc_view_at(const vc_camera *camera, double x_m, double y_m, double yaw_rad, vc_view *view) {
    double c = vc_cos(yaw_rad), s = vc_sin(yaw_rad);
    double pitch_c = vc_cos(camera->pitch_rad), pitch_s = vc_sin(camera->pitch_rad);
    double axes[3][3] = {{-s, c, 0.0}, {-pitch_s * c, -pitch_s * s, -pitch_c}, {pitch_c * c, pitch_c * s, -pitch_s}};
    view->yaw_rad = yaw_rad;
    view->cos_yaw = c;
    view->sin_yaw = s;
    view->centre[0] = x_m + camera->forward_m * c;
    view->centre[1] = y_m + camera->forward_m * s;
    view->centre[2] = camera->height_m;
    memcpy(view->axes, axes, sizeof axes);
    project_axes(camera, view);
}

void vc_ground_homography(const vc_camera *camera, const vc_view *view, double *matrix) {
    for (int i = 0; i < 3; i++) {
        matrix[3 * i] = view->projection[4 * i];
        matrix[3 * i + 1] = view->projection[4 * i + 1];
        matrix[3 * i + 2] = view->projection[4 * i + 3];
    }
    vc_invert(matrix, matrix);
    for (int i = 0; i < 9; i++) matrix[i] *= camera->height_m;
}

int vc_clip(const double *corners, int count, double *clipped) {
    int kept = 0;
    for (int i = 0; i < count; i++) {
        const double *here = corners + 3 * i, *next = corners + 3 * (i + 1 < count ? i + 1 : 0);
        int inside = here[2] > VC_NEAR_M;
        if (inside) memcpy(clipped + 3 * kept++, here, 3 * sizeof *here);
        if (inside == (next[2] > VC_NEAR_M)) continue;
        double share = (VC_NEAR_M - here[2]) / (next[2] - here[2]);
        for (int j = 0; j < 3; j++) clipped[3 * kept + j] = here[j] + share * (next[j] - here[j]);
        kept++;
    }
    return kept;
}
