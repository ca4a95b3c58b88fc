#include "host/surface/immersion.hpp"

#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "host/errors/error.hpp"
#include "host/trace/specular.hpp"

namespace umov::surface {
namespace {

enum class Front {
  none,     // nothing of the medium in front is in the formula
  index,    // n, and κ where there is one, are relative to it
  unknown,  // the formula is of faces in air
};

Front front_of(brdf::Kind kind) {
  switch (kind) {
    case brdf::Kind::lambertian:
    case brdf::Kind::nef:
      return Front::none;
    case brdf::Kind::microfacet:
    case brdf::Kind::ggx:
    case brdf::Kind::he_torrance:
    case brdf::Kind::rayleigh_rice:
    case brdf::Kind::subsurface:
    case brdf::Kind::single_scatter:
      return Front::index;
    case brdf::Kind::li_torrance:
    case brdf::Kind::beard_maxwell:
    case brdf::Kind::phong:
    case brdf::Kind::ward:
    case brdf::Kind::tabulated:
      return Front::unknown;
  }
  return Front::unknown;
}

// Of a part of a sum, without the part's number.
std::string_view plain_name(std::string_view parameter) {
  return parameter.substr(parameter.find_last_of('.') + 1);
}

// Positions of n and κ of a part.
struct IndexPlaces {
  std::size_t n;
  std::optional<std::size_t> kappa;
};

IndexPlaces index_places(const brdf::Model& model, const brdf::Component& part) {
  IndexPlaces places{part.first, {}};
  for (std::size_t i = part.first; i < part.first + part.count; ++i) {
    const std::string_view name = plain_name(model.parameters()[i].name);
    if (name == "n") places.n = i;
    if (name == "kappa") places.kappa = i;
  }
  return places;
}

}  // namespace

brdf::Sampler immersed(const brdf::Sampler& dry, const trace::Medium& liquid) {
  const brdf::Model& model = dry.model();
  std::vector<brdf::SpectralValues> spectrum = dry.spectrum();
  for (std::size_t w = 0; w < spectrum.size(); ++w) spectrum[w].wavelength_um /= liquid.n[w];
  for (const brdf::Component& part : model.components()) {
    const Front front = front_of(part.kind);
    if (front == Front::none) continue;
    if (front == Front::unknown) {
      throw Error("'" + model.name() + "' says how a face looks in air, and here it is wet",
                  "use microfacet, ggx, he-torrance, rayleigh-rice, subsurface, single-scatter, "
                  "lambertian, nef or fresnel where liquid lies on it");
    }
    const IndexPlaces at = index_places(model, part);
    for (std::size_t w = 0; w < spectrum.size(); ++w) {
      std::vector<double>& values = spectrum[w].values;
      const trace::RelativeIndex index = trace::relative_index(
          liquid.n[w], liquid.kappa[w], values[at.n], at.kappa ? values[*at.kappa] : 0.0);
      values[at.n] = index.n;
      if (at.kappa) values[*at.kappa] = index.kappa;
    }
  }
  return {model, std::move(spectrum)};
}

}  // namespace umov::surface
