/* Which raster of a level a view needs. Anchors depend on the view alone, not on the frames before. */
#include <string.h>

#include "ground.h"
#include "vc_math.h"

/* The raster of an anchor: the one that is kept, or the one that was used least recently. */
static Raster *slot_of(Level *level, int64_t heading, int64_t right) {
    Raster *oldest = level->slots;
    for (int i = 0; i < VC_SLOTS; i++) {
        Raster *slot = level->slots + i;
        if (slot->valid && slot->heading == heading && slot->right == right) return slot;
        if (slot->used < oldest->used) oldest = slot;
    }
    oldest->valid = 0;
    oldest->heading = heading;
    oldest->right = right;
    return oldest;
}

/* The mapping of a steep raster that begins at a row and column of its lattice. */
static void lattice(const vc_level *spec, int64_t heading, double row, double column, double *from_world) {
    double c = vc_cos((double)heading * spec->turn_rad), s = vc_sin((double)heading * spec->turn_rad);
    double matrix[9] = {-s / spec->across_m, c / spec->across_m, -0.5 - column,
                        c / spec->along_m,   s / spec->along_m,  -0.5 - row,
                        0.0,                 0.0,                1.0};
    memcpy(from_world, matrix, sizeof matrix);
}

static void paint_block(vc_ground_part *ground, Level *level, Raster *raster, int64_t first, int block) {
    const vc_level *spec = &level->spec;
    int rows = (int)spec->step;
    double from_world[9];
    lattice(spec, raster->heading, (double)(first + block) * spec->step, (double)raster->right * spec->sidestep,
            from_world);
    vc_paint_raster(ground, level, from_world, rows, raster->texels + (size_t)block * rows * spec->columns);
}

static void update_steep(vc_ground_part *ground, Level *level, const vc_view *view) {
    const vc_level *spec = &level->spec;
    int64_t heading = vc_round(view->yaw_rad / spec->turn_rad);
    double c = vc_cos((double)heading * spec->turn_rad), s = vc_sin((double)heading * spec->turn_rad);
    double x = view->centre[0], y = view->centre[1];
    double right = (c * y - s * x + spec->right_m) / spec->across_m - 1.0;
    double ahead = (c * x + s * y + spec->ahead_m) / spec->along_m - 1.0;
    int64_t column = vc_round(right / spec->sidestep) - 1, first = vc_floor(ahead / spec->step);
    Raster *raster = slot_of(level, heading, column);
    int blocks = spec->rows / (int)spec->step;
    size_t block_texels = (size_t)spec->step * spec->columns;
    int64_t moved = raster->valid ? first - raster->ahead : blocks;
    if (moved < -blocks || moved > blocks) moved = blocks;
    int kept = blocks - (int)(moved < 0 ? -moved : moved);
    if (moved > 0) memmove(raster->texels, raster->texels + moved * block_texels, kept * block_texels * sizeof *raster->texels);
    if (moved < 0) memmove(raster->texels - moved * block_texels, raster->texels, kept * block_texels * sizeof *raster->texels);
    for (int block = 0; block < blocks; block++)
        if (moved > 0 ? block >= kept : block < -moved) paint_block(ground, level, raster, first, block);
    raster->valid = 1;
    raster->ahead = first;
    lattice(spec, heading, (double)first * spec->step, (double)column * spec->sidestep, raster->from_world);
    raster->used = ground->frame;
    level->now = raster;
}

static void update_far(vc_core *core, Level *level, const vc_view *view) {
    const vc_level *spec = &level->spec;
    int64_t heading = vc_round(view->yaw_rad / spec->turn_rad - spec->phase);
    double angle = ((double)heading + spec->phase) * spec->turn_rad, c = vc_cos(angle), s = vc_sin(angle);
    double x = view->centre[0], y = view->centre[1];
    int64_t steps = vc_round((c * x + s * y) / spec->step - spec->phase);
    int64_t sidesteps = vc_round((c * y - s * x) / spec->sidestep - spec->phase);
    Raster *raster = slot_of(level, heading, sidesteps);
    raster->used = core->ground->frame;
    level->now = raster;
    if (raster->valid && raster->ahead == steps) return;
    double ahead = ((double)steps + spec->phase) * spec->step, right = ((double)sidesteps + spec->phase) * spec->sidestep;
    double forward = core->camera.forward_m;
    vc_view anchor;
    vc_view_at(&core->camera, ahead * c - right * s - forward * c, ahead * s + right * c - forward * s, angle, &anchor);
    double *matrix = raster->from_world;
    vc_ground_homography(&core->camera, &anchor, matrix);
    vc_invert(matrix, matrix);
    vc_multiply(spec->to_texels, matrix, matrix);
    for (int i = 0; i < 9; i++) matrix[i] *= spec->depth_scale;
    vc_paint_raster(core->ground, level, matrix, spec->rows, raster->texels);
    raster->valid = 1;
    raster->ahead = steps;
}

void vc_update_rasters(vc_core *core) {
    vc_ground_part *ground = core->ground;
    ground->frame++;
    for (int i = 0; i < ground->levels; i++) {
        Level *level = ground->level + i;
        if (level->spec.steep)
            update_steep(ground, level, &core->frame.view);
        else
            update_far(core, level, &core->frame.view);
    }
}
