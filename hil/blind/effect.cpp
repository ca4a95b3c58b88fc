#include "hil/blind/effect.hpp"

#include <cmath>
#include <utility>

#include "hil/blind/effect_table.hpp"
#include "hil/plant/parameter_setting.hpp"
#include "host/errors/error.hpp"

namespace umov::blind {

EffectKind single_parameter(std::string name, bool in_catalogue, std::string parameter,
                            std::string plant_parameter, double smallest, double largest,
                            bool both_signs, std::string about) {
  EffectKind kind;
  kind.name = std::move(name);
  kind.in_catalogue = in_catalogue;
  kind.smallest = smallest;
  kind.largest = largest;
  kind.both_signs = both_signs;
  kind.principal = std::move(parameter);
  kind.further = [](Random&, const EffectContext&) { return std::vector<Named>{}; };
  kind.settings = [plant_parameter = std::move(plant_parameter)](const std::vector<Named>& p,
                                                                 const EffectContext&) {
    return std::vector<Named>{{plant_parameter, p[0].second}};
  };
  kind.about = std::move(about);
  return kind;
}

std::string laser_prefix(std::size_t laser) {
  return "laser." + std::to_string(plant::laser_names[laser]) + ".";
}

std::size_t laser_of(double wavelength_nm) {
  for (std::size_t i = 0; i < plant::laser_count; ++i) {
    if (plant::laser_names[i] == static_cast<int>(std::lround(wavelength_nm))) return i;
  }
  throw Error("the instrument has no laser of " + std::to_string(wavelength_nm) + " nm",
              "use 532, 633 or 814");
}

const std::vector<EffectKind>& effect_kinds() {
  static const std::vector<EffectKind> all = [] {
    std::vector<EffectKind> kinds = catalogue_effects();
    for (EffectKind& kind : foreign_effects()) kinds.push_back(std::move(kind));
    return kinds;
  }();
  return all;
}

const EffectKind& effect_kind(const std::string& name) {
  std::string names;
  for (const EffectKind& kind : effect_kinds()) {
    if (kind.name == name) return kind;
    names += (names.empty() ? "" : ", ") + kind.name;
  }
  throw Error("no effect is called \"" + name + "\"", "there are " + names);
}

Effect draw_effect(const EffectKind& kind, Random& random, const EffectContext& context,
                   double size) {
  Effect effect;
  effect.name = kind.name;
  effect.in_catalogue = kind.in_catalogue;
  const double sign = kind.both_signs ? random.sign() : 1.0;
  effect.parameters.emplace_back(kind.principal, sign * size);
  for (Named& further : kind.further(random, context)) {
    effect.parameters.push_back(std::move(further));
  }
  // Those that go with the principal one were drawn in its units.
  for (std::size_t i = 1; i < kind.scaled_together; ++i) effect.parameters[i].second *= size;
  return effect;
}

Effect scaled(const Effect& effect, double factor) {
  Effect changed = effect;
  const std::size_t count = effect_kind(effect.name).scaled_together;
  for (std::size_t i = 0; i < count; ++i) changed.parameters[i].second *= factor;
  return changed;
}

void apply(const Effect& effect, const EffectContext& context, plant::PlantConfig& config) {
  for (const auto& [name, value] : effect_kind(effect.name).settings(effect.parameters, context)) {
    plant::set_parameter(config, name, value, {});
  }
}

}  // namespace umov::blind
