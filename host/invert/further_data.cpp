#include "host/invert/further_data.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <cstdio>
#include <set>
#include <utility>

#include "host/formats/order_statistics.hpp"
#include "host/formats/scan_table.hpp"
#include "host/invert/normal_equations.hpp"
#include "host/optics/angles.hpp"

namespace umov::invert {
namespace {

using formats::FitResult;

/// Confusions that are looked into; the rest would only repeat them.
constexpr std::size_t most_sentences = 8;
/// A measurement is of help where it leaves less than this share of the standard deviation that as
/// many more points of the present kind would leave.
constexpr double worthwhile = 0.75;

std::string text(const char* format, auto... values) {
  char out[256];
  std::snprintf(out, sizeof out, format, values...);
  return out;
}

bool same(const Channel& a, const Channel& b) {
  for (std::size_t i = 0; i < a.weight.size(); ++i) {
    if (std::abs(a.weight[i] - b.weight[i]) > 1e-9) return false;
  }
  return true;
}

/// What the scan has: channels, incidences, whether it leaves the plane of incidence.
struct Extent {
  std::vector<Channel> channels;
  std::set<double> theta_i_deg;
  bool polarised = false, diagonal = false, out_of_plane = false;
};

Extent extent_of(const Observations& data) {
  Extent out;
  for (const Spectrum& spectrum : data.spectra) {
    for (const Site& site : spectrum.sites) {
      const auto& g = site.view.geometry;
      out.theta_i_deg.insert(std::round(optics::degrees(g.theta_i) * 100) / 100);
      out.out_of_plane =
          out.out_of_plane || std::abs(std::sin(g.theta_r) * std::sin(g.phi_r)) > 0.01;
    }
    for (const Channel& channel : spectrum.channels) {
      const bool known = std::any_of(out.channels.begin(), out.channels.end(),
                                     [&](const Channel& c) { return same(c, channel); });
      if (!known) out.channels.push_back(channel);
    }
  }
  for (const Channel& channel : out.channels) {
    for (std::size_t i = 1; i < 16; ++i) {
      if (std::abs(channel.weight[i]) > 1e-6) out.polarised = true;
    }
    // Elements with U of source or analyser.
    for (const std::size_t i : {2U, 6U, 8U, 9U, 10U}) {
      if (std::abs(channel.weight[i]) > 1e-6) out.diagonal = true;
    }
  }
  return out;
}

struct Candidate {
  std::string data;
  std::vector<std::pair<View, std::vector<Channel>>> sites;  ///< at every wavelength
};

std::vector<Candidate> candidates_for(const Observations& data, const Extent& extent) {
  std::vector<Candidate> out;
  const auto at_the_same_directions = [&](std::string name, std::vector<Channel> channels) {
    Candidate candidate{std::move(name), {}};
    for (const Site& site : data.spectra.front().sites) {
      candidate.sites.push_back({{site.view.geometry}, channels});
    }
    out.push_back(std::move(candidate));
  };
  if (!extent.polarised) {
    at_the_same_directions(
        "channels PP, PS, SP and SS in the same directions",
        {channel_of(0, 0), channel_of(0, 90), channel_of(90, 0), channel_of(90, 90)});
  } else if (!extent.diagonal) {
    at_the_same_directions(
        "channels at +45 and -45 degrees in the same directions",
        {channel_of(45, 45), channel_of(45, -45), channel_of(0, 45), channel_of(90, 45)});
  }
  if (!extent.out_of_plane) {
    Candidate candidate{"rows out of the plane of incidence", {}};
    for (const double theta_i : extent.theta_i_deg) {
      for (const double phi : {45.0, 90.0, 135.0}) {
        for (double theta_r = 10; theta_r <= 75; theta_r += 5) {
          candidate.sites.push_back(
              {{{optics::radians(theta_i), optics::radians(theta_r), optics::radians(phi)}},
               extent.channels});
        }
      }
    }
    out.push_back(std::move(candidate));
  }
  double incidence = 0, distance = 0;
  for (const double theta_i : {15.0, 30.0, 45.0, 60.0, 75.0}) {
    double nearest = 90;
    for (const double known : extent.theta_i_deg) {
      nearest = std::min(nearest, std::abs(theta_i - known));
    }
    if (nearest > distance) {
      distance = nearest;
      incidence = theta_i;
    }
  }
  if (distance >= 10) {
    Candidate candidate{text("rows at an incidence of %g degrees", incidence), {}};
    for (double theta_r = -80; theta_r <= 80; theta_r += 2.5) {
      candidate.sites.push_back(
          {{{optics::radians(incidence), optics::radians(theta_r), 0.0}}, extent.channels});
    }
    out.push_back(std::move(candidate));
  }
  return out;
}

/// Independent noise as it is: a floor, and a share of the signal.
struct Noise {
  double floor = 0, share = 0;
  double operator()(double f) const { return std::hypot(floor, share * f); }
};

Noise noise_of(const Spectrum& spectrum) {
  std::vector<double> shares, rest;
  for (const Observation& point : spectrum.points) {
    if (point.brdf_per_sr > 3 * point.sigma) shares.push_back(point.sigma / point.brdf_per_sr);
  }
  Noise noise;
  // The brightest points have the least relative noise, next to no floor in it.
  if (!shares.empty()) noise.share = formats::quantile(shares, 0.05);
  for (const Observation& point : spectrum.points) {
    const double signal = noise.share * point.brdf_per_sr;
    rest.push_back(std::sqrt(std::max(point.sigma * point.sigma - signal * signal, 0.0)));
  }
  noise.floor = formats::median(rest);
  return noise;
}

Observations hypothetical(const Problem& problem, const Solution& solution,
                          const Candidate& candidate) {
  const Layout& layout = problem.layout;
  Observations out;
  for (std::size_t w = 0; w < problem.data.spectra.size(); ++w) {
    const Noise noise = noise_of(problem.data.spectra[w]);
    const std::vector<double> values = layout.values(w, solution.x);
    Spectrum spectrum;
    spectrum.wavelength_nm = problem.data.spectra[w].wavelength_nm;
    for (const auto& [view, channels] : candidate.sites) {
      std::vector<double> f(channels.size());
      evaluate_channels(layout.model(), values, {}, layout.wavelength_um(w), view, channels, f, {});
      spectrum.sites.push_back({view, spectrum.points.size(), channels.size()});
      for (std::size_t c = 0; c < channels.size(); ++c) {
        Observation point;
        point.brdf_per_sr = f[c];
        point.sigma = noise(f[c]);
        spectrum.points.push_back(point);
        spectrum.channels.push_back(channels[c]);
      }
    }
    out.spectra.push_back(std::move(spectrum));
  }
  return out;
}

/// Inverse of the information, limits counting as knowledge of their width.
Eigen::MatrixXd covariance_of(const Layout& layout, Eigen::MatrixXd information) {
  const Eigen::Index n = information.rows();
  Eigen::VectorXd unit(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    const Coordinate& k = layout.free()[static_cast<std::size_t>(i)].coordinate;
    information(i, i) += 1 / ((k.hi_x() - k.lo_x()) * (k.hi_x() - k.lo_x()));
    unit[i] = 1 / std::sqrt(information(i, i));
  }
  const Eigen::MatrixXd scaled = unit.asDiagonal() * information * unit.asDiagonal();
  return unit.asDiagonal() * scaled.ldlt().solve(Eigen::MatrixXd::Identity(n, n)) *
         unit.asDiagonal();
}

Eigen::MatrixXd information_of(const Problem& problem, const Solution& solution,
                               const Observations& data, const Weighting& weighting,
                               const Priors& priors) {
  return normal_equations({problem.layout, data, priors, weighting}, solution.x, {}).curvature;
}

/// What the sentences are about: a pair that stands in for one another, or one open number.
struct Confusion {
  std::vector<std::size_t> members;
};

std::vector<Confusion> confusions(const Layout& layout, const FitResult& fit) {
  std::vector<Confusion> out;
  const auto free_of = [&](const std::string& name, const std::optional<double>& nm) {
    std::string label = name;
    if (nm) label += " " + wavelength_text(*nm) + " nm";
    for (std::size_t i = 0; i < layout.size(); ++i) {
      if (layout.label(i) == label) return i;
    }
    return layout.size();
  };
  for (const auto& pair : fit.correlations) {
    const std::size_t a = free_of(pair.first, pair.first_wavelength_nm);
    const std::size_t b = free_of(pair.second, pair.second_wavelength_nm);
    if (a < layout.size() && b < layout.size()) out.push_back({{a, b}});
  }
  for (std::size_t i = 0; i < layout.size(); ++i) {
    const FreeParameter& free = layout.free()[i];
    const auto& e = fit.parameters[free.parameter].at(free.wavelength.value_or(0));
    const bool paired = std::any_of(out.begin(), out.end(), [&](const Confusion& c) {
      return std::find(c.members.begin(), c.members.end(), i) != c.members.end();
    });
    if (!e.identifiable && e.at_bound.empty() && !paired) out.push_back({{i}});
  }
  if (out.size() > most_sentences) out.resize(most_sentences);
  return out;
}

/// "k_udf and k_uds at 532 nm".
std::string names_text(const Layout& layout, const std::vector<std::size_t>& members) {
  if (members.size() == 2) {
    const FreeParameter &a = layout.free()[members[0]], &b = layout.free()[members[1]];
    if (a.wavelength && a.wavelength == b.wavelength) {
      return layout.parameter_name(members[0]) + " and " + layout.parameter_name(members[1]) +
             " at " + wavelength_text(layout.wavelengths_nm()[*a.wavelength]) + " nm";
    }
    return layout.label(members[0]) + " and " + layout.label(members[1]);
  }
  return layout.label(members.front());
}

}  // namespace

void describe_further_data(const Problem& problem, const Solution& solution, FitResult& fit) {
  const Layout& layout = problem.layout;
  const std::vector<Confusion> open = confusions(layout, fit);
  if (open.empty()) return;
  const Extent extent = extent_of(problem.data);
  const std::vector<Candidate> candidates = candidates_for(problem.data, extent);
  const Weighting weighting{.scale = problem.weighting.scale};
  const Eigen::MatrixXd known =
      information_of(problem, solution, problem.data, weighting, problem.priors);
  const Eigen::MatrixXd now = covariance_of(layout, known);
  std::vector<Eigen::MatrixXd> then;
  std::vector<std::size_t> points;
  for (const Candidate& candidate : candidates) {
    const Observations more = hypothetical(problem, solution, candidate);
    points.push_back(more.size());
    then.push_back(covariance_of(
        layout, known + information_of(problem, solution, more, weighting, Priors())));
  }
  std::string hopeless;
  const auto present = static_cast<double>(problem.data.size());
  for (const Confusion& confusion : open) {
    std::vector<std::string> labels;
    for (const std::size_t i : confusion.members) labels.push_back(layout.label(i));
    std::string gains;
    for (std::size_t c = 0; c < candidates.size(); ++c) {
      FitResult::Remedy remedy;
      remedy.parameters = labels;
      remedy.data = candidates[c].data;
      remedy.points = points[c];
      std::size_t best = 0;
      for (std::size_t m = 0; m < confusion.members.size(); ++m) {
        const auto i = static_cast<Eigen::Index>(confusion.members[m]);
        const double ratio = std::sqrt(then[c](i, i) / now(i, i));
        if (ratio < remedy.sigma_ratio) {
          remedy.sigma_ratio = ratio;
          best = m;
        }
      }
      if (confusion.members.size() == 2) {
        const auto a = static_cast<Eigen::Index>(confusion.members[0]);
        const auto b = static_cast<Eigen::Index>(confusion.members[1]);
        const auto r = [&](const Eigen::MatrixXd& m) {
          return m(a, b) / std::sqrt(m(a, a) * m(b, b));
        };
        remedy.correlation_now = r(now);
        remedy.correlation_then = r(then[c]);
      }
      const double repeated = std::sqrt(present / (present + static_cast<double>(points[c])));
      if (remedy.sigma_ratio < worthwhile * repeated) {
        gains += (gains.empty() ? "" : "; ") + remedy.data +
                 text(" (%zu points) would make ", remedy.points) + labels[best] +
                 text(" %.2g times as sure", 1 / remedy.sigma_ratio) +
                 text(" (the present rows again: %.2g times)", 1 / repeated);
        if (remedy.correlation_then) gains += text(", correlation %.3f", *remedy.correlation_then);
      }
      fit.remedies.push_back(std::move(remedy));
    }
    const std::string names = names_text(layout, confusion.members);
    if (gains.empty()) {
      hopeless += (hopeless.empty() ? "" : "; ") + names;
    } else {
      fit.identifiability.push_back("to tell " + names + ": " + gains);
    }
  }
  if (hopeless.empty() || candidates.empty()) return;
  std::string tried;
  for (std::size_t c = 0; c < candidates.size(); ++c) {
    tried += (c == 0 ? "" : c + 1 == candidates.size() ? " nor " : ", ") + candidates[c].data;
  }
  fit.identifiability.push_back((candidates.size() > 1 ? "neither " : "not even ") + tried +
                                " would do more than the present rows again for " + hopeless);
}

}  // namespace umov::invert
