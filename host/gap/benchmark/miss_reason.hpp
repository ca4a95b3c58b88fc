// Why a case is missed, as far as the oracle's fit of the truth tells.
#pragma once

#include <array>
#include <optional>
#include <string_view>
#include <vector>

#include "host/gap/benchmark/score.hpp"

namespace umov::gap::benchmark {

enum class MissReason {
  mimicry,   ///< withheld rows speak no more for the truth than for what was named
  faint,     ///< withheld rows speak for the truth by no more than noise does for some effect
  search,    ///< withheld rows speak for the truth, which was not found or not settled
  unseen,    ///< the oracle does not see what is missing either
  rest,      ///< all is named, and something is said to stay unexplained
  more,      ///< all is named, and something besides
  material,  ///< there is no effect; the reflectance is one that no family follows
  chance,    ///< there is no effect, and one Gaussian lobe
};

inline constexpr std::array all_miss_reasons = {
    MissReason::mimicry, MissReason::faint, MissReason::search,   MissReason::unseen,
    MissReason::rest,    MissReason::more,  MissReason::material, MissReason::chance};

std::string_view to_string(MissReason reason);

/// χ² of withheld rows of the case's own scan that the answer leaves above what the truth, fitted,
/// leaves; nullopt where one of them has no gap.
std::optional<double> withheld_excess(const Entry& entry);

/// `claims`: those that missed. What withheld rows say is of the case's own scan whichever answer
/// they are of. nullopt where there is no oracle to compare with.
std::optional<MissReason> miss_reason(const Entry& entry, const std::vector<Claim>& claims);

}  // namespace umov::gap::benchmark
