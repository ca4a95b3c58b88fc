#include "host/calibrate/reference_standard.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <numbers>

#include <fmt/format.h>

#include "host/calibrate/calibration.hpp"
#include "host/errors/error.hpp"
#include "host/formats/order_statistics.hpp"
#include "host/optics/angles.hpp"

namespace umov::calibrate {

namespace {

double positive_key(const formats::ScanTable& scan, const std::string& name, double fallback) {
  const double value = scan.number(name).value_or(fallback);
  if (!(value >= 0) || !std::isfinite(value))
    throw Error(fmt::format("key `{}` is {:g}", name, value), "give a number that is not negative");
  return value;
}

constexpr double angle_tolerance_deg = 0.05;
/// Certificates state a few per cent above one at times (relative scales); per cent are refused.
constexpr double most_reflectance = 1.2;
/// What a sintered standard does although its certificate states a reflectance only; sizes of
/// measured PTFE (T. A. Germer, Applied Optics 2017).
constexpr double typical_shape = 0.15;
constexpr double typical_retention = 0.03;
constexpr double typical_polarization = 0.01;

/// Piecewise-linear curve; nullopt outside its nodes.
std::optional<double> interpolate_linear(const std::map<double, double>& curve, double at,
                                         double tolerance) {
  if (curve.empty()) return std::nullopt;
  auto high = curve.lower_bound(at);
  if (high == curve.end()) {
    if (at - curve.rbegin()->first > tolerance) return std::nullopt;
    return curve.rbegin()->second;
  }
  if (high == curve.begin()) {
    if (high->first - at > tolerance) return std::nullopt;
    return high->second;
  }
  const auto low = std::prev(high);
  const double t = (at - low->first) / (high->first - low->first);
  return (1.0 - t) * low->second + t * high->second;
}

/// Cubic through the two nodes on either side (Lagrange), straight lines at the ends.
std::optional<double> interpolate_cubic(const std::map<double, double>& curve, double at,
                                        double tolerance) {
  const auto high = curve.lower_bound(at);
  if (curve.size() < 4 || high == curve.begin() || high == curve.end() ||
      std::prev(high) == curve.begin() || std::next(high) == curve.end())
    return interpolate_linear(curve, at, tolerance);
  const auto first = std::prev(high, 2), last = std::next(high, 2);
  double sum = 0;
  for (auto k = first; k != last; ++k) {
    double weight = 1;
    for (auto l = first; l != last; ++l)
      if (l != k) weight *= (at - l->first) / (k->first - l->first);
    sum += weight * k->second;
  }
  return sum;
}

}  // namespace

/// In-plane curves of the table: state → wavelength → incidence → (signed exit angle → BRDF).
class ReferenceStandard::Table {
 public:
  using Curve = std::map<double, double>;
  using ByIncidence = std::map<double, Curve>;
  using ByWavelength = std::map<double, ByIncidence>;

  explicit Table(const formats::BrdfTable& table) {
    const auto& p = table.points;
    std::map<std::pair<long long, long long>,
             std::map<std::array<double, 3>, std::pair<double, int>>>
        sums;
    for (std::size_t i = 0; i < p.size(); ++i) {
      if (p.used[i] == 0) continue;
      // Out-of-plane directions have no place on a signed in-plane curve.
      const double phi = std::remainder(p.phi_r_deg[i], 360.0);
      double theta_r = p.theta_r_deg[i];
      if (std::abs(std::abs(phi) - 180.0) < angle_tolerance_deg)
        theta_r = -theta_r;
      else if (std::abs(phi) >= angle_tolerance_deg)
        continue;
      auto& cell = sums[state(p.polarizer_deg[i], p.analyzer_deg[i])]
                       [{p.wavelength_nm[i], p.theta_i_deg[i], theta_r}];
      cell.first += p.brdf_per_sr[i];
      cell.second += 1;
    }
    for (const auto& [key, cells] : sums)
      for (const auto& [at, cell] : cells)
        states_[key][at[0]][at[1]][at[2]] = cell.first / cell.second;
    if (states_.empty())
      throw Error("the standard's table has no used in-plane point",
                  "give a table with phi_r_deg 0 (or 180)");
  }

  bool has(double polarizer_deg, double analyzer_deg) const {
    return states_.contains(state(polarizer_deg, analyzer_deg));
  }

  bool only_open() const {
    return states_.size() == 1 && has(formats::open_axis, formats::open_axis);
  }

  std::optional<double> value(double theta_i, double theta_r, double wavelength, double polarizer,
                              double analyzer) const {
    const auto found = states_.find(state(polarizer, analyzer));
    if (found == states_.end()) return std::nullopt;
    Curve spectrum;  // only bracketing wavelengths are worth interpolating
    const auto& lines = found->second;
    auto high = lines.lower_bound(wavelength - 0.5);
    if (high == lines.end()) return std::nullopt;
    if (high->first <= wavelength + 0.5) return at_incidence(high->second, theta_i, theta_r);
    if (high == lines.begin()) return std::nullopt;
    for (auto line : {std::prev(high), high}) {
      const auto f = at_incidence(line->second, theta_i, theta_r);
      if (!f) return std::nullopt;
      spectrum[line->first] = *f;
    }
    return interpolate_linear(spectrum, wavelength, 0.5);
  }

 private:
  static std::pair<long long, long long> state(double polarizer, double analyzer) {
    const auto axis = [](double a) {
      if (formats::is_open(a)) return -1LL;
      const double folded = a - 180.0 * std::floor(a / 180.0);
      return std::llround(folded * 100.0) % 18000;
    };
    return {axis(polarizer), axis(analyzer)};
  }

  static std::optional<double> at_incidence(const ByIncidence& table, double theta_i,
                                            double theta_r) {
    const auto at = [&](const Curve& curve) {
      return interpolate_cubic(curve, theta_r, angle_tolerance_deg);
    };
    auto high = table.lower_bound(theta_i - angle_tolerance_deg);
    if (high == table.end()) return std::nullopt;
    if (high->first <= theta_i + angle_tolerance_deg) return at(high->second);
    if (high == table.begin()) return std::nullopt;
    const auto low = std::prev(high);
    const auto a = at(low->second), b = at(high->second);
    if (!a || !b) return std::nullopt;
    const double t = (theta_i - low->first) / (high->first - low->first);
    return (1.0 - t) * *a + t * *b;
  }

  std::map<std::pair<long long, long long>, ByWavelength> states_;
};

ReferenceStandard ReferenceStandard::from_keys(const formats::ScanTable& scan) {
  ReferenceStandard standard;
  const double absolute_u = positive_key(scan, "reference_dhr_u", 0.005);
  for (double wavelength : wavelengths_of(scan)) {
    const std::string name = fmt::format("reference_dhr_{:g}", wavelength);
    const auto dhr = scan.number(name);
    if (!dhr)
      throw Error(
          fmt::format("the white scan has no key `{}`", name),
          "state the standard's reflectance in the plan or the file (reference_dhr_<nm>), or "
          "give a table of its BRDF (reference_brdf)");
    if (!(*dhr > 0 && *dhr <= most_reflectance))
      throw Error(fmt::format("key `{}` is {:g}", name, *dhr),
                  "give the reflectance as a fraction, such as 0.99");
    const double relative_u = positive_key(scan, "reference_dhr_relative_u", absolute_u / *dhr);
    standard.stated_.push_back({wavelength, *dhr, relative_u});
  }
  standard.shape_u_ = positive_key(scan, "reference_shape_u", typical_shape);
  standard.retention_u_ = positive_key(scan, "reference_retention_u", typical_retention);
  standard.polarization_u_ = positive_key(scan, "reference_polarization_u", typical_polarization);
  return standard;
}

ReferenceStandard ReferenceStandard::from_table(const formats::BrdfTable& table,
                                                const formats::ScanTable& scan) {
  ReferenceStandard standard;
  standard.table_ = std::make_shared<const Table>(table);
  // What all points share (the scale of a table that was itself measured against a standard) is in
  // its factors, not in its noise.
  std::vector<double> relative;
  for (std::size_t i = 0; i < table.points.size(); ++i) {
    if (table.points.used[i] == 0 || !(table.points.brdf_per_sr[i] > 0)) continue;
    double variance = table.points.brdf_u[i] * table.points.brdf_u[i];
    for (const auto& factor : table.factors) variance += factor.per_point[i] * factor.per_point[i];
    relative.push_back(std::sqrt(variance) / table.points.brdf_per_sr[i]);
  }
  const double typical = formats::median(std::move(relative));
  standard.table_relative_u_ = positive_key(scan, "reference_dhr_relative_u", typical);
  standard.retention_u_ = positive_key(scan, "reference_retention_u", typical_retention);
  standard.polarization_u_ = positive_key(scan, "reference_polarization_u", typical_polarization);
  for (double wavelength : wavelengths_of(scan))
    if (const auto dhr = scan.number(fmt::format("reference_dhr_{:g}", wavelength)))
      standard.stated_.push_back({wavelength, *dhr, standard.table_relative_u_});
  return standard;
}

std::optional<double> ReferenceStandard::brdf(double theta_i_deg, double theta_r_deg,
                                              double phi_r_deg, double wavelength_nm,
                                              double polarizer_deg, double analyzer_deg) const {
  const double share = formats::is_open(analyzer_deg) ? 1.0 : 0.5;
  if (table_) {
    if (std::abs(phi_r_deg) >= angle_tolerance_deg) return std::nullopt;
    if (table_->only_open()) {
      const auto f = table_->value(theta_i_deg, theta_r_deg, wavelength_nm, formats::open_axis,
                                   formats::open_axis);
      return f ? std::optional(share * *f) : std::nullopt;
    }
    return table_->value(theta_i_deg, theta_r_deg, wavelength_nm, polarizer_deg, analyzer_deg);
  }
  const auto stated = dhr(wavelength_nm);
  if (!stated) return std::nullopt;
  return share * *stated * std::numbers::inv_pi * (1.0 + shape_amplitude_ * shape(theta_r_deg));
}

double ReferenceStandard::log_slope_per_deg(double theta_i_deg, double theta_r_deg,
                                            double phi_r_deg, double wavelength_nm,
                                            double polarizer_deg, double analyzer_deg) const {
  constexpr double half_step_deg = 0.5;
  const auto beside = [&](double step_deg) {
    return brdf(theta_i_deg, theta_r_deg + step_deg, phi_r_deg, wavelength_nm, polarizer_deg,
                analyzer_deg);
  };
  const double cosine_part = -optics::radians(1.0) * std::tan(optics::radians(theta_r_deg));
  const auto low = beside(-half_step_deg), high = beside(half_step_deg);
  if (!low || !high || !(*low > 0) || !(*high > 0)) return cosine_part;
  return cosine_part + std::log(*high / *low) / (2 * half_step_deg);
}

std::optional<double> ReferenceStandard::dhr(double wavelength_nm) const {
  for (const Stated& s : stated_)
    if (std::abs(s.wavelength_nm - wavelength_nm) < 0.5) return s.dhr;
  return std::nullopt;
}

double ReferenceStandard::relative_u(double wavelength_nm) const {
  if (table_) return table_relative_u_;
  for (const Stated& s : stated_)
    if (std::abs(s.wavelength_nm - wavelength_nm) < 0.5) return s.relative_u;
  return 0;
}

void ReferenceStandard::set_shape(double amplitude, double u) {
  if (tabulated()) return;
  shape_amplitude_ = amplitude;
  shape_u_ = u;
}

bool ReferenceStandard::polarised() const {
  return table_ && !table_->only_open();
}

double ReferenceStandard::shape(double theta_r_deg) {
  // Twice the integral of θ² sinθ cosθ over 0…90° is π²/8 - 1/2.
  constexpr double unit = 80.0 * std::numbers::pi / 180.0;
  constexpr double mean = (std::numbers::pi * std::numbers::pi / 8.0 - 0.5) / (unit * unit);
  const double x = theta_r_deg / 80.0;
  return mean - x * x;
}

}  // namespace umov::calibrate
