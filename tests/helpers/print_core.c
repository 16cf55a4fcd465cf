/* Prints hashes of what the core computes, without Python: equal on all machines. */
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "glass/glass.h"
#include "rain/streaks.h"
#include "vc_math.h"

/* FNV-1a. */
static uint64_t add_bytes(uint64_t hash, const uint8_t *bytes, size_t count) {
    for (size_t i = 0; i < count; i++) hash = (hash ^ bytes[i]) * 0x100000001b3u;
    return hash;
}

/* The same over the bits of a value. */
static uint64_t add(uint64_t hash, double value) {
    uint8_t bytes[8];
    memcpy(bytes, &value, sizeof bytes);
    return add_bytes(hash, bytes, sizeof bytes);
}

/* Ten frames through a wet windscreen. */
static uint64_t add_glass(uint64_t hash) {
    static uint8_t px[120 * 160 * 3];
    vc_image image = {px, 160, 120};
    vc_windscreen windscreen = {{160, 120, 80.0, 80.0, 79.5, 59.5, 0.0, 0.0, 0.0, 0}, 50.0, 0.92, 0.3, {150, 160, 170}, 7};
    vc_glass *glass = vc_glass_new(&windscreen);
    for (int k = 0; k < 10; k++) {
        for (size_t i = 0; i < sizeof px; i++) px[i] = (uint8_t)(7 * i);
        vc_glass_advance(glass, 150000 * k, 5.5 * k);
        vc_glass_draw(glass, image);
        hash = add_bytes(hash, px, sizeof px);
    }
    vc_glass_free(glass);
    return hash;
}

/* Ten frames of falling rain, at growing speed. */
static uint64_t add_streaks(uint64_t hash) {
    static uint8_t px[120 * 160 * 3];
    vc_image image = {px, 160, 120};
    vc_rainfall rainfall = {{160, 120, 80.0, 80.0, 79.5, 59.5, 0.0, 0.0, 0.03, 0}, 50.0, 0.002, 170.0, 1.0, 7};
    vc_streaks *streaks = vc_streaks_new(&rainfall);
    for (int k = 0; k < 10; k++) {
        memset(px, 70, sizeof px);
        vc_air air = vc_streaks_air(streaks, (double[3]){-2.7 * k, 3.0, 0.0}, 0.31 * k);
        vc_streaks_draw(streaks, &air, 150000 * k, image);
        hash = add_bytes(hash, px, sizeof px);
    }
    vc_streaks_free(streaks);
    return hash;
}

int main(void) {
    uint64_t hash = add_streaks(add_glass(0xcbf29ce484222325u));
    for (int i = -200000; i <= 200000; i++) {
        double angle = i * 0.0137;
        hash = add(add(add(hash, vc_sin(angle)), vc_cos(angle)), vc_hypot(angle, 1.0));
    }
    printf("%016llx\n", (unsigned long long)hash);
    return 0;
}
