#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "host/formats/half_angle_table.hpp"
#include "host/formats/rgl_tensor.hpp"
#include "host/formats/table_comparison.hpp"
#include "host/formats/tensor_file.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/mueller.hpp"

namespace umov::formats {
namespace {

using optics::pi;

constexpr std::size_t incidences = 32;
constexpr double most_incidence_deg = 89.0;
constexpr std::size_t density_columns = 512;
constexpr std::size_t vndf_rows = 64, vndf_columns = 256;
/// Of the warped values; files of many wavelengths stay below some 20 MB.
constexpr std::size_t resolution_for(std::size_t wavelengths) {
  return wavelengths <= 4 ? 96 : 64;
}
/// Exit directions nearer to the horizon, or below it, take the value found here.
constexpr double lowest_cosine = 0.01;
constexpr double last_column = 1.0 - 1e-5;
/// The density of half vectors never falls below this share of its mean.
constexpr double least_density = 1e-9;

double grid(std::size_t index, std::size_t entries) {
  return static_cast<double>(index) / static_cast<double>(entries - 1);
}

double theta_of(double u) {
  return 0.5 * pi * u * u;
}

float as_float(double value) {
  return static_cast<float>(value);
}

/// Density of half vectors over polar angle, from the table: 4 f cos θi cos θr, averaged over pairs
/// of beams that lie symmetrically about the half vector and so are both above the horizon. For a
/// surface of facets that is their slope distribution times Fresnel reflectance and shadowing; any
/// positive density would do, this one puts the samples where light goes.
std::vector<double> half_vector_density(const brdf::Table& table,
                                        const std::vector<double>& wavelengths_um) {
  std::vector<double> density(density_columns, 0.0);
  double mean = 0.0;
  for (std::size_t column = 0; column < density_columns; ++column) {
    const double theta_h = std::min(theta_of(grid(column, density_columns)), 0.5 * pi - 1e-3);
    for (const double theta_d : {0.0, 0.35, 0.7, 1.05}) {
      const double cosine = std::cos(theta_h) * std::cos(theta_d);
      const auto geometry = geometry_of({theta_h, theta_d, 0.5 * pi});
      for (const double um : wavelengths_um)
        density[column] +=
            cosine * cosine * std::max(optics::element(table.at(um, geometry), 0, 0), 0.0);
    }
    mean += density[column] / static_cast<double>(density_columns);
  }
  for (double& value : density) value = mean > 0.0 ? value / mean + least_density : 1.0;
  return density;
}

/// σ(θi) = ∫ D(m) max(0, m·i) dω: midpoints over azimuth, trapezoids over the density's own grid.
double projected_area(const std::vector<double>& density, double theta_i) {
  constexpr std::size_t azimuths = 90;
  std::array<double, azimuths> cosines;
  for (std::size_t k = 0; k < azimuths; ++k)
    cosines[k] = std::cos((static_cast<double>(k) + 0.5) * pi / azimuths);
  double sum = 0.0;
  for (std::size_t column = 0; column < density.size(); ++column) {
    const double u = grid(column, density.size());
    const double theta = theta_of(u);
    const double along = std::cos(theta) * std::cos(theta_i);
    const double across = std::sin(theta) * std::sin(theta_i);
    double ring = 0.0;
    for (const double cosine : cosines) ring += std::max(along + across * cosine, 0.0);
    const double weight = column == 0 || column + 1 == density.size() ? 0.5 : 1.0;
    sum += weight * density[column] * std::sin(theta) * pi * u * ring * 2.0 * pi / azimuths;
  }
  return sum / static_cast<double>(density.size() - 1);
}

/// f cos θr where the half vector stands at u. Below the horizon the value at the horizon goes on,
/// times the negative cosine: so interpolation across the horizon is right above it.
double radiance_at(const brdf::Table& table, double wavelength_um, double theta_i,
                   RglTable::Point u) {
  const double theta_m = theta_of(u.x), phi_m = (2.0 * u.y - 1.0) * pi;
  const double mx = std::sin(theta_m) * std::cos(phi_m), my = std::sin(theta_m) * std::sin(phi_m);
  const double mz = std::cos(theta_m);
  const double ix = std::sin(theta_i), iz = std::cos(theta_i);
  const double along = mx * ix + mz * iz;
  const double x = 2.0 * along * mx - ix, y = 2.0 * along * my, z = 2.0 * along * mz - iz;
  const double theta_r = std::acos(std::clamp(z, lowest_cosine, 1.0));
  const double phi_r = std::atan2(-y, -x);
  return z * optics::element(table.at(wavelength_um, {theta_i, theta_r, phi_r}), 0, 0);
}

void set_axes(RglData& data, const std::vector<double>& wavelengths_um) {
  data.phi_i = {0.0f};
  for (std::size_t i = 0; i < incidences; ++i)
    // Closer towards grazing, where Fresnel reflectance and shadowing change fastest.
    data.theta_i.push_back(as_float(optics::radians(most_incidence_deg) *
                                    (1.0 - std::pow(1.0 - grid(i, incidences), 1.5))));
  for (const double um : wavelengths_um) data.wavelengths_nm.push_back(as_float(um * 1e3));
}

void set_densities(RglData& data, const std::vector<double>& density) {
  data.ndf_rows = data.sigma_rows = 2;
  data.ndf_columns = data.sigma_columns = density_columns;
  for (int row = 0; row < 2; ++row)
    for (const double value : density) data.ndf.push_back(as_float(value));
  for (std::size_t column = 0; column < density_columns; ++column)
    data.sigma.push_back(
        as_float(projected_area(density, theta_of(grid(column, density_columns)))));
  data.sigma.insert(data.sigma.end(), data.sigma.begin(), data.sigma.begin() + density_columns);
}

/// Where the samples go. Any density does for the value of the BRDF, and a reader's importance
/// sampling stays right, since `luminance` makes up for it. This one gives each its share: the
/// light itself, its square root (so that flanks and feet of a peak get samples too), and the
/// square of the half vectors (so that nothing stays without).
void set_warp(RglData& data, const brdf::Table& table, const std::vector<double>& wavelengths_um) {
  constexpr std::array<double, 3> shares = {0.2, 0.5, 0.3};
  const std::size_t count = wavelengths_um.size();
  std::vector<double> some = wavelengths_um;
  if (count > 3) some = {wavelengths_um[0], wavelengths_um[count / 2], wavelengths_um[count - 1]};
  data.vndf_rows = vndf_rows;
  data.vndf_columns = vndf_columns;
  std::array<std::vector<double>, 3> parts;
  for (const float incidence : data.theta_i) {
    const double theta_i = double{incidence};
    for (auto& part : parts) part.clear();
    for (std::size_t row = 0; row < vndf_rows; ++row)
      for (std::size_t column = 0; column < vndf_columns; ++column) {
        const RglTable::Point u = {grid(column, vndf_columns), grid(row, vndf_rows)};
        const double theta = theta_of(u.x), phi = (2.0 * u.y - 1.0) * pi;
        const double along = std::cos(theta) * std::cos(theta_i) +
                             std::sin(theta) * std::sin(theta_i) * std::cos(phi);
        // dω of the half vector in units of the square, times the cosine between it and the beam.
        const double area = std::max(along, 0.0) * std::sin(theta) * u.x;
        double radiance = 0.0;
        if (area > 0.0)
          for (const double um : some)
            radiance += std::max(radiance_at(table, um, theta_i, u), 0.0);
        parts[0].push_back(radiance * area);
        parts[1].push_back(std::sqrt(radiance * area));
        parts[2].push_back(area > 0.0 ? 1.0 : 0.0);
      }
    std::array<double, 3> scale{};
    for (std::size_t k = 0; k < parts.size(); ++k) {
      const double sum = std::accumulate(parts[k].begin(), parts[k].end(), 0.0);
      if (sum > 0.0) scale[k] = shares[k] / sum;
    }
    for (std::size_t i = 0; i < parts[0].size(); ++i)
      data.vndf.push_back(
          as_float(scale[0] * parts[0][i] + scale[1] * parts[1][i] + scale[2] * parts[2][i]));
  }
}

}  // namespace

RglData rgl_fit(const brdf::Table& table, const std::vector<double>& wavelengths_um,
                const std::function<void(double, double)>& progress) {
  RglData data;
  set_axes(data, wavelengths_um);
  set_densities(data, half_vector_density(table, wavelengths_um));
  set_warp(data, table, wavelengths_um);
  const std::size_t resolution = resolution_for(wavelengths_um.size());
  data.resolution = resolution;
  const std::size_t image = resolution * resolution;
  data.luminance.assign(incidences * image, 0.0f);
  data.spectra.assign(incidences * image * wavelengths_um.size(), 0.0f);
  data.valid.assign(incidences * image / 8, 0);
  // The warp, from the very numbers that a reader will have.
  const RglTable warp(data, "memory");
  for (std::size_t i = 0; i < incidences; ++i) {
    const double theta_i = double{data.theta_i[i]};
    for (std::size_t entry = 0; entry < image; ++entry) {
      // The outermost column stands at θm = 90°, where a narrow peak has left no light: what is
      // found just inside it serves the tail better.
      const double x = std::min(grid(entry % resolution, resolution), last_column);
      const RglTable::Point u = warp.unwarped(i, {x, grid(entry / resolution, resolution)});
      const double scale = warp.scale(u, theta_i);
      double mean = 0.0;
      for (std::size_t w = 0; w < wavelengths_um.size(); ++w) {
        const double radiance = radiance_at(table, wavelengths_um[w], theta_i, u);
        const double value = scale > 0.0 ? radiance / scale : 0.0;
        data.spectra[(i * wavelengths_um.size() + w) * image + entry] = as_float(value);
        mean += std::max(value, 0.0) / static_cast<double>(wavelengths_um.size());
        if (radiance > 0.0)
          data.valid[(i * image + entry) / 8] |= static_cast<std::uint8_t>(0x80U >> (entry % 8));
      }
      data.luminance[i * image + entry] = as_float(mean);
    }
    if (progress) progress(static_cast<double>(i + 1), static_cast<double>(incidences));
  }
  return data;
}

std::string rgl_bytes(const RglData& data) {
  const std::size_t phis = data.phi_i.size(), thetas = data.theta_i.size();
  TensorBuilder file;
  file.add("description", data.description);
  file.add("jacobian", {1},
           std::array<std::uint8_t, 1>{data.jacobian ? std::uint8_t{1} : std::uint8_t{0}});
  file.add("luminance", {phis, thetas, data.resolution, data.resolution}, data.luminance);
  file.add("ndf", {data.ndf_rows, data.ndf_columns}, data.ndf);
  file.add("phi_i", {phis}, data.phi_i);
  const bool spectral = !data.wavelengths_nm.empty();
  file.add(spectral ? "spectra" : "rgb",
           {phis, thetas, data.channels(), data.resolution, data.resolution}, data.spectra);
  file.add("sigma", {data.sigma_rows, data.sigma_columns}, data.sigma);
  file.add("theta_i", {thetas}, data.theta_i);
  if (!data.valid.empty()) file.add("valid", {data.valid.size()}, data.valid);
  file.add("vndf", {phis, thetas, data.vndf_rows, data.vndf_columns}, data.vndf);
  if (spectral) file.add("wavelengths", {data.wavelengths_nm.size()}, data.wavelengths_nm);
  return file.finish();
}

std::string write_rgl(const brdf::Table& table, const TableWriting& writing) {
  if (const auto* native = dynamic_cast<const RglTable*>(&table);
      native != nullptr && writing.wavelengths_um.empty())
    return rgl_bytes(native->data());
  const std::vector<double> wavelengths = written_wavelengths(table, writing);
  RglData data = rgl_fit(table, wavelengths, writing.progress);
  TableHeader header = table_header(table, writing, wavelengths, false);
  header.quantity =
      "spectra * ndf / (4 sigma) is BRDF in 1/sr (radiance over irradiance) times cos theta_r";
  header.azimuth =
      "of the half vector, radians, 0 is towards the source; the specular exit is at half vector 0";
  header.notes.push_back("read back, it " +
                         compare_tables(RglTable(data, "memory"), table, wavelengths).sentence());
  data.description = header.description;
  for (const std::string& line : header.lines()) data.description += "\n" + line;
  return rgl_bytes(data);
}

}  // namespace umov::formats
