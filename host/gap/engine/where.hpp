// Where a residual lies: along the axes of a measurement and in its channels, with a significance
// that counts how many places were looked at.
#pragma once

#include <cstdint>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Core>

#include "host/gap/engine/forward_model.hpp"
#include "host/gap/engine/refit.hpp"

namespace umov::gap {

/// A stretch of an axis, in one channel or in all.
struct Cell {
  std::string axis, unit;
  double from = 0, to = 0;
  std::string channel;  ///< empty: all
  /// What else the cell is confined to, by name: filled by the adapter from axis and channel.
  std::vector<std::pair<std::string, std::string>> also;
  std::vector<Eigen::Index> members;
  double z = 0;         ///< of the mean (signed) or of the mean square, whichever is larger
  double p_global = 1;  ///< that noise alone gives a cell as bad anywhere
};

struct Where {
  std::vector<Cell> cells;  ///< worst first; those below p_global .05, twelve at most
  double p_global = 1;      ///< of the worst
};

/// Looks at every axis by itself and with every channel. What noise alone would do is drawn `draws`
/// times, with all that was fitted taken out of each draw.
Where find_where(const ForwardModel& model, const Refit& fit, int draws, std::uint64_t seed);

}  // namespace umov::gap
