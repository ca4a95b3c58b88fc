// What the USB stack hands to the controller, and asks it.
#pragma once

#include <cstdint>
#include <span>

#include "firmware/core/usb/descriptor_builder.hpp"
#include "firmware/core/usb/descriptors.hpp"

namespace umov::firmware::usb {

/// What a hand controller (knob, pendant, gamepad program) sends: one step of one axis.
///
///   byte 0    axis, 0 to 5
///   byte 1    flags: bit 0 stop, bit 1 emergency stop
///   byte 2–3  zero
///   byte 4–7  how far from where the axis is, i32, microdegrees, little-endian; 0: only look
struct HandReport {
  std::uint8_t axis = 0;
  bool stop = false;
  bool emergency = false;
  std::int32_t by_udeg = 0;
};

constexpr HandReport parse_hand_report(std::span<const std::uint8_t, hand_report_bytes> bytes) {
  std::uint32_t by = 0;
  for (std::size_t i = 0; i < 4; ++i) by |= static_cast<std::uint32_t>(bytes[4 + i]) << (8 * i);
  return {bytes[0], (bytes[1] & 1u) != 0, (bytes[1] & 2u) != 0, static_cast<std::int32_t>(by)};
}

/// What a hand controller is shown, whenever it changes.
///
///   byte 0    state (protocol::State)
///   byte 1    fault (protocol::Fault)
///   byte 2    bit a: axis a has been homed
///   byte 3    axis that the hand controller last named
///   byte 4–7  its position, i32, microdegrees, little-endian
struct HandState {
  std::uint8_t state = 0;
  std::uint8_t fault = 0;
  std::uint8_t homed_mask = 0;
  std::uint8_t axis = 0;
  std::int32_t position_udeg = 0;

  constexpr bool operator==(const HandState&) const = default;
};

constexpr Bytes<hand_report_bytes> hand_state_bytes(const HandState& s) {
  const auto position = static_cast<std::uint32_t>(s.position_udeg);
  return {s.state,
          s.fault,
          s.homed_mask,
          s.axis,
          static_cast<std::uint8_t>(position),
          static_cast<std::uint8_t>(position >> 8),
          static_cast<std::uint8_t>(position >> 16),
          static_cast<std::uint8_t>(position >> 24)};
}

class Application {
 public:
  /// Bytes of the host that owns the link, in chunks of any size.
  virtual void on_link_bytes(std::span<const std::uint8_t> bytes) = 0;
  /// A hand controller wants something; refuse it silently where it is not allowed.
  virtual void on_hand_report(const HandReport& report) = 0;
  virtual HandState hand_state(std::uint8_t axis) const = 0;
  /// Whether a host may end the program now to update it (DFU detach): there is a boot loader, and
  /// nothing moves or is measured.
  virtual bool detach_allowed() const = 0;
  /// Restart in the boot loader. Called after the request has been answered.
  virtual void on_detach() = 0;

 protected:
  Application() = default;
  Application(const Application&) = default;
  Application& operator=(const Application&) = default;
  ~Application() = default;
};

}  // namespace umov::firmware::usb
