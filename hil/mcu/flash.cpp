#include "hil/mcu/flash.hpp"

#include <algorithm>
#include <utility>

namespace umov::mcu {
namespace {

constexpr std::uint32_t acr = 0x00, keyr = 0x04, sr = 0x0C, cr = 0x10, optcr = 0x14;
constexpr std::uint32_t lock = 1u << 31, start = 1u << 16, programming = 1, sector_erase = 2,
                        mass_erase = 4;
constexpr std::uint32_t parallelism_error = 1u << 6, sequence_error = 1u << 7,
                        alignment_error = 1u << 5, protection_error = 1u << 4;
constexpr std::uint32_t all_errors = 0xF3;
constexpr Time word_time = 16 * time_per_us;

}  // namespace

Flash::Flash(std::vector<std::uint8_t>& contents, std::function<void(Time)> stall)
    : contents_(&contents), stall_(std::move(stall)) {
  contents.resize(size, 0xFF);
}

Flash::Sector Flash::sector(int number) {
  constexpr std::uint32_t kb = 1024;
  if (number < 4) return {base + static_cast<std::uint32_t>(number) * 16 * kb, 16 * kb};
  if (number == 4) return {base + 64 * kb, 64 * kb};
  return {base + static_cast<std::uint32_t>(number - 4) * 128 * kb, 128 * kb};
}

std::uint32_t Flash::read(std::uint32_t offset) {
  switch (offset) {
    case acr:
      return acr_;
    case keyr:
      return 0;
    case sr:
      return sr_;
    case cr:
      return cr_;
    case optcr:
      return 0x0FFF'AAED & ~(protected_ << 16);
    default:
      refuse_register("the flash interface", offset);
  }
}

void Flash::write(std::uint32_t offset, std::uint32_t value) {
  switch (offset) {
    case acr:
      acr_ = value;
      return;
    case keyr:
      if (key_ == 0 && value == 0x4567'0123) {
        key_ = 1;
      } else if (key_ == 1 && value == 0xCDEF'89AB) {
        key_ = 0;
        cr_ &= ~lock;
      } else {
        key_ = -1;
      }
      return;
    case sr:
      sr_ &= ~(value & all_errors);
      return;
    case cr:
      if ((cr_ & lock) != 0) {
        if ((value & ~lock) != 0) refuse_setting("the flash interface", "CR while locked", value);
        return;
      }
      if ((value & mass_erase) != 0) refuse_setting("the flash interface", "CR", value);
      cr_ = value & ~start;
      if ((value & start) != 0) erase();
      return;
    default:
      refuse_register("the flash interface", offset);
  }
}

bool Flash::refused(int number) {
  const bool refused = (protected_ >> number & 1u) != 0;
  if (refused) sr_ |= protection_error;
  return refused;
}

void Flash::erase() {
  const auto number = static_cast<int>(cr_ >> 3 & 15u);
  if ((cr_ & sector_erase) == 0 || number >= sector_count || (cr_ & programming) != 0) {
    sr_ |= sequence_error;
    return;
  }
  if (refused(number)) return;
  const Sector s = sector(number);
  std::fill_n(contents_->begin() + (s.begin - base), s.size, std::uint8_t{0xFF});
  constexpr Time ms = 1000 * time_per_us;
  stall_(s.size == 16 * 1024 ? 250 * ms : s.size == 64 * 1024 ? 550 * ms : 1000 * ms);
}

void Flash::store(std::uint32_t address, unsigned bytes, std::uint32_t value) {
  if ((cr_ & lock) != 0 || (cr_ & programming) == 0 || (cr_ & sector_erase) != 0) {
    sr_ |= sequence_error;
    return;
  }
  if (1u << (cr_ >> 8 & 3u) != bytes) {
    sr_ |= parallelism_error;
    return;
  }
  if (address % bytes != 0) {
    sr_ |= alignment_error;
    return;
  }
  int number = 0;
  while (address - sector(number).begin >= sector(number).size) ++number;
  if (refused(number)) return;
  for (unsigned i = 0; i < bytes; ++i) {
    auto& cell = (*contents_)[address - base + i];
    cell = static_cast<std::uint8_t>(cell & (value >> 8 * i));
  }
  stall_(word_time);
}

}  // namespace umov::mcu
