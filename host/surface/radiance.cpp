#include "host/surface/radiance.hpp"

#include <cmath>

#include "host/optics/angles.hpp"
#include "host/optics/frames.hpp"
#include "host/optics/mueller.hpp"

namespace umov::surface {

double black_body(double wavelength_um, double kelvin) {
  if (!(kelvin > 0.0)) return 0.0;
  // 2hc² and hc/k, for wavelengths in µm (CODATA 2018, exact).
  constexpr double first = 1.191042972e8;  // W µm⁴/m²/sr
  constexpr double second = 14387.76877;   // µm K
  return first / (std::pow(wavelength_um, 5) * std::expm1(second / (wavelength_um * kelvin)));
}

double sun_irradiance(double wavelength_um) {
  constexpr double temperature_k = 5772.0;
  constexpr double solid_angle_sr = 6.794e-5;
  return solid_angle_sr * black_body(wavelength_um, temperature_k);
}

std::vector<ViewedRadiance> viewed_radiance(const trace::Result& result, const trace::Scene& scene,
                                            const Emission& emission) {
  std::vector<ViewedRadiance> bands;
  const double sun_theta = optics::radians(emission.sun_theta_deg);
  const std::size_t sun_cell = result.hemisphere().find(
      optics::exit_direction(sun_theta, optics::radians(emission.sun_phi_deg)));
  for (std::size_t w = 0; w < scene.wavelengths_um.size(); ++w) {
    ViewedRadiance band{};
    band.wavelength_um = scene.wavelengths_um[w];
    double variance = 0.0;
    double emissivity_variance = 0.0;
    for (std::size_t owner = 0; owner < emission.temperature_k.size(); ++owner) {
      const auto a = result.absorptance(owner, w);
      const double b = black_body(band.wavelength_um, emission.temperature_k[owner]);
      band.emissivity += a[0].mean;
      emissivity_variance += a[0].error * a[0].error;
      band.emitted += a[0].mean * b;
      band.stokes_1 += a[1].mean * b;
      variance += std::pow(a[0].error * b, 2);
    }
    band.emissivity_u = std::sqrt(emissivity_variance);
    band.emitted_u = std::sqrt(variance);
    const trace::MuellerEstimate all = result.hemispherical(w);
    const double sky = black_body(band.wavelength_um, emission.sky_k);
    band.reflected_sky = all.mean[0][0] * sky;
    band.reflected_sky_u = all.error[0][0] * sky;
    band.stokes_1 += optics::element(all.mean, 0, 1) * sky;
    if (!emission.sun.empty()) {
      // Launched from the view into the sun's cell: the transpose of what the sun sends to the
      // view.
      const trace::MuellerEstimate f = result.brdf(sun_cell, w);
      const double light = emission.sun[w] * std::cos(sun_theta);
      band.reflected_sun = f.mean[0][0] * light;
      band.reflected_sun_u = f.error[0][0] * light;
      band.stokes_1 += optics::element(f.mean, 0, 1) * light;
    }
    band.total = band.emitted + band.reflected_sky + band.reflected_sun;
    // What is not absorbed is reflected: their errors go against each other, so this is an upper
    // bound.
    band.total_u = band.emitted_u + band.reflected_sky_u + band.reflected_sun_u;
    bands.push_back(band);
  }
  return bands;
}

}  // namespace umov::surface
