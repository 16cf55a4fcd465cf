/* The windscreen in front of a camera: drops, film and wiper.
 *
 * Water is a function of the seed, the time and the speeds up to then. It is simulated by ticks when a frame is drawn;
 * a frame that is skipped only notes its speed. A glass that begins at any time has the water that earlier frames at the
 * present speed would have left.
 */
#ifndef VC_GLASS_H
#define VC_GLASS_H

#include "core.h"

typedef struct vc_glass vc_glass;

typedef struct {
    vc_camera camera;
    double rain_mmph;       /* that hits the glass; 0 for no water */
    double wiper_period_s;  /* 0 for no wiper */
    double wiper_offset_s;  /* where in its period the wiper is at the time 0 */
    uint8_t sky[3];         /* RGB of the light that drops reflect */
    uint64_t seed;
} vc_windscreen;

/* A drop at rest or running. */
typedef struct {
    double x_px, y_px;   /* its centre */
    double size_mm;      /* diameter of a sphere of equal volume */
    double run_mps;      /* 0 at rest */
    int64_t dies_tick, moved_tick;
    int outline;         /* one of VC_OUTLINES shapes */
} vc_drop;
enum { VC_OUTLINES = 4 };

vc_glass *vc_glass_new(const vc_windscreen *windscreen); /* NULL without memory */
void vc_glass_free(vc_glass *glass);                     /* also of NULL */

const vc_camera *vc_glass_camera(const vc_glass *glass);

/* Goes to a time; `speed_mps` is that since the time before. */
void vc_glass_advance(vc_glass *glass, int64_t time_us, double speed_mps);
/* Draws water and blade of the present time over a frame of the camera's size. */
void vc_glass_draw(vc_glass *glass, vc_image image);
/* (height, width) 1 where water or blade hide more than half of the scene, else 0. */
void vc_glass_hidden(vc_glass *glass, uint8_t *hidden);
/* (height, width) opacity of the water, 0 to 255. */
void vc_glass_opacity(vc_glass *glass, uint8_t *opacity);

/* Angle of the blade at a time: 0 lying, pi / 2 standing. */
double vc_glass_blade_rad(const vc_glass *glass, int64_t time_us);
/* The drops of the present time; returns their number, of which at most `most` are written. */
int vc_glass_drops(vc_glass *glass, vc_drop *drops, int most);
/* Adds a drop at the present time. */
vc_status vc_glass_put(vc_glass *glass, const vc_drop *drop);

#endif
