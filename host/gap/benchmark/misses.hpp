// Cases that the diagnosis missed, and why, as far as the oracle's fit of the truth tells.
#pragma once

#include <array>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "host/gap/benchmark/score.hpp"

namespace umov::gap::benchmark {

enum class MissReason {
  mimicry,   ///< withheld rows speak no more for the truth than for what was named
  faint,     ///< withheld rows speak for the truth by no more than noise does for some effect
  search,    ///< withheld rows speak for the truth, which was not found or not settled
  unseen,    ///< what is missing is not significant
  behind,    ///< all is named, but not in the first place, or only as one with the reflectance
  rest,      ///< all is named, and something is said to stay unexplained
  more,      ///< all is named, and something besides
  material,  ///< there is no effect; the reflectance is not one Gaussian lobe
  chance,    ///< there is no effect, and one Gaussian lobe
};

inline constexpr std::array all_miss_reasons = {
    MissReason::mimicry, MissReason::faint,    MissReason::search,
    MissReason::unseen,  MissReason::behind,   MissReason::rest,
    MissReason::more,    MissReason::material, MissReason::chance};

std::string_view to_string(MissReason reason);

/// χ² of withheld rows of the case's own scan that the answer leaves above what the truth, fitted,
/// leaves; nullopt where it cannot be said: without an oracle, and of a crowd, which the oracle
/// fits coarsely.
std::optional<double> withheld_excess(const Entry& entry);

/// Why `missed`, one of the entry's answers, is wrong. What withheld rows say is of the case's own
/// scan whichever answer it is. nullopt where there is nothing to compare with.
std::optional<MissReason> miss_reason(const Entry& entry, const Answer& missed);

/// One way in which a case counts as missed.
struct Miss {
  std::string name, kind, measure, truth, material, style, answer;
  std::optional<MissReason> reason;
  std::string why;  ///< the reason, with the χ² at stake where it is `search`; empty without one
};

std::vector<Miss> misses(const std::vector<Entry>& entries);

}  // namespace umov::gap::benchmark
