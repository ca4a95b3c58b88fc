// Brings a downloaded image to where it runs, keeping the one that ran before, and brings that one
// back; resumable at any byte.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "firmware/boot/image_check.hpp"
#include "firmware/boot/place_tail.hpp"
#include "firmware/boot/port.hpp"
#include "firmware/boot/trial.hpp"

namespace umov::firmware::boot {

/// A downloaded image waits in `staged`. order() marks it in the last word of its place, which
/// makes the update inevitable; from there each step looks at the flash and nothing else:
///
///   1. running is good, not on trial and not yet the new one: copy it to `previous` (unless it
///      lies there). Where that place fails, the update goes on without: kept() is false then and
///      a note is left;
///   2. erase running (its header spoilt first if it is on trial), put what comes there on trial,
///      copy staged there;
///   3. they are equal: clear the mark.
///
/// Cut anywhere, the next start begins at the first step that is not done. Running is erased only
/// when the staged image is whole and marked, or the previous one is good. To bring that one back,
/// and over an image on trial, the running image's header is spoilt first: a start after a power
/// cut then finds no image there, however much of it and of its trial's marks an erasure has left,
/// and begins to put the other one there again.
class Installer {
 public:
  Installer(Flash& flash, const Trust& trust) : flash_(&flash), trust_(&trust), trial_(flash) {}

  /// Marks the staged image, which must be good. False: the flash failed, nothing will happen.
  bool order();
  /// Looks at the flash: whether there is something to be done by step(). The staged image is
  /// checked unless it has been `verified` just now; then an equal one that has failed starts gets
  /// another trial.
  bool begin(bool verified);
  /// Begins to put the previous image in the place of the running one, whatever that is. False when
  /// the previous one is not good, or an update that cannot be called off would undo it.
  bool begin_restore();

  /// One piece of work: an erasure, or 1 KB copied. False when all is done or the flash has failed.
  bool step();
  bool failed() const { return stage_ == Stage::failed; }
  /// The image that ran before could be kept, or there was none worth it.
  bool kept() const { return kept_; }
  /// The next step is an erasure, in which the processor may stand still for seconds.
  bool erases_next() const {
    return stage_ == Stage::erase_previous || stage_ == Stage::erase_running;
  }

 private:
  enum class Stage : std::uint8_t {
    idle,
    erase_previous,
    keep,
    spoil_running,
    erase_running,
    copy,
    finish,
    failed,
  };

  std::span<const std::uint8_t> image_in(Place place) const;
  bool same(Place a, Place b) const;
  bool ordered() const;
  bool spoil(Place place);
  void erase_for(Stage next);
  void copy_piece(Place to, Stage next);
  void try_again(Place to);
  void finish();

  Flash* flash_;
  const Trust* trust_;
  Trial trial_;
  Stage stage_ = Stage::idle;
  Place source_ = Place::staged;  ///< what is being copied
  std::uint32_t copied_ = 0;
  std::uint32_t tries_ = 0;
  bool kept_ = true;
};

}  // namespace umov::firmware::boot
