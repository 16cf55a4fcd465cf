/* Random numbers by place and time: a stream for any key, so that what is drawn does not depend on what was drawn before. */
#ifndef VC_RANDOM_H
#define VC_RANDOM_H

#include <math.h>
#include <stdint.h>

#include "vc_math.h"

/* A hash that spreads all bits, and a generator by it (Steele, Lea and Flood 2014, "Fast splittable pseudorandom number
 * generators"). */
#define VC_GOLDEN 0x9e3779b97f4a7c15u
static inline uint64_t vc_mix(uint64_t value) {
    value += VC_GOLDEN;
    value = (value ^ (value >> 30)) * 0xbf58476d1ce4e5b9u;
    value = (value ^ (value >> 27)) * 0x94d049bb133111ebu;
    return value ^ (value >> 31);
}

typedef struct {
    uint64_t state;
} vc_random;

static inline uint64_t vc_next(vc_random *random) {
    uint64_t value = vc_mix(random->state);
    random->state += VC_GOLDEN;
    return value;
}

/* The stream of a seed and a key, such as a tick. */
static inline vc_random vc_stream(uint64_t seed, int64_t key) {
    vc_random outer = {seed};
    vc_random inner = {vc_next(&outer) ^ (uint64_t)key};
    vc_random stream = {vc_next(&inner)};
    return stream;
}

/* Uniform in 0..1, 1 excluded. */
static inline double vc_uniform(vc_random *random) { return (double)(vc_next(random) >> 11) * 0x1p-53; }

/* Normal, mean 0 and standard deviation 1, by the sum of 12 uniform numbers; at most 6 either way. */
static inline double vc_normal(vc_random *random) {
    double sum = -6.0;
    for (int i = 0; i < 12; i++) sum += vc_uniform(random);
    return sum;
}

/* A Poisson number: exact up to a mean of 64, by the normal distribution beyond. */
static inline int vc_poisson(vc_random *random, double mean) {
    if (mean > 64.0) {
        double number = mean + vc_normal(random) * sqrt(mean) + 0.5;
        return number > 0.0 ? (int)number : 0;
    }
    double least = vc_exp(-mean), product = vc_uniform(random);
    int number = 0;
    while (product > least) {
        product *= vc_uniform(random);
        number++;
    }
    return number;
}

#endif
