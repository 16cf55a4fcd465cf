/* A rolling shutter: rows are read one after another, so what moves across is shifted from row to row. */
#include <string.h>

#include "internal.h"

enum { FRACTION = 8, ONE = 1 << FRACTION }; /* bits of a fraction of a pixel */

static void repeat(const uint8_t *px, int count, uint8_t *to) {
    for (int i = 0; i < count; i++) memcpy(to + 3 * i, px, 3);
}

static void blend(const uint8_t *restrict from, uint8_t *restrict to, int bytes, int share) {
    uint16_t right = (uint16_t)share, left = (uint16_t)(ONE - share);
    for (int i = 0; i < bytes; i++) {
        uint16_t sum = (uint16_t)(from[i] * left + from[i + 3] * right + ONE / 2);
        to[i] = (uint8_t)(sum >> FRACTION);
    }
}

/* A row whose pixel x shows what `from` has at x + shift / ONE, linear between pixels; the ends go on beyond it. */
static void shift_row(const uint8_t *from, uint8_t *to, int width, int64_t shift) {
    int64_t limit = (int64_t)width << FRACTION;
    shift = shift < -limit ? -limit : shift > limit ? limit : shift;
    int share = (int)(shift & (ONE - 1)), whole = (int)((shift - share) / ONE);
    int first = vc_clamp(-whole, 0, width), last = vc_clamp(width - 1 - whole, first, width);
    repeat(from, first, to);
    if (last > first) blend(from + 3 * (first + whole), to + 3 * first, 3 * (last - first), share);
    repeat(from + 3 * (width - 1), width - last, to + 3 * last);
}

void vc_read_out(const vc_core *core, double shift_px, vc_image from, vc_image to) {
    size_t bytes = 3 * (size_t)from.width;
    for (int y = 0; y < from.height; y++) {
        double shift = vc_limit(shift_px * (y - core->camera.cy_px), -1e6, 1e6) * ONE + 0.5;
        int64_t whole = (int64_t)shift;
        shift_row(from.px + y * bytes, to.px + y * bytes, from.width, whole - ((double)whole > shift));
    }
}
