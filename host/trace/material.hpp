// What faces are made of. All spectra have one value for each wavelength of the scene, in order.
#pragma once

#include <cstdint>
#include <variant>
#include <vector>

#include "host/brdf/sampler.hpp"

namespace umov::trace {

/// Index into Scene::media.
using MediumId = std::uint32_t;
/// Index into Scene::materials.
using MaterialId = std::uint32_t;

/// What light travels in between faces; n + iκ.
struct Medium {
  std::vector<double> n;      ///< > 0
  std::vector<double> kappa;  ///< >= 0; a path loses exp(-4πκ·length/λ)
};

/// The medium that every scene has: vacuum.
inline constexpr MediumId vacuum = 0;

/// Depolarises; exit directions follow the cosine in the medium in front.
struct Lambertian {
  std::vector<double> albedo;  ///< 0 to 1
};

/// A smooth opaque body: reflects after Fresnel, keeps the rest.
struct Conductor {
  std::vector<double> n, kappa;
};

/// A smooth face between two media. `front` is where the face's normal points to.
struct Interface {
  MediumId front, back;
};

/// A flat face with a model of the library; its sampler has been made for the scene's wavelengths.
struct Modelled {
  brdf::Sampler sampler;
};

using Material = std::variant<Lambertian, Conductor, Interface, Modelled>;

}  // namespace umov::trace
