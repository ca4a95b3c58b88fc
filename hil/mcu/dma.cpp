#include "hil/mcu/dma.hpp"

#include <utility>

namespace umov::mcu {
namespace {

constexpr std::uint32_t enable = 1, te_interrupt = 4, ht_interrupt = 8, tc_interrupt = 16,
                        circular = 1u << 8, peripheral_increment = 1u << 9,
                        memory_increment = 1u << 10;
constexpr std::uint32_t not_modelled =
    1u << 5 | 1u << 15 | 3u << 18 | 3u << 21 | 3u << 23;  // flow control, double buffer, bursts
constexpr std::uint32_t te_flag = 8, ht_flag = 16, tc_flag = 32, all_flags = 0x3D;

constexpr unsigned flag_place(int stream) {
  constexpr std::array<unsigned, 4> places = {0, 6, 16, 22};
  return places[static_cast<std::size_t>(stream % 4)];
}

}  // namespace

Dma::Dma(const char* name, BusMaster bus, std::function<void(int, bool)> interrupt)
    : name_(name), bus_(std::move(bus)), interrupt_(std::move(interrupt)) {}

bool Dma::request(int stream, unsigned channel) {
  Stream& s = streams_[static_cast<std::size_t>(stream)];
  if ((s.cr & enable) == 0 || (s.cr >> 25 & 7u) != channel) return false;
  transfer(s);
  tell_interrupt(stream);
  return true;
}

bool Dma::fail(int stream) {
  Stream& s = streams_[static_cast<std::size_t>(stream)];
  if ((s.cr & enable) == 0) return false;
  s.cr &= ~enable;
  s.flags |= te_flag;
  tell_interrupt(stream);
  return true;
}

void Dma::transfer(Stream& s) {
  const unsigned bytes = 1u << (s.cr >> 11 & 3u);
  const std::uint32_t done = s.length - s.ndtr;
  const std::uint32_t memory = s.m0ar + ((s.cr & memory_increment) != 0 ? done * bytes : 0);
  const std::uint32_t peripheral = s.par + ((s.cr & peripheral_increment) != 0 ? done * bytes : 0);
  const bool to_peripheral = (s.cr >> 6 & 3u) == 1;
  const std::uint32_t value = bus_.read(to_peripheral ? memory : peripheral, bytes);
  bus_.write(to_peripheral ? peripheral : memory, bytes, value);
  --s.ndtr;
  if (s.ndtr == s.length / 2) s.flags |= ht_flag;
  if (s.ndtr == 0) {
    s.flags |= tc_flag;
    if ((s.cr & circular) != 0) {
      s.ndtr = s.length;
    } else {
      s.cr &= ~enable;
    }
  }
}

void Dma::tell_interrupt(int number) {
  const Stream& s = streams_[static_cast<std::size_t>(number)];
  const bool level = ((s.flags & ht_flag) != 0 && (s.cr & ht_interrupt) != 0) ||
                     ((s.flags & tc_flag) != 0 && (s.cr & tc_interrupt) != 0) ||
                     ((s.flags & te_flag) != 0 && (s.cr & te_interrupt) != 0);
  interrupt_(number, level);
}

void Dma::set_control(int number, std::uint32_t value) {
  Stream& s = streams_[static_cast<std::size_t>(number)];
  if ((value & not_modelled) != 0 || (value >> 6 & 3u) > 1) refuse_setting(name_, "SxCR", value);
  if ((value >> 11 & 3u) != (value >> 13 & 3u) || (value >> 11 & 3u) > 2)
    refuse_setting(name_, "SxCR (widths that differ)", value);
  const bool starts = (value & ~s.cr & enable) != 0;
  if (starts && s.flags != 0) {
    refuse_setting(name_, "SxCR: a stream switched on with its old flags not cleared", value);
  }
  s.cr = value;
  if (!starts) return;
  s.length = s.ndtr;
  if (s.length == 0) {
    s.cr &= ~enable;
    return;
  }
  if (on_enable_) on_enable_(number);
}

std::uint32_t Dma::read(std::uint32_t offset) {
  if (offset == 0 || offset == 4) {
    std::uint32_t value = 0;
    for (int i = 0; i < 4; ++i) {
      const int stream = offset == 0 ? i : 4 + i;
      value |= streams_[static_cast<std::size_t>(stream)].flags << flag_place(stream);
    }
    return value;
  }
  if (offset == 8 || offset == 12) return 0;
  if (offset < 0x10 || offset >= 0x10 + 8 * 0x18) refuse_register(name_, offset);
  const Stream& s = streams_[(offset - 0x10) / 0x18];
  switch ((offset - 0x10) % 0x18) {
    case 0x00:
      return s.cr;
    case 0x04:
      return s.ndtr;
    case 0x08:
      return s.par;
    case 0x0C:
      return s.m0ar;
    case 0x14:
      return s.fcr;
    default:
      refuse_register(name_, offset);
  }
}

void Dma::write(std::uint32_t offset, std::uint32_t value) {
  if (offset == 8 || offset == 12) {
    for (int i = 0; i < 4; ++i) {
      const int stream = offset == 8 ? i : 4 + i;
      streams_[static_cast<std::size_t>(stream)].flags &=
          ~(value >> flag_place(stream) & all_flags);
      tell_interrupt(stream);
    }
    return;
  }
  if (offset < 0x10 || offset >= 0x10 + 8 * 0x18) refuse_register(name_, offset);
  const auto number = static_cast<int>((offset - 0x10) / 0x18);
  Stream& s = streams_[static_cast<std::size_t>(number)];
  const std::uint32_t place = (offset - 0x10) % 0x18;
  if (place != 0 && (s.cr & enable) != 0)
    refuse_setting(name_, "a register of a stream that is on", value);
  switch (place) {
    case 0x00:
      set_control(number, value);
      break;
    case 0x04:
      s.ndtr = value & 0xFFFF;
      break;
    case 0x08:
      s.par = value;
      break;
    case 0x0C:
      s.m0ar = value;
      break;
    case 0x14:
      if ((value & 4u) != 0) refuse_setting(name_, "SxFCR (FIFO)", value);
      s.fcr = value;
      break;
    default:
      refuse_register(name_, offset);
  }
  tell_interrupt(number);
}

}  // namespace umov::mcu
