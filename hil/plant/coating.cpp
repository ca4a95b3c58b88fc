#include "hil/plant/coating.hpp"

#include "hil/plant/dust_layer.hpp"
#include "hil/plant/surface_marks.hpp"
#include "hil/plant/water.hpp"

namespace umov::plant {

std::shared_ptr<const Sample> coated(std::shared_ptr<const Sample> sample,
                                     const PlantConfig& config) {
  const MarksConfig& marks = config.marks;
  if (marks.lobe_weight != 0.0 || marks.retro_peak_per_sr != 0.0 ||
      marks.fluorescence_yield_532 != 0.0 || marks.fringe_contrast != 0.0 ||
      marks.gradient_per_mm != 0.0) {
    sample = std::make_shared<MarkedSurface>(std::move(sample), marks);
  }
  if (config.film.coverage != 0.0) {
    sample = std::make_shared<WaterFilm>(std::move(sample), config.film);
  }
  if (config.drops.coverage != 0.0) {
    sample = std::make_shared<WaterDrops>(std::move(sample), config.drops);
  }
  if (config.dust.optical_depth_633 != 0.0) {
    sample = std::make_shared<DustLayer>(std::move(sample), config.dust);
  }
  return sample;
}

}  // namespace umov::plant
