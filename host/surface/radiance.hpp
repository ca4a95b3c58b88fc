// Light of a view of a surface, reflected and emitted, from one run launched the way of the view.
#pragma once

#include <vector>

#include "host/surface/scene_file.hpp"
#include "host/trace/simulation.hpp"

namespace umov::surface {

/// Planck's law: spectral radiance [W/m²/sr/µm] of a black body; 0 at 0 K.
double black_body(double wavelength_um, double kelvin);

/// On a face that looks at the sun, above the atmosphere [W/m²/µm]: a black body of 5772 K
/// in 6.794e-5 sr.
double sun_irradiance(double wavelength_um);

/// All [W/m²/sr/µm]. `stokes_1` is Q of the sum (> 0: s).
struct ViewedRadiance {
  double wavelength_um;
  double emissivity, emissivity_u;
  double emitted, emitted_u;
  double reflected_sky, reflected_sky_u;
  double reflected_sun, reflected_sun_u;
  double total, total_u;
  double stokes_1;
};

/// What a detector at θ = theta_i, φ = 0 of `result` sees of the surface. Light that is launched
/// from the detector ends in the sky, in the sun or in a material; with reciprocity and Kirchhoff's
/// law each end sends back as it takes: L = Σ a_j B(T_j) + DHR · B(T_sky) + f(view → sun) E cos θ.
/// At one temperature all round L = B(T). `result` must know absorptances.
std::vector<ViewedRadiance> viewed_radiance(const trace::Result& result, const trace::Scene& scene,
                                            const Emission& emission);

}  // namespace umov::surface
