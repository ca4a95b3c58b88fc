#include "host/cli/blind_truth.hpp"

#include <filesystem>

#include "hil/blind/case_set.hpp"
#include "host/errors/error.hpp"

namespace umov::cli {
namespace {

/// ρ beside the others. Below it an effect is lost in the noise, and fitting it makes a forecast
/// worse.
constexpr double visible_in_a_crowd = 3.0;

}  // namespace

SealedTruth::SealedTruth(const std::string& cases, const std::string& truth_folder)
    : file_(blind::read_truth(std::filesystem::path(truth_folder) / blind::truth_name)) {
  if (!blind::seal_fits(cases, truth_folder)) {
    throw Error({truth_folder}, "is not the truth that " + cases + " was sealed with",
                "name the folder that was made with it; a truth that was changed is void");
  }
}

formats::ScanTable SealedTruth::further_scan(const std::string& name,
                                             const std::vector<std::string>& menus) const {
  const blind::CaseTruth& truth = file_.find(name);
  std::vector<blind::RowBlock> blocks;
  for (const std::string& menu : menus) blocks.push_back(blind::menu_block(truth.plan, menu));
  return blind::further_scan(truth, blocks);
}

std::vector<std::string> SealedTruth::effects(const std::string& name) const {
  std::vector<std::string> names;
  for (const blind::Effect& effect : file_.find(name).effects)
    if (effect.in_catalogue) names.push_back(effect.name);
  return names;
}

std::vector<std::string> SealedTruth::known_causes(const std::string& name) const {
  const blind::CaseTruth& truth = file_.find(name);
  std::vector<std::string> names = effects(name);
  if (truth.kind == blind::CaseClass::crowded) {
    names.clear();
    for (const blind::Effect& effect : truth.effects)
      if (effect.in_catalogue && effect.rho_given_others >= visible_in_a_crowd)
        names.push_back(effect.name);
  }
  if (!truth.material.one_gaussian_lobe) names.emplace_back("sample_model");
  return names;
}

}  // namespace umov::cli
