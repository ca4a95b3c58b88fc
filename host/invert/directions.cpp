#include "host/invert/directions.hpp"

#include <array>
#include <cmath>
#include <cstdio>
#include <string_view>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/number_csv.hpp"
#include "host/optics/angles.hpp"
#include "host/parallel/for_each_index.hpp"

namespace umov::invert {

std::vector<DirectionPrediction> predict_directions(const FittedModel& model,
                                                    const std::vector<Direction>& directions,
                                                    int threads) {
  std::vector<DirectionPrediction> out(directions.size());
  for_each_index(directions.size(), threads, [&](std::size_t i) {
    const Direction& d = directions[i];
    const std::size_t w = model.wavelength(d.wavelength_nm);
    const View view{{optics::radians(d.theta_i_deg), optics::radians(d.theta_r_deg),
                     optics::radians(d.phi_r_deg)}};
    out[i] = {d, model.brdf(w, view, channel_unpolarized()), model.dolp(w, view)};
  });
  return out;
}

std::vector<Direction> direction_grid(const std::string& name,
                                      const std::vector<double>& wavelengths_nm,
                                      const std::vector<double>& theta_i_deg) {
  const bool in_plane = name == "in-plane";
  if (!in_plane && name != "out-of-plane") {
    throw Error("'" + name + "' names no directions",
                "write in-plane, out-of-plane, or a .csv with theta_i_deg,theta_r_deg,phi_r_deg");
  }
  std::vector<Direction> out;
  for (const double nm : wavelengths_nm) {
    for (const double theta_i : theta_i_deg) {
      if (in_plane) {
        for (int theta_r = -75; theta_r <= 75; theta_r += 5) {
          out.push_back({nm, theta_i, static_cast<double>(theta_r), 0});
        }
        continue;
      }
      for (int phi = 30; phi <= 150; phi += 30) {
        for (int theta_r = 10; theta_r <= 70; theta_r += 10) {
          out.push_back({nm, theta_i, static_cast<double>(theta_r), static_cast<double>(phi)});
        }
      }
    }
  }
  return out;
}

std::vector<Direction> read_directions(const std::string& path,
                                       const std::vector<double>& wavelengths_nm) {
  static constexpr std::array<std::string_view, 4> columns{"wavelength_nm", "theta_i_deg",
                                                           "theta_r_deg", "phi_r_deg"};
  const std::string text = formats::read_whole_file(path);
  const bool spectral = formats::csv_header_line(text).find(columns[0]) != std::string_view::npos;
  const std::span<const std::string_view> wanted =
      spectral ? std::span<const std::string_view>(columns)
               : std::span<const std::string_view>(columns).subspan(1);
  std::vector<Direction> out;
  formats::read_number_csv(
      text, path, wanted, 0,
      [&](std::span<const std::string_view>, std::span<const double> n, std::size_t line) {
        const std::span<const double> angles = spectral ? n.subspan(1) : n;
        const auto check = [&](bool good, const char* column, const char* range) {
          if (!good) throw Error({path, line, column}, "lies outside its range", range);
        };
        check(angles[0] >= 0 && angles[0] < 90, "theta_i_deg", "give 0 up to, not including, 90");
        check(std::abs(angles[1]) < 90, "theta_r_deg", "give more than -90 and less than 90");
        check(std::abs(angles[2]) <= 360, "phi_r_deg", "give -360 to 360");
        if (spectral) {
          out.push_back({n[0], angles[0], angles[1], angles[2]});
          return;
        }
        for (const double nm : wavelengths_nm) out.push_back({nm, angles[0], angles[1], angles[2]});
      });
  if (out.empty()) throw Error({path}, "has no directions", "give a line for each");
  return out;
}

std::string directions_csv(const std::vector<DirectionPrediction>& predictions) {
  std::string text =
      "wavelength_nm,theta_i_deg,theta_r_deg,phi_r_deg,brdf_per_sr,brdf_u,brdf_lo,brdf_hi,dolp,"
      "dolp_u,dolp_lo,dolp_hi\n";
  char line[256];
  for (const DirectionPrediction& p : predictions) {
    std::snprintf(line, sizeof line, "%g,%g,%g,%g,%.10g,%.4g,%.10g,%.10g,%.10g,%.4g,%.10g,%.10g\n",
                  p.direction.wavelength_nm, p.direction.theta_i_deg, p.direction.theta_r_deg,
                  p.direction.phi_r_deg, p.brdf.value, p.brdf.u, p.brdf.lo, p.brdf.hi, p.dolp.value,
                  p.dolp.u, p.dolp.lo, p.dolp.hi);
    text += line;
  }
  return text;
}

}  // namespace umov::invert
