/* What the files of the windscreen share. */
#ifndef VC_GLASS_INTERNAL_H
#define VC_GLASS_INTERNAL_H

#include "glass/glass.h"
#include "internal.h"
#include "vc_random.h"

enum { VC_TICK_US = 50000 };
#define VC_TICK_S 0.05

/* ---- pane.c: the glass is a plane, inclined by its rake against the optical axis, nearer at the top of the image ---- */

/* The rake is 55 deg, as in a van; flatter glass would not fill the image. */
#define VC_SIN_RAKE 0.81915204428899180
#define VC_COS_RAKE 0.57357643635104609

/* The glass by image row. */
typedef struct {
    double depth_m;        /* of the glass along the optical axis */
    double across, along;  /* px per mm of glass along the row, and down the image */
    double above_m2;       /* area of glass above the row's upper edge */
} vc_pane_row;

typedef struct {
    const vc_camera *camera;
    vc_pane_row *rows; /* (height + 1,) */
} vc_pane;

void vc_pane_fill(vc_pane *pane);
int vc_pane_row_at(const vc_pane *pane, double y_px); /* within the image */
/* (u, s) m of the point of the glass that a pixel shows: right of the optical axis, and down along the glass. */
void vc_pane_point(const vc_pane *pane, double x_px, double y_px, double *point);
void vc_pane_pixel(const vc_pane *pane, double u_m, double s_m, double *pixel);
/* y_px of a share of the glass's area from the top. */
double vc_pane_spread(const vc_pane *pane, double share);

/* ---- wiper.c: one blade that turns about a pivot below the image on the left ---- */

#define VC_BLADE_FROM_M 0.25
#define VC_BLADE_UNTIL_M 0.84
#define VC_CYCLE_S 1.33 /* up and down, 45 per minute; less for shorter periods */
#define VC_SWEEP_RAD (0.5 * VC_PI)

typedef struct {
    double period_s, cycle_s, offset_s; /* a period of 0 for no wiper */
} vc_wiper;

/* The angles that the blade passes in a span of time. */
typedef struct {
    double low_rad, high_rad;
    double low[2], high[2]; /* directions: cosine, sine */
} vc_swath;

double vc_wiper_angle(const vc_wiper *wiper, double time_s);
vc_swath vc_wiper_swath(const vc_wiper *wiper, double from_s, double until_s);
int vc_swath_holds(const vc_swath *swath, const double *point); /* a point (u, s) of the glass */
/* (right, up) m from the pivot to a point (u, s), and back. */
void vc_from_pivot(const double *point, double *arm);
void vc_to_point(const double *arm, double *point);

/* ---- drops.c: drops land, merge, run, dry and are wiped ---- */

/* Drops that landed in one span of GENERATION ticks. They meet each other only, so that no history is longer. */
typedef struct {
    int64_t number, tick; /* which span; the tick that it has been simulated to */
    int count;
    vc_drop *drops; /* (most,) */
} vc_generation;
enum { VC_GENERATIONS = 3, VC_GENERATION_TICKS = 80, VC_HISTORY = VC_GENERATIONS * VC_GENERATION_TICKS };

#define VC_FOOTPRINT 1.83 /* diameter of the spot over that of the drop */

/* How many drops of which size hit the glass. */
enum { VC_IMPACT_CLASSES = 55 };
typedef struct {
    double by_speed[VC_IMPACT_CLASSES], by_fall[VC_IMPACT_CLASSES]; /* impacts / (s m^2): per m/s, and at rest */
} vc_impacts;

typedef struct {
    vc_generation generations[VC_GENERATIONS];
    vc_impacts impacts;
    int most; /* drops of a generation */
    float speeds_mps[VC_HISTORY]; /* by tick */
    uint64_t seed;
} vc_drops;

void vc_impacts_fill(vc_impacts *impacts, double rain_mmph);
double vc_impacts_rate(const vc_impacts *impacts, double speed_mps); /* impacts / (s m^2) */
double vc_impacts_size(const vc_impacts *impacts, double speed_mps, double rate); /* mm, the `rate` smaller drops */
/* Forgets all drops, and assumes a speed for the time before. */
void vc_drops_begin(vc_drops *drops, double speed_mps);
void vc_drops_note(vc_drops *drops, int64_t tick, double speed_mps); /* the speed of the next tick */
vc_status vc_drops_put(vc_drops *drops, int64_t tick, const vc_drop *drop); /* into the newest generation */
void vc_drops_simulate(vc_drops *drops, const vc_pane *pane, const vc_wiper *wiper, int64_t tick);

/* ---- drop_picture.c: how a drop looks ---- */

enum { VC_DISC = 64, VC_PLANE_ROWS = 2 };

/* Distance from the middle by place in a drop's box, of 255 at its outline: round, and by outline. */
typedef struct {
    uint8_t discs[1 + VC_OUTLINES][VC_DISC * VC_DISC];
} vc_discs;

/* What water shows: a blurred image for the film, and a smaller one that drops turn upside down. */
typedef struct {
    int width, height;
    uint8_t *px; /* (height, width, 3) */
} vc_small;

void vc_discs_fill(vc_discs *discs);
typedef struct {
    const vc_pane *pane;
    const vc_discs *discs;
    const vc_small *scene; /* what drops show */
} vc_drop_look;
/* Draws a drop over a frame; with NULL pixels only its opacity over `opacity` (rows, width), the larger one stays. */
void vc_drop_draw(const vc_drop_look *look, const vc_drop *drop, vc_image image, uint8_t *opacity);

/* ---- film.c: thin water between the drops, fresh behind the blade ---- */

typedef struct {
    int rows, width;     /* pairs of image rows, image columns */
    uint8_t *old;        /* (rows, width, 3) opacity long after the blade, each value three times */
    uint8_t *fresh;      /* (rows, width) right behind it */
    uint16_t *angle;     /* (rows, width) of the blade, in FILM_ANGLES of its sweep; the last one for out of reach */
    uint16_t *range;     /* (rows, 2) smallest and largest angle of each row */
    uint8_t *row;        /* (3 width,) opacity by byte, scratch */
    uint8_t *shown;      /* (3 width,) what a row shows, scratch */
} vc_film;
enum { VC_FILM_ANGLES = 1024 };

void vc_film_fill(vc_film *film, const vc_pane *pane, int wiped, uint64_t seed);
void vc_film_draw(const vc_film *film, const vc_wiper *wiper, double time_s, const vc_small *picture, vc_image image);

/* ---- capture.c ---- */

enum { VC_BLUR_REACH = 6 };

/* For blurring the film's picture. */
typedef struct {
    uint8_t *copy;   /* of the picture */
    uint8_t *padded; /* a row, with VC_BLUR_REACH pixels at both ends */
    uint16_t *sums;  /* a row */
} vc_scratch;

/* Takes the small images from a frame. */
void vc_capture(vc_image image, const uint8_t *sky, vc_small *film, vc_small *scene, vc_scratch *scratch);

/* ---- blade.c ---- */

/* Draws the blade over a frame, or into `opacity` (height, width) with NULL pixels. */
void vc_blade_draw(const vc_pane *pane, const vc_wiper *wiper, double time_s, vc_image image, uint8_t *opacity);

#endif
