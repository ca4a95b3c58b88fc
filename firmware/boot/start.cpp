#include "firmware/boot/start.hpp"

#include "firmware/boot/installer.hpp"

namespace umov::firmware::boot {

void end_update(Flash& flash, const Trust& trust) {
  Installer installer(flash, trust);
  if (!installer.begin(false)) return;
  while (installer.step()) {
  }
}

bool make_runnable(Flash& flash, const Trust& trust) {
  end_update(flash, trust);
  const auto running_is_good = [&] {
    return check_image(flash.contents(Place::running), trust) == Verdict::good;
  };
  if (running_is_good()) return true;
  Installer installer(flash, trust);
  if (!installer.begin_restore()) return false;
  while (installer.step()) {
  }
  return running_is_good();
}

}  // namespace umov::firmware::boot
