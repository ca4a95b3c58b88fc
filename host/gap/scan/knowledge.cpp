#include "host/gap/scan/knowledge.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/errors/error.hpp"

namespace umov::gap::scan {
namespace {

std::vector<std::string> distinct_names(const std::vector<Effect>& effects) {
  std::vector<std::string> names;
  for (const Effect& e : effects)
    if (std::find(names.begin(), names.end(), e.name) == names.end()) names.push_back(e.name);
  return names;
}

}  // namespace

formats::FitResult fit_at(const formats::FitResult& fit,
                          const std::vector<double>& wavelengths_nm) {
  constexpr double same_nm = 0.5;
  formats::FitResult result = fit;
  result.wavelengths_nm = wavelengths_nm;
  for (formats::FitParameter& p : result.parameters)
    if (!p.shared) p.estimates.clear();
  for (const double nm : wavelengths_nm) {
    const auto own = std::find_if(fit.wavelengths_nm.begin(), fit.wavelengths_nm.end(),
                                  [nm](double known) { return std::abs(known - nm) < same_nm; });
    if (own == fit.wavelengths_nm.end())
      throw Error(fmt::format("the fit has no wavelength {:g} nm, only {:g}", nm,
                              fmt::join(fit.wavelengths_nm, ", ")),
                  "name a fit of a scan with the same wavelengths");
    const auto w = static_cast<std::size_t>(own - fit.wavelengths_nm.begin());
    for (std::size_t i = 0; i < result.parameters.size(); ++i)
      if (!result.parameters[i].shared)
        result.parameters[i].estimates.push_back(fit.parameters[i].estimates[w]);
  }
  return result;
}

void apply_tolerances(const std::vector<Tolerance>& tolerances, std::vector<Effect>& effects) {
  for (const Tolerance& t : tolerances) {
    const Place place{t.file, t.line};
    std::vector<std::string> known;
    bool effect_found = false, found = false;
    for (Effect& effect : effects) {
      if (effect.name != t.effect) continue;
      effect_found = true;
      for (Parameter& p : effect.parameters) {
        if (p.choice) continue;
        known.push_back(p.name);
        if (p.name != t.parameter) continue;
        if (p.shape)
          throw Error(place,
                      fmt::format("{} of {} only shapes the effect: it has no size to tolerate",
                                  p.name, effect.name),
                      "state the tolerance of " + effect.parameters.front().name);
        p.prior_u = t.u;
        found = true;
      }
    }
    if (!effect_found)
      throw Error(place, "no effect is called \"" + t.effect + "\"",
                  fmt::format("choose from: {}", fmt::join(distinct_names(effects), ", ")));
    if (!found)
      throw Error(place, fmt::format("{} has no parameter \"{}\"", t.effect, t.parameter),
                  fmt::format("choose from: {}", fmt::join(known, ", ")));
  }
}

}  // namespace umov::gap::scan
