#include "host/cli/study/chamber_page.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "host/cli/study/plots.hpp"

namespace umov::study {
namespace {

constexpr std::array colours{"#1f5fbf", "#d4331d", "#16883a", "#1c222b"};

}  // namespace

void add_maps(Page& page, const std::string& name, const std::string& caption,
              const std::vector<NamedMap>& maps, const std::optional<chamber::Region>& region) {
  double largest = 0.0;
  for (const NamedMap& one : maps)
    largest = std::max(largest, *std::max_element(one.map->luminance_cd_m2.begin(),
                                                  one.map->luminance_cd_m2.end()));
  // All of a map needs no more than its half resolution.
  const std::size_t bin = region ? 1 : 2;
  Json data = Json::array();
  Json layout = {{"width", 1000},
                 {"height", region ? 520 : 560},
                 {"margin", {{"t", 40}}},
                 {"annotations", Json::array()}};
  for (std::size_t k = 0; k < maps.size(); ++k) {
    const chamber::Map part = region ? chamber::cut(*maps[k].map, *region) : *maps[k].map;
    const double x0 = region ? region->x_from_mm : 0.0;
    const double y0 = region ? region->y_from_mm : 0.0;
    Json rows = Json::array();
    Json xs = Json::array();
    Json ys = Json::array();
    const double step = part.pixel_mm * static_cast<double>(bin);
    const auto middle = [&](double from, std::size_t i) {
      return std::round(1e3 * (from + step * (static_cast<double>(i) + 0.5))) / 1e3;
    };
    for (std::size_t x = 0; x < part.width / bin; ++x) xs.push_back(middle(x0, x));
    for (std::size_t y = 0; y < part.height / bin; ++y) {
      ys.push_back(middle(y0, y));
      Json row = Json::array();
      for (std::size_t x = 0; x < part.width / bin; ++x) {
        double sum = 0.0;
        for (std::size_t i = 0; i < bin; ++i) {
          for (std::size_t j = 0; j < bin; ++j) sum += part.at(bin * x + i, bin * y + j);
        }
        row.push_back(std::round(sum / static_cast<double>(bin * bin)));
      }
      rows.push_back(std::move(row));
    }
    const std::string number = k == 0 ? "" : std::to_string(k + 1);
    data.push_back({{"type", "heatmap"},
                    {"x", xs},
                    {"y", ys},
                    {"z", rows},
                    {"xaxis", "x" + number},
                    {"yaxis", "y" + number},
                    {"zmin", 0},
                    {"zmax", largest},
                    {"colorscale", "Greys"},
                    {"reversescale", true},
                    {"showscale", k == 0},
                    {"colorbar", {{"title", {{"text", "cd/m²"}}}}}});
    const double left = k % 2 == 0 ? 0.0 : 0.54;
    const double bottom = k < 2 ? 0.58 : 0.0;
    layout["xaxis" + number] = {
        {"title", {{"text", "X / mm"}}}, {"domain", {left, left + 0.44}}, {"anchor", "y" + number}};
    layout["yaxis" + number] = {{"title", {{"text", "Y / mm"}}},
                                {"domain", {bottom, bottom + 0.4}},
                                {"anchor", "x" + number}};
    layout["annotations"].push_back({{"text", maps[k].name},
                                     {"xref", "paper"},
                                     {"yref", "paper"},
                                     {"x", left},
                                     {"y", bottom + 0.4},
                                     {"xanchor", "left"},
                                     {"yanchor", "bottom"},
                                     {"showarrow", false}});
  }
  page.figure(name, caption, data, layout);
}

void add_distributions(Page& page, const std::vector<NamedDistribution>& all) {
  for (const std::size_t plane : {std::size_t{0}, std::size_t{1}}) {
    Json data = Json::array();
    for (std::size_t k = 0; k < all.size(); ++k) {
      const chamber::Distribution& d = *all[k].distribution;
      std::vector<double> x;
      std::vector<double> y;
      const std::size_t opposite = plane + d.c_deg.size() / 2;
      for (std::size_t g = d.gamma_deg.size(); g-- > 1;) {
        if (d.gamma_deg[g] > 90.0) continue;
        x.push_back(-d.gamma_deg[g]);
        y.push_back(d.intensity(opposite, g));
      }
      for (std::size_t g = 0; g < d.gamma_deg.size() && d.gamma_deg[g] <= 90.0; ++g) {
        x.push_back(d.gamma_deg[g]);
        y.push_back(d.intensity(plane, g));
      }
      data.push_back(line(all[k].name, x, y, colours[k % colours.size()],
                          k + 1 == all.size() ? "solid" : "dash"));
    }
    const std::string planes = plane == 0 ? "C0–C180" : "C45–C225";
    page.figure(plane == 0 ? "figure-9a" : "figure-9b",
                fmt::format("Intensity in {}, as figure 9 of [M].", planes), data,
                axes("γ / °", "intensity / cd"));
  }
}

}  // namespace umov::study
