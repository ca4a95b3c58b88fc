#include "host/gap/engine/alternatives.hpp"

#include <algorithm>

namespace umov::gap {
namespace {

/// Values of one effect of a fit with their 95 % intervals.
std::vector<NamedValue> values_of(const ForwardModel& model, const Refit& fit, std::size_t effect) {
  const Eigen::VectorXd errors = standard_errors(fit.precision);
  std::vector<NamedValue> values;
  auto column = static_cast<Eigen::Index>(fit.explanation.base.size());
  for (std::size_t k = 0; k < fit.explanation.effects.size(); ++k) {
    const auto& declared = model.effects()[fit.explanation.effects[k]].parameters;
    for (std::size_t i = 0; i < declared.size(); ++i, ++column) {
      if (fit.explanation.effects[k] != effect) continue;
      values.push_back(named_value(declared[i], fit.explanation.alpha[k][i], errors[column]));
    }
  }
  return values;
}

}  // namespace

std::vector<Alternative> alternatives_of(const ForwardModel& model, const Diagnosis& d) {
  const auto& effects = d.best.explanation.effects;
  std::vector<Alternative> out;
  for (const Diagnosis::Rival& rival : d.rivals) {
    for (const std::size_t e : rival.rival.explanation.effects) {
      if (model.effects()[e].name != rival.rival_effect ||
          std::find(effects.begin(), effects.end(), e) != effects.end())
        continue;
      out.push_back({rival.effect, model.effects()[e], values_of(model, rival.rival, e)});
    }
  }
  return out;
}

}  // namespace umov::gap
