#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include <fmt/format.h>

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/zemax_bsdf.hpp"
#include "host/optics/angles.hpp"

namespace umov::formats {
namespace {

std::vector<double> even_steps(double from, double to, double step) {
  std::vector<double> angles;
  for (int i = 0; from + i * step <= to + 1e-9; ++i) angles.push_back(from + i * step);
  return angles;
}

/// Steps of a fifth of the angle, from 0.02 to 2.5 degrees: a gloss peak of any width gets its
/// share.
std::vector<double> radial_steps() {
  std::vector<double> angles = {0.0, 0.02};
  while (angles.back() < 12.5) angles.push_back(angles.back() + std::max(0.02, angles.back() / 5));
  angles.back() = 12.5;
  for (const double angle : even_steps(15.0, 180.0, 2.5)) angles.push_back(angle);
  for (double& angle : angles) angle = std::round(angle * 1e4) / 1e4;
  return angles;
}

SpecularAxes written_axes() {
  SpecularAxes axes;
  axes.theta_i_deg = even_steps(0.0, 85.0, 5.0);
  axes.azimuth_deg = even_steps(0.0, 180.0, 5.0);
  axes.radial_deg = radial_steps();
  return axes;
}

/// Mean of both sides of the plane of incidence, of which the file holds one.
double two_sided(const brdf::Table& table, double wavelength_um, brdf::Geometry<double> geometry) {
  double sum = optics::element(table.at(wavelength_um, geometry), 0, 0);
  geometry.phi_r = -geometry.phi_r;
  sum += optics::element(table.at(wavelength_um, geometry), 0, 0);
  return std::max(0.5 * sum, 0.0);
}

/// ∫ BRDF cos θr dω, by three Gauss-Legendre nodes each way in every patch of radial and azimuth
/// steps.
double total_integrated_scatter(const brdf::Table& table, double wavelength_um, double theta_i,
                                const SpecularAxes& axes) {
  constexpr std::array<double, 3> node = {0.1127016653792583, 0.5, 0.8872983346207417};
  constexpr std::array<double, 3> weight = {5.0 / 18.0, 8.0 / 18.0, 5.0 / 18.0};
  double sum = 0.0;
  for (std::size_t r = 0; r + 1 < axes.radial_deg.size(); ++r) {
    const double r0 = optics::radians(axes.radial_deg[r]);
    const double dr = optics::radians(axes.radial_deg[r + 1]) - r0;
    for (std::size_t a = 0; a + 1 < axes.azimuth_deg.size(); ++a) {
      const double a0 = optics::radians(axes.azimuth_deg[a]);
      const double da = optics::radians(axes.azimuth_deg[a + 1]) - a0;
      for (std::size_t i = 0; i < node.size(); ++i) {
        const double radial = r0 + node[i] * dr;
        for (std::size_t k = 0; k < node.size(); ++k) {
          const auto g = geometry_of(theta_i, {radial, a0 + node[k] * da});
          const double cosine = std::cos(g.theta_r);
          if (!(cosine > 0.0)) continue;
          sum += 2.0 * weight[i] * weight[k] * dr * da * std::sin(radial) * cosine *
                 two_sided(table, wavelength_um, g);
        }
      }
    }
  }
  return sum;
}

SpecularTable sampled(const brdf::Table& table, const TableWriting& writing) {
  const double wavelength_um = single_wavelength(table, writing, "zemax");
  SpecularAxes axes = written_axes();
  std::vector<double> values, tis;
  for (std::size_t i = 0; i < axes.theta_i_deg.size(); ++i) {
    const double theta_i = optics::radians(axes.theta_i_deg[i]);
    for (const double azimuth : axes.azimuth_deg)
      for (const double radial : axes.radial_deg) {
        const auto g = geometry_of(theta_i, {optics::radians(radial), optics::radians(azimuth)});
        values.push_back(std::cos(g.theta_r) > 1e-6 ? two_sided(table, wavelength_um, g) : 0.0);
      }
    tis.push_back(total_integrated_scatter(table, wavelength_um, theta_i, axes));
    if (writing.progress)
      writing.progress(static_cast<double>(i + 1), static_cast<double>(axes.theta_i_deg.size()));
  }
  return {std::move(axes), {wavelength_um}, std::move(values), std::move(tis), "memory"};
}

void append_list(std::string& text, std::span<const double> numbers, bool exact) {
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    if (i > 0) text += ' ';
    if (exact) {
      append_shortest(text, numbers[i]);
    } else {
      fmt::format_to(std::back_inserter(text), "{:.8e}", numbers[i]);
    }
  }
  text += '\n';
}

/// `exact`: numbers keep every digit, since they came from a file.
std::string text_of(const SpecularTable& table, const TableHeader& header, bool exact) {
  const SpecularAxes& axes = table.axes();
  const bool tristimulus = table.wavelengths_um().size() == 3;
  std::string text;
  for (const std::string& line : header.lines()) text += "# " + line + "\n";
  text += "# values below the horizon are 0 and mean nothing\n";
  if (!exact)
    text +=
        "# TIS: directional-hemispherical reflectance of the source, not of the interpolated "
        "values\n";
  text += "Source  Measured\nSymmetry  ";
  text += axes.symmetric ? "PlaneSymmetrical" : "ASymmetrical";
  text += tristimulus ? "\nSpectralContent  XYZ" : "\nSpectralContent  Monochrome";
  text += "\nScatterType  BRDF\nSampleRotation  1\n0\n";
  const auto append_axis = [&](const char* name, const std::vector<double>& angles) {
    text += fmt::format("{}  {}\n", name, angles.size());
    append_list(text, angles, true);
  };
  append_axis("AngleOfIncidence", axes.theta_i_deg);
  append_axis("ScatterAzimuth", axes.azimuth_deg);
  append_axis("ScatterRadial", axes.radial_deg);
  const std::size_t incidences = axes.theta_i_deg.size(), radials = axes.radial_deg.size();
  const std::size_t azimuths = axes.azimuth_deg.size();
  for (std::size_t block = 0; block < table.wavelengths_um().size(); ++block) {
    // Wavelengths ascend (Z, Y, X), the file runs X, Y, Z.
    const std::size_t w = tristimulus ? 2 - block : block;
    constexpr std::array<const char*, 3> names = {"TristimulusX", "TristimulusY", "TristimulusZ"};
    text += fmt::format("\n{}\nDataBegin\n", tristimulus ? names[block] : "Monochrome");
    for (std::size_t i = 0; i < incidences; ++i) {
      text += "TIS ";
      append_list(text, table.tis().subspan(w * incidences + i, 1), exact);
      for (std::size_t a = 0; a < azimuths; ++a)
        append_list(
            text, table.values().subspan(((w * incidences + i) * azimuths + a) * radials, radials),
            exact);
    }
    text += "DataEnd\n";
  }
  return text;
}

bool holds_tristimulus(const SpecularTable& table) {
  return std::equal(table.wavelengths_um().begin(), table.wavelengths_um().end(),
                    std::begin(zemax_tristimulus_um), std::end(zemax_tristimulus_um));
}

}  // namespace

std::string write_zemax(const brdf::Table& table, const TableWriting& writing) {
  const auto header_of = [&](const std::vector<double>& wavelengths_um) {
    TableHeader header = table_header(table, writing, wavelengths_um, false);
    header.azimuth =
        "around the mirror direction, 0 towards the surface normal; ScatterRadial is the angle "
        "from "
        "the mirror direction; degrees";
    return header;
  };
  const auto* native = dynamic_cast<const SpecularTable*>(&table);
  if (native != nullptr && (written_wavelengths(table, writing) == native->wavelengths_um()) &&
      (native->wavelengths_um().size() == 1 || holds_tristimulus(*native))) {
    return text_of(*native, header_of(native->wavelengths_um()), true);
  }
  const SpecularTable own = sampled(table, writing);
  return text_of(own, header_of(own.wavelengths_um()), false);
}

}  // namespace umov::formats
