// One pass of the kernel with a fixed number of derivatives. Instantiated in one source file for
// each number: the model templates are the expensive part of this folder's build.
#pragma once

#include <span>

#include "host/brdf/model.hpp"
#include "host/invert/kernel.hpp"

namespace umov::invert {

/// Derivatives by at most `Size` parameters `active`; `derivatives` has `stride` entries a channel,
/// of which active.size() are written.
template <int Size>
void dual_pass(const brdf::Model& model, std::span<const double> parameters,
               std::span<const int> active, double wavelength_um, const View& view,
               std::span<const Channel> channels, std::span<double> f, double* derivatives,
               std::size_t stride);

extern template void dual_pass<6>(const brdf::Model&, std::span<const double>, std::span<const int>,
                                  double, const View&, std::span<const Channel>, std::span<double>,
                                  double*, std::size_t);
extern template void dual_pass<12>(const brdf::Model&, std::span<const double>,
                                   std::span<const int>, double, const View&,
                                   std::span<const Channel>, std::span<double>, double*,
                                   std::size_t);

}  // namespace umov::invert
