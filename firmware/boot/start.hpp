// What the boot loader does before anything runs.
#pragma once

#include "firmware/boot/image_check.hpp"
#include "firmware/boot/port.hpp"

namespace umov::firmware::boot {

/// Ends an update that was cut short, if there is one.
void end_update(Flash& flash, const Trust& trust);

/// Does that, puts the previous image back where none is good, and says
/// whether the program in `running` may be started. If not, DFU mode is left.
bool make_runnable(Flash& flash, const Trust& trust);

}  // namespace umov::firmware::boot
