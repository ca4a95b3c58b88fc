#include "hil/mcu/otg_fs.hpp"

#include <algorithm>
#include <utility>

namespace umov::mcu {
namespace {

constexpr const char* name = "OTG_FS";

constexpr std::uint32_t gahbcfg = 0x008, gusbcfg = 0x00C, grstctl = 0x010, gintsts = 0x014,
                        gintmsk = 0x018, grxstsr = 0x01C, grxstsp = 0x020, grxfsiz = 0x024,
                        dieptxf0 = 0x028, gccfg = 0x038, cid = 0x03C, dieptxf1 = 0x104,
                        dieptxf3 = 0x10C;
constexpr std::uint32_t dcfg = 0x800, dctl = 0x804, dsts = 0x808, diepmsk = 0x810, doepmsk = 0x814,
                        daint = 0x818, daintmsk = 0x81C, in_endpoints = 0x900,
                        out_endpoints = 0xB00, endpoints_end = 0xB00 + 4 * 0x20, fifos = 0x1000;

// GINTSTS
constexpr std::uint32_t rx_not_empty = 1u << 4, global_out_nak = 1u << 7, usb_reset = 1u << 12,
                        enumerated = 1u << 13, in_endpoint = 1u << 18, out_endpoint = 1u << 19;
constexpr std::uint32_t cleared_by_writing = 0xF03C'FC0A & ~(in_endpoint | out_endpoint);
constexpr std::uint32_t soft_disconnect = 2, set_global_out_nak = 1u << 9,
                        clear_global_out_nak = 1u << 10;
constexpr std::uint32_t force_device = 1u << 30, power_up = 1u << 16;
// DxEPCTL, DxEPINT
constexpr std::uint32_t kept_settings = 0x03EC'87FF;
constexpr std::uint32_t active = 1u << 15, stalled = 1u << 21, clear_nak = 1u << 26,
                        set_nak = 1u << 27, disable = 1u << 30, enable = 1u << 31;
constexpr std::uint32_t complete = 1, disabled = 2, setup_done = 8;
// PKTSTS
constexpr std::uint32_t is_global_nak = 1, is_data = 2, is_out_done = 3, is_setup_done = 4,
                        is_setup_data = 6;
constexpr std::uint32_t size_mask = 0x7'FFFF;

constexpr std::uint32_t words(std::size_t bytes) {
  return static_cast<std::uint32_t>((bytes + 3) / 4);
}

}  // namespace

OtgFs::OtgFs(InterruptLine interrupt) : interrupt_(std::move(interrupt)) {}

void OtgFs::core_reset() {
  gintsts_ = 0;
  gahbcfg_ = gintmsk_ = 0;
  dcfg_ = dsts_ = diepmsk_ = doepmsk_ = daintmsk_ = 0;
  dctl_ = soft_disconnect;
  in_ = {};
  out_ = {};
  received_.clear();
  reading_.clear();
  global_nak_ = false;
}

bool OtgFs::connected() const {
  return (gccfg_ & power_up) != 0 && (gusbcfg_ & force_device) != 0 &&
         (dctl_ & soft_disconnect) == 0;
}

std::uint32_t OtgFs::packet_size(unsigned number, const Endpoint& endpoint) const {
  if (number != 0) return endpoint.settings & 0x7FFu;
  constexpr std::array<std::uint32_t, 4> sizes = {64, 32, 16, 8};
  return sizes[in_[0].settings & 3u];
}

std::uint32_t OtgFs::receive_room() const {
  std::uint32_t used = words(reading_.size());
  for (const Received& r : received_) used += 1 + words(r.bytes.size());
  return grxfsiz_ > used ? grxfsiz_ - used : 0;
}

std::uint32_t OtgFs::transmit_room(unsigned number) const {
  const std::uint32_t depth = transmit_fifo_[number] >> 16;
  const auto used = static_cast<std::uint32_t>(in_[number].words.size());
  return depth > used ? depth - used : 0;
}

void OtgFs::push(unsigned endpoint, std::uint32_t kind, std::span<const std::uint8_t> bytes) {
  received_.push_back({endpoint | static_cast<std::uint32_t>(bytes.size()) << 4 | kind << 17,
                       {bytes.begin(), bytes.end()}});
}

void OtgFs::bus_reset() {
  if (!connected()) return;
  for (unsigned i = 1; i < endpoint_count; ++i) {
    in_[i].settings &= ~active;
    out_[i].settings &= ~active;
  }
  dcfg_ &= ~(0x7Fu << 4);
  dsts_ = 3u << 1;  // full speed
  gintsts_ |= usb_reset | enumerated;
  tell_interrupt();
}

UsbAnswer OtgFs::setup(std::span<const std::uint8_t, 8> packet) {
  if (!connected()) return UsbAnswer::none;
  // Endpoint 0 takes SETUP whatever it is doing, and is free for what follows.
  in_[0].settings &= ~stalled;
  out_[0].settings &= ~stalled;
  in_[0].nak = out_[0].nak = true;
  push(0, is_setup_data, packet);
  push(0, is_setup_done, {});
  tell_interrupt();
  return UsbAnswer::ack;
}

UsbAnswer OtgFs::out(unsigned endpoint, std::span<const std::uint8_t> bytes) {
  if (!connected() || endpoint >= endpoint_count) return UsbAnswer::none;
  Endpoint& e = out_[endpoint];
  if (endpoint != 0 && (e.settings & active) == 0) return UsbAnswer::none;
  if ((e.settings & stalled) != 0) return UsbAnswer::stall;
  if (!e.enabled || e.nak || global_nak_) return UsbAnswer::nak;
  if (receive_room() < words(bytes.size()) + 2) return UsbAnswer::nak;
  push(endpoint, is_data, bytes);
  const std::uint32_t packets = (e.size >> 19 & 0x3FFu) - 1;
  const std::uint32_t left = e.size & size_mask;
  const auto taken = static_cast<std::uint32_t>(bytes.size());
  e.size = (e.size & 0x6000'0000u) | packets << 19 | (left > taken ? left - taken : 0);
  if (packets == 0 || bytes.size() < packet_size(endpoint, e)) {
    push(endpoint, is_out_done, {});
    e.nak = true;
  }
  tell_interrupt();
  return UsbAnswer::ack;
}

UsbAnswer OtgFs::in(unsigned endpoint, std::vector<std::uint8_t>& packet) {
  if (!connected() || endpoint >= endpoint_count) return UsbAnswer::none;
  Endpoint& e = in_[endpoint];
  if (endpoint != 0 && (e.settings & active) == 0) return UsbAnswer::none;
  if ((e.settings & stalled) != 0) return UsbAnswer::stall;
  if (!e.enabled || e.nak) return UsbAnswer::nak;
  const std::uint32_t left = e.size & size_mask;
  const std::uint32_t count = std::min(left, packet_size(endpoint, e));
  if (e.words.size() < words(count)) return UsbAnswer::nak;  // not yet all in the FIFO
  packet.clear();
  for (std::uint32_t i = 0; i < words(count); ++i) {
    for (unsigned b = 0; b < 4 && packet.size() < count; ++b)
      packet.push_back(static_cast<std::uint8_t>(e.words.front() >> 8 * b));
    e.words.pop_front();
  }
  const std::uint32_t packets = (e.size >> 19 & 0x3FFu) - 1;
  e.size = packets << 19 | (left - count);
  if (packets == 0) {
    e.enabled = false;
    e.nak = true;
    e.interrupts |= complete;
  }
  tell_interrupt();
  return UsbAnswer::ack;
}

std::uint32_t OtgFs::endpoint_interrupts() const {
  std::uint32_t bits = 0;
  for (unsigned i = 0; i < endpoint_count; ++i) {
    if ((in_[i].interrupts & diepmsk_) != 0) bits |= 1u << i;
    if ((out_[i].interrupts & doepmsk_) != 0) bits |= 1u << (16 + i);
  }
  return bits;
}

std::uint32_t OtgFs::pending() const {
  const std::uint32_t endpoints = endpoint_interrupts() & daintmsk_;
  return gintsts_ | (received_.empty() ? 0 : rx_not_empty) |
         ((endpoints & 0xFFFFu) != 0 ? in_endpoint : 0) |
         ((endpoints >> 16) != 0 ? out_endpoint : 0);
}

void OtgFs::tell_interrupt() {
  interrupt_((gahbcfg_ & 1u) != 0 && (pending() & gintmsk_) != 0);
}

std::uint32_t OtgFs::pop_status() {
  if (received_.empty()) return 0;
  if (!reading_.empty())
    refuse_setting(name, "GRXSTSP before the last packet was read, bytes left",
                   static_cast<std::uint32_t>(reading_.size()));
  const Received entry = std::move(received_.front());
  received_.pop_front();
  reading_.assign(entry.bytes.begin(), entry.bytes.end());
  Endpoint& e = out_[entry.status & 3u];
  switch (entry.status >> 17 & 15u) {
    case is_setup_done:
      // RM0090 34.16.4, DOEPCTL0: EPENA is cleared before the phase is reported done.
      out_[0].enabled = false;
      out_[0].interrupts |= setup_done;
      break;
    case is_out_done:
      e.enabled = false;
      e.interrupts |= complete;
      break;
    case is_global_nak:
      gintsts_ |= global_out_nak;
      break;
    default:
      break;
  }
  tell_interrupt();
  return entry.status;
}

std::uint32_t OtgFs::pop_word() {
  if (reading_.empty()) refuse_setting(name, "a read of an empty receive FIFO", 0);
  std::uint32_t word = 0;
  for (unsigned b = 0; b < 4 && !reading_.empty(); ++b) {
    word |= static_cast<std::uint32_t>(reading_.front()) << 8 * b;
    reading_.pop_front();
  }
  return word;
}

void OtgFs::write_fifo(unsigned number, std::uint32_t word) {
  if (number >= endpoint_count || !in_[number].enabled)
    refuse_setting(name, "a store to the FIFO of an endpoint that is not enabled", number);
  if (transmit_room(number) == 0) refuse_setting(name, "a store to a full FIFO", number);
  in_[number].words.push_back(word);
}

std::uint32_t OtgFs::read_control(const Endpoint& endpoint) const {
  return endpoint.settings | (endpoint.nak ? 1u << 17 : 0u) | (endpoint.enabled ? enable : 0u);
}

void OtgFs::write_control(Endpoint& endpoint, unsigned number, bool in, std::uint32_t value) {
  std::uint32_t settings = value & kept_settings;
  if (number == 0) settings |= active | (endpoint.settings & stalled);  // only SETUP ends its stall
  endpoint.settings = settings;
  if ((value & set_nak) != 0) endpoint.nak = true;
  if ((value & clear_nak) != 0) endpoint.nak = false;
  if ((value & disable) != 0) {
    if (!in && number == 0) refuse_setting(name, "DOEPCTL0.EPDIS, which does not exist", value);
    if (!in && (gintsts_ & global_out_nak) == 0)
      refuse_setting(name, "DOEPCTL.EPDIS without global OUT NAK", value);
    endpoint.enabled = false;
    endpoint.interrupts |= disabled;
  } else if ((value & enable) != 0) {
    endpoint.enabled = true;
  }
}

std::uint32_t OtgFs::read_endpoint(std::uint32_t offset) const {
  const bool in = offset < out_endpoints;
  const unsigned number = (offset - (in ? in_endpoints : out_endpoints)) / 0x20;
  if (number >= endpoint_count) refuse_register(name, offset);
  const Endpoint& e = in ? in_[number] : out_[number];
  switch (offset % 0x20) {
    case 0x00:
      return read_control(e);
    case 0x08:
      return e.interrupts;
    case 0x10:
      return e.size;
    case 0x18:
      if (in) return transmit_room(number);
      [[fallthrough]];
    default:
      refuse_register(name, offset);
  }
}

void OtgFs::write_endpoint(std::uint32_t offset, std::uint32_t value) {
  const bool in = offset < out_endpoints;
  const unsigned number = (offset - (in ? in_endpoints : out_endpoints)) / 0x20;
  if (number >= endpoint_count) refuse_register(name, offset);
  Endpoint& e = in ? in_[number] : out_[number];
  switch (offset % 0x20) {
    case 0x00:
      write_control(e, number, in, value);
      break;
    case 0x08:
      e.interrupts &= ~value;
      break;
    case 0x10:
      if (e.enabled) refuse_setting(name, "DxEPTSIZ of an endpoint that is enabled", value);
      e.size = value;
      break;
    default:
      refuse_register(name, offset);
  }
}

std::uint32_t OtgFs::read(std::uint32_t offset) {
  if (offset >= fifos) return pop_word();
  if (offset >= in_endpoints && offset < endpoints_end) return read_endpoint(offset);
  if (offset >= dieptxf1 && offset <= dieptxf3) return transmit_fifo_[(offset - dieptxf1) / 4 + 1];
  switch (offset) {
    case gahbcfg:
      return gahbcfg_;
    case gusbcfg:
      return gusbcfg_;
    case grstctl:
      return 1u << 31;  // what was asked for is done; the bus is idle
    case gintsts:
      return pending();
    case gintmsk:
      return gintmsk_;
    case grxstsr:
      return received_.empty() ? 0 : received_.front().status;
    case grxstsp:
      return pop_status();
    case grxfsiz:
      return grxfsiz_;
    case dieptxf0:
      return transmit_fifo_[0];
    case gccfg:
      return gccfg_;
    case cid:
      return 0x1200;
    case dcfg:
      return dcfg_;
    case dctl:
      return dctl_ | (global_nak_ ? 8u : 0u);
    case dsts:
      return dsts_;
    case diepmsk:
      return diepmsk_;
    case doepmsk:
      return doepmsk_;
    case daint:
      return endpoint_interrupts();
    case daintmsk:
      return daintmsk_;
    default:
      refuse_register(name, offset);
  }
}

void OtgFs::write(std::uint32_t offset, std::uint32_t value) {
  if (offset >= fifos) {
    write_fifo((offset - fifos) / 0x1000, value);
  } else if (offset >= in_endpoints && offset < endpoints_end) {
    write_endpoint(offset, value);
  } else if (offset >= dieptxf1 && offset <= dieptxf3) {
    transmit_fifo_[(offset - dieptxf1) / 4 + 1] = value;
  } else {
    switch (offset) {
      case gahbcfg:
        if ((value & ~1u) != 0) refuse_setting(name, "GAHBCFG", value);
        gahbcfg_ = value;
        break;
      case gusbcfg:
        gusbcfg_ = value;
        break;
      case grstctl:
        if ((value & 1u) != 0) core_reset();
        if ((value & 16u) != 0) {
          received_.clear();
          reading_.clear();
        }
        if ((value & 32u) != 0) {
          const std::uint32_t fifo = value >> 6 & 31u;
          for (std::uint32_t i = 0; i < endpoint_count; ++i)
            if (fifo == i || fifo == 16) in_[i].words.clear();
        }
        break;
      case gintsts:
        gintsts_ &= ~(value & cleared_by_writing);
        break;
      case gintmsk:
        gintmsk_ = value;
        break;
      case grxfsiz:
        grxfsiz_ = value & 0xFFFF;
        break;
      case dieptxf0:
        transmit_fifo_[0] = value;
        break;
      case gccfg:
        gccfg_ = value;
        break;
      case dcfg:
        dcfg_ = value;
        break;
      case dctl:
        dctl_ = value & soft_disconnect;
        if ((value & set_global_out_nak) != 0 && !global_nak_) {
          global_nak_ = true;
          push(0, is_global_nak, {});
        }
        if ((value & clear_global_out_nak) != 0) {
          global_nak_ = false;
          gintsts_ &= ~global_out_nak;
        }
        break;
      case diepmsk:
        diepmsk_ = value;
        break;
      case doepmsk:
        doepmsk_ = value;
        break;
      case daintmsk:
        daintmsk_ = value;
        break;
      default:
        refuse_register(name, offset);
    }
  }
  std::uint32_t fifo_end = grxfsiz_;
  for (const std::uint32_t fifo : transmit_fifo_)
    fifo_end = std::max(fifo_end, (fifo & 0xFFFFu) + (fifo >> 16));
  if (gintmsk_ != 0 && fifo_end > fifo_words)
    refuse_setting(name, "FIFOs beyond their memory of 320 words, end", fifo_end);
  tell_interrupt();
}

}  // namespace umov::mcu
