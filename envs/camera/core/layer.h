/* A canvas that is finer than the image, on which the faces of an item are drawn. */
#ifndef VC_LAYER_H
#define VC_LAYER_H

#include "internal.h"

typedef struct {
    uint32_t *samples;  /* transparent between items */
    vc_extent *extents; /* by row, what is filled */
    size_t room, rows;  /* samples, and rows, for which there is memory */
} vc_layer;

int vc_layer_make(vc_layer *layer, size_t samples, size_t rows); /* 0 without memory */
void vc_layer_free(vc_layer *layer);
/* Fills a convex polygon (n, 2), in samples, on a canvas of `wide` x `tall` samples. */
void vc_layer_fill(vc_layer *layer, int wide, int tall, const double *points, int count, uint32_t colour);
/* Lays the means of `fine` x `fine` samples over `wide` x `tall` pixels, rows `stride` bytes apart; empties the layer. */
void vc_layer_lay(vc_layer *layer, int wide, int tall, int fine, uint8_t *px, size_t stride);

#endif
