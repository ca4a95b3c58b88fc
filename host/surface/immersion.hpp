// A model of the library for faces that stand in a liquid.
#pragma once

#include "host/brdf/sampler.hpp"
#include "host/trace/material.hpp"

namespace umov::surface {

/// The model of `dry`, seen from `liquid`: what its formula takes from the medium in front of the
/// face are an index relative to that medium and the wavelength in it. So it is for microfacet,
/// ggx, he-torrance, rayleigh-rice, subsurface and single-scatter. lambertian and nef are of a body
/// whose reflectance is taken as the same. `liquid` has the wavelengths of `dry`.
///
/// Throws umov::Error for models that are fits to what is seen in air (phong, ward, beard-maxwell,
/// li-torrance, tabulated), and for bodies of a smaller index than the liquid's that a formula does
/// not take.
brdf::Sampler immersed(const brdf::Sampler& dry, const trace::Medium& liquid);

}  // namespace umov::surface
