// What faces are made of. All spectra have one value for each wavelength of the scene, in order.
#pragma once

#include <cstdint>
#include <utility>
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
/// A scene has no more media than this: each path counts the bodies that it is in, by medium.
inline constexpr std::size_t most_media = 12;

/// Depolarises; exit directions follow the cosine in the medium in front.
struct Lambertian {
  std::vector<double> albedo;  ///< 0 to 1
};

/// A smooth opaque body: reflects after Fresnel, keeps the rest.
struct Conductor {
  std::vector<double> n, kappa;
};

/// The smooth skin of a body of one medium, which lies behind the face (where its normal does not
/// point to). Bodies may overlap: where several do, there is that of the highest MediumId, and the
/// others' skins are not there. So drops of one liquid flow together, and a film may stand round
/// the foot of a drop.
struct Interface {
  MediumId inside;
};

/// A flat face with a model of the library; samplers have been made for the scene's wavelengths.
struct Modelled {
  brdf::Sampler sampler;
  /// What the face is in other media than vacuum; in those that are not named, `sampler`.
  std::vector<std::pair<MediumId, brdf::Sampler>> immersed = {};

  const brdf::Sampler& in(MediumId medium) const {
    for (const auto& [front, wet] : immersed) {
      if (front == medium) return wet;
    }
    return sampler;
  }
};

using Material = std::variant<Lambertian, Conductor, Interface, Modelled>;

}  // namespace umov::trace
