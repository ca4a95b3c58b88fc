// Brings a downloaded image to where it runs, keeping the one that ran before; resumable at any
// byte.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/boot/image_check.hpp"
#include "firmware/boot/port.hpp"

namespace umov::firmware::boot {

/// A downloaded image waits in `staged`. order() marks it in the last word of its place, which
/// makes the update inevitable; from there each step looks at the flash and nothing else:
///
///   1. running is good and not yet the new one: copy it to `previous` (unless it lies there);
///   2. erase running, copy staged there;
///   3. they are equal: clear the mark.
///
/// Cut anywhere, the next start begins at the first step that is not done. Running is erased only
/// when the staged image is whole and marked.
class Installer {
 public:
  Installer(Flash& flash, const Trust& trust) : flash_(&flash), trust_(&trust) {}

  /// Marks the staged image, which must be good. False: the flash failed, nothing will happen.
  bool order();
  /// Looks at the flash: whether there is something to be done by step(). The staged image is
  /// checked unless it has been `verified` just now.
  bool begin(bool verified);
  /// Nothing good runs and the previous image is good: begins to put that back.
  bool begin_restore();

  /// One piece of work: an erasure, or 1 KB copied. False when all is done or the flash has failed.
  bool step();
  bool failed() const { return stage_ == Stage::failed; }
  /// The next step is an erasure, in which the processor may stand still for seconds.
  bool erases_next() const {
    return stage_ == Stage::erase_previous || stage_ == Stage::erase_running;
  }

  /// Bytes of a place that an image may take: the mark's word is not for it.
  static constexpr std::uint32_t reserved_bytes = 4;

 private:
  enum class Stage : std::uint8_t {
    idle,
    erase_previous,
    keep,
    erase_running,
    copy,
    finish,
    failed,
  };

  std::span<const std::uint8_t> image_in(Place place) const;
  bool same(Place a, Place b) const;
  void copy_piece(Place to, Stage next);

  Flash* flash_;
  const Trust* trust_;
  Stage stage_ = Stage::idle;
  Place source_ = Place::staged;  ///< what is being copied
  std::uint32_t copied_ = 0;
  std::uint32_t tries_ = 0;
};

}  // namespace umov::firmware::boot
