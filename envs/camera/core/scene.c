/* Takes over the content of the scene. */
#include "scene.h"

#include <stdlib.h>
#include <string.h>

#include "vc_math.h"

static void free_faces(Faces *faces) {
    void *all[] = {faces->starts, faces->points_m, faces->normals, faces->offsets_m, faces->colours, faces->flags,
                   faces->middles_m};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) free(all[i]);
}

static void free_mesh(Mesh *mesh) {
    free_faces(&mesh->faces);
    free(mesh->thickness_m);
    free(mesh->part_first);
    free(mesh->centres_m);
}

void vc_scene_free(vc_scene_part *scene) {
    if (scene == NULL) return;
    for (int i = 0; i < scene->meshes; i++) free_mesh(scene->mesh + i);
    free_faces(&scene->roadside.faces);
    Roadside *roadside = &scene->roadside;
    void *all[] = {(void *)scene->light.transmission, roadside->first,  roadside->circles_m,  roadside->from_m,
                   roadside->until_m,                 roadside->fading, scene->mesh,          scene->objects, scene->lamps,
                   scene->candidates,                 scene->order,     scene->nearest_m,     scene->distance_m, scene->boxes,
                   scene->in_front,                   scene->part_distance, scene->part_order};
    for (size_t i = 0; i < sizeof all / sizeof *all; i++) free(all[i]);
    vc_layer_free(&scene->layer);
    free(scene);
}

vc_status vc_set_light(vc_core *core, const vc_light *light) {
    if (core->scene != NULL || light->transmissions < 1) return VC_INVALID;
    vc_scene_part *scene = core->scene = calloc(1, sizeof *scene);
    if (scene == NULL) return VC_NO_MEMORY;
    scene->light = *light;
    scene->light.transmission = vc_copied(light->transmission, (size_t)light->transmissions, sizeof(double), 0);
    return scene->light.transmission == NULL ? VC_NO_MEMORY : vc_make_room(core);
}

/* Copies the corners of a face that differ from the one before; returns how many. */
static int take_corners(const double *from, int corners, double *to) {
    int kept = 0;
    for (int i = 0; i < corners; i++)
        if (i == 0 || memcmp(from + 3 * i, from + 3 * (i - 1), 3 * sizeof(double)) != 0)
            memcpy(to + 3 * kept++, from + 3 * i, 3 * sizeof(double));
    return kept;
}

static void middle_of(const double *points, int count, double *middle) {
    for (int j = 0; j < 3; j++) {
        double low = points[j], high = points[j];
        for (int i = 1; i < count; i++) {
            double place = points[3 * i + j];
            low = place < low ? place : low;
            high = place > high ? place : high;
        }
        middle[j] = 0.5 * (low + high);
    }
}

/* Takes faces in an order, NULL for their own. */
static vc_status take_faces(Faces *to, const vc_faces *from, const int32_t *order) {
    size_t count = (size_t)from->count;
    if (from->count < 0 || from->corners < 3 || from->corners > VC_CORNERS) return VC_INVALID;
    to->starts = malloc((count + 1) * sizeof *to->starts);
    to->points_m = malloc((count * from->corners + 1) * 3 * sizeof(double));
    to->normals = malloc((count + 1) * 3 * sizeof(double));
    to->offsets_m = malloc((count + 1) * sizeof(double));
    to->colours = malloc((count + 1) * 3 * sizeof(double));
    to->middles_m = malloc((count + 1) * 3 * sizeof(double));
    to->flags = malloc(count + 1);
    if (!to->starts || !to->points_m || !to->normals || !to->offsets_m || !to->colours || !to->flags || !to->middles_m)
        return VC_NO_MEMORY;
    to->count = from->count;
    to->starts[0] = 0;
    for (int i = 0; i < to->count; i++) {
        int source = order == NULL ? i : order[i];
        const double *points = from->points_m + (size_t)3 * from->corners * source, *normal = from->normals + 3 * source;
        to->starts[i + 1] = to->starts[i] + take_corners(points, from->corners, to->points_m + 3 * to->starts[i]);
        to->offsets_m[i] = normal[0] * points[0] + normal[1] * points[1] + normal[2] * points[2];
        memcpy(to->normals + 3 * i, normal, 3 * sizeof(double));
        memcpy(to->colours + 3 * i, from->colours + 3 * source, 3 * sizeof(double));
        to->flags[i] = from->flags[source];
        middle_of(to->points_m + 3 * to->starts[i], to->starts[i + 1] - to->starts[i], to->middles_m + 3 * i);
    }
    return VC_OK;
}

vc_status vc_set_roadside(vc_core *core, const vc_roadside *from, const vc_faces *faces) {
    vc_scene_part *scene = core->scene;
    if (scene == NULL || scene->roadside.items > 0 || from->items < 0) return VC_INVALID;
    for (int i = 0; i < from->items; i++)
        if (from->first[i] > from->first[i + 1] || from->first[0] != 0) return VC_INVALID;
    if (from->items > 0 && from->first[from->items] != faces->count) return VC_INVALID;
    Roadside *to = &scene->roadside;
    size_t items = (size_t)from->items, count = (size_t)faces->count;
    to->first = vc_copied(from->first, items + 1, sizeof *to->first, 0);
    to->circles_m = malloc((items + 1) * 3 * sizeof(double));
    to->from_m = vc_copied(from->from_m, count, sizeof(double), 0);
    to->until_m = vc_copied(from->until_m, count, sizeof(double), 0);
    to->fading = vc_copied(from->fading, count, sizeof(double), 0);
    if (!to->first || !to->circles_m || !to->from_m || !to->until_m || !to->fading) return VC_NO_MEMORY;
    for (size_t i = 0; i < items; i++) {
        to->circles_m[3 * i] = from->middles_m[2 * i];
        to->circles_m[3 * i + 1] = from->middles_m[2 * i + 1];
        to->circles_m[3 * i + 2] = from->radii_m[i];
    }
    vc_status status = take_faces(&to->faces, faces, NULL);
    if (status != VC_OK) return status;
    to->items = from->items;
    for (int i = 0; core->lamps == NULL && i < to->faces.count; i++) /* by day the roadside's light does not change */
        vc_shade(&scene->light, scene->light.sun, &to->faces, i, to->faces.colours + 3 * i);
    return vc_make_room(core);
}

/* The faces of a mesh part by part, and the first face of each part. */
static void group(const vc_mesh *mesh, int faces, int32_t *order, int32_t *part_first) {
    int count = 0;
    for (int part = 0; part < mesh->centres; part++) {
        part_first[part] = count;
        for (int i = 0; i < faces; i++)
            if (mesh->parts[i] == part) order[count++] = i;
    }
    part_first[mesh->centres] = count;
}

static double reach_of(const Faces *faces) {
    double reach = 0.0;
    for (int i = 0; i < faces->starts[faces->count]; i++) {
        const double *p = faces->points_m + 3 * i;
        double length = vc_hypot(vc_hypot(p[0], p[1]), p[2]);
        if (length > reach) reach = length;
    }
    return reach;
}

static vc_status take_mesh(Mesh *to, const vc_mesh *from, const vc_faces *faces) {
    size_t count = (size_t)faces->count, parts = (size_t)from->centres;
    for (size_t i = 0; i < count; i++)
        if (from->parts[i] < 0 || from->parts[i] >= from->centres) return VC_INVALID;
    int32_t *order = malloc((count + 1) * sizeof *order);
    to->part_first = malloc((parts + 1) * sizeof *to->part_first);
    to->centres_m = vc_copied(from->centres_m, parts, 3 * sizeof(double), 0);
    to->thickness_m = malloc((count + 1) * sizeof(double));
    vc_status status = VC_NO_MEMORY;
    if (order && to->part_first && to->centres_m && to->thickness_m) {
        group(from, faces->count, order, to->part_first);
        for (size_t i = 0; i < count; i++) to->thickness_m[i] = from->thickness_m[order[i]];
        status = take_faces(&to->faces, faces, order);
    }
    free(order);
    to->parts = from->centres;
    to->length_m = from->length_m;
    to->width_m = from->width_m;
    to->height_m = from->height_m;
    if (status == VC_OK) to->reach_m = reach_of(&to->faces);
    return status;
}

int vc_add_mesh(vc_core *core, const vc_mesh *mesh, const vc_faces *faces) {
    vc_scene_part *scene = core->scene;
    if (scene == NULL || mesh->centres < 1 || faces->count < 0) return VC_INVALID;
    Mesh *all = realloc(scene->mesh, ((size_t)scene->meshes + 1) * sizeof *all);
    if (all == NULL) return VC_NO_MEMORY;
    scene->mesh = all;
    Mesh *added = all + scene->meshes;
    memset(added, 0, sizeof *added);
    vc_status status = take_mesh(added, mesh, faces);
    if (status != VC_OK) {
        free_mesh(added);
        return status;
    }
    scene->meshes++;
    status = vc_make_room(core);
    return status == VC_OK ? scene->meshes - 1 : status;
}
