/* Finds what a view shows and projects it, the farthest first. */
#include <stdlib.h>
#include <string.h>

#include "scene.h"
#include "vc_math.h"

#define RANGE_M 250.0         /* of furniture beside the road */
#define OBJECT_RANGE_M 220.0  /* at which objects appear, and from which they are opaque */
#define OBJECT_OPAQUE_M 180.0
#define THINNEST_PX 0.6       /* thinner faces of objects are left out */
#define FULL (1.0 / 0.15)     /* an item of the roadside fades over the last share of its range */
#define ON_EDGE_M 1e-6        /* least distance from the plane of a visible face */

uint32_t vc_hazed(const vc_light *light, const double *contrast, double depth_m, double opacity) {
    int step = vc_clamp(vc_floor(depth_m / VC_HAZE_STEP_M), 0, light->transmissions - 1);
    double left = light->transmission[step] * opacity;
    uint32_t colour = (uint32_t)vc_round(255.0 * (1.0 - opacity)) << 24;
    for (int i = 0; i < 3; i++) {
        int level = vc_round(contrast[i] * left + opacity * light->horizon[i]);
        colour |= (uint32_t)vc_clamp(level, 0, 255) << (8 * i);
    }
    return colour;
}

void vc_shade(const vc_light *light, const double *sun, const Faces *faces, int index, double *contrast) {
    const double *n = faces->normals + 3 * index, *colour = faces->colours + 3 * index;
    double facing = n[0] * sun[0] + n[1] * sun[1] + n[2] * sun[2];
    for (int i = 0; i < 3; i++) {
        double factor = light->sky[i] + light->direct[i] * (facing > 0.0 ? facing : 0.0);
        double level = faces->flags[index] & VC_LIT ? colour[i] * factor : colour[i];
        contrast[i] = (level < 255.0 ? level : 255.0) - light->horizon[i];
    }
}

static void add_face(vc_core *core, vc_growing *growing, const double *projection, const Faces *faces, int index,
                     double distance_m, uint32_t colour) {
    int start = faces->starts[index];
    vc_face face = {core->frame.item_count, 0, 0, colour, faces->normals + 3 * index, distance_m};
    vc_item_add(core, growing, projection, faces->points_m + 3 * start, faces->starts[index + 1] - start, face);
}

static void keep(vc_core *core, vc_growing *growing) {
    vc_frame *frame = &core->frame;
    VC_CHECK(frame->item_count < core->scene->item_room);
    if (vc_item_end(core, growing)) frame->items[frame->item_count++] = growing->item;
}

static double distance_of(const Faces *faces, int index, const double *eye) {
    const double *n = faces->normals + 3 * index;
    return n[0] * eye[0] + n[1] * eye[1] + n[2] * eye[2] - faces->offsets_m[index];
}

/* Contrast with the horizon of a face in the light of lamps; its middle and normal in world axes. */
static void light_up(const vc_core *core, const Faces *faces, int index, const double *middle, const double *normal,
                     double *contrast) {
    double factors[3] = {1.0, 1.0, 1.0};
    const double *horizon = core->scene->light.horizon;
    if (faces->flags[index] & VC_LIT) vc_lamplight(core, middle, normal, faces->flags[index], factors);
    for (int i = 0; i < 3; i++) {
        double level = faces->colours[3 * index + i] * factors[i];
        contrast[i] = (level < 255.0 ? level : 255.0) - horizon[i];
    }
}

static void add_furniture(vc_core *core, int index, double depth_m) {
    const Roadside *roadside = &core->scene->roadside;
    const vc_view *view = &core->frame.view;
    vc_growing growing = vc_item_begin(core, -1, depth_m);
    for (int i = roadside->first[index]; i < roadside->first[index + 1]; i++) {
        if (depth_m < roadside->from_m[i] || depth_m >= roadside->until_m[i]) continue;
        double distance = distance_of(&roadside->faces, i, view->centre);
        double opacity = vc_limit(FULL - depth_m * roadside->fading[i], 0.0, 1.0);
        if (distance <= ON_EDGE_M || opacity <= 0.0) continue;
        double contrast[3];
        const double *shown = roadside->faces.colours + 3 * i;
        if (core->lamps != NULL) {
            light_up(core, &roadside->faces, i, roadside->faces.middles_m + 3 * i, roadside->faces.normals + 3 * i, contrast);
            shown = contrast;
        }
        uint32_t colour = vc_hazed(&core->scene->light, shown, depth_m, opacity);
        add_face(core, &growing, view->projection, &roadside->faces, i, distance, colour);
    }
    keep(core, &growing);
}

/* The view from a mesh's axes. */
typedef struct {
    double eye[3], sun[3], projection[12], depth_m;
} Near;

static Near near_of(const vc_core *core, const vc_object *object) {
    const vc_view *view = &core->frame.view;
    const double *sun = core->scene->light.sun, *p = view->projection;
    double c = vc_cos(object->heading_rad), s = vc_sin(object->heading_rad);
    double x = view->centre[0] - object->x_m, y = view->centre[1] - object->y_m;
    Near near = {{c * x + s * y, c * y - s * x, view->centre[2]},
                 {c * sun[0] + s * sun[1], c * sun[1] - s * sun[0], sun[2]}, {0}, 0.0};
    for (int i = 0; i < 12; i += 4) {
        near.projection[i] = p[i] * c + p[i + 1] * s;
        near.projection[i + 1] = p[i + 1] * c - p[i] * s;
        near.projection[i + 2] = p[i + 2];
        near.projection[i + 3] = p[i] * object->x_m + p[i + 1] * object->y_m + p[i + 3];
    }
    near.depth_m = -(view->axes[2][0] * x + view->axes[2][1] * y + view->axes[2][2] * view->centre[2]);
    return near;
}

/* The parts of a mesh, the farthest first, in scene->part_order. */
static void order_parts(vc_scene_part *scene, const Mesh *mesh, const double *eye) {
    for (int i = 0; i < mesh->parts; i++) {
        const double *centre = mesh->centres_m + 3 * i;
        double x = centre[0] - eye[0], y = centre[1] - eye[1], z = centre[2] - eye[2], squared = x * x + y * y + z * z;
        int at = i;
        for (; at > 0 && scene->part_distance[at - 1] < squared; at--) {
            scene->part_distance[at] = scene->part_distance[at - 1];
            scene->part_order[at] = scene->part_order[at - 1];
        }
        scene->part_distance[at] = squared;
        scene->part_order[at] = i;
    }
}

static uint32_t shaded(const vc_light *light, const Faces *faces, int index, const Near *near, double opacity) {
    double contrast[3];
    vc_shade(light, near->sun, faces, index, contrast);
    return vc_hazed(light, contrast, near->depth_m, opacity);
}

/* The same in the light of lamps. */
static uint32_t lit_by_lamps(const vc_core *core, const Faces *faces, int index, const vc_object *object, const Near *near,
                             double opacity) {
    double c = vc_cos(object->heading_rad), s = vc_sin(object->heading_rad), contrast[3];
    const double *n = faces->normals + 3 * index, *m = faces->middles_m + 3 * index;
    double normal[3] = {c * n[0] - s * n[1], s * n[0] + c * n[1], n[2]};
    double middle[3] = {object->x_m + c * m[0] - s * m[1], object->y_m + s * m[0] + c * m[1], m[2]};
    light_up(core, faces, index, middle, normal, contrast);
    return vc_hazed(&core->scene->light, contrast, near->depth_m, opacity);
}

static void add_object(vc_core *core, int index, double nearest_m) {
    vc_scene_part *scene = core->scene;
    const vc_object *object = scene->objects + index;
    const Mesh *mesh = scene->mesh + object->mesh;
    Near near = near_of(core, object);
    double opacity = vc_limit((OBJECT_RANGE_M - near.depth_m) / (OBJECT_RANGE_M - OBJECT_OPAQUE_M), 0.0, 1.0);
    if (opacity <= 0.0) return;
    double thinnest_m = THINNEST_PX * (near.depth_m > 2.0 ? near.depth_m - 2.0 : 0.0) / core->camera.fx_px;
    vc_growing growing = vc_item_begin(core, index + 1, nearest_m);
    order_parts(scene, mesh, near.eye);
    for (int k = 0; k < mesh->parts; k++) {
        int part = scene->part_order[k];
        for (int i = mesh->part_first[part]; i < mesh->part_first[part + 1]; i++) {
            double distance = distance_of(&mesh->faces, i, near.eye);
            if (mesh->thickness_m[i] < thinnest_m || distance <= ON_EDGE_M) continue;
            uint32_t colour = core->lamps == NULL
                                  ? shaded(&scene->light, &mesh->faces, i, &near, opacity)
                                  : lit_by_lamps(core, &mesh->faces, i, object, &near, opacity);
            add_face(core, &growing, near.projection, &mesh->faces, i, distance, colour);
        }
    }
    keep(core, &growing);
}

static int find_furniture(const vc_core *core, Candidate *candidates) {
    const Roadside *roadside = &core->scene->roadside;
    const vc_view *view = &core->frame.view;
    const double *ahead = view->axes[2], *right = view->axes[0];
    double slope = 0.5 * core->camera.width_px / core->camera.fx_px;
    int count = 0;
    for (int i = 0; i < roadside->items; i++) {
        const double *circle = roadside->circles_m + 3 * i;
        double x = circle[0] - view->centre[0], y = circle[1] - view->centre[1], reach = circle[2];
        double depth = ahead[0] * x + ahead[1] * y, aside = right[0] * x + right[1] * y;
        double wide = slope * (depth + reach) + 1.5 * reach;
        if (depth <= -reach || depth >= RANGE_M || aside > wide || aside < -wide) continue;
        Candidate found = {depth, VC_FACES, i};
        candidates[count++] = found;
    }
    return count;
}

/* The farthest first; the order of equals does not depend on the sort. */
static int by_depth(const void *a, const void *b) {
    const Candidate *one = a, *other = b;
    if (one->depth_m != other->depth_m) return one->depth_m < other->depth_m ? 1 : -1;
    if (one->kind != other->kind) return one->kind < other->kind ? -1 : 1;
    return one->index < other->index ? -1 : one->index > other->index;
}

static void add_scenery(vc_core *core, const Candidate *candidate) {
    if (candidate->kind == VC_FACES) {
        add_furniture(core, candidate->index, candidate->depth_m);
        return;
    }
    vc_item item = {candidate->kind, -1, candidate->index, candidate->index, 0, 0, 0, 0, candidate->depth_m};
    int shows = candidate->kind == VC_TREE ? vc_tree_box(core, candidate->index, candidate->depth_m, &item)
                                           : vc_glow_box(core, candidate->index, &item);
    if (shows) core->frame.items[core->frame.item_count++] = item;
}

/* The lamps of an object, or those that belong to none, as candidates. */
static int find_lamps(const vc_core *core, int object, Candidate *candidates) {
    int count = 0;
    for (int i = 0; i < core->frame.lamp_count; i++) {
        const vc_lamp *lamp = core->frame.lamps + i;
        if (lamp->object == object) candidates[count++] = (Candidate){lamp->depth_m, VC_GLOW, i};
    }
    return count;
}

/* Objects in their own order; scenery before the first object that begins nearer. */
static void add_all(vc_core *core) {
    vc_scene_part *scene = core->scene;
    int count = find_furniture(core, scene->candidates);
    count += vc_find_trees(core, scene->candidates + count);
    count += find_lamps(core, -1, scene->candidates + count);
    qsort(scene->candidates, (size_t)count, sizeof *scene->candidates, by_depth);
    int next = 0;
    for (int k = 0; k < scene->order_count; k++) {
        int object = scene->order[k];
        for (; next < count && scene->candidates[next].depth_m > scene->nearest_m[object]; next++)
            add_scenery(core, scene->candidates + next);
        add_object(core, object, scene->nearest_m[object]);
        int lamps = find_lamps(core, object, scene->candidates + count);
        for (int i = 0; i < lamps; i++) add_scenery(core, scene->candidates + count + i);
    }
    for (; next < count; next++) add_scenery(core, scene->candidates + next);
}

static int are_lamps(const vc_core *core, const vc_lamp *lamps, int count) {
    if (count < 0 || count > (core->scene == NULL ? 0 : core->scene->lamp_room)) return 0;
    for (int i = 0; i < count; i++)
        if (lamps[i].glow < 0 || lamps[i].glow >= vc_glow_count(core) || lamps[i].depth_m <= 0.0) return 0;
    return 1;
}

vc_status vc_begin(vc_core *core, const vc_pose *pose, const vc_object *objects, int count, const vc_lamp *lamps,
                   int lamp_count) {
    vc_scene_part *scene = core->scene;
    if (count < 0 || count > (scene == NULL ? 0 : scene->reserved)) return VC_INVALID;
    if (!are_lamps(core, lamps, lamp_count)) return VC_INVALID;
    for (int i = 0; i < count; i++)
        if (objects[i].mesh < -1 || objects[i].mesh >= scene->meshes) return VC_INVALID;
    vc_frame *frame = &core->frame;
    frame->pose = *pose;
    vc_view_at(&core->camera, pose->x_m, pose->y_m, pose->yaw_rad, &frame->view);
    frame->item_count = frame->face_count = frame->point_count = 0;
    frame->object_count = count;
    if (scene == NULL) return VC_OK;
    if (count > 0) memcpy(scene->objects, objects, (size_t)count * sizeof *objects);
    frame->objects = scene->objects;
    if (lamp_count > 0) memcpy(scene->lamps, lamps, (size_t)lamp_count * sizeof *lamps);
    frame->lamps = scene->lamps;
    frame->lamp_count = lamp_count;
    vc_begin_lamps(core);
    vc_order_objects(core);
    add_all(core);
    return VC_OK;
}

void vc_plane(const vc_core *core, const vc_item *item, const vc_face *face, double *plane) {
    const double *n = face->normal;
    double c = 1.0, s = 0.0;
    if (item->instance > 0) {
        double heading = core->frame.objects[item->instance - 1].heading_rad;
        c = vc_cos(heading);
        s = vc_sin(heading);
    }
    double x = c * n[0] - s * n[1], y = s * n[0] + c * n[1];
    for (int i = 0; i < 3; i++) {
        const double *axis = core->frame.view.axes[i];
        plane[i] = (axis[0] * x + axis[1] * y + axis[2] * n[2]) / -face->distance_m;
    }
}
