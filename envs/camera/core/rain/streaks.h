/* Falling rain: every visible drop as a speck or a streak.
 *
 * Drops are drawn anew for each moment, since between frames a drop moves farther than its streak is long.
 */
#ifndef VC_STREAKS_H
#define VC_STREAKS_H

#include "core.h"

typedef struct vc_streaks vc_streaks;

typedef struct {
    vc_camera camera;
    double rain_mmph;   /* > 0 */
    double exposure_s;
    double brightness;  /* of a drop, grey levels; it is invisible before what is as bright */
    double gain;        /* of the drops' light; 1 is physical, less than 1 also leaves out those that become too faint */
    uint64_t seed;
} vc_rainfall;

/* A projected drop. */
typedef struct {
    double x_px, y_px;   /* its middle */
    double dx_px, dy_px; /* its motion during the exposure */
    double width_px;
    double level;        /* grey levels above what is behind it */
} vc_speck;

/* Velocity of the air in the camera's axes, right, down, depth, and the direction of fall there. */
typedef struct {
    double drift_mps[3], down[3];
} vc_air;

vc_streaks *vc_streaks_new(const vc_rainfall *rainfall); /* NULL without memory */
void vc_streaks_free(vc_streaks *streaks);               /* also of NULL */

const vc_camera *vc_streaks_camera(const vc_streaks *streaks);

/* The air that moves at a velocity (3,) m/s of the world's axes as a camera with this yaw sees it. */
vc_air vc_streaks_air(const vc_streaks *streaks, const double *velocity_mps, double yaw_rad);
/* Draws the drops of a moment. */
void vc_streaks_draw(vc_streaks *streaks, const vc_air *air, int64_t time_us, vc_image image);
/* Lists them instead; returns their number, of which at most `most` are written. */
int vc_streaks_list(vc_streaks *streaks, const vc_air *air, int64_t time_us, vc_image image, vc_speck *specks, int most);

#endif
