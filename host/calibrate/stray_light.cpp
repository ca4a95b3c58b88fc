#include "host/calibrate/stray_light.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "host/optics/angles.hpp"

namespace umov::calibrate {

namespace {

/// Widths of the forward part that are tried. Between neighbours the shape hardly differs.
constexpr std::array<double, 7> widths_deg = {4, 6, 8, 10, 14, 20, 30};

double forward_angle_deg(double theta_r_deg, double phi_r_deg) {
  const double cosine =
      std::sin(optics::radians(theta_r_deg)) * std::cos(optics::radians(phi_r_deg));
  return optics::degrees(std::acos(std::clamp(cosine, -1.0, 1.0)));
}

double share_of(double angle_deg, double width_deg) {
  return std::exp(-angle_deg * angle_deg / (2.0 * width_deg * width_deg));
}

struct Row {
  double signal_v, variance;
  double volts_per_level;  ///< C a ΔΩ monitor
  double forward_angle_deg;
  Eigen::Index wavelength;
  std::size_t dark;  ///< number of the dark level
};

/// A dark level of one scan and range: what is known of it, in V.
struct DarkPrior {
  double u;
  bool measured;
};

struct Material {
  std::vector<Row> rows;
  std::vector<DarkPrior> darks;
  double range_u = 0;  ///< of the amplifier ranges that were used, the largest
};

bool taken_without_sample(const formats::ScanTable& scan, const ScanRows& set_up, std::size_t i) {
  if (set_up.block[i] < 0 || scan.shutter_open[i] == 0 || scan.saturated[i] != 0) return false;
  const formats::Block& block = scan.blocks[static_cast<std::size_t>(set_up.block[i])];
  if (block.name != "no_sample") return false;
  // Another filter or aperture on top would be another instrument.
  return std::all_of(block.settings.begin(), block.settings.end(), [](const auto& setting) {
    return setting.first == "sample_removed" || setting.first == "optical_density";
  });
}

Material gather(std::span<const RangeInput> inputs, std::span<const StrayGain> gains,
                double solid_angle_sr, const RangeErrors& ranges) {
  Material material;
  for (const RangeInput& input : inputs) {
    const formats::ScanTable& scan = *input.scan;
    std::map<double, std::size_t> dark_of;
    for (std::size_t i = 0; i < scan.size(); ++i) {
      if (!taken_without_sample(scan, *input.set_up, i) || !(scan.monitor_v[i] > 0)) continue;
      const auto known = std::find_if(gains.begin(), gains.end(), [&](const StrayGain& g) {
        return std::abs(g.wavelength_nm - scan.wavelength_nm[i]) < 0.5;
      });
      if (known == gains.end()) continue;
      const double gain = scan.gain[i];
      const DarkLevel dark = input.dark->at(gain);
      const auto [place, fresh] = dark_of.emplace(gain, material.darks.size());
      if (fresh) material.darks.push_back({dark.x_u, input.dark->measured(gain)});
      Row row;
      const RangeError range = ranges.at(gain);
      material.range_u = std::max(material.range_u, range.u);
      row.signal_v = ((scan.x_v[i] - dark.x_v) * std::cos(known->phase_rad) +
                      (scan.y_v[i] - dark.y_v) * std::sin(known->phase_rad)) /
                     (1.0 + range.error);
      row.variance = input.noise->variance_normalised(scan.wavelength_nm[i], gain, scan.x_v[i]);
      row.volts_per_level = known->gain_constant_v * stray_share(scan.analyzer_deg[i]) *
                            solid_angle_sr * scan.monitor_v[i];
      row.forward_angle_deg = forward_angle_deg(scan.theta_r_deg[i], scan.phi_r_deg[i]);
      row.wavelength = static_cast<Eigen::Index>(known - gains.begin());
      row.dark = place->second;
      material.rows.push_back(row);
    }
  }
  return material;
}

struct Fit {
  Eigen::VectorXd parameters;  ///< L, F, then the errors of the dark levels
  Eigen::MatrixXd covariance;
  double objective = std::numeric_limits<double>::infinity();  ///< chi2 with the priors' share
  double chi2 = 0;
};

Fit fit_width(const Material& material, Eigen::Index wavelengths, double width_deg,
              double tolerance) {
  const Eigen::Index stray = 2 * wavelengths;
  const auto size = stray + static_cast<Eigen::Index>(material.darks.size());
  // In units of the priors' standard deviations, so that the matrix is well scaled.
  Eigen::VectorXd unit(size);
  unit.head(stray).setConstant(tolerance);
  for (std::size_t k = 0; k < material.darks.size(); ++k)
    unit(stray + static_cast<Eigen::Index>(k)) = std::max(material.darks[k].u, 1e-15);
  Eigen::MatrixXd normal = Eigen::MatrixXd::Identity(size, size);
  Eigen::VectorXd right = Eigen::VectorXd::Zero(size);
  const auto levers = [&](const Row& row) {
    const double share = share_of(row.forward_angle_deg, width_deg);
    const Eigen::Index f = wavelengths + row.wavelength,
                       d = stray + static_cast<Eigen::Index>(row.dark);
    return std::array<std::pair<Eigen::Index, double>, 3>{
        {{row.wavelength, row.volts_per_level * unit(row.wavelength)},
         {f, row.volts_per_level * share * unit(f)},
         {d, unit(d)}}};
  };
  for (const Row& row : material.rows) {
    const auto own = levers(row);
    for (const auto& [a, lever_a] : own) {
      right(a) += lever_a * row.signal_v / row.variance;
      for (const auto& [b, lever_b] : own) normal(a, b) += lever_a * lever_b / row.variance;
    }
  }
  const Eigen::LDLT<Eigen::MatrixXd> solver(normal);
  const Eigen::VectorXd scaled = solver.solve(right);
  Fit fit;
  for (const Row& row : material.rows) {
    double expected = 0;
    for (const auto& [a, lever] : levers(row)) expected += lever * scaled(a);
    fit.chi2 += (row.signal_v - expected) * (row.signal_v - expected) / row.variance;
  }
  fit.objective = fit.chi2 + scaled.squaredNorm();
  fit.parameters = unit.cwiseProduct(scaled);
  fit.covariance =
      unit.asDiagonal() * solver.solve(Eigen::MatrixXd::Identity(size, size)) * unit.asDiagonal();
  return fit;
}

/// Says where a dark level that nobody measured stands for stray light or the reverse.
void report_ambiguity(const Material& material, const Fit& fit, std::span<const StrayGain> gains,
                      std::vector<std::string>& notes) {
  const auto stray = static_cast<Eigen::Index>(2 * gains.size());
  for (std::size_t w = 0; w < gains.size(); ++w)
    for (std::size_t k = 0; k < material.darks.size(); ++k) {
      if (material.darks[k].measured) continue;
      const auto a = static_cast<Eigen::Index>(w), b = stray + static_cast<Eigen::Index>(k);
      const double correlation =
          fit.covariance(a, b) / std::sqrt(fit.covariance(a, a) * fit.covariance(b, b));
      if (correlation < -0.8) {
        notes.push_back(fmt::format(
            "{:g} nm: stray light and the dark signal cannot be told apart (correlation {:.2f}): "
            "no record of that amplifier range has the shutter closed; measure a block `shutter`, "
            "or the block `no_sample` at several powers",
            gains[w].wavelength_nm, correlation));
        break;
      }
    }
}

}  // namespace

double stray_share(double analyzer_deg) {
  return formats::is_open(analyzer_deg) ? 1.0 : 0.5;
}

Eigen::Index StrayLight::number(double wavelength) const {
  for (std::size_t w = 0; w < wavelength_nm.size(); ++w)
    if (std::abs(wavelength_nm[w] - wavelength) < 0.5) return static_cast<Eigen::Index>(w);
  return -1;
}

double StrayLight::forward_share(double theta_r_deg, double phi_r_deg) const {
  return share_of(forward_angle_deg(theta_r_deg, phi_r_deg), forward_width_deg);
}

double StrayLight::level(double wavelength, double theta_r_deg, double phi_r_deg) const {
  const Eigen::Index w = number(wavelength);
  if (w < 0) return 0;
  const auto at = static_cast<std::size_t>(w);
  return even_per_sr[at] + forward_per_sr[at] * forward_share(theta_r_deg, phi_r_deg);
}

double StrayLight::level_u(double wavelength, double theta_r_deg, double phi_r_deg) const {
  const Eigen::Index w = number(wavelength);
  if (w < 0) return 0;
  const Eigen::Index f = w + static_cast<Eigen::Index>(wavelength_nm.size());
  const double share = forward_share(theta_r_deg, phi_r_deg);
  return std::sqrt(covariance(w, w) + 2 * share * covariance(w, f) +
                   share * share * covariance(f, f));
}

Eigen::MatrixXd StrayLight::shifts() const {
  if (covariance.size() == 0) return covariance;
  return Eigen::LLT<Eigen::MatrixXd>(covariance).matrixL();
}

double StrayLight::level_shift(const Eigen::VectorXd& column, double wavelength, double theta_r_deg,
                               double phi_r_deg) const {
  const Eigen::Index w = number(wavelength);
  if (w < 0) return 0;
  return column(w) + column(w + static_cast<Eigen::Index>(wavelength_nm.size())) *
                         forward_share(theta_r_deg, phi_r_deg);
}

StrayLight find_stray_light(std::span<const RangeInput> inputs, std::span<const StrayGain> gains,
                            double solid_angle_sr, const RangeErrors& ranges,
                            const StrayOptions& options, std::vector<std::string>& notes) {
  StrayLight result;
  if (!(options.tolerance_per_sr > 0)) return result;
  const auto count = static_cast<Eigen::Index>(gains.size());
  const Material material = gather(inputs, gains, solid_angle_sr, ranges);
  Fit best = fit_width(material, count, result.forward_width_deg, options.tolerance_per_sr);
  for (const double width : widths_deg) {
    Fit fit = fit_width(material, count, width, options.tolerance_per_sr);
    if (fit.objective < best.objective - 1e-9) {
      result.forward_width_deg = width;
      best = std::move(fit);
    }
  }
  result.records = material.rows.size();
  result.chi2 = best.chi2;
  result.dof =
      std::max(0.0, static_cast<double>(material.rows.size()) - 2.0 * static_cast<double>(count));
  // Scatter beyond the noise counts as noise, as everywhere.
  const double widening = result.dof > 0 ? std::max(1.0, result.chi2 / result.dof) : 1.0;
  result.covariance = widening * best.covariance.topLeftCorner(2 * count, 2 * count);
  const Eigen::VectorXd scale = material.range_u * best.parameters.head(2 * count);
  result.covariance += scale * scale.transpose();
  std::string missing;
  for (std::size_t w = 0; w < gains.size(); ++w) {
    const auto at = static_cast<Eigen::Index>(w);
    result.wavelength_nm.push_back(gains[w].wavelength_nm);
    result.even_per_sr.push_back(best.parameters(at));
    result.forward_per_sr.push_back(best.parameters(count + at));
    const bool seen = std::any_of(material.rows.begin(), material.rows.end(),
                                  [at](const Row& row) { return row.wavelength == at; });
    result.measured.push_back(seen ? 1 : 0);
    if (!seen)
      missing += fmt::format("{}{:g}", missing.empty() ? "" : ", ", gains[w].wavelength_nm);
  }
  if (!missing.empty())
    notes.push_back(fmt::format(
        "stray light was not measured at {} nm: 0 +- {:.2g} /sr (as BRDF cos) is assumed (a block "
        "`no_sample` measures it)",
        missing, options.tolerance_per_sr));
  report_ambiguity(material, best, gains, notes);
  return result;
}

}  // namespace umov::calibrate
