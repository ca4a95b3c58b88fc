// Measurements made up from a model of the library: known truth, known noise, known gain errors.
#pragma once

#include <cmath>
#include <random>
#include <string>
#include <utility>
#include <vector>

#include "host/brdf/evaluate.hpp"
#include "host/brdf/model.hpp"
#include "host/formats/brdf_table.hpp"
#include "host/formats/scan_table.hpp"
#include "host/invert/invert.hpp"
#include "host/invert/observations.hpp"
#include "host/optics/angles.hpp"

namespace umov::invert::test {

struct Scene {
  std::string model = "li-torrance";
  std::vector<double> wavelengths_nm{532, 633, 814};
  /// [wavelength][parameter in the model's order]
  std::vector<std::vector<double>> truth;
  std::vector<double> theta_i_deg{30, 50};
  double theta_r_from = -75, theta_r_to = 75, theta_r_step = 5;
  std::vector<std::pair<double, double>> states{
      {0, 0}, {0, 90}, {90, 90}, {formats::open_axis, formats::open_axis}};
  double relative_noise = 0.005;
  double floor_per_sr = 2e-4;  ///< noise of a dark point
  double gain_sigma = 0;       ///< 1 sigma of a gain error for each wavelength; 0: no factors
  double outlier_share = 0;    ///< of points, thrown off by 20 … 60 sigma
};

/// Red gloss paint as li-torrance: absorbing at 532 nm, red diffuse light above.
inline Scene red_gloss() {
  Scene scene;
  //        n    kappa sigma tau  k_dd k_udf  k_uds  k_fs  width pol
  scene.truth = {{1.5, 0.15, 0.8, 12, 0.90, 0.020, 0.0028, 0.004, 14, 0.6},
                 {1.5, 0.10, 0.8, 12, 0.95, 0.020, 0.4600, 0.010, 14, 0.6},
                 {1.5, 0.10, 0.8, 12, 1.00, 0.020, 0.4714, 0.015, 14, 0.6}};
  return scene;
}

/// Semi-gloss black as microfacet+nef: n, kappa, slope_rms, bias, rho_d1, rho_d2.
inline Scene black_paint() {
  Scene scene;
  scene.model = "microfacet+nef";
  scene.wavelengths_nm = {532, 814};
  scene.truth = {{1.5, 0.30, 0.12, 1, 0.010, 0.0040}, {1.5, 0.20, 0.12, 1, 0.014, 0.0050}};
  return scene;
}

/// A fit of a scene's model without what a test of parameters does not need.
inline Options quick(const Scene& scene, int starts = 3) {
  Options options;
  options.model = scene.model;
  options.starts = starts;
  options.dhr = options.held_out = false;
  return options;
}

struct Made {
  formats::BrdfTable table;
  std::vector<double> clean;  ///< without noise and gain error
  std::vector<double> gains;  ///< drawn gain errors in standard deviations, by wavelength
};

inline Made make(const Scene& scene, std::uint64_t seed, double noise_scale = 1) {
  const brdf::Model model = brdf::Model::by_name(scene.model);
  std::mt19937_64 engine(seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  Made made;
  auto& p = made.table.points;
  for (std::size_t w = 0; w < scene.wavelengths_nm.size(); ++w) {
    made.gains.push_back(scene.gain_sigma > 0 ? normal(engine) : 0.0);
    for (const double theta_i : scene.theta_i_deg) {
      for (double theta_r = scene.theta_r_from; theta_r <= scene.theta_r_to + 1e-9;
           theta_r += scene.theta_r_step) {
        for (const auto& [polarizer, analyzer] : scene.states) {
          p.theta_i_deg.push_back(theta_i);
          p.theta_r_deg.push_back(theta_r);
          p.phi_r_deg.push_back(0);
          p.wavelength_nm.push_back(scene.wavelengths_nm[w]);
          p.polarizer_deg.push_back(polarizer);
          p.analyzer_deg.push_back(analyzer);
          double f = 0;
          const Channel channel = channel_of(polarizer, analyzer);
          evaluate_channels(model, scene.truth[w], {}, scene.wavelengths_nm[w] * 1e-3,
                            {{optics::radians(theta_i), optics::radians(theta_r), 0.0}},
                            std::span(&channel, 1), std::span(&f, 1), {});
          made.clean.push_back(f);
          const double u = std::hypot(scene.floor_per_sr, scene.relative_noise * f);
          double value =
              f * (1 + scene.gain_sigma * made.gains[w]) + noise_scale * u * normal(engine);
          if (scene.outlier_share > 0 && uniform(engine) < scene.outlier_share) {
            value += (uniform(engine) < 0.5 ? -1 : 1) * u * (20 + 40 * uniform(engine));
          }
          p.brdf_per_sr.push_back(value);
          p.brdf_u.push_back(u);
          p.used.push_back(1);
        }
      }
    }
  }
  if (scene.gain_sigma > 0) {
    for (std::size_t w = 0; w < scene.wavelengths_nm.size(); ++w) {
      formats::BrdfTable::Factor factor;
      factor.name = "gain " + std::to_string(static_cast<int>(scene.wavelengths_nm[w])) + " nm";
      for (std::size_t i = 0; i < p.size(); ++i) {
        factor.per_point.push_back(p.wavelength_nm[i] == scene.wavelengths_nm[w]
                                       ? scene.gain_sigma * p.brdf_per_sr[i]
                                       : 0.0);
      }
      made.table.factors.push_back(std::move(factor));
    }
  }
  return made;
}

}  // namespace umov::invert::test
