// How the two tables of effects are written down.
#pragma once

#include <vector>

#include "hil/blind/effect.hpp"

namespace umov::blind {

/// Effects that the diagnosis' catalogue has.
std::vector<EffectKind> catalogue_effects();
/// Effects that it does not have.
std::vector<EffectKind> foreign_effects();

/// An effect with one parameter, which is one parameter of the plant.
EffectKind single_parameter(std::string name, bool in_catalogue, std::string parameter,
                            std::string plant_parameter, double smallest, double largest,
                            bool both_signs, std::string about);

/// "laser.532." …
std::string laser_prefix(std::size_t laser);
/// The laser whose wavelength this is.
std::size_t laser_of(double wavelength_nm);

}  // namespace umov::blind
