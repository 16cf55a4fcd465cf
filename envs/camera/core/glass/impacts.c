#include <math.h>

#include "glass/parts.h"

#define SMALLEST_MM 0.5 /* smaller drops are part of the film */
#define CLASS_MM 0.1

/* Sizes: N(D) = 8000 exp(-4.1 R^-0.21 D) / (m^3 mm) (Marshall and Palmer 1948). Fall speed: v(D) = 9.65 -
 * 10.3 exp(-0.6 D) m/s (Atlas, Srivastava and Sekhon 1973). At a speed V, glass of rake r is hit by
 * N(D) (V sin r + v(D) cos r) drops per second and m^2. */
void vc_impacts_fill(vc_impacts *impacts, double rain_mmph) {
    double slope = 4.1 * vc_exp(-0.21 * vc_log(fmax(rain_mmph, 1e-6)));
    for (int i = 0; i < VC_IMPACT_CLASSES; i++) {
        double middle = SMALLEST_MM + (i + 0.5) * CLASS_MM;
        double density = 8000.0 * vc_exp(-slope * middle) * CLASS_MM;
        impacts->by_speed[i] = density * VC_SIN_RAKE;
        impacts->by_fall[i] = density * (9.65 - 10.3 * vc_exp(-0.6 * middle)) * VC_COS_RAKE;
    }
}

double vc_impacts_rate(const vc_impacts *impacts, double speed_mps) {
    double rate = 0.0;
    for (int i = 0; i < VC_IMPACT_CLASSES; i++) rate += impacts->by_speed[i] * speed_mps + impacts->by_fall[i];
    return rate;
}

double vc_impacts_size(const vc_impacts *impacts, double speed_mps, double rate) {
    for (int i = 0; i < VC_IMPACT_CLASSES; i++) {
        double own = impacts->by_speed[i] * speed_mps + impacts->by_fall[i];
        if (rate <= own) return SMALLEST_MM + (i + rate / own) * CLASS_MM;
        rate -= own;
    }
    return SMALLEST_MM + VC_IMPACT_CLASSES * CLASS_MM;
}
