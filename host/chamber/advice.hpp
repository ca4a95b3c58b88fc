// How much of a BRDF a luminaire needs: its surfaces are simplified step by step, and what that
// does to its map, its distribution and its glare is held against the full material.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host/chamber/scene_file.hpp"

namespace umov::chamber {

/// How far a quantity may be off. The glare: CIE 117 takes one unit as the least noticeable.
struct Tolerances {
  double intensity = 0.02;  ///< root mean square, of the peak
  double luminance = 0.05;  ///< NRMSE of the region (the map where there is none)
  double ugr = 1.0;
};

/// One simplification of one surface and what it costs.
struct Ablation {
  std::string surface;  ///< name in the scene
  std::string knows;    ///< "reflectance alone", "6 incidences, 2.5°"
  int readings = 0;     ///< that a laboratory takes for it, one of a sphere included
  /// As far as it is beyond the noise of the rays; nothing where the scene does not measure it.
  std::optional<double> intensity, luminance, ncc, ugr;
};

struct Advice {
  std::vector<Ablation> ablations;  ///< each surface's by rising number of readings
  std::vector<std::string> sentences;
};

struct AdviceRequest {
  Tolerances tolerances;
  std::uint64_t rays_per_pixel = 400;
  std::uint64_t launches = 1'000'000;
  std::uint64_t seed = 1;
  int threads = 0;
  std::function<void(double)> progress = {};
  const Team* team = nullptr;  ///< all must make the same request; changes no result
};

/// Throws umov::Error where every surface is Lambertian, as nothing can be simplified, and for one
/// that is not and has a spectrum. Maps are taken
/// with at most some 2,000 pixels. Tables too coarse to hold the light of their lobe (see
/// PlanesSurface) are left out.
Advice advise(const Job& job, const AdviceRequest& request);

/// A surface as a goniometer would find it in two planes, at 555 nm.
brdf::PlanesTable measured_planes(const Surface& surface, const std::vector<double>& theta_i_deg,
                                  double step_deg);
/// What an aperture of 2.5° half angle gets in the mirror direction beyond the level 60° across,
/// and the mirror part where the surface has one.
double measured_specular(const Surface& surface, double theta_i_deg);

}  // namespace umov::chamber
