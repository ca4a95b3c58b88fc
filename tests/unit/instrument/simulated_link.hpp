// A pipe to a SimulatedDevice that can be as bad as one likes, in virtual time and seeded.
#pragma once

#include <algorithm>
#include <cstdint>
#include <deque>
#include <memory>
#include <span>
#include <string>
#include <utility>

#include "host/instrument/link_lost.hpp"
#include "host/instrument/transport.hpp"
#include "tests/unit/instrument/bad_cable.hpp"
#include "tests/unit/instrument/simulated_device.hpp"

namespace umov::instrument::testing {

/// The cable: outlives the transports plugged into it.
struct Cable : BadCable {
  SimulatedDevice device;
  Bytes stale;                   ///< what the next host finds in the pipe
  std::uint64_t one_way_us = 0;  ///< latency of each direction
  std::uint64_t jitter_us = 0;   ///< up to this much more, from host to device only
};

class SimulatedLink final : public Transport {
 public:
  explicit SimulatedLink(Cable& cable) : cable_(&cable) {
    to_host_ = std::exchange(cable.stale, {});
    cable.device.sent.clear();
  }

  void write(std::span<const std::uint8_t> bytes) override {
    check();
    if (cable_->one_way_us + cable_->jitter_us > 0) {
      const std::uint64_t jitter = cable_->jitter_us > 0 ? cable_->random() % cable_->jitter_us : 0;
      pass(cable_->one_way_us + jitter);
    }
    Bytes arrived;
    carry(Bytes(bytes.begin(), bytes.end()), held_to_device_, arrived);
    cable_->device.receive(arrived);
    check();
  }

  std::size_t read(std::span<std::uint8_t> buffer, std::chrono::microseconds timeout) override {
    check();
    const std::uint64_t end =
        cable_->device.now_us() +
        static_cast<std::uint64_t>(std::max<std::int64_t>(timeout.count(), 0));
    collect();
    while (to_host_.empty() && cable_->device.now_us() < end) {
      pass(std::min<std::uint64_t>(100, end - cable_->device.now_us()));
      collect();
    }
    check();
    const std::size_t count = std::min(buffer.size(), to_host_.size());
    std::copy_n(to_host_.begin(), count, buffer.begin());
    to_host_.erase(to_host_.begin(), to_host_.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }

  std::uint64_t clock_us() override { return cable_->device.now_us(); }
  std::string name() const override { return "simulated"; }

 private:
  void pass(std::uint64_t us) { cable_->device.step(us); }

  void check() const {
    if (broken_) throw LinkLost("simulated", "connection lost");
  }

  void collect() {
    while (!cable_->device.sent.empty()) {
      if (cable_->one_way_us > 0) pass(cable_->one_way_us);
      Bytes frame = std::move(cable_->device.sent.front());
      cable_->device.sent.pop_front();
      carry(std::move(frame), held_to_host_, to_host_);
    }
  }

  void carry(const Bytes& frame, Bytes& held, Bytes& out) {
    if (!cable_->carry(frame, held, out)) broken_ = true;
  }

  Cable* cable_;
  Bytes to_host_;
  Bytes held_to_host_;
  Bytes held_to_device_;
  bool broken_ = false;
};

inline std::unique_ptr<Transport> plug_into(Cable& cable) {
  return std::make_unique<SimulatedLink>(cable);
}

}  // namespace umov::instrument::testing
