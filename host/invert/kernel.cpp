#include "host/invert/kernel.hpp"

#include <algorithm>

#include "host/brdf/evaluate.hpp"
#include "host/invert/kernel_pass.hpp"
#include "host/optics/mueller.hpp"

namespace umov::invert {

void evaluate_channels(const brdf::Model& model, std::span<const double> parameters,
                       std::span<const int> active, double wavelength_um, const View& view,
                       std::span<const Channel> channels, std::span<double> f,
                       std::span<double> derivatives) {
  if (derivatives.empty() || active.empty()) {
    optics::Mueller<double> mueller =
        brdf::evaluate(model, parameters, wavelength_um, view.geometry);
    if (view.mirror_per_sr > 0) {
      mueller += brdf::mirror_reflectance(model, parameters, wavelength_um, view.geometry.theta_i) *
                 view.mirror_per_sr;
    }
    for (std::size_t c = 0; c < channels.size(); ++c) {
      double sum = 0;
      for (std::size_t i = 0; i < 16; ++i) {
        sum += channels[c].weight[i] *
               optics::element(mueller, static_cast<int>(i / 4), static_cast<int>(i % 4));
      }
      f[c] = sum;
    }
    return;
  }
  // Models with more free parameters than the widest pass carries take several passes.
  for (std::size_t first = 0; first < active.size(); first += 12) {
    const auto part = active.subspan(first, std::min<std::size_t>(12, active.size() - first));
    double* out = derivatives.data() + first;
    if (part.size() <= 6) {
      dual_pass<6>(model, parameters, part, wavelength_um, view, channels, f, out, active.size());
    } else {
      dual_pass<12>(model, parameters, part, wavelength_um, view, channels, f, out, active.size());
    }
  }
}

}  // namespace umov::invert
