/* Prints hashes of what the core computes, without Python: equal on all machines. */
#include <stdint.h>
#include <stdio.h>
#include <string.h>

#include "vc_math.h"

/* FNV-1a over the bits of a value. */
static uint64_t add(uint64_t hash, double value) {
    uint64_t bits;
    memcpy(&bits, &value, sizeof bits);
    for (int i = 0; i < 8; i++) hash = (hash ^ (bits >> (8 * i) & 255)) * 0x100000001b3u;
    return hash;
}

int main(void) {
    uint64_t hash = 0xcbf29ce484222325u;
    for (int i = -200000; i <= 200000; i++) {
        double angle = i * 0.0137;
        hash = add(add(add(hash, vc_sin(angle)), vc_cos(angle)), vc_hypot(angle, 1.0));
    }
    printf("%016llx\n", (unsigned long long)hash);
    return 0;
}
