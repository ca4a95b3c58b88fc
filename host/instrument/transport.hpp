// A byte pipe to a controller.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

namespace umov::instrument {

/// Bytes to and from a controller. Implementations: TCP here; the in-process emulator in
/// host/cli/emulator. Not thread-safe. A lost connection throws `LinkLost`.
class Transport {
 public:
  virtual ~Transport() = default;
  /// Sends all bytes or throws LinkLost.
  virtual void write(std::span<const std::uint8_t> bytes) = 0;
  /// Waits up to `timeout` for at least one byte; returns the number read, 0 on timeout.
  /// An emulator that owns virtual time lets it pass here.
  virtual std::size_t read(std::span<std::uint8_t> buffer, std::chrono::microseconds timeout) = 0;
  /// Host clock that belongs to this pipe, microseconds: wall time, or the emulator's virtual time.
  virtual std::uint64_t clock_us() = 0;
  /// What the user called it, such as "tcp:localhost:5025".
  virtual std::string name() const = 0;
};

}  // namespace umov::instrument
