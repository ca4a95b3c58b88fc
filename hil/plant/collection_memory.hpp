// Throughputs by geometry: a scan comes back to the same angles in other polarisation states.
#pragma once

#include <cstddef>
#include <optional>
#include <unordered_map>

#include "hil/plant/collection.hpp"

namespace umov::plant {

/// Holds some thousand entries and begins anew when full.
class CollectionMemory {
 public:
  struct Entry {
    std::optional<Throughput> dry, humid;  ///< filled by whoever asks first
  };

  void clear() { entries_.clear(); }
  /// The entry of a laser at a geometry. Valid until clear() or the next call of `at`.
  Entry& at(int laser, const Geometry& geometry);

 private:
  struct Key {
    int laser;
    Geometry geometry;
    bool operator==(const Key&) const = default;
  };
  struct Hash {
    std::size_t operator()(const Key& key) const;
  };

  std::unordered_map<Key, Entry, Hash> entries_;
};

}  // namespace umov::plant
