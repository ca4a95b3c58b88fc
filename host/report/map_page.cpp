#include "host/report/map_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "host/gap/answer/words.hpp"
#include "host/report/assets.hpp"
#include "host/report/diagnosis_parts.hpp"
#include "host/report/json_parts.hpp"
#include "host/report/numbers.hpp"
#include "host/report/page_template.hpp"

namespace umov::report {
namespace {

using gap::MapPicture;

/// The part of a map that holds its used pixels.
struct Frame {
  std::size_t width, x_from, x_to, y_from, y_to;

  explicit Frame(const MapPicture& p)
      : width(p.width), x_from(p.width), x_to(0), y_from(p.height), y_to(0) {
    for (std::size_t i = 0; i < p.measured.size(); ++i) {
      if (!std::isfinite(p.measured[i])) continue;
      x_from = std::min(x_from, i % width);
      x_to = std::max(x_to, i % width + 1);
      y_from = std::min(y_from, i / width);
      y_to = std::max(y_to, i / width + 1);
    }
  }

  /// Row by row from below; null where there is no value.
  Json rows(const std::vector<double>& values, int digits) const {
    Json out = Json::array();
    for (std::size_t y = y_from; y < y_to; ++y)
      out.push_back(rounded(std::span(values).subspan(y * width + x_from, x_to - x_from), digits));
    return out;
  }
};

Json centres(std::size_t from, std::size_t to, double pixel_mm) {
  std::vector<double> mm;
  for (std::size_t i = from; i < to; ++i) mm.push_back(pixel_mm * (static_cast<double>(i) + 0.5));
  return rounded(mm, 6);
}

double quantile_of_size(const std::vector<double>& values, double share) {
  std::vector<double> sizes;
  for (const double v : values)
    if (std::isfinite(v)) sizes.push_back(std::abs(v));
  if (sizes.empty()) return 0.0;
  const auto at =
      sizes.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(sizes.size() - 1));
  std::nth_element(sizes.begin(), at, sizes.end());
  return *at;
}

std::vector<double> residual(const MapPicture& p, const std::vector<double>& model, bool percent) {
  std::vector<double> out;
  for (std::size_t i = 0; i < model.size(); ++i)
    out.push_back((p.measured[i] - model[i]) / (percent ? 0.01 * p.best[i] : p.sigma[i]));
  return out;
}

Json maps_json(const MapPicture& p) {
  constexpr double shown = 0.98;  // of the pixels lie within the colours
  const Frame frame(p);
  Json residuals;
  for (const bool percent : {false, true}) {
    const std::vector<double> before = residual(p, p.base, percent);
    residuals[percent ? "percent" : "sigma"] = {
        {"before", frame.rows(before, 3)},
        {"after", frame.rows(residual(p, p.best, percent), 3)},
        {"clip", rounded(std::max(percent ? 0.2 : 4.0, quantile_of_size(before, shown)), 2)}};
  }
  return {{"x_mm", centres(frame.x_from, frame.x_to, p.pixel_mm)},
          {"y_mm", centres(frame.y_from, frame.y_to, p.pixel_mm)},
          {"measured", frame.rows(p.measured, 4)},
          {"before", frame.rows(p.base, 4)},
          {"after", frame.rows(p.best, 4)},
          {"largest", rounded(quantile_of_size(p.measured, 1.0), 4)},
          {"residual", std::move(residuals)}};
}

/// What each effect does, beside what all else leaves of the measurement.
Json signatures_json(const MapPicture& p) {
  const Frame frame(p);
  Json out = Json::array();
  for (const gap::MapContribution& c : p.contributions) {
    const auto view = [&](const std::vector<double>& does) {
      std::vector<double> left;
      for (std::size_t i = 0; i < does.size(); ++i)
        left.push_back(p.measured[i] - p.best[i] + does[i]);
      return Json{{"left", frame.rows(left, 4)},
                  {"does", frame.rows(does, 4)},
                  {"clip", rounded(std::max(1e-9, quantile_of_size(does, 0.99)), 3)}};
    };
    out.push_back({{"plain", gap::plain_name(c.effect.name)},
                   {"family", c.effect.family},
                   {"named", c.named},
                   {"delta_chi2", plain(c.delta_chi2, 3)},
                   {"refitted", view(c.refitted)},
                   {"held", view(c.held)}});
  }
  return out;
}

std::string change(double before, double after) {
  return fmt::format("{} % → {} %", plain(100 * before, 4), plain(100 * after, 4));
}

std::string name_of(const MapPageInput& input) {
  return input.files.empty() ? "luminance map" : input.files.front();
}

Json facts(const MapPageInput& input) {
  const gap::Diagnosis& d = input.diagnosis->answer;
  const MapPicture& p = input.diagnosis->picture;
  const bool explained = !p.contributions.empty();
  Json out = Json::array();
  const auto likeness = [&](const char* name, double before, double after, const char* note) {
    out.push_back({{"name", name},
                   {"value", explained ? change(before, after) : plain(100 * before, 4) + " %"},
                   {"note", note}});
  };
  likeness("NCC", p.before.ncc, p.after.ncc, "normalised cross-correlation");
  likeness("NRMSE", p.before.nrmse, p.after.nrmse, "rms difference over the largest value");
  if (explained) out.push_back(closed_fact(d));
  out.push_back({{"name", "pixels used"},
                 {"value", count(static_cast<long long>(input.source.used))},
                 {"note", "of " + count(static_cast<long long>(input.source.records))}});
  return out;
}

Json provenance_rows(const MapPageInput& input) {
  Json rows = Json::array();
  for (const std::string& file : input.files)
    rows.push_back({rows.empty() ? "map" : "scene", file});
  rows.push_back({"sha256 of the map", input.source.sha256});
  rows.push_back({"program", "umov " + input.source.version});
  rows.push_back({"command", input.source.command});
  rows.push_back({"seed", fmt::format("{}", input.source.seed)});
  return rows;
}

}  // namespace

std::string map_data(const MapPageInput& input) {
  const gap::Diagnosis& d = input.diagnosis->answer;
  const MapPicture& picture = input.diagnosis->picture;
  std::vector<gap::Effect> declared;
  for (const gap::MapContribution& c : picture.contributions) declared.push_back(c.effect);
  Json data = data_of_any(d, input.source, input.created);
  data.update({{"title", name_of(input)},
               {"items", "pixels"},
               {"facts", facts(input)},
               {"causes", causes_json(d, declared, picture.alternatives)},
               {"next", Json::array()},
               {"explained", !picture.contributions.empty()},
               {"map", maps_json(picture)},
               {"signatures", signatures_json(picture)},
               {"provenance", provenance_rows(input)}});
  return embeddable(data.dump(-1, ' ', false, Json::error_handler_t::replace));
}

std::string map_page(const MapPageInput& input) {
  return filled_page({"umov " + input.source.version, "Diagnosis: " + name_of(input),
                      map_data(input), assets().map_diagnosis});
}

}  // namespace umov::report
