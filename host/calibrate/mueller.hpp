// Mueller reflectometry: the linear part of the Mueller BRDF from points in several states.
#pragma once

#include <cstddef>
#include <optional>
#include <string>
#include <vector>

#include "host/formats/brdf_table.hpp"

namespace umov::calibrate {

struct MuellerSummary {
  std::size_t directions = 0;             ///< with an entry in the table
  std::size_t complete = 0;               ///< all nine elements determined
  std::size_t left_out = 0;               ///< directions with P, S and open states only
  std::size_t unphysical = 0;             ///< realisable_z below -3
  double chi2 = 0, dof = 0;               ///< over all directions
  double largest_condition = 0;           ///< of complete directions
  std::vector<std::string> undetermined;  ///< names of elements that some entry lacks
};

/// Weighted least squares of every direction's used points, in ideal states, for the nine elements
/// of the linear part: point = Aᵀ F S with A = ½ (1, -cos 2α, sin 2α), S = (1, -cos 2β, sin 2β), or
/// (1, 0, 0) open. The covariance has the points' own noise and all shared factors. Elements that
/// the states leave open are NaN, the others are not touched by that. Directions without an oblique
/// state have four elements at most and are left out unless `partial`. nullopt where none is left.
std::optional<formats::BrdfTable::Mueller> find_mueller(const formats::BrdfTable& table,
                                                        bool partial, MuellerSummary& summary);

}  // namespace umov::calibrate
