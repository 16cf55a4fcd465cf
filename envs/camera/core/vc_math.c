#include "vc_math.h"

#include <math.h>

/* An angle within a quarter turn around 0, as the sum of two doubles, and the quarter turns taken off it. */
typedef struct {
    double high, low;
    int quarter;
} Reduced;

/* A quarter turn in three parts; the first two have 33 bits, so that their products with whole numbers are exact. */
static const double QUARTER[3] = {0x1.921fb54400000p+0, 0x1.0b4611a600000p-34, 0x1.3198a2e037073p-69};
static const double QUARTERS_PER_RAD = 0x1.45f306dc9c883p-1;

static Reduced reduce(double angle) {
    double turns = floor(angle * QUARTERS_PER_RAD + 0.5);
    double first = angle - turns * QUARTER[0];
    double second = turns * QUARTER[1];
    double rest = first - second;
    double low = ((first - rest) - second) - turns * QUARTER[2];
    double high = rest + low;
    Reduced reduced = {high, (rest - high) + low, (int)((long long)turns & 3)};
    return reduced;
}

/* Taylor's series of sin(a) / a and cos(a) from their third and second terms; the next term is below 2^-60. */
static double sine(double a, double low) {
    double z = a * a;
    double tail = -1.0 / 6.0 +
                  z * (1.0 / 120.0 +
                       z * (-1.0 / 5040.0 +
                            z * (1.0 / 362880.0 +
                                 z * (-1.0 / 39916800.0 +
                                      z * (1.0 / 6227020800.0 +
                                           z * (-1.0 / 1307674368000.0 + z * (1.0 / 355687428096000.0)))))));
    return a + (a * z * tail + low * (1.0 - 0.5 * z));
}

static double cosine(double a, double low) {
    double z = a * a;
    double tail = 1.0 / 24.0 +
                  z * (-1.0 / 720.0 +
                       z * (1.0 / 40320.0 +
                            z * (-1.0 / 3628800.0 +
                                 z * (1.0 / 479001600.0 +
                                      z * (-1.0 / 87178291200.0 +
                                           z * (1.0 / 20922789888000.0 + z * (-1.0 / 6402373705728000.0)))))));
    double half = 0.5 * z;
    double whole = 1.0 - half;
    return whole + (((1.0 - whole) - half) + (z * z * tail - a * low));
}

static double quadrant(Reduced angle, int quarter) {
    double value = quarter & 1 ? cosine(angle.high, angle.low) : sine(angle.high, angle.low);
    return quarter & 2 ? -value : value;
}

double vc_sin(double angle_rad) {
    Reduced angle = reduce(angle_rad);
    return quadrant(angle, angle.quarter);
}

double vc_cos(double angle_rad) {
    Reduced angle = reduce(angle_rad);
    return quadrant(angle, angle.quarter + 1);
}

/* e^x = 2^k e^r with |r| <= ln 2 / 2; the first part of ln 2 has 33 bits. */
double vc_exp(double x) {
    static const double LN2[2] = {0x1.62e42fef00000p-1, 0x1.473de6af278edp-34};
    double k = floor(x * 0x1.71547652b82fep+0 + 0.5);
    double r = (x - k * LN2[0]) - k * LN2[1];
    double sum = 1.0;
    for (int n = 14; n > 0; n--) sum = 1.0 + sum * r / n;
    return ldexp(sum, (int)k);
}

/* Halley's method for e^y = m with x = m 2^k: each step triples the digits. */
double vc_log(double x) {
    int k;
    double m = frexp(x, &k);
    double y = (m - 0.75) / 0.75 - 0.28768207245178093;
    for (int i = 0; i < 3; i++) {
        double e = vc_exp(y);
        y += 2.0 * (m - e) / (m + e);
    }
    return y + k * 0x1.62e42fefa39efp-1;
}

double vc_hypot(double x, double y) {
    return sqrt(x * x + y * y);
}
