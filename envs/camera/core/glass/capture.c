#include <string.h>

#include "glass/parts.h"

enum { FILM_REACH = 2, DROP_REACH = VC_BLUR_REACH }; /* px of the small images; a drop of 10 px is blurred by 4 px */
enum { SKY = 31 }; /* share of reflected skylight in a drop, of 256 */

/* Halves or quarters an image by the four pixels about the middle of each block. */
static void shrink(const uint8_t *from, int width, int height, const vc_small *to) {
    uint32_t across = ((uint32_t)width << 16) / (uint32_t)to->width, down = ((uint32_t)height << 16) / (uint32_t)to->height;
    for (int y = 0; y < to->height; y++) {
        int row = vc_min((int)((down / 2 + down * (uint32_t)y) >> 16), height - 1);
        const uint8_t *low = from + (size_t)row * width * 3, *high = from + (size_t)vc_max(row - 1, 0) * width * 3;
        uint8_t *px = to->px + (size_t)y * to->width * 3;
        uint32_t place = across / 2;
        for (int x = 0; x < to->width; x++, px += 3, place += across) {
            int right = vc_min((int)(place >> 16), width - 1) * 3, left = vc_max(right - 3, 0);
            for (int i = 0; i < 3; i++)
                px[i] = (uint8_t)((high[left + i] + high[right + i] + low[left + i] + low[right + i] + 2) >> 2);
        }
    }
}

/* A place mirrored at the ends of 0..size - 1. */
static int mirrored(int place, int size) {
    if (size == 1) return 0;
    int period = 2 * (size - 1);
    place = (place % period + period) % period;
    return place < size ? place : period - place;
}

/* Adds bytes to sums. */
static void add(uint16_t *restrict sums, const uint8_t *restrict bytes, int count) {
    for (int i = 0; i < count; i++) sums[i] = (uint16_t)(sums[i] + bytes[i]);
}

/* sum / parts, rounded, for sums of at most 13 bytes. */
static void divide(uint8_t *restrict means, const uint16_t *restrict sums, int count, int parts) {
    uint32_t scale = 65536u / (uint32_t)parts;
    for (int i = 0; i < count; i++) means[i] = (uint8_t)((sums[i] * scale + 32768) >> 16);
}

/* A row with `reach` mirrored pixels at both ends. */
static void pad(uint8_t *padded, const uint8_t *row, int width, int reach) {
    memcpy(padded + 3 * reach, row, (size_t)width * 3);
    for (int i = 1; i <= reach; i++) {
        memcpy(padded + 3 * (reach - i), row + 3 * mirrored(-i, width), 3);
        memcpy(padded + 3 * (reach + width - 1 + i), row + 3 * mirrored(width - 1 + i, width), 3);
    }
}

/* Means over squares of 2 reach + 1 pixels: along the rows, then down the columns. */
static void blur(const vc_small *image, int reach, vc_scratch *scratch) {
    int bytes = 3 * image->width, parts = 2 * reach + 1;
    for (int y = 0; y < image->height; y++) {
        pad(scratch->padded, image->px + (size_t)y * bytes, image->width, reach);
        memset(scratch->sums, 0, (size_t)bytes * sizeof *scratch->sums);
        for (int i = 0; i < parts; i++) add(scratch->sums, scratch->padded + 3 * i, bytes);
        divide(scratch->copy + (size_t)y * bytes, scratch->sums, bytes, parts);
    }
    for (int y = 0; y < image->height; y++) {
        memset(scratch->sums, 0, (size_t)bytes * sizeof *scratch->sums);
        for (int i = -reach; i <= reach; i++)
            add(scratch->sums, scratch->copy + (size_t)mirrored(y + i, image->height) * bytes, bytes);
        divide(image->px + (size_t)y * bytes, scratch->sums, bytes, parts);
    }
}

void vc_capture(vc_image image, const uint8_t *sky, vc_small *film, vc_small *scene, vc_scratch *scratch) {
    shrink(image.px, image.width, image.height, film);
    shrink(film->px, film->width, film->height, scene);
    blur(film, FILM_REACH, scratch);
    blur(scene, DROP_REACH, scratch);
    for (int i = 0; i < 3 * scene->width * scene->height; i++)
        scene->px[i] = (uint8_t)((scene->px[i] * (256 - SKY) + sky[i % 3] * SKY + 128) >> 8);
}
