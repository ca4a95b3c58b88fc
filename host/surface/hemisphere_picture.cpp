#include "host/surface/hemisphere_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <optional>

#include "host/formats/image_file.hpp"
#include "host/formats/picture_scale.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/frames.hpp"
#include "host/optics/mueller.hpp"

namespace umov::surface {
namespace {

using formats::Picture;

constexpr Picture::Colour paper{255, 255, 255};
constexpr Picture::Colour ink{30, 34, 43};
constexpr Picture::Colour unseen{200, 200, 200};  // cells that no light was seen in
constexpr std::size_t pixels_a_ring = 5;          // and side
constexpr std::size_t picture_side = 721;
constexpr std::size_t margin = 60, legend = 190;
// Of m00: beyond it a linear scale shows little.
constexpr double linear_contrast = 20.0;
constexpr double decades = 4.0;  // of the logarithmic one, at most

// The cell of a pixel of a square map of `side` pixels; nothing outside of the hemisphere.
std::optional<std::size_t> cell_at(const trace::Hemisphere& hemisphere, std::size_t side,
                                   std::size_t x, std::size_t y) {
  const double half = 0.5 * static_cast<double>(side);
  const double right = (static_cast<double>(x) + 0.5 - half) / half;
  const double up = (half - static_cast<double>(y) - 0.5) / half;
  const double radius = std::hypot(right, up);
  if (radius >= 1.0) return std::nullopt;
  return hemisphere.find(optics::exit_direction(radius * 0.5 * optics::pi, std::atan2(up, right)));
}

std::size_t rings_of(const trace::Hemisphere& hemisphere) {
  std::size_t rings = 0;
  double theta = -1.0;
  for (std::size_t i = 0; i < hemisphere.cells(); ++i) {
    if (hemisphere.cell(i).theta_low > theta) ++rings;
    theta = hemisphere.cell(i).theta_low;
  }
  return rings;
}

Picture::Colour between(const Picture::Colour& a, const Picture::Colour& b, double part) {
  Picture::Colour c{};
  for (std::size_t k = 0; k < 3; ++k) {
    c[k] = static_cast<std::uint8_t>(std::lround((1.0 - part) * a[k] + part * b[k]));
  }
  return c;
}

template <std::size_t count>
Picture::Colour along(const std::array<Picture::Colour, count>& stops, double share) {
  const double place = std::clamp(share, 0.0, 1.0) * static_cast<double>(count - 1);
  const auto low = std::min(static_cast<std::size_t>(place), count - 2);
  return between(stops[low], stops[low + 1], place - static_cast<double>(low));
}

// From dark to bright, so that it reads in grey too.
Picture::Colour of_size(double share) {
  static constexpr std::array<Picture::Colour, 5> stops{
      {{20, 14, 54}, {62, 60, 140}, {32, 137, 141}, {120, 200, 90}, {252, 240, 120}}};
  return along(stops, share);
}

// About a neutral middle.
Picture::Colour of_sign(double share) {
  static constexpr std::array<Picture::Colour, 3> stops{
      {{30, 80, 170}, {245, 245, 245}, {180, 40, 30}}};
  return along(stops, share);
}

// What stands where on the scale.
struct Scale {
  double low, high;
  bool logarithmic;

  double share(double value) const {
    if (!logarithmic) return (value - low) / (high - low);
    return value > 0.0 ? std::log(value / low) / std::log(high / low) : 0.0;
  }
  std::vector<formats::ScaleMark> marks() const {
    std::vector<formats::ScaleMark> all;
    const auto add = [&](double value) {
      if (share(value) < -1e-6 || share(value) > 1.0 + 1e-6) return;
      const double at = std::abs(value) < 1e-12 * high ? 0.0 : value;
      all.push_back({std::clamp(share(at), 0.0, 1.0), fmt::format("{:.3g}", at)});
    };
    if (logarithmic) {
      const int first = static_cast<int>(std::floor(std::log10(low)));
      for (int e = first; std::pow(10.0, e) <= high; ++e) {
        for (const double m : {1.0, 2.0, 5.0}) add(m * std::pow(10.0, e));
      }
      return all;
    }
    const double step = formats::round_step(high - low);
    for (double v = std::ceil(low / step - 1e-9) * step; v <= high * (1.0 + 1e-9); v += step) {
      add(v);
    }
    return all;
  }
};

// Of m00: all of it. Of a share: as far as 99 % of the cells reach, for few exits make any share.
Scale scale_of(std::vector<double> values, bool signed_share) {
  if (signed_share) {
    for (double& v : values) v = std::abs(v);
    double reach = 1.0;
    if (!values.empty()) {
      const auto at = values.begin() + static_cast<std::ptrdiff_t>(99 * (values.size() - 1) / 100);
      std::nth_element(values.begin(), at, values.end());
      reach = std::clamp(*at, 1e-3, 1.0);
    }
    return {-reach, reach, false};
  }
  double least = 0.0, most = 0.0;
  for (const double v : values) {
    most = std::max(most, v);
    if (v > 0.0) least = least > 0.0 ? std::min(least, v) : v;
  }
  if (!(most > 0.0)) return {0.0, 1.0, false};
  if (most <= linear_contrast * least) return {0.0, most, false};
  return {std::max(least, most * std::pow(10.0, -decades)), most, true};
}

void draw_rings(Picture& picture, std::size_t left, std::size_t top) {
  const double half = 0.5 * static_cast<double>(picture_side);
  const auto mark = [&](double theta_deg, double phi, const Picture::Colour& colour) {
    const double r = half * theta_deg / 90.0;
    const double x = half + r * std::cos(phi);
    const double y = half - r * std::sin(phi);
    if (x < 0.0 || y < 0.0) return;
    picture.set(left + static_cast<std::size_t>(x), top + static_cast<std::size_t>(y), colour);
  };
  for (const double theta : {30.0, 60.0, 90.0}) {
    constexpr int steps = 2000;
    for (int i = 0; i < steps; ++i) {
      // Dashed, so that cells show through.
      if (theta < 90.0 && i / 10 % 2 == 1) continue;
      mark(theta, 2.0 * optics::pi * i / steps, ink);
    }
    const auto x =
        static_cast<std::size_t>(half * (1.0 + theta / 90.0 * std::cos(0.25 * optics::pi)));
    const auto y =
        static_cast<std::size_t>(half * (1.0 - theta / 90.0 * std::sin(0.25 * optics::pi)));
    const std::string label = fmt::format("{:g}", theta);
    const std::size_t wide = Picture::text_width(label, formats::scale_letter) + 6;
    picture.fill(left + x, top + y - 10, wide, 20, paper);
    picture.text(left + x + 3, top + y - 7, label, formats::scale_letter, ink);
  }
}

// A cross where a mirror sends the light.
void draw_mirror(Picture& picture, std::size_t left, std::size_t top, double theta_i_deg) {
  const double half = 0.5 * static_cast<double>(picture_side);
  const auto x = left + static_cast<std::size_t>(half * (1.0 + theta_i_deg / 90.0));
  const auto y = top + static_cast<std::size_t>(half);
  picture.fill(x - 8, y - 1, 17, 3, paper);
  picture.fill(x - 1, y - 8, 3, 17, paper);
  picture.fill(x - 7, y, 15, 1, ink);
  picture.fill(x, y - 7, 1, 15, ink);
}

}  // namespace

void write_hemisphere_exr(const std::filesystem::path& path, const Hemispheres& hemispheres) {
  const trace::Hemisphere& cells = hemispheres.results.front().hemisphere();
  const std::size_t side = 2 * pixels_a_ring * rings_of(cells) + 1;
  std::vector<std::optional<std::size_t>> cell_of;
  std::vector<double> alpha;
  for (std::size_t y = 0; y < side; ++y) {
    for (std::size_t x = 0; x < side; ++x) {
      cell_of.push_back(cell_at(cells, side, x, y));
      alpha.push_back(cell_of.back() ? 1.0 : 0.0);
    }
  }
  std::vector<std::pair<std::string, std::vector<double>>> named{{"A", alpha}};
  std::vector<double> by_cell(cells.cells());
  const auto add = [&](const std::string& name) {
    std::vector<double> values;
    for (const auto& cell : cell_of) values.push_back(cell ? by_cell[*cell] : 0.0);
    named.emplace_back(name, std::move(values));
  };
  for (std::size_t i = 0; i < hemispheres.results.size(); ++i) {
    for (std::size_t w = 0; w < hemispheres.wavelengths_um.size(); ++w) {
      const std::string layer = fmt::format("{:g}deg.{:g}nm.", hemispheres.theta_i_deg[i],
                                            1e3 * hemispheres.wavelengths_um[w]);
      std::vector<trace::MuellerEstimate> found;
      for (std::size_t cell = 0; cell < cells.cells(); ++cell) {
        found.push_back(hemispheres.results[i].brdf(cell, w));
      }
      for (int e = 0; e < 16; ++e) {
        for (std::size_t cell = 0; cell < found.size(); ++cell) {
          by_cell[cell] = optics::element(found[cell].mean, e / 4, e % 4);
        }
        add(layer + fmt::format("m{}{}", e / 4, e % 4));
      }
      for (std::size_t cell = 0; cell < found.size(); ++cell) {
        by_cell[cell] = found[cell].error[0][0];
      }
      add(layer + "m00_se");
    }
  }
  std::vector<formats::ImagePlane> planes;
  for (const auto& [name, values] : named) planes.push_back({name, values});
  formats::write_exr(
      path, side, side, planes,
      {{"unit", "1/sr"}, {"projection", "radius theta_r/90 deg; phi_r = 0 right, 90 deg up"}});
}

std::string hemisphere_png(const trace::Result& result, double theta_i_deg, double wavelength_um,
                           std::size_t wavelength, int row, int column) {
  const trace::Hemisphere& cells = result.hemisphere();
  const bool share = row + column > 0;
  std::vector<double> value(cells.cells());
  std::vector<char> seen(cells.cells());
  std::vector<double> of_seen;
  for (std::size_t cell = 0; cell < cells.cells(); ++cell) {
    const trace::MuellerEstimate e = result.brdf(cell, wavelength);
    seen[cell] = e.mean[0][0] > 0.0;
    if (!seen[cell]) continue;
    value[cell] = optics::element(e.mean, row, column) / (share ? e.mean[0][0] : 1.0);
    of_seen.push_back(value[cell]);
  }
  const Scale scale = scale_of(of_seen, share);
  const auto colour = share ? of_sign : of_size;
  const std::size_t top = margin, left = margin / 2;
  Picture picture(left + picture_side + legend, top + picture_side + margin / 2, paper);
  for (std::size_t y = 0; y < picture_side; ++y) {
    for (std::size_t x = 0; x < picture_side; ++x) {
      const auto cell = cell_at(cells, picture_side, x, y);
      if (!cell) continue;
      picture.set(left + x, top + y, seen[*cell] ? colour(scale.share(value[*cell])) : unseen);
    }
  }
  draw_rings(picture, left, top);
  draw_mirror(picture, left, top, theta_i_deg);
  const std::string name = fmt::format("m{}{}", row, column);
  picture.text(left, 16,
               fmt::format("{}  {:g} nm  light from {:g} deg", share ? name + " / m00" : name,
                           1e3 * wavelength_um, theta_i_deg),
               formats::scale_letter, ink);
  formats::draw_scale(picture, left + picture_side + 30, top, picture_side,
                      share ? name + "/m00" : "1/sr", scale.marks(), colour, ink);
  return formats::png_bytes(picture);
}

}  // namespace umov::surface
