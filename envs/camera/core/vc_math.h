/* Elementary functions with the same bits on every machine.
 *
 * The C library's own functions differ between systems in their last bits. These use only additions, products, divisions
 * and square roots of doubles, which IEEE 754 rounds equally everywhere, as long as the compiler does not fuse or reorder
 * them: hence the checks below, and -ffp-contract=off in the build.
 */
#ifndef VC_MATH_H
#define VC_MATH_H

#include <float.h>

#define VC_PI 0x1.921fb54442d18p+1

#if defined(__FAST_MATH__)
#error "the camera's core needs exact arithmetic: build without -ffast-math"
#endif
#if FLT_EVAL_METHOD != 0
#error "the camera's core needs doubles without extra bits: build with -msse2 -mfpmath=sse"
#endif

/* Sine of an angle of at most 1,000,000 rad either way, within 0.75 of the last bit. */
double vc_sin(double angle_rad);

/* Cosine of an angle of at most 1,000,000 rad either way, within 0.75 of the last bit. */
double vc_cos(double angle_rad);

/* e^x for -700 <= x <= 700, and the natural logarithm of x > 0, within 2 of the last bit. */
double vc_exp(double x);
double vc_log(double x);

/* Length of (x, y), within 1.5 of the last bit; no guard against overflow. */
double vc_hypot(double x, double y);

#endif
