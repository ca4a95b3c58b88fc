// A newly installed image is on trial until it has proved itself.
#pragma once

#include <cstdint>

#include "firmware/boot/port.hpp"
#include "protocol/boot_note.hpp"

namespace umov::firmware::boot {

/// Why the chip starts.
enum class Restart : std::uint8_t {
  power,     ///< the supply came up, or sagged
  asked,     ///< program and boot loader agreed upon it
  watchdog,  ///< the program hung
  crash,     ///< a processor fault, or the program reset the chip of its own
  button,    ///< the reset line was pulled
};

/// Marks in the running image's place, written with it and erased with it, so that they can never
/// be taken for those of another image. The installer marks an image as on trial before it copies
/// it; the boot loader notes each start of it that failed; the program confirms itself. Images that
/// came another way (a programmer, the chip's ROM loader) are not on trial.
///
/// A start has failed when the next one comes by watchdog, crash or reset line. One that the supply
/// ended says nothing of the image: a computer that boots switches its USB off and on several
/// times.
class Trial {
 public:
  /// `flash` must outlive it.
  explicit Trial(Flash& flash) : flash_(&flash) {}

  /// So many starts may fail; then the image is given up.
  static constexpr std::uint32_t most_failures = 3;

  /// The running image is on trial and has not confirmed itself.
  bool open() const;
  std::uint32_t failures() const;
  bool failed() const { return open() && failures() >= most_failures; }
  /// How the last start that failed ended.
  protocol::RollBackReason last_failure() const;

  /// Puts the image that is about to be copied to the erased place on trial. False when the flash
  /// fails (also below).
  bool begin();
  /// Notes that the start before this one failed, if `why` says so.
  bool note_failure(Restart why);
  /// The image has proved itself. The program calls it.
  bool confirm();

 private:
  Flash* flash_;
};

}  // namespace umov::firmware::boot
