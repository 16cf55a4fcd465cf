#include <math.h>

#include "glass/parts.h"

#define DISTANCE_M 0.1 /* along the optical axis */
#define NEAREST_SHARE 0.5 /* limits of the depth, also for rays that miss the glass */
#define FARTHEST_SHARE 3.0

static double depth_at(const vc_camera *camera, double y_px) {
    double t = (y_px - camera->cy_px) / camera->fy_px;
    double share = 1.0 / fmax(1.0 - t * VC_COS_RAKE / VC_SIN_RAKE, 0.1);
    return DISTANCE_M * vc_limit(share, NEAREST_SHARE, FARTHEST_SHARE);
}

void vc_pane_fill(vc_pane *pane) {
    const vc_camera *camera = pane->camera;
    double above_m2 = 0.0;
    for (int y = 0; y <= camera->height_px; y++) {
        vc_pane_row *row = &pane->rows[y];
        row->depth_m = depth_at(camera, y);
        row->across = 1e-3 * camera->fx_px / row->depth_m;
        row->along = 1e-3 * camera->fy_px * DISTANCE_M * VC_SIN_RAKE / (row->depth_m * row->depth_m);
        row->above_m2 = above_m2;
        above_m2 += 1e-6 * camera->width_px / (row->across * row->along);
    }
}

int vc_pane_row_at(const vc_pane *pane, double y_px) {
    return (int)vc_limit(y_px + 0.5, 0.0, pane->camera->height_px - 0.5);
}

void vc_pane_point(const vc_pane *pane, double x_px, double y_px, double *point) {
    const vc_camera *camera = pane->camera;
    double depth = depth_at(camera, y_px);
    point[0] = (x_px - camera->cx_px) / camera->fx_px * depth;
    point[1] = (y_px - camera->cy_px) / camera->fy_px * depth / VC_SIN_RAKE;
}

void vc_pane_pixel(const vc_pane *pane, double u_m, double s_m, double *pixel) {
    const vc_camera *camera = pane->camera;
    double depth = fmax(DISTANCE_M + s_m * VC_COS_RAKE, 0.1 * DISTANCE_M);
    pixel[0] = camera->cx_px + camera->fx_px * u_m / depth;
    pixel[1] = camera->cy_px + camera->fy_px * s_m * VC_SIN_RAKE / depth;
}

double vc_pane_spread(const vc_pane *pane, double share) {
    int low = 0, high = pane->camera->height_px;
    double area = share * pane->rows[high].above_m2;
    while (high - low > 1) {
        int middle = (low + high) / 2;
        if (pane->rows[middle].above_m2 <= area) low = middle;
        else high = middle;
    }
    double above = pane->rows[low].above_m2;
    return low - 0.5 + (area - above) / (pane->rows[low + 1].above_m2 - above);
}
