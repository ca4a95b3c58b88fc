// How each model is drawn: its parts, each with a proposal.
#pragma once

#include <span>
#include <variant>
#include <vector>

#include "host/brdf/sampler.hpp"
#include "host/brdf/sampling_lobes.hpp"
#include "host/brdf/sampling_table.hpp"

namespace umov::brdf {

using Lobe = std::variant<CosineLobe, UniformLobe, GaussianFacetLobe, GgxFacetLobe, GrooveLobe,
                          CosinePowerLobe, ChordLobe, TableLobe>;

/// A proposal and the light it stands for, of all wavelengths together.
struct SampledPart {
  Lobe lobe;
  TableLobe::Brdf brdf;  ///< m00, mean over the wavelengths; only for preparation
};

/// The parts of `model`. Those without light at any wavelength are left out.
std::vector<SampledPart> sampled_parts(const Model& model,
                                       std::span<const SpectralValues> spectrum);

}  // namespace umov::brdf
