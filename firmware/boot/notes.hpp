// What the boot loader has done and the user should know: left in flash for the program to tell.
#pragma once

#include <cstdint>
#include <optional>

#include "firmware/boot/port.hpp"
#include "protocol/messages.hpp"

namespace umov::firmware::boot {

/// A fault that the program raises for the boot loader: rolled_back or no_fallback, with its detail
/// (protocol/boot_note.hpp).
struct Note {
  protocol::Fault fault = protocol::Fault::none;
  std::int32_t detail = 0;
  bool operator==(const Note&) const = default;
};

/// Up to four, in the tail of the staged place, which the next update erases: an update that takes
/// its course needs two. A note is a word, its complement and a mark when it has been told; one
/// that a power cut tore is passed over.
class Notes {
 public:
  /// `flash` must outlive it.
  explicit Notes(Flash& flash) : flash_(&flash) {}

  static constexpr std::uint32_t capacity = 4;

  /// Leaves a note, unless one of that fault waits already: it is of the same event, which a power
  /// cut interrupted. False when there is no room or the flash fails.
  bool leave(const Note& note);
  /// One of that fault has not been told.
  bool waits(protocol::Fault fault) const;
  /// The oldest that has not been told.
  std::optional<Note> next() const;
  /// That one has been told. False when the flash fails: it will be told again.
  bool mark_told();

 private:
  std::optional<Note> at(std::uint32_t index) const;
  bool told(std::uint32_t index) const;
  std::uint32_t first_untold() const;

  Flash* flash_;
};

}  // namespace umov::firmware::boot
