#include <math.h>

#include "glass/parts.h"

static const double PIVOT_M[2] = {-0.45, 0.62}; /* right of the optical axis, down along the glass */

/* It moves as a sine from lying along the lower edge to standing by the left edge and back, then rests. */
double vc_wiper_angle(const vc_wiper *wiper, double time_s) {
    double periods = (time_s + wiper->offset_s) / wiper->period_s;
    double phase = (periods - floor(periods)) * wiper->period_s / wiper->cycle_s;
    return phase >= 1.0 ? 0.0 : 0.5 * VC_SWEEP_RAD * (1.0 - vc_cos(2.0 * VC_PI * phase));
}

/* Whether the wiper is at a place in its period, s from its start, within a span of time. */
static int passes(const vc_wiper *wiper, double place_s, double from_s, double until_s) {
    double periods = (place_s - from_s - wiper->offset_s) / wiper->period_s;
    return (periods - floor(periods)) * wiper->period_s <= until_s - from_s;
}

vc_swath vc_wiper_swath(const vc_wiper *wiper, double from_s, double until_s) {
    double first = vc_wiper_angle(wiper, from_s), last = vc_wiper_angle(wiper, until_s);
    double low = fmin(first, last), high = fmax(first, last);
    if (passes(wiper, 0.0, from_s, until_s)) low = 0.0;
    if (passes(wiper, 0.5 * wiper->cycle_s, from_s, until_s)) high = VC_SWEEP_RAD;
    vc_swath swath = {low, high, {vc_cos(low), vc_sin(low)}, {vc_cos(high), vc_sin(high)}};
    return swath;
}

void vc_from_pivot(const double *point, double *arm) {
    arm[0] = point[0] - PIVOT_M[0];
    arm[1] = PIVOT_M[1] - point[1];
}

static double cross(const double *a, const double *b) { return a[0] * b[1] - a[1] * b[0]; }

int vc_swath_holds(const vc_swath *swath, const double *point) {
    double arm[2];
    vc_from_pivot(point, arm);
    double square = arm[0] * arm[0] + arm[1] * arm[1];
    if (square < VC_BLADE_FROM_M * VC_BLADE_FROM_M || square > VC_BLADE_UNTIL_M * VC_BLADE_UNTIL_M) return 0;
    return cross(swath->low, arm) >= 0.0 && cross(swath->high, arm) <= 0.0;
}

void vc_to_point(const double *arm, double *point) {
    point[0] = PIVOT_M[0] + arm[0];
    point[1] = PIVOT_M[1] - arm[1];
}
