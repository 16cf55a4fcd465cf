/* How many drops of which size are visible in which part of the image. */
#ifndef VC_SHOWER_H
#define VC_SHOWER_H

#include "rain/streaks.h"

/* A stratum is one size class in one cell of the image, out to the range at which its largest and slowest drop is seen. */
enum { VC_SIZES = 29, VC_CELLS_X = 16, VC_CELLS_Y = 12, VC_CELLS = VC_CELLS_X * VC_CELLS_Y, VC_STRATA = VC_SIZES * VC_CELLS };
enum { VC_GUIDES = 4096 };
#define VC_SMALLEST_MM 0.3
#define VC_SIZE_MM 0.2    /* width of a class */
#define VC_NEAREST_M 0.6  /* no rain nearer than the windscreen */

typedef struct {
    int drift[3];                  /* rounded, m/s: what it was computed for */
    int used;
    double expected;               /* number of drops over all strata, also nearer than VC_NEAREST_M */
    float range_m[VC_STRATA];
    uint32_t until[VC_STRATA];     /* share of the drops up to each stratum, of 2^32 */
    uint16_t guides[VC_GUIDES];    /* the stratum at each 4096th of the drops */
} vc_shower;

/* v(D) = 9.65 - 10.3 exp(-0.6 D) m/s (Atlas, Srivastava and Sekhon 1973), by hundredths of mm. */
enum { VC_SPEEDS = 612 };
void vc_fall_speeds(double *speeds);
static inline double vc_fall_speed(const double *speeds, double diameter_mm) {
    double place = 100.0 * diameter_mm;
    int i = (int)place;
    return speeds[i] + (place - i) * (speeds[i + 1] - speeds[i]);
}

/* The shower of drops with an opacity of at least `faintest`, for air that drifts at the shower's rounded velocity. */
void vc_shower_fill(vc_shower *shower, const vc_rainfall *rainfall, const double *speeds, const double *down, double faintest);
int vc_shower_stratum(const vc_shower *shower, uint32_t share);

#endif
