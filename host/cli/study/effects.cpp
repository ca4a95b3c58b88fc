#include "host/cli/study/effects.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <memory>
#include <span>
#include <string>
#include <tuple>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/cli/study/bench.hpp"
#include "host/cli/study/effect_look_alikes.hpp"
#include "host/cli/study/effect_signatures.hpp"
#include "host/cli/study/embedded_plans.hpp"
#include "host/cli/study/plots.hpp"
#include "host/gap/answer/words.hpp"
#include "host/optics/angles.hpp"

namespace umov::study {
namespace {

using gap::scan::Record;
using gap::scan::ScanModel;

/// White noise of the light that the monitor misses, beside the records' own: as on a usual bench.
constexpr double relative_noise = 0.003;

constexpr std::array channel_colours{"#1f5fbf", "#d4331d", "#16883a", "#c86a06"};

/// Where an effect shows best.
enum class Along { theta_r, record, signal };

Along axis_of(const gap::Effect& effect) {
  if (effect.stage == "source" && effect.name.starts_with("laser_") &&
      effect.name != "laser_crosstalk")
    return Along::record;
  if (effect.name == "detector_nonlinearity" || effect.name == "detector_saturation" ||
      effect.name == "low_signal_pedestal")
    return Along::signal;
  return Along::theta_r;
}

std::string channel_of(const Record& r) {
  const auto letter = [](double axis) { return axis < 0.5 ? "P" : "S"; };
  return fmt::format("{} → {}", letter(r.polarizer), letter(r.analyzer));
}

/// A curve of one channel, before and after the refit.
struct Curve {
  std::string name;
  std::vector<double> x, alone, left;
};

struct Drawn {
  std::vector<Curve> curves;
  std::string x_title, where;
  bool log_x = false;
};

/// The row of channels where what the refit leaves is largest.
Drawn along_angle(const ScanModel& model, const EffectSignature& s) {
  const auto& records = model.records().records;
  const auto n = static_cast<Eigen::Index>(model.used());
  // Observations are those of the records that are not saturated, in their order.
  std::vector<std::size_t> used;
  for (std::size_t i = 0; i < records.size(); ++i)
    if (!records[i].saturated) used.push_back(i);
  using Line = std::tuple<bool, double, std::size_t>;  // quadrature, θi, wavelength
  std::map<Line, double> strength;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Record& r = records[used[static_cast<std::size_t>(k)]];
    if (!r.shutter_open) continue;
    for (const bool y : {false, true})
      strength[{y, r.theta_i, r.wavelength}] +=
          std::pow(s.size > 0 ? s.left[k + (y ? n : 0)] : s.alone[k + (y ? n : 0)], 2);
  }
  const auto best = std::max_element(strength.begin(), strength.end(), [](auto& a, auto& b) {
                      return a.second < b.second;
                    })->first;
  const auto [quadrature, theta_i, wavelength] = best;
  std::map<std::string, Curve> curves;
  for (Eigen::Index k = 0; k < n; ++k) {
    const Record& r = records[used[static_cast<std::size_t>(k)]];
    if (!r.shutter_open || r.theta_i != theta_i || r.wavelength != wavelength) continue;
    Curve& c = curves[channel_of(r)];
    c.x.push_back(optics::degrees(r.theta_r));
    c.alone.push_back(s.alone[k + (quadrature ? n : 0)]);
    c.left.push_back(s.left[k + (quadrature ? n : 0)]);
  }
  Drawn drawn{{}, "θr / °", {}};
  drawn.where = fmt::format("{} at {:g} nm and θi = {:g}°", quadrature ? "Y" : "X",
                            model.records().wavelengths_nm[wavelength],
                            std::round(optics::degrees(theta_i) * 100) / 100);
  for (auto& [name, curve] : curves) {
    // A serpentine scan has every second row the other way round.
    std::vector<std::size_t> order(curve.x.size());
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
    std::stable_sort(order.begin(), order.end(),
                     [&](std::size_t a, std::size_t b) { return curve.x[a] < curve.x[b]; });
    Curve sorted{name, {}, {}, {}};
    for (const std::size_t i : order) {
      sorted.x.push_back(curve.x[i]);
      sorted.alone.push_back(curve.alone[i]);
      sorted.left.push_back(curve.left[i]);
    }
    drawn.curves.push_back(std::move(sorted));
  }
  return drawn;
}

/// All records in order of time or signal, the relative change that neighbours share, per cent.
Drawn along_all(const ScanModel& model, const gap::Refit& at, const gap::Whitening& whitening,
                const EffectSignature& s, Along along) {
  constexpr std::size_t bins = 60;
  const auto n = static_cast<Eigen::Index>(model.used());
  std::vector<std::pair<double, Eigen::Index>> sorted;
  for (Eigen::Index k = 0; k < n; ++k) {
    const double signal = at.mean[k];
    if (signal < 3 * whitening.white_sigma()[k]) continue;
    sorted.emplace_back(along == Along::record ? static_cast<double>(k) : signal, k);
  }
  std::sort(sorted.begin(), sorted.end());
  Curve curve{"all channels", {}, {}, {}};
  for (std::size_t b = 0; b < bins; ++b) {
    const std::size_t from = b * sorted.size() / bins, to = (b + 1) * sorted.size() / bins;
    double weight = 0, alone = 0, left = 0, x = 0;
    for (std::size_t i = from; i < to; ++i) {
      const Eigen::Index k = sorted[i].second;
      const double steepness = at.mean[k] / whitening.white_sigma()[k];
      weight += steepness * steepness;
      alone += steepness * s.alone[k];
      left += steepness * s.left[k];
      x += sorted[i].first;
    }
    curve.x.push_back(x / static_cast<double>(to - from));
    curve.alone.push_back(100 * alone / weight);
    curve.left.push_back(100 * left / weight);
  }
  Drawn drawn{{std::move(curve)}, {}, "X of all records, neighbours joined"};
  drawn.x_title = along == Along::record ? "record, in the order of measurement" : "signal / V";
  drawn.log_x = along == Along::signal;
  return drawn;
}

void draw(Page& page, const std::string& name, const std::string& caption, const Drawn& drawn,
          bool percent) {
  const std::string y = percent ? "change / % of the signal" : "change / σ of a record";
  Json data = Json::array();
  for (std::size_t c = 0; c < drawn.curves.size(); ++c) {
    const Curve& curve = drawn.curves[c];
    const auto colour = channel_colours[c % channel_colours.size()];
    Json before = line(curve.name, curve.x, curve.alone, colour);
    Json after = line(curve.name, curve.x, curve.left, colour);
    before["showlegend"] = drawn.curves.size() > 1;
    after["showlegend"] = false;
    data.push_back(std::move(before));
    data.push_back(on(std::move(after), 2));
  }
  Json layout = axes(drawn.x_title, y);
  layout["width"] = 860;
  layout["height"] = 330;
  layout["margin"] = {{"l", 74}, {"r", 16}, {"t", 66}, {"b", 56}};
  layout["legend"] = {{"orientation", "h"}, {"x", 0}, {"y", 1.1}, {"yanchor", "bottom"}};
  layout["xaxis"]["domain"] = {0.0, 0.41};
  layout["xaxis2"] = layout["xaxis"];
  layout["xaxis2"]["domain"] = {0.59, 1.0};
  layout["xaxis2"]["anchor"] = "y2";
  layout["yaxis2"] = layout["yaxis"];
  layout["yaxis2"]["anchor"] = "x2";
  layout["annotations"] = Json::array();
  for (const auto& [text, x] : {std::pair{"alone", 0.41}, std::pair{"base fitted anew", 1.0}})
    layout["annotations"].push_back({{"text", text},
                                     {"x", x},
                                     {"y", 1.0},
                                     {"xref", "paper"},
                                     {"yref", "paper"},
                                     {"xanchor", "right"},
                                     {"yanchor", "bottom"},
                                     {"showarrow", false}});
  if (drawn.log_x)
    for (const char* axis : {"xaxis", "xaxis2"}) {
      layout[axis]["type"] = "log";
      layout[axis]["dtick"] = 1;
    }
  page.figure(name, caption, std::move(data), std::move(layout));
}

std::string figure_name(const gap::Effect& effect) {
  std::string name = effect.name;
  if (!effect.family.empty()) name += "-" + effect.family;
  std::replace(name.begin(), name.end(), '+', '-');
  return name;
}

std::string size_text(const EffectSignature& s) {
  if (gap::is_series(s.effect->parameters.size())) return "every term one sigma of its prior";
  std::vector<std::string> parts;
  for (std::size_t i = 0; i < s.alpha.size(); ++i) {
    const gap::Parameter& p = s.effect->parameters[i];
    parts.push_back(
        fmt::format("`{}` {:.3g}{}", p.name, s.alpha[i], p.unit == "1" ? "" : " " + p.unit));
  }
  return fmt::format("{}", fmt::join(parts, ", "));
}

void describe(Page& page, const ScanModel& model, const gap::Refit& at,
              const gap::Whitening& whitening, const EffectSignature& s) {
  const gap::Effect& effect = *s.effect;
  page.heading(full_name(effect));
  const std::string source = effect.source.empty() ? "" : fmt::format(" ({})", effect.source);
  page.paragraph(fmt::format("**{}.** {}{}", effect.stage, effect.physics, source));
  if (gap::is_series(effect.parameters.size())) {
    page.paragraph(fmt::format("{} parameters, `{}` to `{}`: {}.", effect.parameters.size(),
                               effect.parameters.front().name, effect.parameters.back().name,
                               effect.parameters.front().meaning));
  } else {
    std::vector<std::vector<std::string>> rows;
    for (const gap::Parameter& p : effect.parameters)
      rows.push_back({"`" + p.name + "`", p.unit, p.meaning});
    page.table({"parameter", "unit", "meaning"}, std::move(rows));
  }
  if (const LookAlikes* known = look_alikes_of(effect.name)) {
    std::string text;
    if (!known->sign.empty()) text += fmt::format("Sign: {}. ", known->sign);
    text += fmt::format("In the plane of incidence it looks like {}.", known->others);
    if (!known->tells.empty()) text += fmt::format(" What separates: {}.", known->tells);
    page.paragraph(text);
  }
  if (s.alone.size() == 0) {
    page.paragraph("Looked for in scans that leave the plane of incidence; this one does not.");
    return;
  }
  const Along along = axis_of(effect);
  const Drawn drawn =
      along == Along::theta_r ? along_angle(model, s) : along_all(model, at, whitening, s, along);
  std::string caption = fmt::format("At its usual size ({}): {}. ", size_text(s), drawn.where);
  if (effect.scatter)
    caption += "One pattern of many: every place has its own, in proportion to the signal. ";
  caption +=
      s.size >= 1
          ? fmt::format("A refit of the base leaves {:.3g} σ of it in the whole scan.", s.size)
          : "A refit of the base takes it up: such a scan can't see it.";
  if (!s.alike.empty()) {
    std::vector<std::string> names;
    for (const auto& other : s.alike)
      names.push_back(fmt::format("`{}` ({:.3f})", other.name, other.cosine));
    caption +=
        fmt::format(" In this scan what is left is most like that of {}.", fmt::join(names, ", "));
  }
  draw(page, figure_name(effect), caption, drawn, along != Along::theta_r);
  page.numbers()["effects"].push_back({{"effect", effect.name},
                                       {"family", effect.family},
                                       {"left_sigma", s.size},
                                       {"alone_sigma", s.alone.norm()}});
}

}  // namespace

Page effects(const Options& options) {
  Bench bench(options, options.folder / "scans", "ideal", "red-gloss");
  formats::ScanTable scan =
      bench.measure("effects", embedded_plan("effects"), "red-gloss", 0.0, 0.3);
  for (const auto& [key, value] : data_sheet) scan.set_key(key, value);
  const auto report = [&](double share, const char* what) {
    if (options.keep_going && !options.keep_going()) throw Stopped{};
    if (options.progress) options.progress(share, what);
  };
  report(0.3, "base");
  const ScanModel model({scan});
  const gap::Refit start = gap::refit(model, gap::base_explanation(model),
                                      gap::Whitening(model.noise(model.observations().value)));
  const gap::Whitening whitening(model.noise(start.mean), {relative_noise, 0, 0});
  const gap::Refit at = gap::refit(model, start.explanation, whitening);
  report(0.6, "signatures");
  const auto all = effect_signatures(model, at, whitening, options.threads);

  Page page("effects", "The effects that a diagnosis knows", "");
  page.paragraph(
      "What `umov diagnose` can name of a scan: every effect of the catalogue with its place in "
      "the "
      "signal chain, its parameters, what it is taken for, and its signature. `umov diagnose "
      "--effects` prints the list (with `--luminaire SCENE` that of a luminance map). Effects of "
      "maps and of surfaces: `docs/diagnosis.md`.");
  page.paragraph(fmt::format(
      "The pictures show what each effect at its usual size (one sigma of its prior) does to a "
      "scan of the emulated instrument: red gloss paint, {} records, wavelengths {:g} nm, "
      "incidences 20, 45 and 70°, channels P and S, every second row downwards. Left: the change "
      "that it makes, all else held. Right: what is left of it when the base model (reflectance "
      "and gains) is fitted anew, to first order: only this can be seen in a measurement. Changes "
      "are in standard deviations of a record (its own noise and .3 % of the signal), or in per "
      "cent where they follow time or "
      "signal.",
      scan.size(), fmt::join(model.records().wavelengths_nm, ", ")));
  for (std::size_t i = 0; i < model.base().size(); ++i)
    page.numbers()["base"][model.base()[i].name] = at.explanation.base[i];
  page.numbers()["effects"] = Json::array();
  for (const EffectSignature& s : all) describe(page, model, at, whitening, s);
  page.paragraph(fmt::format("Made by `{}`.",
                             options.command.empty() ? "umov study effects" : options.command));
  return page;
}

}  // namespace umov::study
