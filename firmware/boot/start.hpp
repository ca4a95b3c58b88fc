// What the boot loader does before anything runs.
#pragma once

#include <cstdint>

#include "firmware/boot/image_check.hpp"
#include "firmware/boot/port.hpp"
#include "firmware/boot/trial.hpp"

namespace umov::firmware::boot {

/// What may be started.
enum class Start : std::uint8_t {
  program,       ///< the running image
  no_image,      ///< nothing: neither it nor the previous one is good
  failed_trial,  ///< nothing: it failed its trial, and the previous one is not good
  flash_fails,   ///< nothing: where the running image belongs nothing can be written
};

struct StartDecision {
  Start start = Start::no_image;
  bool rolled_back = false;  ///< by this very start: the reset before it was another image's
};

/// Ends an update that was cut short, if there is one.
void end_update(Flash& flash, const Trust& trust);

/// Does that, notes a failed start of an image on trial, puts the previous image back where the
/// running one is not good or has failed its trial (and leaves a note of it), and says what may be
/// started. If nothing may, DFU mode is left.
StartDecision make_runnable(Flash& flash, const Trust& trust, Restart why);

}  // namespace umov::firmware::boot
