/* Shadows of objects on the road: the sun's, and the dark contact right under them. */
#include "scene.h"
#include "vc_math.h"

#define RANGE_M 75.0 /* and the distance from which they are full */
#define FULL_M 45.0
#define NO_SUN 0.97   /* shadows that leave more of the light are left out */
#define FULLNESS 0.85 /* height of the box that casts the shadow, over the object's */

/* Corners of an object's footprint, scaled along and across it. */
static void footprint(const vc_object *object, double length_m, double width_m, double corners[4][3]) {
    double c = vc_cos(object->heading_rad), s = vc_sin(object->heading_rad);
    for (int i = 0; i < 4; i++) {
        double along = (i < 2 ? -0.5 : 0.5) * length_m, across = (i == 0 || i == 3 ? -0.5 : 0.5) * width_m;
        corners[i][0] = object->x_m + along * c - across * s;
        corners[i][1] = object->y_m + along * s + across * c;
        corners[i][2] = 0.0;
    }
}

static void add(vc_core *core, vc_growing *growing, const double *corners, double left, double full) {
    vc_face face = {0, 0, 0, (uint32_t)vc_round(255.0 - 255.0 * full * (1.0 - left)) << 24, NULL, 1.0};
    vc_item_add(core, growing, core->frame.view.projection, corners, 4, face);
}

/* The area that a box sweeps as it falls along the sun's rays: its top and bottom, and what lies between their sides. */
static void add_sun(vc_core *core, vc_growing *growing, const vc_object *object, const Mesh *mesh, double full) {
    const vc_light *light = &core->scene->light;
    double foot[4][3], top[4][3], high = FULLNESS * mesh->height_m;
    footprint(object, mesh->length_m, mesh->width_m, foot);
    for (int i = 0; i < 4; i++) {
        top[i][0] = foot[i][0] + light->fall_x * high;
        top[i][1] = foot[i][1] + light->fall_y * high;
        top[i][2] = 0.0;
    }
    add(core, growing, foot[0], light->shadow, full);
    add(core, growing, top[0], light->shadow, full);
    for (int i = 0; i < 4; i++) {
        int next = (i + 1) & 3;
        double side[4][3] = {{foot[i][0], foot[i][1], 0.0}, {foot[next][0], foot[next][1], 0.0},
                             {top[next][0], top[next][1], 0.0}, {top[i][0], top[i][1], 0.0}};
        add(core, growing, side[0], light->shadow, full);
    }
}

static void draw(vc_core *core, const vc_object *object, vc_image image) {
    const vc_light *light = &core->scene->light;
    const Mesh *mesh = core->scene->mesh + object->mesh;
    const double *eye = core->frame.view.centre;
    double distance = vc_hypot(object->x_m - eye[0], object->y_m - eye[1]);
    if (distance > RANGE_M) return;
    double full = vc_limit((RANGE_M - distance) / (RANGE_M - FULL_M), 0.0, 1.0), contact[4][3];
    int faces = core->frame.face_count, points = core->frame.point_count;
    vc_growing growing = vc_item_begin(core, 0, distance);
    if (light->shadow < NO_SUN) add_sun(core, &growing, object, mesh, full);
    footprint(object, 0.97 * mesh->length_m, 0.9 * mesh->width_m, contact);
    add(core, &growing, contact[0], light->contact, full);
    if (vc_item_end(core, &growing)) vc_paint_item(core, &growing.item, image);
    core->frame.face_count = faces; /* shadows are nothing that later calls see */
    core->frame.point_count = points;
}

void vc_draw_shadows(vc_core *core, vc_image image) {
    const vc_scene_part *scene = core->scene;
    for (int i = 0; i < scene->order_count; i++) draw(core, scene->objects + scene->order[i], image);
}
