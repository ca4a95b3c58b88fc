#include "firmware/boot/start.hpp"

#include "firmware/boot/installer.hpp"

namespace umov::firmware::boot {

bool make_runnable(Flash& flash, const Trust& trust) {
  Installer installer(flash, trust);
  ImageHeader header;
  const auto running_is_good = [&] {
    return check_image(flash.contents(Place::running), trust, header) == Verdict::good;
  };
  if (installer.begin()) {
    while (installer.step()) {
    }
  }
  if (running_is_good()) return true;
  if (!installer.begin_restore()) return false;
  while (installer.step()) {
  }
  return running_is_good();
}

}  // namespace umov::firmware::boot
