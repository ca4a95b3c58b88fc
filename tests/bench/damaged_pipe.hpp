// Any transport behind a bad cable.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/instrument/link_lost.hpp"
#include "host/instrument/transport.hpp"
#include "tests/unit/instrument/bad_cable.hpp"

namespace umov::bench {

/// The bytes of the transport inside, cut into frames at their zeros.
class DamagedPipe final : public instrument::Transport {
 public:
  DamagedPipe(std::unique_ptr<instrument::Transport> inner, instrument::testing::BadCable& cable)
      : inner_(std::move(inner)), cable_(&cable) {}

  void write(std::span<const std::uint8_t> bytes) override {
    check();
    feed(bytes, to_device_);
    check();
    if (!to_device_.out.empty()) inner_->write(std::exchange(to_device_.out, {}));
  }

  std::size_t read(std::span<std::uint8_t> buffer, std::chrono::microseconds timeout) override {
    check();
    if (to_host_.out.empty()) {
      Bytes bytes(4096);
      bytes.resize(inner_->read(bytes, timeout));
      feed(bytes, to_host_);
      check();
    }
    const std::size_t count = std::min(buffer.size(), to_host_.out.size());
    std::copy_n(to_host_.out.begin(), count, buffer.begin());
    to_host_.out.erase(to_host_.out.begin(),
                       to_host_.out.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }

  std::uint64_t clock_us() override { return inner_->clock_us(); }
  std::string name() const override { return inner_->name(); }

 private:
  using Bytes = std::vector<std::uint8_t>;

  struct Direction {
    Bytes frame, held, out;
  };

  void feed(std::span<const std::uint8_t> bytes, Direction& way) {
    for (const auto byte : bytes) {
      if (broken_) return;
      way.frame.push_back(byte);
      if (byte != 0) continue;
      const Bytes frame = std::exchange(way.frame, {});
      if (frame.size() == 1) {
        way.out.push_back(0);  // an empty frame: clears what lies in the pipe
      } else if (!cable_->carry(frame, way.held, way.out)) {
        broken_ = true;
      }
    }
  }

  void check() const {
    if (broken_) throw instrument::LinkLost(name(), "connection lost");
  }

  std::unique_ptr<instrument::Transport> inner_;
  instrument::testing::BadCable* cable_;
  Direction to_device_, to_host_;
  bool broken_ = false;
};

}  // namespace umov::bench
