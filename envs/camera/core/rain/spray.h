/* What other files need of the spray. */
#ifndef VC_SPRAY_H
#define VC_SPRAY_H

#include "internal.h"

enum { VC_PUFFS = 3 }; /* per object at a time */

/* Makes room for the puffs of so many objects; returns how many items they may add, -1 without memory. */
int vc_spray_room(vc_core *core, int objects);
void vc_paint_puff(const vc_core *core, const vc_item *item, vc_image image, vc_labels labels);

#endif
