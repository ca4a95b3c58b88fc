// The simulations of the study `chamber`.
#pragma once

#include <memory>
#include <string>
#include <vector>

#include "host/chamber/figures.hpp"
#include "host/chamber/mixing_chamber.hpp"

namespace umov::study {

/// [M]'s three models of the material, in its order.
struct WallModel {
  std::string name;   ///< "diffuse"
  std::string title;  ///< "diffuse, R = 0.984"
  std::shared_ptr<const chamber::Surface> surface;
};
std::vector<WallModel> wall_models();

/// The material that the models are of, as well as it can be known.
std::shared_ptr<const chamber::Surface> plastic_wall(double total);

/// The chamber as the models know it, and as it is measured: with what the models are not told.
chamber::MixingChamber known_chamber();
chamber::MixingChamber measured_chamber();
/// Sentences that say what is withheld.
std::vector<std::string> withheld();

/// Independent noise of a camera, one standard deviation over the signal.
inline constexpr double camera_noise = 0.005;
void add_camera_noise(chamber::Map& map, std::uint64_t seed);

/// The region about the highlights: as printed, in a window centred on the opening; and as large,
/// centred on the axis. The printed one reaches over the opening's edge there.
chamber::Region printed_region();
chamber::Region centred_region();
/// Pixels that see the inside of the chamber with all of their corners.
chamber::Map inside_only(const chamber::Map& map, const chamber::Region& region,
                         const chamber::MixingChamber& chamber);

}  // namespace umov::study
