#include "firmware/boot/start.hpp"

#include "firmware/boot/installer.hpp"
#include "firmware/boot/notes.hpp"

namespace umov::firmware::boot {
namespace {

bool good(const Flash& flash, Place place, const Trust& trust) {
  return check_image(flash.contents(place), trust) == Verdict::good;
}

/// The version in the header of the running image; 0 when there is none.
std::uint32_t running_version(const Flash& flash, const Trust& trust) {
  ImageHeader header;
  const auto place = flash.contents(Place::running);
  const bool known = check_header(place, place.size(), trust, header) == Verdict::good;
  return known ? header.version : 0;
}

/// The previous image takes the place of the running one; `otherwise`: what is said when there is
/// none.
StartDecision put_back(Flash& flash, const Trust& trust, protocol::RollBackReason reason,
                       Start otherwise) {
  Installer installer(flash, trust);
  if (!installer.begin_restore()) return {otherwise, false};
  Notes(flash).leave({protocol::Fault::rolled_back,
                      protocol::roll_back_detail(reason, running_version(flash, trust))});
  while (installer.step()) {
  }
  if (!good(flash, Place::running, trust)) return {Start::flash_fails, false};
  return {Start::program, true};
}

}  // namespace

void end_update(Flash& flash, const Trust& trust) {
  Installer installer(flash, trust);
  if (!installer.begin(false)) return;
  while (installer.step()) {
  }
}

StartDecision make_runnable(Flash& flash, const Trust& trust, Restart why) {
  end_update(flash, trust);
  if (!good(flash, Place::running, trust)) {
    return put_back(flash, trust, protocol::RollBackReason::damaged, Start::no_image);
  }
  Trial trial(flash);
  if (!trial.note_failure(why)) return {Start::flash_fails, false};
  if (!trial.failed()) return {Start::program, false};
  return put_back(flash, trust, trial.last_failure(), Start::failed_trial);
}

}  // namespace umov::firmware::boot
