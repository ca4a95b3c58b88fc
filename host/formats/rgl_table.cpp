#include "host/formats/rgl_table.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include <fmt/format.h>

#include "host/brdf/table_axis.hpp"
#include "host/errors/error.hpp"
#include "host/formats/half_angle_table.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/mueller.hpp"

namespace umov::formats {
namespace {

using optics::pi;

/// Cell of a regular grid over [0, 1] and the position within it.
struct Cell {
  std::size_t index;
  double share;
};

Cell cell_of(double position, std::size_t entries) {
  const double p = std::clamp(position, 0.0, 1.0) * static_cast<double>(entries - 1);
  const auto index = std::min(static_cast<std::size_t>(p), entries - 2);
  return {index, p - static_cast<double>(index)};
}

double bilinear(const float* grid, std::size_t rows, std::size_t columns, double x, double y) {
  const Cell c = cell_of(x, columns), r = cell_of(y, rows);
  const float* at = grid + r.index * columns + c.index;
  const double below = (1.0 - c.share) * double{at[0]} + c.share * double{at[1]};
  const double above = (1.0 - c.share) * double{at[columns]} + c.share * double{at[columns + 1]};
  return (1.0 - r.share) * below + r.share * above;
}

/// x in [0, 1] up to which a density that goes linearly from `a` to `b` holds `mass`.
double share_of_mass(double a, double b, double mass) {
  const double whole = 0.5 * (a + b);
  if (!(whole > 0.0) || !(mass > 0.0)) return 0.0;
  if (mass >= whole) return 1.0;
  // The root of a x + (b - a) x²/2 = mass that loses no digits for a = b.
  return std::clamp(2.0 * mass / (a + std::sqrt(a * a + 2.0 * (b - a) * mass)), 0.0, 1.0);
}

}  // namespace

void check_rgl(const RglData& data,
               const std::function<void(const char*, std::size_t, const std::string&)>& fail) {
  if (data.phi_i.empty() || data.phi_i.size() > 2)
    fail("phi_i", 0,
         fmt::format("{} azimuths of incidence: the surface is anisotropic, tables here "
                     "are isotropic",
                     data.phi_i.size()));
  if (data.theta_i.empty()) fail("theta_i", 0, "no incidences");
  const auto rises = [&](const char* name, const std::vector<float>& axis, double least,
                         double most) {
    for (std::size_t i = 0; i < axis.size(); ++i) {
      if (!(double{axis[i]} >= least && double{axis[i]} <= most))
        fail(name, i, fmt::format("{} is out of the range {:.6g} to {:.6g}", axis[i], least, most));
      if (i > 0 && !(axis[i] > axis[i - 1]))
        fail(name, i, fmt::format("{} does not rise above {}", axis[i], axis[i - 1]));
    }
  };
  rises("phi_i", data.phi_i, -2.0 * pi - 1e-3, 2.0 * pi + 1e-3);
  rises("theta_i", data.theta_i, 0.0, 0.5 * pi + 1e-4);
  rises("wavelengths", data.wavelengths_nm, 10.0, 1e6);
  const std::size_t slices = data.phi_i.size() * data.theta_i.size();
  const auto holds = [&](const char* name, const std::vector<float>& values, std::size_t images,
                         std::size_t rows, std::size_t columns) {
    if (rows < 2 || columns < 2) fail(name, 0, "has fewer than two rows or columns");
    if (values.size() % rows != 0 || values.size() / rows % columns != 0 ||
        values.size() / rows / columns != images)
      fail(name, 0,
           fmt::format("has {} values, not {} x {} x {}", values.size(), images, rows, columns));
    for (std::size_t i = 0; i < values.size(); ++i)
      if (!std::isfinite(values[i])) fail(name, i, "is not a finite number");
  };
  holds("ndf", data.ndf, 1, data.ndf_rows, data.ndf_columns);
  holds("sigma", data.sigma, 1, data.sigma_rows, data.sigma_columns);
  holds("vndf", data.vndf, slices, data.vndf_rows, data.vndf_columns);
  holds("luminance", data.luminance, slices, data.resolution, data.resolution);
  holds("spectra", data.spectra, slices * data.channels(), data.resolution, data.resolution);
  if (!data.valid.empty() && data.valid.size() != (data.luminance.size() + 7) / 8)
    fail("valid", 0,
         fmt::format("has {} bytes, not a bit for each of {} entries", data.valid.size(),
                     data.luminance.size()));
  const auto not_negative = [&](const char* name, const std::vector<float>& values) {
    for (std::size_t i = 0; i < values.size(); ++i)
      if (values[i] < 0.0f) fail(name, i, fmt::format("{} is negative", values[i]));
  };
  not_negative("ndf", data.ndf);
  not_negative("sigma", data.sigma);
  not_negative("vndf", data.vndf);
  const std::size_t image = data.vndf_rows * data.vndf_columns;
  for (std::size_t slice = 0; slice < slices; ++slice) {
    // A density needs a cell with mass: with one entry above 0 there is one.
    const auto from = data.vndf.begin() + static_cast<std::ptrdiff_t>(slice * image);
    if (std::all_of(from, from + static_cast<std::ptrdiff_t>(image),
                    [](float value) { return value == 0.0f; }))
      fail("vndf", slice * image, fmt::format("slice {} is 0 throughout", slice + 1));
  }
}

/// The stored slices around an incidence and their weights.
struct RglTable::Slices {
  struct One {
    std::size_t index;
    double weight;
  };
  std::array<One, 4> all;
  std::size_t count = 0;
  template <class Value>
  double mean(Value value) const {
    double sum = 0.0;
    for (std::size_t i = 0; i < count; ++i) sum += all[i].weight * value(all[i].index);
    return sum;
  }
};

RglTable::RglTable(RglData data, std::string origin)
    : data_(std::move(data)), origin_(std::move(origin)) {
  check_rgl(data_, [&](const char* field, std::size_t entry, const std::string& problem) {
    throw Error(Place{origin_, 0, fmt::format("{}[{}]", field, entry)}, problem,
                "the fields of an RGL tensor describe one isotropic BRDF");
  });
  if (data_.wavelengths_nm.empty()) {
    wavelengths_um_.assign(HalfAngleTable::channel_um.begin(), HalfAngleTable::channel_um.end());
    channels_ = {2, 1, 0};
  } else {
    for (const float nm : data_.wavelengths_nm) {
      channels_.push_back(channels_.size());
      // The shortest decimal of the stored number: 532.8 nm, not 532.79998779296875 nm.
      wavelengths_um_.push_back(std::stod(fmt::format("{}", nm)) * 1e-3);
    }
  }
  const std::size_t rows = data_.vndf_rows, columns = data_.vndf_columns;
  conditional_.reserve(data_.vndf.size());
  const std::size_t slices = data_.phi_i.size() * data_.theta_i.size();
  for (std::size_t slice = 0; slice < slices; ++slice) {
    const float* density = data_.vndf.data() + slice * rows * columns;
    double total = 0.0, before = 0.0;
    for (std::size_t row = 0; row < rows; ++row) {
      double sum = 0.0;
      for (std::size_t column = 0; column < columns; ++column) {
        if (column > 0)
          sum += 0.5 * (double{density[row * columns + column - 1]} +
                        double{density[row * columns + column]});
        conditional_.push_back(sum);
      }
      if (row > 0) total += 0.5 * (before + sum);
      before = sum;
      marginal_.push_back(total);
    }
    inverse_total_.push_back(1.0 / total);
    const auto scaled = [&](std::vector<double>& values, std::size_t count) {
      for (std::size_t i = values.size() - count; i < values.size(); ++i) values[i] /= total;
    };
    scaled(conditional_, rows * columns);
    scaled(marginal_, rows);
  }
}

std::string RglTable::description() const {
  std::string text =
      fmt::format("RGL tensor {} x {} x {}, {} {}, from {}", data_.theta_i.size(), data_.resolution,
                  data_.resolution, data_.channels(),
                  data_.wavelengths_nm.empty() ? "colour channels" : "wavelengths", origin_);
  const std::string first = data_.description.substr(0, data_.description.find('\n'));
  if (!first.empty()) text += " (" + first + ")";
  return text;
}

RglTable::Slices RglTable::slices_at(double theta_i) const {
  const auto place = [](const std::vector<float>& axis, double value) {
    const auto above = std::upper_bound(axis.begin(), axis.end(), value,
                                        [](double v, float entry) { return v < double{entry}; });
    if (above == axis.begin()) return brdf::AxisPlace{0, 0, 0.0};
    const auto upper = static_cast<std::size_t>(above - axis.begin());
    if (upper == axis.size()) return brdf::AxisPlace{upper - 1, upper - 1, 0.0};
    const double low = double{axis[upper - 1]};
    return brdf::AxisPlace{upper - 1, upper, (value - low) / (double{axis[upper]} - low)};
  };
  const brdf::AxisPlace t = place(data_.theta_i, theta_i);
  const brdf::AxisPlace p = place(data_.phi_i, 0.0);  // the source stands at azimuth 0
  Slices slices;
  for (const auto& [phi, phi_weight] : {std::pair(p.lower, 1.0 - p.weight), {p.upper, p.weight}})
    for (const auto& [theta, theta_weight] :
         {std::pair(t.lower, 1.0 - t.weight), {t.upper, t.weight}})
      if (const double weight = phi_weight * theta_weight; weight > 0.0)
        slices.all[slices.count++] = {phi * data_.theta_i.size() + theta, weight};
  return slices;
}

bool RglTable::warp(const Slices& slices, Point& u) const {
  const std::size_t rows = data_.vndf_rows, columns = data_.vndf_columns;
  const Cell r = cell_of(u.y, rows), c = cell_of(u.x, columns);
  const std::size_t image = rows * columns;
  const auto density = [&](std::size_t row, std::size_t column) {
    return slices.mean([&](std::size_t slice) {
      return double{data_.vndf[slice * image + row * columns + column]} * inverse_total_[slice];
    });
  };
  const auto cumulated = [&](std::size_t row, std::size_t column) {
    return slices.mean(
        [&](std::size_t slice) { return conditional_[slice * image + row * columns + column]; });
  };
  const auto between_rows = [&](double below, double above) {
    return (1.0 - r.share) * below + r.share * above;
  };
  const double left = between_rows(density(r.index, c.index), density(r.index + 1, c.index));
  const double right =
      between_rows(density(r.index, c.index + 1), density(r.index + 1, c.index + 1));
  const double row_below = cumulated(r.index, columns - 1);
  const double row_above = cumulated(r.index + 1, columns - 1);
  const double row_mass = between_rows(row_below, row_above);
  if (!(row_mass > 0.0)) return false;
  const double x = between_rows(cumulated(r.index, c.index), cumulated(r.index + 1, c.index)) +
                   c.share * (left + 0.5 * c.share * (right - left));
  const double y = slices.mean([&](std::size_t slice) {
    return marginal_[slice * rows + r.index];
  }) + r.share * (row_below + 0.5 * r.share * (row_above - row_below));
  u = {std::min(x / row_mass, 1.0), std::min(y, 1.0)};
  return true;
}

RglTable::Point RglTable::unwarped(std::size_t incidence, Point s) const {
  const std::size_t rows = data_.vndf_rows, columns = data_.vndf_columns;
  const double* marginal = marginal_.data() + incidence * rows;
  const double* conditional = conditional_.data() + incidence * rows * columns;
  const float* density = data_.vndf.data() + incidence * rows * columns;
  const auto cell_holding = [](std::size_t entries, auto cumulated, double mass) {
    std::size_t low = 0, high = entries - 2;
    while (low < high) {
      const std::size_t middle = (low + high) / 2;
      if (cumulated(middle + 1) < mass) {
        low = middle + 1;
      } else {
        high = middle;
      }
    }
    return low;
  };
  const double mass_y = std::clamp(s.y, 0.0, 1.0) * marginal[rows - 1];
  const std::size_t row = cell_holding(
      rows, [&](std::size_t i) { return marginal[i]; }, mass_y);
  const double row_below = conditional[row * columns + columns - 1];
  const double row_above = conditional[(row + 1) * columns + columns - 1];
  const double dy = share_of_mass(row_below, row_above, mass_y - marginal[row]);
  const auto blend = [&](double below, double above) { return (1.0 - dy) * below + dy * above; };
  const auto cumulated = [&](std::size_t i) {
    return blend(conditional[row * columns + i], conditional[(row + 1) * columns + i]);
  };
  const double mass_x = std::clamp(s.x, 0.0, 1.0) * cumulated(columns - 1);
  const std::size_t column = cell_holding(columns, cumulated, mass_x);
  const auto at = [&](std::size_t i) {
    return inverse_total_[incidence] *
           blend(double{density[row * columns + i]}, double{density[(row + 1) * columns + i]});
  };
  const double dx = share_of_mass(at(column), at(column + 1), mass_x - cumulated(column));
  return {(static_cast<double>(column) + dx) / static_cast<double>(columns - 1),
          (static_cast<double>(row) + dy) / static_cast<double>(rows - 1)};
}

double RglTable::scale(Point u, double theta_i) const {
  if (!data_.jacobian) return 1.0;
  const double sigma = bilinear(data_.sigma.data(), data_.sigma_rows, data_.sigma_columns,
                                std::sqrt(theta_i * 2.0 / pi), 0.5);
  if (!(sigma > 0.0)) return 0.0;
  return bilinear(data_.ndf.data(), data_.ndf_rows, data_.ndf_columns, u.x, u.y) / (4.0 * sigma);
}

double RglTable::channel_value(const Slices& slices, std::size_t channel, Point s) const {
  const std::size_t image = data_.resolution * data_.resolution;
  return slices.mean([&](std::size_t slice) {
    return bilinear(data_.spectra.data() + (slice * data_.channels() + channel) * image,
                    data_.resolution, data_.resolution, s.x, s.y);
  });
}

optics::Mueller<double> RglTable::at(double wavelength_um,
                                     const brdf::Geometry<double>& geometry) const {
  optics::Mueller<double> m(0.0);
  const double cos_r = std::cos(geometry.theta_r);
  if (!(std::cos(geometry.theta_i) > 0.0) || !(cos_r > 0.0)) return m;
  // Source at azimuth 0, exit turned by half a circle: there φ = 0 is away from the source.
  const double sine = std::sin(geometry.theta_r);
  const double x = std::sin(geometry.theta_i) - sine * std::cos(geometry.phi_r);
  const double y = -sine * std::sin(geometry.phi_r);
  const double theta_m = std::atan2(std::hypot(x, y), std::cos(geometry.theta_i) + cos_r);
  const double turn = std::atan2(y, x) / (2.0 * pi) + 0.5;
  const Point u = {std::sqrt(theta_m * 2.0 / pi), turn - std::floor(turn)};
  const Slices slices = slices_at(geometry.theta_i);
  Point s = u;
  if (!warp(slices, s)) return m;
  const brdf::AxisPlace w = brdf::place_on(wavelengths_um_, wavelength_um);
  double value = channel_value(slices, channels_[w.lower], s);
  if (w.weight != 0.0)
    value = (1.0 - w.weight) * value + w.weight * channel_value(slices, channels_[w.upper], s);
  m[0][0] = std::max(value * scale(u, geometry.theta_i) / std::max(cos_r, lowest_cosine), 0.0);
  return m;
}

}  // namespace umov::formats
