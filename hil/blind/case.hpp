// One case of the withheld-effect benchmark: what is drawn for it, and the scans it gives.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "hil/blind/change.hpp"
#include "hil/blind/effect.hpp"
#include "hil/blind/material.hpp"
#include "hil/blind/scan_rows.hpp"
#include "host/formats/scan_table.hpp"

namespace umov::blind {

enum class CaseClass { none, single, two, triple, foreign, confounded, crowded };
inline constexpr int class_count = 7;
inline constexpr std::array<std::string_view, class_count> class_names = {
    "none", "single", "double", "triple", "foreign", "confounded", "crowded"};
/// Cases of each class in a hundred.
inline constexpr std::array<int, class_count> cases_in_a_hundred = {20, 30, 18, 7, 12, 5, 8};
/// Throws umov::Error for an unknown name.
CaseClass class_named(std::string_view name);
std::string_view name_of(CaseClass c);

/// What may be fixed instead of drawn.
struct CaseOptions {
  std::optional<CaseClass> only_class;
  std::optional<std::string> only_effect;  ///< cases are then single, or foreign
  std::optional<Style> only_style;
  double rho_from = 3.0, rho_to = 50.0;
};

/// A catalogue member that a case's change could be taken for.
struct LookAlike {
  std::string effect;
  double rho_left = 0.0;  ///< of ρ, when it is fitted instead
};

struct CaseTruth {
  std::string name;  ///< "case_0001"
  CaseClass kind = CaseClass::none;
  std::vector<Effect> effects;  ///< largest ρ first
  double rho = 0.0;             ///< of all together
  std::vector<LookAlike> look_alikes;
  Material material;
  double rho_beyond_one_gaussian_lobe = 0.0;  ///< see lobe_fit.hpp
  CasePlan plan;
  double relative_noise = 0.003;  ///< of a record
  double additive_noise_v = 3e-7;
  double duration_s = 0.0;
  std::size_t records = 0;
  std::uint64_t seed = 1;
  plant::PlantConfig config;  ///< with the effects in it
  /// Header's gain constants: the true ones with an error of 1 %.
  std::array<double, plant::laser_count> stated_gain_v{};
};

/// Classes of `count` cases in their shuffled order.
std::vector<CaseClass> case_classes(std::size_t count, std::uint64_t seed,
                                    const CaseOptions& options = {});

/// Case `number` (from 1) of a set. Depends on nothing but the arguments.
CaseTruth make_case(std::uint64_t seed, std::size_t number, CaseClass kind,
                    const CaseOptions& options = {});

/// The case's own scan.
formats::ScanTable own_scan(const CaseTruth& truth);
/// One more scan of the same sample on the same instrument, time running on after the case's own.
/// `white_tile` blocks make a scan of role white. Throws umov::Error where blocks of both kinds are
/// mixed.
formats::ScanTable further_scan(const CaseTruth& truth, const std::vector<RowBlock>& blocks);

/// Catalogue members that leave less than `limit` of the effects' change when one of them is fitted
/// beside the base instead; least left first.
std::vector<LookAlike> look_alikes(const ChangeMeter& meter, const std::vector<Effect>& effects,
                                   std::uint64_t seed, double limit = 3.0);

}  // namespace umov::blind
