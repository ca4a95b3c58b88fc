#include "host/cli/study/contaminants.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "host/cli/study/contaminants_parts.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/mueller.hpp"
#include "host/surface/hidden_shares.hpp"

namespace umov::study {

const char* const band_text =
    "[surface]\nwavelengths_um = { from = 0.40, to = 0.90, step = 0.05 }\nperiod_um = 2000\n";

namespace {

surface::ReadSurface reader(const std::string& text) {
  return [text](const surface::Reading& reading) {
    return surface::surface_from_toml(text, "contaminants", reading);
  };
}

}  // namespace

trace::Result SurfaceBench::simulate(const std::string& text, double theta_i_deg,
                                     surface::Reading reading, std::uint64_t samples) {
  if (options_.keep_going && !options_.keep_going()) throw Stopped{};
  trace::Request request;
  request.theta_i = optics::radians(theta_i_deg);
  // Random numbers and lays of its own: with the same, errors of simulations would go together.
  const std::uint64_t own = std::uint64_t{1000 + done_} << 40;
  request.seed = options_.seed + own;
  reading.seed = surface::lay_seed(options_.seed, own);
  request.threads = options_.threads;
  request.samples = samples;
  request.progress = [&](const trace::Progress& p) {
    if (!options_.progress) return;
    options_.progress((static_cast<double>(done_) + p.done) / static_cast<double>(simulations_),
                      fmt::format("simulation {} of {}", done_ + 1, simulations_));
  };
  request.stop = [&] { return options_.keep_going && !options_.keep_going(); };
  const surface::Lays lays(reader(text), reading);
  trace::Result result =
      lays.simulate(trace::Hemisphere(18, 90, optics::radians(4.0)), request, launches_a_lay);
  if (request.stop()) throw Stopped{};
  ++done_;
  const trace::Ledger& ledger = result.ledger();
  rays_ += ledger.rays;
  for (std::size_t w = 0; w < bands; ++w) {
    lost_ = std::max(lost_, (ledger.lost[w] + ledger.below[w]) / ledger.launched[w]);
  }
  return result;
}

trace::Estimate SurfaceBench::hidden(const std::string& text, double theta_i_deg,
                                     std::uint64_t number) const {
  trace::Request how;
  how.seed = options_.seed + (number << 40);
  how.threads = options_.threads;
  how.samples = 1u << 19;
  const surface::Reading reading{.seed = surface::lay_seed(options_.seed, number << 40)};
  const surface::ReadSurface read = reader(text);
  trace::Estimate sum{0.0, 0.0};
  for (const trace::Estimate& e :
       surface::hidden_shares(read, reading, theta_i_deg, how, launches_a_lay)) {
    sum.mean += e.mean;
    sum.error = std::hypot(sum.error, e.error);
  }
  return sum;
}

std::vector<double> InPlane::times_cosine() const {
  std::vector<double> out;
  for (std::size_t i = 0; i < brdf.size(); ++i) {
    out.push_back(brdf[i] * std::cos(optics::radians(theta_deg[i])));
  }
  return out;
}

namespace {

trace::Estimate mean_of(const InPlane& plane, const std::vector<double>& value,
                        const std::vector<double>& error, double low, double high) {
  trace::Estimate sum{0.0, 0.0};
  double count = 0.0;
  for (std::size_t i = 0; i < value.size(); ++i) {
    if (plane.theta_deg[i] < low || plane.theta_deg[i] > high) continue;
    sum.mean += value[i];
    sum.error = std::hypot(sum.error, error[i]);
    ++count;
  }
  return {sum.mean / count, sum.error / count};
}

}  // namespace

trace::Estimate InPlane::mean(double low, double high) const {
  return mean_of(*this, brdf, brdf_u, low, high);
}

trace::Estimate InPlane::mean_s1(double low, double high) const {
  return mean_of(*this, s1, s1_u, low, high);
}

InPlane in_plane(const trace::Result& result, std::size_t wavelengths) {
  InPlane plane;
  const trace::Hemisphere& hemisphere = result.hemisphere();
  for (std::size_t cell = hemisphere.cells(); cell < hemisphere.size(); ++cell) {
    const trace::Cell c = hemisphere.cell(cell);
    plane.theta_deg.push_back(optics::degrees(0.5 * (c.theta_low + c.theta_high)));
    double f = 0.0;
    double f_u = 0.0;
    double q = 0.0;
    double q_u = 0.0;
    for (std::size_t w = 0; w < wavelengths; ++w) {
      const trace::MuellerEstimate e = result.brdf(cell, w);
      const double n = static_cast<double>(wavelengths);
      f += optics::element(e.mean, 0, 0) / n;
      q += optics::element(e.mean, 1, 0) / n;
      // The same rays carry all wavelengths, so errors do not average out.
      f_u += optics::element(e.error, 0, 0) / n;
      q_u += optics::element(e.error, 1, 0) / n;
    }
    plane.brdf.push_back(f);
    plane.brdf_u.push_back(f_u);
    plane.s1.push_back(f > 0.0 ? q / f : 0.0);
    plane.s1_u.push_back(f > 0.0 ? std::hypot(q_u, q / f * f_u) / f : 1.0);
  }
  return plane;
}

Page contaminants(const Options& options) {
  SurfaceBench bench(options, soil_simulations + water_simulations);
  Page page("contaminants", "Contaminants on painted surfaces: figures 4 to 9 of the paper");
  page.paragraph(fmt::format(
      "*Micro-scale modeling of contaminant effects on surface optical properties* repeated by "
      "`{}`. Light comes from 20° and 60°; 11 bands from 0.40 to 0.90 µm; each simulation launches "
      "{} bundles (drops of 180° four times as many), each of which bounces as often as it must "
      "and carries whole Mueller matrices. "
      "Errors are one standard error. Particles are laid anew after every {} bundles, so errors "
      "hold "
      "where they lie too.",
      options.command.empty() ? "umov study contaminants" : options.command, launches,
      launches_a_lay));
  add_soil(page, bench);
  add_water(page, bench);
  page.paragraph(
      fmt::format("{:.3g} rays in all; largest share of light lost in any simulation: "
                  "{:.1e}.",
                  static_cast<double>(bench.rays()), bench.lost()));
  page.numbers()["rays"] = bench.rays();
  page.numbers()["lost"] = bench.lost();
  return page;
}

}  // namespace umov::study
