// What the boot loader needs of a board's flash.
#pragma once

#include <cstdint>
#include <span>

namespace umov::firmware::boot {

/// The program that runs, the one that has been downloaded, the one that ran before.
enum class Place : std::uint8_t { running, staged, previous };

/// Three places of equal size. Erased bytes read 0xFF; programming clears bits.
class Flash {
 public:
  /// All of a place, readable like memory.
  virtual std::span<const std::uint8_t> contents(Place place) const = 0;
  /// May take seconds. False when the flash reports an error.
  virtual bool erase(Place place) = 0;
  /// `offset` and the size are multiples of 4. False when the flash reports an error or reads back
  /// something else.
  virtual bool program(Place place, std::uint32_t offset, std::span<const std::uint8_t> bytes) = 0;

 protected:
  Flash() = default;
  Flash(const Flash&) = default;
  Flash& operator=(const Flash&) = default;
  ~Flash() = default;
};

}  // namespace umov::firmware::boot
