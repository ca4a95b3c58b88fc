// Another transport behind a bad cable: its frames are damaged, dropped, doubled, swapped, and the
// pipe breaks. Seeded.
#pragma once

#include <algorithm>
#include <cstdint>
#include <memory>
#include <random>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/instrument/link_lost.hpp"
#include "host/instrument/transport.hpp"
#include "tests/unit/instrument/simulated_link.hpp"

namespace umov::bench {

/// What outlives the pipes that break.
struct Damage {
  instrument::testing::LinkFaults faults;
  instrument::testing::LinkCounters counters;
  std::mt19937_64 random;

  bool happens(double probability) {
    return static_cast<double>(random() >> 11) * 0x1p-53 < probability;
  }
};

class DamagedPipe final : public instrument::Transport {
 public:
  DamagedPipe(std::unique_ptr<instrument::Transport> inner, Damage& damage)
      : inner_(std::move(inner)), damage_(&damage) {}

  void write(std::span<const std::uint8_t> bytes) override {
    check();
    to_device_.feed(bytes, *damage_, broken_);
    check();
    if (!to_device_.out.empty()) inner_->write(std::exchange(to_device_.out, {}));
  }

  std::size_t read(std::span<std::uint8_t> buffer, std::chrono::microseconds timeout) override {
    check();
    if (to_host_.out.empty()) {
      Bytes bytes(4096);
      bytes.resize(inner_->read(bytes, timeout));
      to_host_.feed(bytes, *damage_, broken_);
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

  /// One direction: bytes go in, whole frames (up to their zero) are carried as badly as told.
  struct Direction {
    Bytes frame, held, out;

    void feed(std::span<const std::uint8_t> bytes, Damage& damage, bool& broken) {
      for (const auto byte : bytes) {
        if (broken) return;
        frame.push_back(byte);
        if (byte == 0) carry(std::exchange(frame, {}), damage, broken);
      }
    }
    void carry(const Bytes& whole, Damage& damage, bool& broken) {
      if (whole.size() == 1) {  // an empty frame: clears what lies in the pipe
        out.push_back(0);
        return;
      }
      ++damage.counters.frames;
      if (damage.happens(damage.faults.disconnect)) {
        ++damage.counters.disconnects;
        broken = true;
        return;
      }
      if (damage.happens(damage.faults.drop)) {
        ++damage.counters.dropped;
        return;
      }
      const bool twice = damage.happens(damage.faults.duplicate);
      damage.counters.duplicated += twice ? 1 : 0;
      for (int copy = 0; copy < (twice ? 2 : 1); ++copy) {
        Bytes bytes = whole;
        for (auto& byte : bytes) {
          if (!damage.happens(damage.faults.byte_error)) continue;
          byte = static_cast<std::uint8_t>(byte ^ (1u << (damage.random() % 8)));
          ++damage.counters.damaged_bytes;
        }
        if (held.empty() && damage.happens(damage.faults.reorder)) {
          ++damage.counters.reordered;
          held = std::move(bytes);
          continue;
        }
        out.insert(out.end(), bytes.begin(), bytes.end());
        out.insert(out.end(), held.begin(), held.end());
        held.clear();
      }
    }
  };

  void check() const {
    if (broken_) throw instrument::LinkLost(name(), "connection lost");
  }

  std::unique_ptr<instrument::Transport> inner_;
  Damage* damage_;
  Direction to_device_, to_host_;
  bool broken_ = false;
};

}  // namespace umov::bench
