#include "hil/plant/collection_memory.hpp"

#include <bit>
#include <cstdint>

#include "hil/plant/noise.hpp"

namespace umov::plant {
namespace {

/// 5 MB.
constexpr std::size_t most_entries = 8192;

}  // namespace

std::size_t CollectionMemory::Hash::operator()(const Key& key) const {
  const Geometry& g = key.geometry;
  auto bits = static_cast<std::uint64_t>(key.laser);
  for (const double value :
       {g.theta_i, g.theta_r, g.phi_r, g.steer_in_p, g.steer_in_s, g.steer_out_p, g.steer_out_s}) {
    bits = mix(bits + std::bit_cast<std::uint64_t>(value));
  }
  return static_cast<std::size_t>(bits);
}

CollectionMemory::Entry& CollectionMemory::at(int laser, const Geometry& geometry) {
  const Key key{laser, geometry};
  const auto found = entries_.find(key);
  if (found != entries_.end()) return found->second;
  if (entries_.size() >= most_entries) entries_.clear();
  return entries_[key];
}

}  // namespace umov::plant
