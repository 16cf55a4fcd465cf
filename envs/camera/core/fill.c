#include "internal.h"

/* One side of a convex polygon, from its top down. */
typedef struct {
    const double *points;
    int count, at, step, left; /* corner that the present edge ends at, +1 or -1, edges that are left */
    int end;                   /* the first row below the present edge */
    double x, slope;           /* where the edge crosses the middle of the present row; its change by row */
} Side;

/* Moves on to the edge that crosses the middle of a row; 0 where the side ends above. */
static int reach(Side *side, int row) {
    while (row >= side->end) {
        if (side->left-- == 0) return 0;
        const double *from = side->points + 2 * side->at;
        side->at += side->step;
        if (side->at < 0) side->at += side->count;
        if (side->at >= side->count) side->at -= side->count;
        const double *to = side->points + 2 * side->at;
        side->end = vc_ceil(to[1] - 0.5);
        if (side->end <= row) continue;
        side->slope = (to[0] - from[0]) / (to[1] - from[1]);
        side->x = from[0] + (row + 0.5 - from[1]) * side->slope;
    }
    return 1;
}

static void fill_span(uint32_t *row, int width, double left, double right, uint32_t value) {
    int first = left <= 0.0 ? 0 : left >= width ? width : vc_ceil(left - 0.5);
    int last = right <= 0.0 ? 0 : right >= width ? width : vc_ceil(right - 0.5);
    for (int column = first; column < last; column++) row[column] = value;
}

void vc_fill_convex(uint32_t *canvas, int width, int height, const double *points, int count, uint32_t value) {
    int top = 0;
    double lowest = points[1];
    for (int i = 1; i < count; i++) {
        if (points[2 * i + 1] < points[2 * top + 1]) top = i;
        if (points[2 * i + 1] > lowest) lowest = points[2 * i + 1];
    }
    if (lowest <= 0.0 || points[2 * top + 1] >= height) return;
    int first = vc_max(0, vc_ceil(points[2 * top + 1] - 0.5)), last = lowest >= height ? height : vc_ceil(lowest - 0.5);
    Side one = {points, count, top, 1, count, first, 0.0, 0.0}, other = {points, count, top, -1, count, first, 0.0, 0.0};
    for (int row = first; row < last; row++) {
        if (!reach(&one, row) || !reach(&other, row)) return;
        double a = one.x, b = other.x;
        fill_span(canvas + (size_t)row * width, width, a < b ? a : b, a < b ? b : a, value);
        one.x += one.slope;
        other.x += other.slope;
    }
}
