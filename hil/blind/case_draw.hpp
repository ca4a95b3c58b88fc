// The parts of a case that are drawn: instrument, plan, and effects of a wanted size.
#pragma once

#include <optional>
#include <vector>

#include "hil/blind/case.hpp"
#include "hil/blind/random.hpp"

namespace umov::blind {

/// Plan of a scan of some thousand records.
CasePlan draw_plan(Random& random, const CaseOptions& options);

/// A bench without effects: lasers, amplifier, noise. Fills the truth's noise and stated gains.
plant::PlantConfig draw_instrument(Random& random, CaseTruth& truth);

/// Does this effect show only in blocks that the `full` style alone has?
bool needs_blocks(const std::string& effect);

/// The effect with its size set so that ρ is `target` within 2 %, or within 15 % where ρ jumps with
/// the size; nothing where no size within the kind's range does it.
std::optional<Effect> sized(const ChangeMeter& meter, const Effect& effect, double target);

/// Effects of a case of this class, with their ρ; nothing where none of the allowed kinds reaches
/// the wanted size on this material and plan.
std::optional<std::vector<Effect>> draw_effects(const ChangeMeter& meter, CaseClass kind,
                                                Style style, const CaseOptions& options,
                                                Random& random);

/// A real bench: every small imperfection of `small` in the instrument …
struct Crowd {
  plant::PlantConfig config;  ///< what has no canonical name
  std::vector<Effect> small;  ///< the rest, of usual size
};
Crowd draw_crowd(Random& random, const plant::PlantConfig& bare, const EffectContext& context);
/// … of which one is made five to twenty times larger. Returns all with their ρ, the largest first;
/// nothing where none would stand out.
std::optional<std::vector<Effect>> enlarge_one(const ChangeMeter& meter, std::vector<Effect> small,
                                               Random& random);

}  // namespace umov::blind
