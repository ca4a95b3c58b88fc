#include "host/invert/identifiability.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <numeric>

namespace umov::invert {
namespace {

constexpr double confusable = 0.95;
/// An interval wider than this share of the allowed range says that the data hardly speak.
constexpr double vague_share = 0.25;
/// Below this share a parameter is known, whatever it is correlated with.
constexpr double clear_share = 0.025;
/// A limit within so many sigma may have shaped the estimate.
constexpr double near_limit_sigmas = 4;

std::string number_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3g", value);
  return text;
}

std::string precise_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.5g", value);
  return text;
}

std::string signed_text(double value) {
  char text[32];
  std::snprintf(text, sizeof text, "%.3f", value);
  return text;
}

std::string interval_text(const formats::Estimate& e) {
  return number_text(e.lo) + " … " + number_text(e.hi);
}

std::string at_text(const FreeParameter& a, const FreeParameter& b, const Layout& layout) {
  if (!a.wavelength && !b.wavelength) return "";
  const auto text = [&](const FreeParameter& p) {
    return wavelength_text(layout.wavelengths_nm()[*p.wavelength]) + " nm";
  };
  if (!a.wavelength) return " at " + text(b);
  if (!b.wavelength || *a.wavelength == *b.wavelength) return " at " + text(a);
  return "";
}

formats::Estimate* estimate_of(const Layout& layout, formats::FitResult& fit, std::size_t free) {
  const FreeParameter& parameter = layout.free()[free];
  return &fit.parameters[parameter.parameter].estimates[parameter.wavelength.value_or(0)];
}

/// The derived quantity of both parameters, for the sentence, where the scan knows it at least
/// twice as well as either of them.
std::string combination_text(const Layout& layout, const Eigen::MatrixXd& covariance,
                             const formats::FitResult& fit, std::size_t a, std::size_t b) {
  const auto i = static_cast<Eigen::Index>(a), j = static_cast<Eigen::Index>(b);
  const std::string& first = layout.parameter_name(a);
  const std::string& second = layout.parameter_name(b);
  const bool slope = bare_name(first) == "sigma_um" && bare_name(second) == "tau_um";
  // In logarithms the slope is the difference of its two parameters.
  const double sign = slope ? -1 : 1;
  const double together = covariance(i, i) + covariance(j, j) + 2 * sign * covariance(i, j);
  if (!(together < 0.25 * std::min(covariance(i, i), covariance(j, j)))) return "";
  const std::size_t wavelength =
      layout.free()[a].wavelength.value_or(layout.free()[b].wavelength.value_or(0));
  for (const formats::FitParameter& derived : fit.derived) {
    const std::string part = first.substr(0, first.size() - bare_name(first).size());
    if (derived.name != (slope ? part + "slope_2sigma_over_tau" : first + "+" + second)) continue;
    const formats::Estimate& e = derived.at(wavelength);
    return std::string("; ") + (slope ? "the slope 2 sigma/tau" : "their sum") + " = " +
           precise_text(e.value) + " ± " + number_text(1.96 * e.standard_error) + " is determined";
  }
  return "";
}

/// Half the 95 % interval as a share of what the parameter may be. Widths hardly depend on the
/// noise drawn, so judging by them does not pick lucky values. For kappa, whose allowed range
/// reaches to the best metals, the share of 1 in kappa².
double share_of_range(const Layout& layout, const Posterior& posterior, std::size_t free) {
  const Coordinate& k = layout.free()[free].coordinate;
  const double span = k.hi_x() - k.lo_x();
  return 1.96 * posterior.sigma(free) / (k.scale == Scale::square ? std::min(1.0, span) : span);
}

/// The singular vector of the scaled Jacobian that the data know least, in words: the widest axis
/// of the parameters' correlation, where it is much wider than independent parameters would make
/// it. Vague parameters, which are told one by one, are left out.
std::string weakest_combination(const Layout& layout, const Eigen::MatrixXd& covariance,
                                const std::vector<bool>& vague) {
  std::vector<Eigen::Index> members;
  for (std::size_t i = 0; i < vague.size(); ++i) {
    if (!vague[i]) members.push_back(static_cast<Eigen::Index>(i));
  }
  if (members.size() < 2) return "";
  const Eigen::MatrixXd part = covariance(members, members);
  const Eigen::VectorXd unit = part.diagonal().cwiseSqrt();
  const Eigen::MatrixXd correlation =
      unit.cwiseInverse().asDiagonal() * part * unit.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
  const Eigen::Index last = correlation.rows() - 1;
  // Eigenvalues of the correlation are squares of inverse singular values of the scaled Jacobian.
  const double spread =
      std::sqrt(eigen.eigenvalues()[last] / std::max(eigen.eigenvalues()[0], 1e-300));
  if (spread < 10) return "";
  Eigen::VectorXd axis = eigen.eigenvectors().col(last);
  Eigen::Index largest = 0;
  axis.cwiseAbs().maxCoeff(&largest);
  if (axis[largest] < 0) axis = -axis;
  std::string terms;
  for (Eigen::Index i = 0; i < axis.size(); ++i) {
    if (std::abs(axis[i]) < 0.3) continue;
    terms += (terms.empty() ? ""
              : axis[i] < 0 ? " - "
                            : " + ") +
             (terms.empty() && axis[i] < 0 ? std::string("-") : std::string()) +
             number_text(std::abs(axis[i])) + " " +
             layout.label(static_cast<std::size_t>(members[static_cast<std::size_t>(i)]));
  }
  return "the combination that the data know least, each in units of its own uncertainty, is " +
         terms + ": " + number_text(spread) + " times wider than the best known one";
}

/// "unpolarised data in the plane of incidence".
std::string kind_of(const Observations& data) {
  bool polarised = false, out_of_plane = false;
  for (const Spectrum& spectrum : data.spectra) {
    for (const Channel& channel : spectrum.channels) {
      for (std::size_t i = 1; i < 16; ++i) polarised = polarised || channel.weight[i] != 0;
    }
    for (const Site& site : spectrum.sites) {
      const auto& g = site.view.geometry;
      out_of_plane = out_of_plane || std::abs(std::sin(g.theta_r) * std::sin(g.phi_r)) > 0.01;
    }
  }
  return std::string(polarised ? "polarised" : "unpolarised") + " data " +
         (out_of_plane ? "in and out of" : "in") + " the plane of incidence";
}

}  // namespace

void describe_identifiability(const Layout& layout, const Observations& data,
                              const Posterior& posterior, formats::FitResult& fit) {
  const std::string kind = kind_of(data);
  const Eigen::MatrixXd& covariance = posterior.covariance_given_calibration();
  const std::size_t n = layout.size();
  std::vector<bool> paired(n, false), vague(n, false);

  for (std::size_t i = 0; i < n; ++i) {
    formats::Estimate& e = *estimate_of(layout, fit, i);
    const Coordinate& k = layout.free()[i].coordinate;
    const double x = k.to_x(e.value), reach = near_limit_sigmas * posterior.sigma(i);
    if (x - reach < k.lo_x() || x + reach > k.hi_x()) e.identifiable = false;
    vague[i] = share_of_range(layout, posterior, i) > vague_share &&
               k.to_x(e.hi) - k.to_x(e.lo) > vague_share * (k.hi_x() - k.lo_x());
    if (vague[i]) {
      e.identifiable = false;
      fit.identifiability.push_back(layout.label(i) +
                                    " is not determined by these data: anything in " +
                                    interval_text(e) + " fits");
    } else if (e.at_bound == "lower" || (e.lo <= k.lo && e.hi < k.hi)) {
      e.identifiable = false;
      fit.identifiability.push_back("for " + layout.label(i) +
                                    " the data give an upper limit only: below " +
                                    number_text(e.hi));
    } else if (e.at_bound == "upper" || (e.hi >= k.hi && e.lo > k.lo)) {
      e.identifiable = false;
      fit.identifiability.push_back("for " + layout.label(i) +
                                    " the data give a lower limit only: above " +
                                    number_text(e.lo));
    }
  }

  for (std::size_t i = 0; i < n; ++i) {
    for (std::size_t j = i + 1; j < n; ++j) {
      const auto a = static_cast<Eigen::Index>(i), b = static_cast<Eigen::Index>(j);
      const double r = covariance(a, b) / std::sqrt(covariance(a, a) * covariance(b, b));
      if (!(std::abs(r) > confusable)) continue;
      const FreeParameter &first = layout.free()[i], &second = layout.free()[j];
      formats::FitResult::Correlation pair;
      pair.first = layout.parameter_name(i);
      pair.second = layout.parameter_name(j);
      pair.coefficient = r;
      if (first.wavelength) pair.first_wavelength_nm = layout.wavelengths_nm()[*first.wavelength];
      if (second.wavelength)
        pair.second_wavelength_nm = layout.wavelengths_nm()[*second.wavelength];
      fit.correlations.push_back(pair);
      paired[i] = paired[j] = true;
      // An interval that is narrow all the same stands on its own.
      bool apart = true;
      for (const std::size_t member : {i, j}) {
        formats::Estimate& e = *estimate_of(layout, fit, member);
        if (share_of_range(layout, posterior, member) < clear_share) continue;
        e.identifiable = false;
        apart = false;
      }
      const std::string where = at_text(first, second, layout);
      const std::string names = where.empty() ? layout.label(i) + " and " + layout.label(j)
                                              : pair.first + " and " + pair.second;
      fit.identifiability.push_back(names +
                                    (apart ? " are hard to separate" : " cannot be separated") +
                                    where + " by " + kind + ": correlation " + signed_text(r) +
                                    combination_text(layout, covariance, fit, i, j));
    }
  }

  if (n >= 2) {
    if (const std::string weakest = weakest_combination(layout, covariance, vague);
        !weakest.empty()) {
      fit.identifiability.push_back(weakest);
    }
  }

  // Confusions of three and more: the widest principal axes in units of each parameter's own sigma,
  // where the pairs do not tell already.
  if (n >= 3) {
    const Eigen::VectorXd unit = covariance.diagonal().cwiseSqrt();
    const Eigen::MatrixXd correlation =
        unit.cwiseInverse().asDiagonal() * covariance * unit.cwiseInverse().asDiagonal();
    const Eigen::VectorXd determined = correlation.inverse().diagonal().cwiseInverse();
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(correlation);
    std::vector<bool> told(n, false);
    for (Eigen::Index axis = static_cast<Eigen::Index>(n) - 1;
         axis >= 0 && eigen.eigenvalues()[axis] > 2; --axis) {
      std::vector<std::size_t> members;
      for (std::size_t i = 0; i < n; ++i) {
        const auto row = static_cast<Eigen::Index>(i);
        // Less than a tenth of its variance is its own: the others can take its place.
        if (std::abs(eigen.eigenvectors()(row, axis)) > 0.3 && determined[row] < 0.1 && !vague[i]) {
          members.push_back(i);
        }
      }
      const bool news = std::any_of(members.begin(), members.end(),
                                    [&](std::size_t i) { return !paired[i] && !told[i]; });
      if (members.size() < 3 || !news) continue;
      std::string names;
      for (std::size_t m = 0; m < members.size(); ++m) {
        names += (m == 0                    ? ""
                  : m + 1 == members.size() ? " and "
                                            : ", ") +
                 layout.label(members[m]);
        told[members[m]] = true;
      }
      fit.identifiability.push_back(
          names + " are confounded together: each alone is known " +
          number_text(std::sqrt(1 / determined[static_cast<Eigen::Index>(members.front())])) +
          " times better once the others are");
    }
  }
}

}  // namespace umov::invert
