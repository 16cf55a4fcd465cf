/* Memory for the frames of a scene, as large as its content can need. */
#include <stdlib.h>

#include "rain/spray.h"
#include "scene.h"

/* Grows an array; what it held is lost. */
static int grow(void *array, size_t count, size_t size) {
    void **pointer = array;
    free(*pointer);
    *pointer = malloc((count + 1) * size);
    return *pointer != NULL;
}

static int room_for_objects(vc_scene_part *scene) {
    size_t count = (size_t)scene->reserved;
    return grow(&scene->lamps, (size_t)scene->lamp_room, sizeof *scene->lamps) &&
           grow(&scene->objects, count, sizeof *scene->objects) && grow(&scene->order, count, sizeof *scene->order) &&
           grow(&scene->distance_m, count, sizeof(double)) && grow(&scene->nearest_m, count, sizeof(double));
}

static int room_for_frame(vc_core *core) {
    vc_scene_part *scene = core->scene;
    vc_frame *frame = &core->frame;
    int faces = 0, parts = 1;
    for (int i = 0; i < scene->meshes; i++) {
        faces = vc_max(faces, scene->mesh[i].faces.count);
        parts = vc_max(parts, scene->mesh[i].parts);
    }
    size_t candidates = (size_t)scene->roadside.items + vc_tree_count(core) + scene->lamp_room;
    scene->face_room = scene->roadside.faces.count + faces * scene->reserved + VC_SHADOW_FACES;
    int puffs = vc_spray_room(core, scene->reserved);
    if (puffs < 0) return 0;
    scene->item_room = (int)candidates + scene->reserved + puffs;
    scene->point_room = scene->face_room * (VC_CORNERS + 2);
    return grow(&scene->candidates, candidates, sizeof *scene->candidates) &&
           grow(&scene->part_distance, (size_t)parts, sizeof(double)) &&
           grow(&scene->part_order, (size_t)parts, sizeof(int)) &&
           grow(&frame->faces, (size_t)scene->face_room, sizeof *frame->faces) &&
           grow(&frame->items, (size_t)scene->item_room, sizeof *frame->items) &&
           grow(&frame->points, (size_t)scene->point_room, 2 * sizeof(double));
}

static int room_for_drawing(vc_core *core) {
    vc_scene_part *scene = core->scene;
    if (scene->layer.samples != NULL) return 1;
    size_t samples = (size_t)vc_max(VC_LAYER, 16 * core->camera.width_px);
    return vc_layer_make(&scene->layer, samples, 4 * (size_t)core->camera.height_px) &&
           grow(&scene->boxes, VC_ORDERED, sizeof *scene->boxes) &&
           grow(&scene->in_front, VC_ORDERED * VC_ORDERED, 1);
}

vc_status vc_make_room(vc_core *core) {
    core->frame.item_count = core->frame.face_count = core->frame.point_count = core->frame.object_count = 0;
    core->scene->order_count = core->frame.lamp_count = 0;
    core->scene->lamp_room = core->lamps == NULL ? 0 : 2 * core->scene->reserved + vc_lamp_room(core);
    return room_for_objects(core->scene) && room_for_frame(core) && room_for_drawing(core) ? VC_OK : VC_NO_MEMORY;
}

vc_status vc_reserve(vc_core *core, int objects) {
    if (core->scene == NULL || objects < 0) return VC_INVALID;
    if (objects <= core->scene->reserved) return VC_OK;
    core->scene->reserved = objects;
    return vc_make_room(core);
}
