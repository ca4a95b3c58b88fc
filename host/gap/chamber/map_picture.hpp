// What a page or a figure shows of a diagnosed luminance map: for every pixel what was measured,
// what the simulation and the best explanation say, and what each cause does.
#pragma once

#include <cstddef>
#include <vector>

#include "host/chamber/figures.hpp"
#include "host/gap/chamber/chamber_model.hpp"
#include "host/gap/engine/alternatives.hpp"
#include "host/gap/engine/diagnosis.hpp"

namespace umov::gap {

/// What an effect of the best explanation does to the map, cd/m²: the best prediction less one
/// without the effect.
struct MapContribution {
  Effect effect;
  bool named = false;        ///< among the diagnosis' causes; others fit but are not sure enough
  std::vector<double> held;  ///< all else as it is in the best explanation
  std::vector<double> refitted;  ///< all else fitted anew: what nothing but the effect explains
  double delta_chi2 = 0;         ///< lost without it, all else fitted anew
};

/// Row by row from below; not a number where a pixel was not used.
struct MapPicture {
  std::size_t width = 0, height = 0;
  double pixel_mm = 1;
  std::vector<double> measured, base, best;  ///< cd/m²
  std::vector<double> sigma;  ///< of the measurement less a simulation that is right, cd/m²
  std::vector<MapContribution> contributions;
  std::vector<Alternative> alternatives;
  /// Of the measurement with the simulation as described, and with the best explanation.
  chamber::Likeness before, after;
};

MapPicture picture_of(const ChamberModel& model, const Diagnosis& diagnosis);

}  // namespace umov::gap
