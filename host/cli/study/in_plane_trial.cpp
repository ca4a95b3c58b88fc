#include "host/cli/study/in_plane_trial.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "host/brdf/model.hpp"
#include "host/errors/error.hpp"
#include "host/formats/order_statistics.hpp"
#include "host/formats/scan_table.hpp"
#include "host/invert/fitted_model.hpp"
#include "host/invert/invert.hpp"
#include "host/invert/neighbours.hpp"
#include "host/invert/row_selection.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/frames.hpp"

namespace umov::study {
namespace {

constexpr double normal_incidence_deg = 0.5;
constexpr std::size_t joint_stride = 7, joint_first = 1;
constexpr int joint_starts = 6, lone_starts = 2;

formats::BrdfTable in_plane_rows(const formats::BrdfTable& table, const std::string& wavelengths) {
  std::vector<invert::RowCondition> conditions = {invert::parse_row_condition("in-plane")};
  if (!wavelengths.empty())
    conditions.push_back(invert::parse_row_condition("wavelength_nm=" + wavelengths));
  const auto selected = invert::select_rows(table, conditions);
  formats::BrdfTable kept;
  kept.keys = selected.keys;
  const auto& from = selected.points;
  auto& to = kept.points;
  for (std::size_t i = 0; i < from.size(); ++i) {
    if (from.used[i] == 0) continue;
    to.theta_i_deg.push_back(from.theta_i_deg[i]);
    to.theta_r_deg.push_back(from.theta_r_deg[i]);
    to.phi_r_deg.push_back(from.phi_r_deg[i]);
    to.wavelength_nm.push_back(from.wavelength_nm[i]);
    to.polarizer_deg.push_back(from.polarizer_deg[i]);
    to.analyzer_deg.push_back(from.analyzer_deg[i]);
    to.brdf_per_sr.push_back(from.brdf_per_sr[i]);
    to.brdf_u.push_back(from.brdf_u[i]);
    to.used.push_back(1);
  }
  return kept;
}

void add_point(TrialPoints& points, double wavelength_nm, double brdf_per_sr, double relative_u,
               const Direction& direction) {
  const std::size_t i = points.size();
  points.wavelength_nm.push_back(wavelength_nm);
  points.brdf_per_sr.push_back(brdf_per_sr);
  points.relative_u.push_back(relative_u);
  points.direction.push_back(direction);
  if (!(brdf_per_sr > 0)) return;
  if (direction.in_plane) {
    points.in_plane.push_back(i);
  } else if (direction.theta_i_deg > normal_incidence_deg) {
    points.judged.push_back(i);
  }
}

/// What in-plane points far from the lobe scatter by, 1/sr: each against the plane through its
/// neighbours in (θh, θd), where both ways of the light through the sample stand side by side.
/// Median size, as one sigma of a normal distribution. By wavelength.
std::map<double, double> in_plane_scatter(const TrialPoints& points) {
  constexpr double off_lobe_deg = 25, median_to_sigma = 1.4826;
  std::map<double, std::vector<std::size_t>> off_lobe;
  for (const std::size_t i : points.in_plane) {
    if (points.direction[i].half_deg > off_lobe_deg) off_lobe[points.wavelength_nm[i]].push_back(i);
  }
  std::map<double, double> out;
  for (const auto& [nm, list] : off_lobe) {
    std::vector<double> sizes;
    for (const std::size_t i : list) {
      HalfAnglePlane others;
      for (const std::size_t j : list)
        if (j != i) others.add(points.direction[j], points.brdf_per_sr[j]);
      if (!others.empty())
        sizes.push_back(std::abs(points.brdf_per_sr[i] - others.at(points.direction[i])));
    }
    out[nm] = median_to_sigma * formats::median(sizes);
  }
  return out;
}

std::vector<double> wavelengths_of(const TrialPoints& points) {
  std::vector<double> list = points.wavelength_nm;
  std::sort(list.begin(), list.end());
  list.erase(std::unique(list.begin(), list.end()), list.end());
  return list;
}

Attempt::Kind kind_of(const brdf::Model& model) {
  std::size_t lobes = 0;
  for (const auto& part : model.components()) {
    switch (part.kind) {
      case brdf::Kind::lambertian:
      case brdf::Kind::nef:
      case brdf::Kind::subsurface:
      case brdf::Kind::single_scatter:
        break;
      case brdf::Kind::li_torrance:
        lobes += 2;  // off the surface, and scattered forward below it
        break;
      default:
        ++lobes;
    }
  }
  return lobes == 0   ? Attempt::Kind::no_lobe
         : lobes == 1 ? Attempt::Kind::one_lobe
                      : Attempt::Kind::several;
}

invert::Options fit_options(const std::string& model, const Options& options, int starts) {
  invert::Options own;
  own.model = model;
  own.starts = starts;
  own.seed = options.seed;
  own.threads = 1;
  own.held_out = own.dhr = false;
  if (options.keep_going) {
    own.progress = [&options](double, const std::string&) {
      if (!options.keep_going()) throw Stopped{};
    };
  }
  return own;
}

invert::View view_of(const Direction& d) {
  return {.geometry = {optics::radians(d.theta_i_deg), optics::radians(d.theta_r_deg),
                       optics::radians(d.phi_r_deg)}};
}

/// Fills what the fit says of all points, or only of those at its first wavelength.
void foretell(const Trial& trial, const formats::FitResult& fit, bool all_wavelengths,
              Attempt& out) {
  const invert::FittedModel model(fit);
  const auto& points = trial.points;
  for (std::size_t i = 0; i < points.size(); ++i) {
    if (!all_wavelengths && points.wavelength_nm[i] != fit.wavelengths_nm.front()) continue;
    const std::size_t w = model.wavelength(points.wavelength_nm[i]);
    const invert::View view = view_of(points.direction[i]);
    const double f11 = model.value(w, view, invert::channel_unpolarized());
    out.foretold[i] = f11;
    if (points.normalised.empty()) continue;
    for (std::size_t e = 0; e < 16; ++e) {
      invert::Channel channel;
      channel.weight[e] = 1;
      out.normalised[i][e] = f11 > 0 ? model.value(w, view, channel) / f11 : 0.0;
    }
  }
}

void add_remainder(const Trial& trial, Attempt& out) {
  const auto& points = trial.points;
  std::map<double, HalfAnglePlane> remainder;
  for (const std::size_t i : points.in_plane) {
    if (out.foretold[i] > 0)
      remainder[points.wavelength_nm[i]].add(points.direction[i],
                                             std::log(points.brdf_per_sr[i] / out.foretold[i]));
  }
  out.with_remainder = out.foretold;
  for (std::size_t i = 0; i < points.size(); ++i) {
    const auto at = remainder.find(points.wavelength_nm[i]);
    if (at != remainder.end() && !at->second.empty())
      out.with_remainder[i] *= std::exp(at->second.at(points.direction[i]));
  }
}

void fit_model(const Trial& trial, const Options& options, Attempt& out) {
  const auto joint = invert::invert(trial.joint, fit_options(out.name, options, joint_starts));
  out.parameters = joint.covariance.names.size();
  const auto n = static_cast<double>(joint.points);
  out.in_plane_bic = 2 * n * std::log(std::max(joint.interval_scale, 1e-6)) +
                     static_cast<double>(out.parameters) * std::log(n);
  if (trial.alone.empty()) {
    foretell(trial, joint, true, out);
    return;
  }
  auto lone = fit_options(out.name, options, lone_starts);
  for (const auto& parameter : joint.parameters) {
    if (parameter.shared && !parameter.fixed)
      lone.fix.push_back({parameter.name, std::nullopt, parameter.at(0).value});
  }
  for (const auto& table : trial.alone) {
    if (options.keep_going && !options.keep_going()) throw Stopped{};
    foretell(trial, invert::invert(table, lone), false, out);
  }
}

/// The measured matrices in the basis of the scattering plane, which in plane is the one they have;
/// interpolated there and turned to the bases of the direction asked for.
class MatrixPlane {
 public:
  void add(const Direction& direction, const std::array<double, 16>& normalised) {
    for (std::size_t e = 0; e < 16; ++e) elements_[e].add(direction, normalised[e]);
  }
  std::array<double, 16> at(const Direction& d) const {
    const auto in = optics::incident_beam(optics::radians(d.theta_i_deg));
    const auto out =
        optics::exit_beam(optics::radians(d.theta_r_deg), optics::radians(d.phi_r_deg));
    optics::Mueller<double> m(0.0);
    for (int e = 0; e < 16; ++e)
      optics::set_element(m, e / 4, e % 4, elements_[static_cast<std::size_t>(e)].at(d));
    m = optics::to_beam_bases(m, in, out, optics::scattering_plane_normal(in, out));
    std::array<double, 16> turned{};
    for (int e = 0; e < 16; ++e)
      turned[static_cast<std::size_t>(e)] = optics::element(m, e / 4, e % 4);
    return turned;
  }

 private:
  std::array<HalfAnglePlane, 16> elements_;
};

/// The nearest four points, as `umov invert --compare interpolation` takes them.
std::vector<double> nearest(const TrialPoints& points) {
  formats::BrdfTable table;
  auto& p = table.points;
  std::vector<bool> known(points.size(), false);
  const std::vector<bool> wanted(points.size(), true);
  for (std::size_t i = 0; i < points.size(); ++i) {
    p.theta_i_deg.push_back(points.direction[i].theta_i_deg);
    p.theta_r_deg.push_back(points.direction[i].theta_r_deg);
    p.phi_r_deg.push_back(points.direction[i].phi_r_deg);
    p.polarizer_deg.push_back(formats::open_axis);
    p.analyzer_deg.push_back(formats::open_axis);
  }
  p.wavelength_nm = points.wavelength_nm;
  p.brdf_per_sr = points.brdf_per_sr;
  p.brdf_u.assign(points.size(), 1);
  p.used.assign(points.size(), 1);
  for (const std::size_t i : points.in_plane) known[i] = true;
  return invert::from_neighbours(table, known, wanted);
}

}  // namespace

const char* kind_name(Attempt::Kind kind) {
  constexpr std::array names = {"no lobe", "one lobe", "several lobes", "interpolation"};
  return names[static_cast<std::size_t>(kind)];
}

Trial polarimeter_trial(const std::string& name, const formats::MuellerTable& table) {
  Trial trial;
  trial.name = name;
  for (std::size_t n = 0; n < table.size(); ++n) {
    const auto& m = table.mueller[n];
    add_point(trial.points, table.wavelength_nm[n], m[0], table.m00_relative_u[n],
              direction_at(table.theta_i_deg[n], table.theta_r_deg[n], table.phi_r_deg[n]));
    std::array<double, 16> normalised = m;
    for (double& element : normalised) element /= m[0];
    trial.points.normalised.push_back(normalised);
  }
  trial.joint = in_plane_rows(formats::independent_channels(table), "");
  return trial;
}

Trial unpolarised_trial(const std::string& name, const formats::BrdfTable& table) {
  Trial trial;
  trial.name = name;
  const auto& p = table.points;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const bool used = p.used[i] != 0 && p.brdf_per_sr[i] > 0;
    add_point(trial.points, p.wavelength_nm[i], used ? p.brdf_per_sr[i] : 0.0,
              used ? p.brdf_u[i] / p.brdf_per_sr[i] : 0.0,
              direction_at(p.theta_i_deg[i], p.theta_r_deg[i], p.phi_r_deg[i]));
  }
  trial.scatter_per_sr = in_plane_scatter(trial.points);
  formats::BrdfTable widened = table;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const auto scatter = trial.scatter_per_sr.find(p.wavelength_nm[i]);
    if (scatter == trial.scatter_per_sr.end()) continue;
    double& u = widened.points.brdf_u[i];
    u = std::hypot(u, scatter->second);
    if (trial.points.brdf_per_sr[i] > 0)
      trial.points.relative_u[i] = u / trial.points.brdf_per_sr[i];
  }
  const auto wavelengths = wavelengths_of(trial.points);
  std::string joint;
  for (std::size_t w = 0; w < wavelengths.size(); ++w) {
    const std::string text = std::to_string(wavelengths[w]);
    if (w % joint_stride == joint_first) joint += (joint.empty() ? "" : ",") + text;
    trial.alone.push_back(in_plane_rows(widened, text));
  }
  trial.joint = in_plane_rows(widened, joint);
  return trial;
}

std::vector<std::string> trial_models() {
  // The costly ones first, so that no thread ends long after the others.
  return {"li-torrance+single-scatter+subsurface",
          "li-torrance",
          "microfacet+microfacet+nef",
          "microfacet+microfacet+lambertian",
          "ggx+ggx+nef",
          "ggx+ggx+subsurface",
          "ggx+ggx+phong+subsurface",
          "microfacet:slopes=exponential+ggx+subsurface",
          "ggx+phong+subsurface",
          "microfacet+single-scatter+subsurface",
          "he-torrance+nef",
          "beard-maxwell",
          "ggx+nef",
          "ggx+lambertian",
          "ggx+subsurface",
          "microfacet+nef",
          "microfacet+lambertian",
          "microfacet+subsurface",
          "microfacet:slopes=exponential+subsurface",
          "ward+lambertian",
          "phong+lambertian",
          "phong+subsurface",
          "single-scatter+subsurface",
          "subsurface",
          "nef",
          "lambertian"};
}

Attempt try_model(const Trial& trial, const std::string& model, const Options& options) {
  Attempt out;
  out.name = model;
  out.kind = kind_of(brdf::Model::by_name(model));
  out.foretold.assign(trial.points.size(), std::nan(""));
  if (!trial.points.normalised.empty()) out.normalised.resize(trial.points.size());
  try {
    fit_model(trial, options, out);
    add_remainder(trial, out);
  } catch (const Error& error) {
    out.failure = error.what();
  }
  return out;
}

std::vector<Attempt> interpolations(const Trial& trial) {
  const auto& points = trial.points;
  std::map<double, HalfAnglePlane> planes;
  std::map<double, MatrixPlane> matrices;
  std::map<double, MirrorAngleCurves> curves;
  for (const std::size_t i : points.in_plane) {
    const double nm = points.wavelength_nm[i], value = std::log(points.brdf_per_sr[i]);
    planes[nm].add(points.direction[i], value);
    curves[nm].add(points.direction[i], value);
    if (!points.normalised.empty()) matrices[nm].add(points.direction[i], points.normalised[i]);
  }
  std::vector<Attempt> list(3);
  list[0].name = "(θh, θd), four nearest";
  list[1].name = "(θh, θd), local plane";
  list[2].name = "(θi, angle to mirror direction)";
  list[0].foretold = nearest(points);
  for (std::size_t i = 0; i < points.size(); ++i) {
    const double nm = points.wavelength_nm[i];
    const bool known = planes.contains(nm);
    list[1].foretold.push_back(known ? std::exp(planes.at(nm).at(points.direction[i]))
                                     : std::nan(""));
    list[2].foretold.push_back(known ? std::exp(curves.at(nm).at(points.direction[i]))
                                     : std::nan(""));
    if (!points.normalised.empty() && known)
      list[1].normalised.push_back(matrices.at(nm).at(points.direction[i]));
  }
  for (Attempt& attempt : list) attempt.kind = Attempt::Kind::interpolation;
  return list;
}

}  // namespace umov::study
