#include "host/calibrate/budget.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <optional>

#include <fmt/format.h>
#include <boost/math/distributions/students_t.hpp>

#include "host/formats/order_statistics.hpp"

namespace umov::calibrate {

namespace {

constexpr double infinite = std::numeric_limits<double>::infinity();
constexpr double unknown = std::numeric_limits<double>::quiet_NaN();

/// Number at the end of a factor's name, such as the amplifier range.
double number_at_end(const std::string& name) {
  return std::strtod(name.c_str() + name.find_last_of(' ') + 1, nullptr);
}

/// What is known of an input quantity at a point.
struct Input {
  char type = 'B';
  const char* unit = "1";
  double u = unknown, dof = infinite;
};

/// Polariser, analyser and source quantities carry the names of the polarisation calibration.
std::optional<Input> polarization_input(const std::string& name, const Calibration& calibration,
                                        double wavelength_nm) {
  if (!calibration.polarization) return std::nullopt;
  const auto* entry = calibration.polarization->find(wavelength_nm);
  if (entry == nullptr) return std::nullopt;
  for (Eigen::Index k = 0; k < polarization_parameters; ++k) {
    const auto parameter = static_cast<PolarizationParameter>(k);
    if (name_of(parameter) != name) continue;
    const auto w = static_cast<Eigen::Index>(entry - calibration.polarization->wavelengths.data());
    const Eigen::Index at = w * polarization_parameters + k;
    const bool axis = parameter == PolarizationParameter::polarizer_axis_deg ||
                      parameter == PolarizationParameter::analyzer_axis_deg;
    return Input{'A', axis ? "deg" : "1", std::sqrt(calibration.polarization->covariance(at, at)),
                 entry->dof > 0 ? entry->dof : infinite};
  }
  return std::nullopt;
}

double measured_dof(bool measured, double dof) {
  return measured && dof > 0 ? dof : infinite;
}

/// Input behind a contribution at one point; `factor` is the full name of its only factor.
Input input_of(const std::string& name, const std::string& factor, const Reduction& reduction,
               const Calibration& calibration, std::size_t i) {
  const PointOrigin& origin = reduction.origin[i];
  const auto& points = reduction.table.points;
  const WavelengthCalibration& entry = calibration.wavelengths[origin.wavelength];
  const double fit_dof = entry.dof > 0 ? entry.dof : infinite;
  if (name == "gain") return {'A', "1", std::sqrt(entry.covariance(0, 0)), fit_dof};
  if (name == "instrument function") return {'A', "1", unknown, fit_dof};
  if (name == "detector bias") return {'A', "1", entry.detector_bias_u, fit_dof};
  if (name == "reference standard") return {'B', "1", entry.reference_relative_u, infinite};
  if (name == "reference shape") return {'B', "1", calibration.shape_u, infinite};
  if (name.starts_with("scan dark range")) return {'A', "V", unknown, infinite};
  if (name.starts_with("dark range")) {
    const DarkLevel level = calibration.dark.at(number_at_end(factor));
    const bool measured = level.records > 1;
    return {measured ? 'A' : 'B', "V", level.x_u,
            measured ? static_cast<double>(level.records - 1) : infinite};
  }
  const Nonlinearity& law = calibration.nonlinearity;
  if (name.starts_with("gain range")) {
    const RangeError range = calibration.ranges.at(number_at_end(factor));
    return {range.measured ? 'A' : 'B', "1", range.u, measured_dof(range.measured, law.dof)};
  }
  if (name == "detector nonlinearity")
    return {law.measured ? 'A' : 'B', "1/V", law.kappa_u_per_v,
            measured_dof(law.measured, law.dof)};
  if (name == "stray light") {
    const StrayLight& stray = calibration.stray;
    const Eigen::Index w = stray.number(points.wavelength_nm[i]);
    const bool measured = w >= 0 && stray.measured[static_cast<std::size_t>(w)] != 0;
    return {measured ? 'A' : 'B', "1/sr",
            stray.level_u(points.wavelength_nm[i], points.theta_r_deg[i], points.phi_r_deg[i]),
            measured_dof(measured, stray.dof)};
  }
  const DeclaredDoubts& declared = calibration.declared;
  if (name == "detector zero") return {'B', "deg", declared.theta_r_zero_u_deg, infinite};
  if (name == "incidence zero") return {'B', "deg", declared.theta_i_zero_u_deg, infinite};
  if (name == "detector eccentricity")
    return {'B', "deg", declared.theta_r_eccentricity_u_deg, infinite};
  if (name == "detector play") return {'B', "deg", declared.theta_r_play_u_deg, infinite};
  if (name == "sample lean" || name == "standard lean")
    return {'B', "deg", declared.sample_lean_u_deg, infinite};
  if (name == "detector stop" || name == "incidence stop")
    return {'B', "deg", declared.position_u_deg, infinite};
  if (name == "source") return {'B', "1", declared.source_relative_u, infinite};
  if (name == "aperture") return {'B', "1", 1.0, infinite};
  if (name == "solid angle") return {'B', "1", declared.solid_angle_relative_u, infinite};
  return polarization_input(name, calibration, points.wavelength_nm[i]).value_or(Input{});
}

}  // namespace

std::string contribution_name(const std::string& factor) {
  std::string name = factor;
  const auto is_number = [](std::string_view word) {
    return !word.empty() && word.find_first_not_of("-0123456789.") == std::string_view::npos;
  };
  const auto last_word = [&name] {
    const auto space = name.find_last_of(' ');
    return space == std::string::npos ? std::string_view{}
                                      : std::string_view(name).substr(space + 1);
  };
  // The number of a column goes, that of an amplifier range stays: it names the quantity.
  if (is_number(last_word()) && name.find(" range ") == std::string::npos)
    name.resize(name.size() - last_word().size() - 1);
  if (last_word() == "nm") {
    name.resize(name.size() - 3);
    if (is_number(last_word())) name.resize(name.size() - last_word().size() - 1);
  }
  return name;
}

double coverage_factor_95(double dof) {
  constexpr double normal = 1.959963984540054;
  if (!std::isfinite(dof) || dof > 1e6) return normal;
  const boost::math::students_t distribution(std::max(1.0, dof));
  return boost::math::quantile(distribution, 0.975);
}

std::vector<PointBudget> budget_of(const Reduction& reduction, const Calibration& calibration) {
  const auto& table = reduction.table;
  struct Group {
    std::string name, factor;
    std::vector<std::size_t> members;
  };
  std::vector<Group> groups;
  for (std::size_t k = 0; k < table.factors.size(); ++k) {
    const std::string name = contribution_name(table.factors[k].name);
    const auto known = std::find_if(groups.begin(), groups.end(),
                                    [&name](const Group& g) { return g.name == name; });
    if (known == groups.end())
      groups.push_back({name, table.factors[k].name, {k}});
    else
      known->members.push_back(k);
  }

  std::vector<PointBudget> budget;
  for (std::size_t i = 0; i < table.points.size(); ++i) {
    PointBudget point;
    point.point = i;
    Contribution noise;
    noise.name = "noise";
    noise.type = 'A';
    noise.unit = "1/sr";
    noise.input_u = noise.u_per_sr = table.points.brdf_u[i];
    noise.sensitivity = 1;
    noise.dof = reduction.origin[i].noise_dof > 0 ? reduction.origin[i].noise_dof : infinite;
    point.contributions.push_back(noise);
    for (const Group& group : groups) {
      double variance = 0, sum = 0;
      int active = 0;
      for (std::size_t k : group.members) {
        const double shift = table.factors[k].per_point[i];
        variance += shift * shift;
        sum += shift;
        active += shift != 0;
      }
      if (active == 0) continue;
      const Input input = input_of(group.name, group.factor, reduction, calibration, i);
      Contribution c;
      c.name = group.name;
      c.type = input.type;
      c.unit = input.unit;
      c.input_u = input.u;
      c.u_per_sr = std::sqrt(variance);
      c.dof = input.dof;
      if (input.u > 0) c.sensitivity = std::copysign(c.u_per_sr, active == 1 ? sum : 1.0) / input.u;
      if (group.name.starts_with("scan dark range") && reduction.origin[i].per_volt > 0) {
        c.sensitivity = -reduction.origin[i].per_volt;
        c.input_u = c.u_per_sr / reduction.origin[i].per_volt;
      }
      point.contributions.push_back(std::move(c));
    }
    double variance = 0, fourth = 0;
    for (const Contribution& c : point.contributions) {
      const double v = c.u_per_sr * c.u_per_sr;
      variance += v;
      if (std::isfinite(c.dof)) fourth += v * v / c.dof;
    }
    point.combined_u = std::sqrt(variance);
    if (fourth > 0) point.effective_dof = variance * variance / fourth;
    point.coverage_factor = coverage_factor_95(point.effective_dof);
    point.expanded_u = point.coverage_factor * point.combined_u;
    budget.push_back(std::move(point));
  }
  return budget;
}

std::vector<BudgetShare> budget_shares(const Reduction& reduction,
                                       const std::vector<PointBudget>& budget) {
  const auto& points = reduction.table.points;
  struct Sizes {
    char type = 'B';
    std::vector<double> relative;
  };
  std::map<std::string, Sizes> sizes;
  for (const PointBudget& point : budget) {
    const double f = std::abs(points.brdf_per_sr[point.point]);
    if (points.used[point.point] == 0 || !(f > 0)) continue;
    for (const Contribution& c : point.contributions) {
      Sizes& own = sizes[c.name];
      if (c.type == 'A') own.type = 'A';
      own.relative.push_back(c.u_per_sr / f);
    }
  }
  std::vector<BudgetShare> shares;
  for (const auto& [name, own] : sizes)
    shares.push_back(
        {name, own.type, formats::median(own.relative), formats::quantile(own.relative, 0.95)});
  std::sort(shares.begin(), shares.end(), [](const BudgetShare& a, const BudgetShare& b) {
    return a.median_relative_u > b.median_relative_u;
  });
  return shares;
}

}  // namespace umov::calibrate
