#include "host/calibrate/ideal_states.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "host/calibrate/point_factors.hpp"
#include "host/optics/angles.hpp"

namespace umov::calibrate {

namespace {

using Elements = Eigen::Matrix<double, 9, 1>;  // m00 m01 m02 m10 … m22
using Design = Eigen::Matrix<double, Eigen::Dynamic, 9>;

/// Elements that are odd in the azimuth of an isotropic sample: zero in its plane of incidence.
constexpr std::array<int, 4> odd_elements = {2, 5, 6, 7};
constexpr int uu_element = 8;
/// One standard deviation of an element that may lie anywhere within ± m00.
const double free_element_u = 1.0 / std::sqrt(3.0);
constexpr double in_plane_deg = 0.05;

Elements outer(const Eigen::Vector3d& analyzer, const Eigen::Vector3d& source) {
  Elements row;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) row(3 * i + j) = analyzer(i) * source(j);
  return row;
}

/// Polarisation parameters as they are used with the δ of the gain's fit, and their doubt once δ is
/// given. Joint over the wavelengths that calibration and mirror scan share.
struct GivenBias {
  std::vector<std::size_t> wavelength;     ///< numbers in the calibration
  std::vector<PolarizationVector> values;  ///< an entry each
  Eigen::MatrixXd gain;                    ///< d parameters / d δ, 9 rows and one column an entry
  Eigen::MatrixXd lower;                   ///< factor of the covariance given all δ

  Eigen::Index entries() const { return static_cast<Eigen::Index>(wavelength.size()); }
};

/// Lower factor of a covariance that may be singular.
Eigen::MatrixXd lower_factor(Eigen::MatrixXd covariance) {
  const Eigen::Index n = covariance.rows();
  Eigen::MatrixXd lower = Eigen::MatrixXd::Zero(n, n);
  const Eigen::VectorXd scale = covariance.diagonal().cwiseMax(0.0);
  for (Eigen::Index k = 0; k < n; ++k) {
    const double pivot = covariance(k, k);
    if (!(pivot > 1e-12 * scale(k)) || !(pivot > 0)) continue;
    lower.col(k).tail(n - k) = covariance.col(k).tail(n - k) / std::sqrt(pivot);
    covariance.bottomRightCorner(n - k, n - k) -=
        lower.col(k).tail(n - k) * lower.col(k).tail(n - k).transpose();
  }
  return lower;
}

GivenBias given_bias(const Calibration& calibration) {
  GivenBias result;
  std::vector<Eigen::Index> place;
  const PolarizationCalibration& polarization = *calibration.polarization;
  for (std::size_t w = 0; w < calibration.wavelengths.size(); ++w) {
    if (!has_true_states(calibration, w)) continue;
    const PolarizationWavelength* entry =
        polarization.find(calibration.wavelengths[w].wavelength_nm);
    result.wavelength.push_back(w);
    result.values.push_back(entry->values());
    place.push_back((entry - polarization.wavelengths.data()) * polarization_parameters);
  }
  const Eigen::Index entries = result.entries(), side = entries * polarization_parameters;
  const Eigen::Index bias = index_of(PolarizationParameter::detector_bias);
  Eigen::MatrixXd covariance(side, side);
  for (Eigen::Index a = 0; a < entries; ++a)
    for (Eigen::Index b = 0; b < entries; ++b)
      covariance.block(a * polarization_parameters, b * polarization_parameters,
                       polarization_parameters, polarization_parameters) =
          polarization.covariance.block(place[static_cast<std::size_t>(a)],
                                        place[static_cast<std::size_t>(b)], polarization_parameters,
                                        polarization_parameters);
  // Regression of all parameters on the δ of all wavelengths.
  Eigen::MatrixXd with_bias(side, entries), of_bias(entries, entries);
  Eigen::VectorXd shift(entries);
  for (Eigen::Index b = 0; b < entries; ++b) {
    with_bias.col(b) = covariance.col(b * polarization_parameters + bias);
    const auto number = static_cast<std::size_t>(b);
    shift(b) = calibration.wavelengths[result.wavelength[number]].detector_bias -
               result.values[number](bias);
  }
  for (Eigen::Index a = 0; a < entries; ++a)
    of_bias.row(a) = with_bias.row(a * polarization_parameters + bias);
  of_bias.diagonal().array() += 1e-18;
  result.gain = of_bias.ldlt().solve(with_bias.transpose()).transpose();
  for (Eigen::Index a = 0; a < entries; ++a)
    for (Eigen::Index b = 0; b < entries; ++b)
      result.gain(a * polarization_parameters + bias, b) = a == b ? 1.0 : 0.0;
  const Eigen::VectorXd moved = result.gain * shift;
  for (Eigen::Index a = 0; a < entries; ++a) {
    auto& values = result.values[static_cast<std::size_t>(a)];
    values += moved.segment<polarization_parameters>(a * polarization_parameters);
    for (PolarizationParameter e :
         {PolarizationParameter::polarizer_extinction, PolarizationParameter::analyzer_extinction})
      values(index_of(e)) = std::max(values(index_of(e)), 0.0);
  }
  Eigen::MatrixXd rest = covariance - result.gain * with_bias.transpose();
  for (Eigen::Index a = 0; a < entries; ++a) {
    rest.row(a * polarization_parameters + bias).setZero();
    rest.col(a * polarization_parameters + bias).setZero();
  }
  result.lower = lower_factor(0.5 * (rest + rest.transpose()));
  return result;
}

/// The points of one geometry and wavelength.
struct Group {
  std::vector<std::size_t> point;
  std::size_t entry = 0;
  bool in_plane = false;
  double azimuth_sign = 1;
};

class Geometry {
 public:
  Geometry(const Group& group, const formats::BrdfTable::Points& points)
      : group_(group), points_(points) {
    const auto n = static_cast<Eigen::Index>(group.point.size());
    values = Eigen::VectorXd(n);
    weight_ = Eigen::VectorXd(n);
    ideal_ = Design(n, 9);
    double brightest = 0;
    for (Eigen::Index i = 0; i < n; ++i) {
      const std::size_t p = group.point[static_cast<std::size_t>(i)];
      values(i) = points.brdf_per_sr[p];
      ideal_.row(i) = outer(ideal_analyzer_vector(points.analyzer_deg[p]),
                            ideal_source_vector(points.polarizer_deg[p]));
      brightest = std::max(brightest, std::abs(values(i)) / ideal_(i, 0));
    }
    level = std::max(brightest, 1e-12);
    for (Eigen::Index i = 0; i < n; ++i) {
      const std::size_t p = group.point[static_cast<std::size_t>(i)];
      // A part in a thousand of the point and 1e-6 of the level bound the weights from above.
      const double u = std::hypot(points.brdf_u[p], std::hypot(1e-3 * values(i), 1e-6 * level));
      weight_(i) = points.used[p] != 0 ? 1.0 / u : 1e-3 / std::max(u, level);
    }
  }

  /// Map from points behind true elements to points behind ideal ones.
  Eigen::MatrixXd to_ideal(const PolarizationVector& parameters) const {
    const auto n = values.size();
    const Design truth = design(parameters);
    // Bayesian least squares: m00 free, the others within ± m00, the odd ones zero in plane.
    Eigen::Matrix<double, 9, 9> normal =
        truth.transpose() * weight_.cwiseAbs2().asDiagonal() * truth;
    const double free = 1.0 / (free_element_u * level), zero = 1e6 / level;
    for (int k = 1; k < 9; ++k) normal(k, k) += free * free;
    if (group_.in_plane)
      for (int k : odd_elements) normal(k, k) += zero * zero;
    const Eigen::Matrix<double, 9, Eigen::Dynamic> solve =
        normal.ldlt().solve(truth.transpose() * weight_.cwiseAbs2().asDiagonal());
    return Eigen::MatrixXd::Identity(n, n) + (ideal_ - truth) * solve;
  }

  Design design(const PolarizationVector& parameters) const {
    Design truth(values.size(), 9);
    for (Eigen::Index i = 0; i < values.size(); ++i) {
      const std::size_t p = group_.point[static_cast<std::size_t>(i)];
      truth.row(i) = outer(analyzer_vector(parameters, points_.analyzer_deg[p]),
                           source_vector(parameters, points_.polarizer_deg[p]));
    }
    return truth;
  }

  /// Shift of the ideal points for one standard deviation of element `k` where the states leave it
  /// open; zero where they fix it.
  Eigen::VectorXd open_element(const PolarizationVector& parameters, int k) const {
    const bool odd = std::find(odd_elements.begin(), odd_elements.end(), k) != odd_elements.end();
    if (odd && group_.in_plane) return Eigen::VectorXd::Zero(values.size());
    Elements unit = Elements::Zero();
    unit(k) = 1;
    const Eigen::VectorXd seen = ideal_ * unit;
    if (seen.cwiseAbs().maxCoeff() > 1e-6) return Eigen::VectorXd::Zero(values.size());
    const double sign = odd ? group_.azimuth_sign : 1.0;
    return sign * free_element_u * level * (ideal_ - design(parameters)).col(k);
  }

  Eigen::VectorXd values;
  double level = 0;  ///< of m00

 private:
  const Group& group_;
  const formats::BrdfTable::Points& points_;
  Eigen::VectorXd weight_;
  Design ideal_;
};

std::vector<Group> group_points(const formats::BrdfTable::Points& points,
                                const std::vector<std::size_t>& wavelength,
                                const std::vector<std::size_t>& entries) {
  const auto rounded = [](double v) { return std::llround(v * 1e4); };
  std::map<std::array<long long, 4>, std::size_t> number;
  std::vector<Group> groups;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto entry = std::find(entries.begin(), entries.end(), wavelength[i]);
    if (entry == entries.end()) continue;
    const std::array<long long, 4> key = {
        rounded(points.theta_i_deg[i]), rounded(points.theta_r_deg[i]),
        rounded(points.phi_r_deg[i]), static_cast<long long>(wavelength[i])};
    const auto [at, fresh] = number.try_emplace(key, groups.size());
    if (fresh) {
      Group group;
      group.entry = static_cast<std::size_t>(entry - entries.begin());
      const double sine = std::sin(optics::radians(points.phi_r_deg[i]));
      group.in_plane = std::abs(sine) < std::sin(optics::radians(in_plane_deg)) ||
                       std::abs(points.theta_r_deg[i]) < in_plane_deg;
      group.azimuth_sign = sine < 0 ? -1 : 1;
      groups.push_back(group);
    }
    groups[at->second].point.push_back(i);
  }
  return groups;
}

std::vector<double>& factor_named(formats::BrdfTable& table, const std::string& name) {
  for (auto& factor : table.factors)
    if (factor.name == name) return factor.per_point;
  table.factors.push_back({name, std::vector<double>(table.points.size(), 0.0)});
  return table.factors.back().per_point;
}

/// Drops factors that nobody could see in the points, by the rule of point_factors.
void drop_invisible(formats::BrdfTable& table, std::size_t from) {
  const auto invisible = [&table](const formats::BrdfTable::Factor& factor) {
    double visible = 0;
    for (std::size_t i = 0; i < factor.per_point.size(); ++i) {
      const double u = table.points.brdf_u[i];
      visible += u > 0 ? factor.per_point[i] * factor.per_point[i] / (u * u) : 0.0;
    }
    return visible < 0.003;
  };
  table.factors.erase(std::remove_if(table.factors.begin() + static_cast<std::ptrdiff_t>(from),
                                     table.factors.end(), invisible),
                      table.factors.end());
}

}  // namespace

bool has_true_states(const Calibration& calibration, std::size_t wavelength) {
  const WavelengthCalibration& entry = calibration.wavelengths[wavelength];
  return calibration.polarization && entry.polarization_shift.size() > 0 &&
         calibration.polarization->find(entry.wavelength_nm) != nullptr;
}

std::vector<std::string> to_ideal_states(formats::BrdfTable& table,
                                         const std::vector<std::size_t>& wavelength,
                                         const Calibration& calibration) {
  std::vector<std::string> notes;
  if (!calibration.polarization) return notes;
  const GivenBias given = given_bias(calibration);
  if (given.wavelength.empty()) return notes;
  auto& points = table.points;
  const std::vector<Group> groups = group_points(points, wavelength, given.wavelength);

  // d point / d parameter of its own wavelength.
  Eigen::MatrixXd slope =
      Eigen::MatrixXd::Zero(static_cast<Eigen::Index>(points.size()), polarization_parameters);
  std::array<std::vector<double>, 9> open;
  for (auto& column : open) column.assign(points.size(), 0.0);
  const PolarizationVector step =
      (PolarizationVector() << 1e-3, 1e-3, 1e-6, 1e-6, 1e-5, 1e-5, 1e-4, 1e-4, 1e-3).finished();
  double largest = 0;
  for (const Group& group : groups) {
    const PolarizationVector& parameters = given.values[group.entry];
    const Geometry geometry(group, points);
    const Eigen::MatrixXd map = geometry.to_ideal(parameters);
    for (Eigen::Index k = 0; k < polarization_parameters; ++k) {
      PolarizationVector up = parameters, down = parameters;
      up(k) += step(k);
      down(k) = std::max(down(k) - step(k), k == 2 || k == 3 ? 0.0 : -1e9);
      const Eigen::VectorXd change =
          (geometry.to_ideal(up) - geometry.to_ideal(down)) * geometry.values / (up(k) - down(k));
      for (std::size_t i = 0; i < group.point.size(); ++i)
        slope(static_cast<Eigen::Index>(group.point[i]), k) = change(static_cast<Eigen::Index>(i));
    }
    for (int k : {2, 5, 6, 7, uu_element}) {
      const Eigen::VectorXd shift = geometry.open_element(parameters, k);
      for (std::size_t i = 0; i < group.point.size(); ++i)
        open[static_cast<std::size_t>(k)][group.point[i]] = shift(static_cast<Eigen::Index>(i));
    }
    const auto n = static_cast<Eigen::Index>(group.point.size());
    const auto gather = [&](const std::vector<double>& column) {
      Eigen::VectorXd v(n);
      for (Eigen::Index i = 0; i < n; ++i) v(i) = column[group.point[static_cast<std::size_t>(i)]];
      return v;
    };
    const auto scatter = [&](const Eigen::VectorXd& v, std::vector<double>& column) {
      for (Eigen::Index i = 0; i < n; ++i) column[group.point[static_cast<std::size_t>(i)]] = v(i);
    };
    const Eigen::VectorXd value = map * geometry.values;
    for (Eigen::Index i = 0; i < n; ++i)
      largest = std::max(largest, std::abs(value(i) - geometry.values(i)) / geometry.level);
    const Eigen::VectorXd variance = map.cwiseAbs2() * gather(points.brdf_u).cwiseAbs2();
    scatter(value, points.brdf_per_sr);
    scatter(variance.cwiseSqrt(), points.brdf_u);
    for (auto& factor : table.factors) scatter(map * gather(factor.per_point), factor.per_point);
  }

  // Shift of every point for a change of the parameters of all entries: directly, and through the
  // gain that the standard gave with the same elements.
  const auto shifted = [&](const Eigen::VectorXd& change, std::vector<double>& column,
                           bool through_standard) {
    for (const Group& group : groups) {
      const auto entry = static_cast<Eigen::Index>(group.entry);
      const PolarizationVector own =
          change.segment<polarization_parameters>(entry * polarization_parameters);
      const WavelengthCalibration& gain = calibration.wavelengths[given.wavelength[group.entry]];
      const Eigen::VectorXd of_standard = gain.polarization_shift * own;
      const auto count = static_cast<Eigen::Index>(gain.instrument_function.degrees.size());
      for (std::size_t i : group.point) {
        double shift = slope.row(static_cast<Eigen::Index>(i)).dot(own);
        if (through_standard) {
          double log_shift = -of_standard(0);
          if (count > 0)
            log_shift -= gain.instrument_function.basis(points.theta_r_deg[i])
                             .dot(of_standard.segment(1, count));
          shift += points.brdf_per_sr[i] * log_shift;
        }
        column[i] += shift;
      }
    }
  };

  // δ: a parameter of the gain's fit, so its share belongs to the fit's own columns.
  for (Eigen::Index b = 0; b < given.entries(); ++b) {
    const WavelengthCalibration& entry =
        calibration.wavelengths[given.wavelength[static_cast<std::size_t>(b)]];
    if (!entry.bias_active) continue;
    const Eigen::MatrixXd lower = Eigen::LLT<Eigen::MatrixXd>(entry.covariance).matrixL();
    const Eigen::Index last = entry.parameters() - 1;
    for (Eigen::Index k = 0; k <= last; ++k) {
      if (lower(last, k) == 0) continue;
      const Eigen::VectorXd change = given.gain.col(b) * lower(last, k);
      shifted(change, factor_named(table, statistics_factor_name(entry, k)), true);
    }
  }
  const std::size_t own_factors = table.factors.size();
  for (Eigen::Index k = 0; k < given.lower.cols(); ++k) {
    if (given.lower.col(k).isZero(0)) continue;
    const auto entry = static_cast<std::size_t>(k / polarization_parameters);
    const auto parameter = static_cast<PolarizationParameter>(k % polarization_parameters);
    table.factors.push_back(
        {fmt::format("{} {:g} nm", name_of(parameter),
                     calibration.wavelengths[given.wavelength[entry]].wavelength_nm),
         std::vector<double>(points.size(), 0.0)});
    shifted(given.lower.col(k), table.factors.back().per_point, true);
  }
  const std::array<const char*, 9> element = {"", "", "m02", "", "", "m12", "m20", "m21", "m22"};
  for (std::size_t e = 0; e < given.wavelength.size(); ++e)
    for (std::size_t k : {2UL, 5UL, 6UL, 7UL, 8UL}) {
      formats::BrdfTable::Factor factor{
          fmt::format("undetermined {} {:g} nm", element[k],
                      calibration.wavelengths[given.wavelength[e]].wavelength_nm),
          std::vector<double>(points.size(), 0.0)};
      for (const Group& group : groups)
        if (group.entry == e)
          for (std::size_t i : group.point) factor.per_point[i] = open[k][i];
      table.factors.push_back(std::move(factor));
    }
  drop_invisible(table, own_factors);
  notes.push_back(fmt::format(
      "points refer to ideal polarisers and analysers: axes, extinction and biases of the mirror "
      "scan are taken out (up to {:.2g} of m00)",
      largest));
  return notes;
}

}  // namespace umov::calibrate
