// What a bad cable does to frames: damages, drops, doubles, swaps them, or breaks. Seeded.
#pragma once

#include <cstdint>
#include <random>
#include <utility>
#include <vector>

namespace umov::instrument::testing {

/// Probabilities of what can go wrong.
struct LinkFaults {
  double byte_error = 0;  ///< per byte: one bit flips
  double drop = 0;        ///< per frame
  double duplicate = 0;   ///< per frame
  double reorder = 0;     ///< per frame: it comes after its successor
  double disconnect = 0;  ///< per frame: the pipe breaks, with what is in it
};

struct LinkCounters {
  std::uint64_t frames = 0;
  std::uint64_t damaged_bytes = 0;
  std::uint64_t dropped = 0;
  std::uint64_t duplicated = 0;
  std::uint64_t reordered = 0;
  std::uint64_t disconnects = 0;
};

/// Outlives the pipes that break.
struct BadCable {
  LinkFaults faults;
  LinkCounters counters;
  std::mt19937_64 random{1};

  bool happens(double probability) {
    return probability > 0 && static_cast<double>(random() >> 11) * 0x1p-53 < probability;
  }

  /// Appends to `out` what comes of the frame; `held` is the one that its successor overtakes, of
  /// this direction. False: the pipe is broken.
  bool carry(const std::vector<std::uint8_t>& frame, std::vector<std::uint8_t>& held,
             std::vector<std::uint8_t>& out) {
    ++counters.frames;
    if (happens(faults.disconnect)) {
      ++counters.disconnects;
      return false;
    }
    if (happens(faults.drop)) {
      ++counters.dropped;
      return true;
    }
    const bool twice = happens(faults.duplicate);
    counters.duplicated += twice ? 1 : 0;
    for (int copy = 0; copy < (twice ? 2 : 1); ++copy) {
      std::vector<std::uint8_t> bytes = frame;
      for (auto& byte : bytes) {
        if (!happens(faults.byte_error)) continue;
        byte = static_cast<std::uint8_t>(byte ^ (1u << (random() % 8)));
        ++counters.damaged_bytes;
      }
      if (held.empty() && happens(faults.reorder)) {
        ++counters.reordered;
        held = std::move(bytes);
        continue;
      }
      out.insert(out.end(), bytes.begin(), bytes.end());
      out.insert(out.end(), held.begin(), held.end());
      held.clear();
    }
    return true;
  }
};

}  // namespace umov::instrument::testing
