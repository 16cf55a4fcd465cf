#include "internal.h"

#include <stdlib.h>
#include <string.h>

enum { LARGEST_PX = 8192 };

static int makes_sense(const vc_camera *camera) {
    return camera->width_px > 0 && camera->width_px <= LARGEST_PX && camera->height_px > 0 &&
           camera->height_px <= LARGEST_PX && camera->ground_top >= 0 && camera->ground_top <= camera->height_px &&
           camera->fx_px > 0.0 && camera->fy_px > 0.0 && camera->height_m > 0.0;
}

vc_core *vc_new(const vc_camera *camera) {
    if (!makes_sense(camera)) return NULL;
    vc_core *core = calloc(1, sizeof *core);
    if (core == NULL) return NULL;
    core->camera = *camera;
    vc_view_at(camera, 0.0, 0.0, 0.0, &core->frame.view);
    return core;
}

void vc_free(vc_core *core) {
    if (core == NULL) return;
    vc_ground_free(core->ground);
    vc_sky_free(core->sky);
    vc_scene_free(core->scene);
    vc_tree_free(core->trees);
    vc_lamps_free(core->lamps);
    vc_wet_free(core->wet);
    vc_spray_free(core->spray);
    vc_noise_free(core->noise);
    free(core->frame.items);
    free(core->frame.faces);
    free(core->frame.points);
    free(core);
}

int vc_ground_rows(const vc_core *core) { return core->camera.height_px - core->camera.ground_top; }

void vc_draw_backdrop(vc_core *core, vc_image image) {
    vc_draw_sky(core, image);
    vc_draw_ground(core, image);
}

void *vc_copied(const void *from, size_t count, size_t size, size_t spare) {
    char *copy = malloc(count * size + spare + 1);
    if (copy == NULL) return NULL;
    if (count > 0) memcpy(copy, from, count * size);
    memset(copy + count * size, 0, spare + 1);
    return copy;
}
