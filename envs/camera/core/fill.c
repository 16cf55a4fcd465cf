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

/* The columns whose middles lie right of a place begin here. */
static int column_at(double place, int width) { return place <= 0.0 ? 0 : place >= width ? width : vc_ceil(place - 0.5); }

static void fill_span(uint32_t *row, int first, int last, uint32_t value) {
    for (int column = first; column < last; column++) row[column] = value;
}

static void widen(vc_extent *extent, int first, int last) {
    if (first >= last) return;
    extent->first = vc_min(extent->first, first);
    extent->last = vc_max(extent->last, last);
}

void vc_fill_convex(uint32_t *canvas, int width, int height, const double *points, int count, uint32_t value,
                    vc_extent *extents) {
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
        int a = column_at(one.x, width), b = column_at(other.x, width), left = vc_min(a, b), right = vc_max(a, b);
        fill_span(canvas + (size_t)row * width, left, right, value);
        if (extents != NULL) widen(extents + row, left, right);
        one.x += one.slope;
        other.x += other.slope;
    }
}
