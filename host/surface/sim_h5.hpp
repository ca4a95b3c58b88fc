// What a simulated hemisphere adds to brdf.h5 (sim.h5).
#pragma once

#include <cstdint>
#include <string>

#include "host/formats/hdf5_image.hpp"
#include "host/surface/scene_file.hpp"
#include "host/trace/simulation.hpp"

namespace umov::surface {

/// What a result does not say of itself.
struct Simulated {
  double theta_i_deg;
  std::uint64_t seed;
  std::uint64_t lays;  ///< 1: errors are those of rays alone
};

/// Group `path` ("/hemisphere"): theta_r_deg, phi_r_deg and solid_angle_sr by cell, wavelength_nm,
/// mueller and mueller_se [cell, wavelength, 16] in 1/sr, row by row; the same of the strip in the
/// plane of incidence with signed θr in PATH/strip, if there is one. Attributes: theta_i_deg, dhr,
/// dhr_se, hemispherical_dop, hemispherical_dop_se, absorbed, lost (by wavelength), rays, samples,
/// seed, lays. With `emission` and absorptances, group PATH/radiance (radiance.hpp).
void add_hemisphere(formats::Hdf5Builder& file, const std::string& path,
                    const trace::Result& result, const trace::Scene& scene,
                    const Simulated& simulated, const std::optional<Emission>& emission);

}  // namespace umov::surface
