#include "tests/unit/report/synthetic.hpp"

#include <array>
#include <cmath>
#include <random>
#include <vector>

#include "host/brdf/model.hpp"
#include "host/calibrate/calibration.hpp"
#include "host/calibrate/dolp.hpp"
#include "host/formats/scan_table.hpp"
#include "host/report/fitted_model.hpp"

namespace umov::report::synthetic {

namespace {

constexpr double p_axis = 0, s_axis = 90;
constexpr double solid_angle_sr = 1e-4;

formats::FitParameter shared(const std::string& name, const std::string& unit, double value,
                             double half) {
  return {
      name, unit, true, half == 0, {{value, value - half, value + half, half / 1.96, "", true}}};
}

formats::FitParameter spectral(const std::string& name, std::array<double, 3> values, double half) {
  formats::FitParameter out{name, "1", false, false, {}};
  for (const double v : values)
    out.estimates.push_back({v, v - half, v + half, half / 1.96, "", true});
  return out;
}

formats::FitResult red_gloss_fit() {
  formats::FitResult fit;
  fit.model = "li-torrance";
  fit.wavelengths_nm = {532, 633, 814};
  fit.parameters = {shared("n", "1", 1.5, 0.004),
                    spectral("kappa", {0.001, 0.001, 0.001}, 0.02),
                    shared("sigma_um", "um", 1.2, 0.3),
                    shared("tau_um", "um", 34, 8),
                    spectral("k_dd", {1.0, 1.0, 1.0}, 0.012),
                    spectral("k_udf", {0.0162, 0.003, 0.0001}, 0.0021),
                    spectral("k_uds", {0.0028, 0.486, 0.4914}, 0.0024),
                    spectral("k_fs", {0.004, 0.012, 0.011}, 0.0009),
                    shared("fs_width_deg", "deg", 14, 1.1),
                    shared("fs_polarization", "1", 0.45, 0.06)};
  fit.parameters[1].estimates[0].at_bound = "lower";
  fit.parameters[2].estimates[0].identifiable = false;
  fit.parameters[3].estimates[0].identifiable = false;
  fit.derived = {shared("slope_2sigma_over_tau", "1", 0.0706, 0.0004),
                 spectral("k_udf+k_uds", {0.019, 0.489, 0.4915}, 0.0012)};
  fit.at_bound = {"kappa 532 nm"};
  fit.correlations = {{"sigma_um", "tau_um", 0.998, {}, {}}};
  fit.identifiability = {
      "sigma_um and tau_um are known only through their ratio, the slope 2σ/τ (correlation 0.998): "
      "at "
      "this roughness the lobe has no other memory of them."};
  for (const double theta : {0.0, 30.0, 60.0}) {
    const std::array<double, 3> values{0.0645 + theta * 2e-4, 0.5301 + theta * 2e-4,
                                       0.5322 + theta * 2e-4};
    for (std::size_t w = 0; w < 3; ++w)
      fit.dhr.push_back(
          {fit.wavelengths_nm[w], theta, values[w], values[w] - 0.0031, values[w] + 0.0031});
  }
  fit.factors = {{"gain 532 nm", 0.4, 0.3}, {"gain 633 nm", -0.7, 0.3}, {"gain 814 nm", 0.1, 0.3}};
  fit.covariance.names = {"n", "sigma_um", "tau_um", "k_udf 532 nm", "k_uds 532 nm"};
  const std::size_t n = fit.covariance.names.size();
  fit.covariance.values.assign(n * n, 0);
  for (std::size_t i = 0; i < n; ++i) fit.covariance.values[i * n + i] = 4;
  fit.covariance.values[1 * n + 2] = fit.covariance.values[2 * n + 1] = 4 * 0.998;
  fit.covariance.values[3 * n + 4] = fit.covariance.values[4 * n + 3] = -4 * 0.93;
  fit.objective = 6012;
  fit.dof = 5900;
  fit.chi2 = 1.02 * 5900;
  fit.robust_scale_sigma = 4;
  fit.iterations = 87;
  fit.starts = 12;
  fit.starts_agreeing = 9;
  fit.converged = true;
  fit.program = "umov 0.1.0";
  fit.command = "umov invert brdf.h5 --model li-torrance -o fit.json";
  return fit;
}

std::vector<double> exit_angles(double theta_i) {
  std::vector<double> out;
  for (int x = -80; x <= 80; x += 2) out.push_back(x);
  for (double off = -4.5; off <= 4.5; off += 1) out.push_back(theta_i + off);
  return out;
}

}  // namespace

Sample red_gloss(const std::string& name) {
  Sample sample;
  sample.name = name;
  sample.fit = FitInput{{"fit.json", std::string(64, 'f')}, red_gloss_fit()};
  formats::FitResult& fit = sample.fit->fit;
  const FittedModel model(fit, solid_angle_sr);
  BrdfInput brdf{{"brdf.h5", std::string(64, 'b')}, {}};
  formats::BrdfTable& table = brdf.file.table;
  table.keys = {{"sample", name}, {"device", "emulator"}, {"solid_angle_sr", "1e-4"}};
  for (std::size_t w = 0; w < 3; ++w)
    table.factors.push_back(
        {"gain " + std::to_string(static_cast<int>(fit.wavelengths_nm[w])) + " nm", {}});
  std::mt19937_64 random(20);
  std::normal_distribution<double> normal;
  const double open = formats::open_axis;
  const std::array<std::array<double, 2>, 6> states{{{p_axis, p_axis},
                                                     {p_axis, s_axis},
                                                     {p_axis, open},
                                                     {s_axis, s_axis},
                                                     {s_axis, p_axis},
                                                     {s_axis, open}}};
  auto& p = table.points;
  for (const double theta_i : {0.0, 30.0, 45.0, 60.0}) {
    for (const auto& state : states) {
      for (const double theta_r : exit_angles(theta_i)) {
        for (std::size_t w = 0; w < 3; ++w) {
          const double f = contracted(model.mueller(w, theta_i, theta_r, 0), state[0], state[1]);
          const double u = 0.008 * f + 2e-5;
          p.theta_i_deg.push_back(theta_i);
          p.theta_r_deg.push_back(theta_r);
          p.phi_r_deg.push_back(0);
          p.wavelength_nm.push_back(fit.wavelengths_nm[w]);
          p.polarizer_deg.push_back(state[0]);
          p.analyzer_deg.push_back(state[1]);
          const double gain = 1 + 0.01 * fit.factors[w].value;
          p.brdf_per_sr.push_back(gain * f + u * normal(random));
          p.brdf_u.push_back(u);
          p.used.push_back(std::abs(theta_r + theta_i) < 3 ? 0 : 1);
          for (std::size_t k = 0; k < 3; ++k)
            table.factors[k].per_point.push_back(k == w ? 0.01 * f : 0.0);
        }
      }
    }
  }
  calibrate::add_dolp(table);
  for (std::size_t w = 0; w < 3; ++w) {
    table.dhr.wavelength_nm.push_back(fit.wavelengths_nm[w]);
    table.dhr.theta_i_deg.push_back(0);
    table.dhr.dhr.push_back(fit.dhr[w].value + 0.001);
    table.dhr.dhr_u.push_back(0.004);
  }
  brdf.file.provenance = {"umov 0.1.0",
                          "umov reduce scan.h5 --calibration cal.h5 -o brdf.h5",
                          "2026-01-02T03:04:05Z",
                          "emulator",
                          "",
                          "sample",
                          "",
                          ""};
  brdf.file.content_sha256 = formats::content_sha256(table);
  fit.data_sha256 = brdf.file.content_sha256;
  fit.data_file = "brdf.h5";
  fit.points = p.size();
  sample.brdf = std::move(brdf);
  return sample;
}

Sample diffuse_standard() {
  Sample sample;
  sample.name = "diffuse standard";
  formats::FitResult fit;
  fit.model = "nef";
  fit.wavelengths_nm = {532, 633};
  fit.parameters = {
      {"rho_d1",
       "1/sr",
       false,
       false,
       {{0.30, 0.298, 0.302, 0.001, "", true}, {0.298, 0.296, 0.300, 0.001, "", true}}},
      {"rho_d2",
       "1/sr",
       false,
       false,
       {{0.004, 0.0038, 0.0042, 1e-4, "", true}, {0.004, 0.0038, 0.0042, 1e-4, "", true}}}};
  fit.points = 200;
  fit.dof = 196;
  fit.chi2 = 250;
  fit.converged = true;
  fit.covariance = {{"rho_d1 532 nm", "rho_d2 532 nm"}, {1, -0.4, -0.4, 1}};
  const FittedModel model(fit, 0);
  BrdfInput brdf{{"standard.h5", std::string(64, 's')}, {}};
  formats::BrdfTable& table = brdf.file.table;
  table.keys = {{"sample", sample.name}};
  std::mt19937_64 random(21);
  std::normal_distribution<double> normal;
  auto& p = table.points;
  for (std::size_t w = 0; w < 2; ++w) {
    for (const double theta_i : {0.0, 45.0, 75.0}) {
      for (double theta_r = 5; theta_r < 85; theta_r += 10) {
        for (int phi = -180; phi < 180; phi += 20) {
          const double f = model.mueller(w, theta_i, theta_r, phi)[0];
          const bool outside = phi != 0 && phi != -180;
          p.theta_i_deg.push_back(theta_i);
          p.theta_r_deg.push_back(theta_r);
          p.phi_r_deg.push_back(phi);
          p.wavelength_nm.push_back(fit.wavelengths_nm[w]);
          p.polarizer_deg.push_back(formats::open_axis);
          p.analyzer_deg.push_back(formats::open_axis);
          p.brdf_per_sr.push_back(f * (outside ? 1.02 : 1.0) * (1 + 0.003 * normal(random)));
          p.brdf_u.push_back(0.003 * f);
          p.used.push_back(1);
        }
      }
    }
  }
  brdf.file.content_sha256 = formats::content_sha256(table);
  fit.data_sha256 = brdf.file.content_sha256;
  sample.brdf = std::move(brdf);
  sample.fit = FitInput{{"standard.json", ""}, std::move(fit)};
  return sample;
}

ScanInput raw_scan() {
  const Sample sample = red_gloss();
  const auto& p = sample.brdf->file.table.points;
  ScanInput scan{{"scan.h5", std::string(64, 'c')}, {}};
  formats::ScanTable& t = scan.file.table;
  t.set_key("sample", "red gloss");
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double x =
        600 * p.brdf_per_sr[i] * solid_angle_sr * std::cos(p.theta_r_deg[i] * 0.01745329);
    const double range = std::abs(x) > 0.3     ? 1
                         : std::abs(x) > 0.03  ? 10
                         : std::abs(x) > 0.003 ? 100
                                               : 1000;
    t.index.push_back(static_cast<std::int64_t>(i));
    t.time_s.push_back(0.12 * static_cast<double>(i));
    t.theta_i_deg.push_back(p.theta_i_deg[i]);
    t.theta_r_deg.push_back(p.theta_r_deg[i]);
    t.phi_r_deg.push_back(0);
    t.wavelength_nm.push_back(p.wavelength_nm[i]);
    t.polarizer_deg.push_back(p.polarizer_deg[i]);
    t.analyzer_deg.push_back(p.analyzer_deg[i]);
    t.direction.push_back(1);
    t.gain.push_back(range);
    t.x_v.push_back(x);
    t.y_v.push_back(0);
    t.x_se_v.push_back(1e-6);
    t.y_se_v.push_back(1e-6);
    t.monitor_v.push_back(1 + 0.01 * std::sin(1e-3 * static_cast<double>(i)));
    t.saturated.push_back(i % 911 == 5 ? 1 : 0);
    t.shutter_open.push_back(1);
  }
  t.blocks.push_back({"flip", 10, 20, {{"sample_azimuth_deg", "180"}}});
  return scan;
}

CalibrationInput calibration() {
  auto c = std::make_shared<calibrate::Calibration>();
  for (const double nm : {532.0, 633.0, 814.0}) {
    calibrate::WavelengthCalibration w;
    w.wavelength_nm = nm;
    w.gain_constant_v = 610 + 0.02 * nm;
    w.instrument_function.degrees = {2, 4};
    w.instrument_function.coefficients = {0.004, 0.0102 - 1e-5 * nm};
    w.covariance = Eigen::MatrixXd::Zero(3, 3);
    w.covariance.diagonal() << 1e-6, 4e-6, 4e-6;
    w.reference_relative_u = 0.005;
    w.records = 480;
    w.chi2 = 470;
    w.dof = 475;
    c->wavelengths.push_back(std::move(w));
    c->checks.push_back({"white tile .99", nm, 0.99, 0.9902, 0.0012, true});
  }
  c->notes = {"No mirror scan was given: the axes of the polarisers are taken as stated."};
  return {{"cal.h5", std::string(64, 'd')}, std::move(c)};
}

Sample nearly_nothing() {
  Sample sample;
  sample.name = "one point";
  sample.brdf = BrdfInput{{"one.h5", ""}, {}};
  auto& p = sample.brdf->file.table.points;
  for (auto* column : {&p.theta_i_deg, &p.theta_r_deg, &p.phi_r_deg}) column->push_back(0);
  p.wavelength_nm.push_back(632.8);
  p.polarizer_deg.push_back(45);
  p.analyzer_deg.push_back(formats::open_axis);
  p.brdf_per_sr.push_back(-1e-5);
  p.brdf_u.push_back(1e-5);
  p.used.push_back(1);
  sample.scans.push_back({{"empty.h5", ""}, {}});
  return sample;
}

}  // namespace umov::report::synthetic
