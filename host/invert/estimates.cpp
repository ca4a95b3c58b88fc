#include "host/invert/estimates.hpp"

#include <algorithm>
#include <cmath>
#include <optional>
#include <set>
#include <utility>

#include "host/brdf/dhr.hpp"
#include "host/invert/dhr_gradient.hpp"
#include "host/optics/angles.hpp"
#include "host/parallel/for_each_index.hpp"

namespace umov::invert {
namespace {

using formats::Estimate;
using formats::FitParameter;
using formats::FitResult;

/// Reflectance is listed at so many of the data's incidences unless the user names them.
constexpr std::size_t most_incidences = 10;

/// Adds a quantity made of two parameters, shared where both are.
void add_derived(const Layout& layout, const Solution& solution, const Posterior& posterior,
                 std::size_t first, std::size_t second, const std::string& name,
                 const std::string& unit, auto value_and_slopes, FitResult& fit) {
  FitParameter derived;
  derived.name = name;
  derived.unit = unit;
  derived.shared = layout.is_shared(first) && layout.is_shared(second);
  for (std::size_t w = 0; w < (derived.shared ? 1 : fit.wavelengths_nm.size()); ++w) {
    const std::vector<double> values = layout.values(w, solution.x);
    const auto [value, by_first, by_second] = value_and_slopes(values[first], values[second]);
    Eigen::VectorXd by_x = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(layout.size()));
    for (const auto& [parameter, by] : {std::pair{first, by_first}, {second, by_second}}) {
      if (const auto free = layout.slot(w, parameter)) {
        by_x[static_cast<Eigen::Index>(*free)] +=
            by * layout.free()[*free].coordinate.slope(solution.x[*free]);
      }
    }
    const Interval interval = posterior.interval(value, by_x);
    Estimate e;
    e.value = value;
    e.lo = std::max(interval.lo, 0.0);  // slopes and reflectances are not negative
    e.hi = interval.hi;
    e.standard_error = (e.hi - e.lo) / (2 * 1.959963984540054);
    derived.estimates.push_back(e);
  }
  fit.derived.push_back(std::move(derived));
}

}  // namespace

void set_parameters(const Layout& layout, const Solution& solution, const Posterior& posterior,
                    FitResult& fit) {
  const auto& list = layout.model().parameters();
  for (std::size_t i = 0; i < list.size(); ++i) {
    FitParameter parameter;
    parameter.name = list[i].name;
    parameter.unit = list[i].unit;
    parameter.shared = layout.is_shared(i);
    parameter.fixed = true;
    const std::size_t count = parameter.shared ? 1 : fit.wavelengths_nm.size();
    for (std::size_t w = 0; w < count; ++w) {
      Estimate e;
      e.value = layout.values(w, solution.x)[i];
      e.lo = e.hi = e.value;
      if (const auto free = layout.slot(w, i)) {
        parameter.fixed = false;
        const Coordinate& k = layout.free()[*free].coordinate;
        const double x = solution.x[*free], span = k.hi_x() - k.lo_x();
        if (x - k.lo_x() <= 1e-9 * span) {
          e.at_bound = "lower";
          e.value = k.lo;
        } else if (k.hi_x() - x <= 1e-9 * span) {
          e.at_bound = "upper";
          e.value = k.hi;
        }
        if (!e.at_bound.empty()) fit.at_bound.push_back(layout.label(*free));
        const Interval interval = posterior.parameter_interval(*free);
        e.lo = std::min(interval.lo, e.value);
        e.hi = std::max(interval.hi, e.value);
        e.standard_error = (e.hi - e.lo) / (2 * 1.959963984540054);
      }
      parameter.estimates.push_back(e);
    }
    fit.parameters.push_back(std::move(parameter));
  }
}

void set_derived(const Layout& layout, const Solution& solution, const Posterior& posterior,
                 FitResult& fit) {
  struct Values {
    double value, by_first, by_second;
  };
  const auto& list = layout.model().parameters();
  const auto find = [&](const std::string& name) -> std::optional<std::size_t> {
    for (std::size_t i = 0; i < list.size(); ++i) {
      if (list[i].name == name) return i;
    }
    return std::nullopt;
  };
  for (std::size_t i = 0; i < list.size(); ++i) {
    const std::string bare = bare_name(list[i].name);
    const std::string part = list[i].name.substr(0, list[i].name.size() - bare.size());
    if (bare == "sigma_um") {
      if (const auto tau = find(part + "tau_um")) {
        add_derived(
            layout, solution, posterior, i, *tau, part + "slope_2sigma_over_tau", "1",
            [](double sigma, double length) {
              return Values{2 * sigma / length, 2 / length, -2 * sigma / (length * length)};
            },
            fit);
      }
    }
    if (bare == "k_udf") {
      if (const auto uds = find(part + "k_uds")) {
        add_derived(
            layout, solution, posterior, i, *uds, part + "k_udf+" + part + "k_uds", "1",
            [](double udf, double below) {
              return Values{udf + below, 1, 1};
            },
            fit);
      }
    }
  }
}

void set_dhr(const Layout& layout, const formats::BrdfTable& table, const Solution& solution,
             const Posterior& posterior, const Options& options, FitResult& fit) {
  std::set<double> angles(options.dhr_theta_i_deg.begin(), options.dhr_theta_i_deg.end());
  if (angles.empty()) {
    angles.insert(0);
    for (std::size_t i = 0; i < table.points.size(); ++i) {
      // An aligned table may have the normal a little to the other side.
      if (table.points.used[i] != 0) angles.insert(std::abs(table.points.theta_i_deg[i]));
    }
    if (angles.size() > most_incidences) {
      const std::vector<double> all(angles.begin(), angles.end());
      angles.clear();
      for (std::size_t i = 0; i < most_incidences; ++i) {
        angles.insert(all[i * (all.size() - 1) / (most_incidences - 1)]);
      }
    }
  }
  for (std::size_t w = 0; w < fit.wavelengths_nm.size(); ++w) {
    for (const double angle : angles) fit.dhr.push_back({fit.wavelengths_nm[w], angle});
  }
  for_each_index(fit.dhr.size(), options.threads, [&](std::size_t i) {
    FitResult::Dhr& entry = fit.dhr[i];
    const std::size_t w = i / angles.size();
    const double theta_i = optics::radians(entry.theta_i_deg);
    const std::vector<double> values = layout.values(w, solution.x);
    entry.mirror =
        brdf::mirror_dhr(layout.model(), values, layout.wavelength_um(w), theta_i).unpolarized;
    entry.value = brdf::dhr(layout.model(), values, layout.wavelength_um(w), theta_i).unpolarized +
                  entry.mirror;
    const Interval interval =
        posterior.interval(entry.value, dhr_gradient(layout, solution.x, w, theta_i));
    entry.lo = std::max(interval.lo, 0.0);
    entry.hi = interval.hi;
  });
}

void set_covariance(const Layout& layout, const Solution& solution, const Posterior& posterior,
                    FitResult& fit) {
  FitResult::Covariance& out = fit.covariance;
  const auto at = [](std::size_t i) { return static_cast<Eigen::Index>(i); };
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const Coordinate& k = layout.free()[i].coordinate;
    const double slope_i = k.slope(solution.x[i]);
    out.names.push_back(layout.label(i));
    for (std::size_t j = 0; j < layout.size(); ++j) {
      const double slope_j = layout.free()[j].coordinate.slope(solution.x[j]);
      out.values.push_back(slope_i * slope_j * posterior.covariance()(at(i), at(j)));
    }
    out.coordinates.push_back(
        {scale_name(k.scale), solution.x[i], k.lo_x(), k.hi_x(), posterior.centre()[at(i)]});
  }
  for (const Hinge& hinge : posterior.hinges()) {
    out.orders.push_back({hinge.value, {hinge.slope.begin(), hinge.slope.end()}});
  }
}

}  // namespace umov::invert
