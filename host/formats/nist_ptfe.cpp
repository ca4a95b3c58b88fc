// Conventions of the table, found from the data and checked in tests/unit/formats:
// - thetai is the (negative) angle of the source on the -x side, so |thetai| is the incidence and
//   phir = 0 the forward half-plane, as here; 0.001 deg stands for 0.
// - The incident Stokes vector is in the basis {s, p} of the plane of incidence with Q > 0 for s
// and
//   the same handedness as here. The exit vector is referred to axes that do not turn with phir:
//   at normal incidence m21, m31 go as cos 2 phir, sin 2 phir, which for an isotropic surface is
//   only possible so. Turning the exit basis by phir brings them to {s, p}; then m12 = m21,
//   m13 = m31, m23 = m32 hold at theta_r = theta_i within the scatter of .003/sr, as reciprocity
//   wants, and the other choices of sign and turn fail by two to five times that.
// - The sign of V is left as it stands; nothing in the linear block depends on it.
#include "host/formats/nist_ptfe.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numbers>
#include <tuple>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/number_csv.hpp"

namespace umov::formats {
namespace {

constexpr std::array<std::string_view, 21> columns = {
    "lambda",      "thetai",      "phi",         "thetar",      "phir",        "f_r11",
    "f_r12/f_r11", "f_r13/f_r11", "f_r14/f_r11", "f_r21/f_r11", "f_r22/f_r11", "f_r23/f_r11",
    "f_r24/f_r11", "f_r31/f_r11", "f_r32/f_r11", "f_r33/f_r11", "f_r34/f_r11", "f_r41/f_r11",
    "f_r42/f_r11", "f_r43/f_r11", "f_r44/f_r11"};

constexpr double normal_incidence_deg = 0.002;  ///< below it the table means 0
constexpr double in_plane_deg = 1e-6;

/// Turns the basis of the exit beam by `angle` about its direction.
std::array<double, 16> turn_exit(const std::array<double, 16>& m, double angle) {
  const double c = std::cos(2 * angle), s = std::sin(2 * angle);
  std::array<double, 16> turned = m;
  for (std::size_t j = 0; j < 4; ++j) {
    turned[4 + j] = c * m[4 + j] + s * m[8 + j];
    turned[8 + j] = -s * m[4 + j] + c * m[8 + j];
  }
  return turned;
}

double snapped(double theta_deg) {
  return std::abs(theta_deg) < normal_incidence_deg ? 0.0 : std::abs(theta_deg);
}

void add_row(MuellerTable& table, std::span<const double> row, const std::string& name,
             std::size_t line) {
  const auto refuse = [&](const char* column, const char* problem) {
    throw Error(Place{name, line, column}, problem, "check the line against the published table");
  };
  const double wavelength_um = row[0], phi_i_deg = row[2], f11 = row[5];
  double theta_r_deg = snapped(row[3]), phi_r_deg = row[4];
  if (wavelength_um < 0.1 || wavelength_um > 20) refuse("lambda", "no wavelength in micrometres");
  if (row[1] > 0 || row[1] < -90) refuse("thetai", "not within -90 to 0 deg");
  if (phi_i_deg != 0) refuse("phi", "the table has all incidence at phi = 0");
  if (row[3] < 0 || row[3] > 90) refuse("thetar", "not within 0 to 90 deg");
  if (phi_r_deg < -180 || phi_r_deg > 180) refuse("phir", "not within -180 to 180 deg");
  if (f11 <= 0 || f11 > 1e6) refuse("f_r11", "not a positive BRDF");
  std::array<double, 16> mueller;
  mueller[0] = f11;
  for (std::size_t i = 1; i < 16; ++i) {
    if (std::abs(row[5 + i]) > 2) refuse(columns[5 + i].data(), "far above f_r11");
    mueller[i] = f11 * row[5 + i];
  }
  mueller = turn_exit(mueller, phi_r_deg * std::numbers::pi / 180);
  // In plane the angle is signed; turning by 180 deg changes no Stokes vector. The table's forward
  // azimuths are 1e-15 and the like.
  if (180 - std::abs(phi_r_deg) < in_plane_deg) {
    theta_r_deg = -theta_r_deg;
    phi_r_deg = 0;
  } else if (std::abs(phi_r_deg) < in_plane_deg) {
    phi_r_deg = 0;
  }
  table.theta_i_deg.push_back(snapped(row[1]));
  table.theta_r_deg.push_back(theta_r_deg + 0.0);
  table.phi_r_deg.push_back(phi_r_deg);
  table.wavelength_nm.push_back(std::round(wavelength_um * 1e6) / 1e3);
  table.mueller.push_back(mueller);
}

/// Polar angles that share an uncertainty: it grows with the detector's angle.
std::size_t angle_bin(double theta_r_deg) {
  const double theta = std::abs(theta_r_deg);
  return theta < 30 ? 0 : theta < 50 ? 1 : theta < 70 ? 2 : 3;
}

struct Scatter {
  double m00 = 0, elements = 0;
  std::size_t pairs = 0;
};

/// The table says nothing of uncertainties. The surface is isotropic, so f at +phi and -phi must be
/// mirror images: what they differ by measures the scatter.
void estimate_uncertainties(MuellerTable& table) {
  using Direction = std::tuple<double, double, long, long>;
  const auto rounded = [](double deg) { return std::lround(deg * 100); };
  std::map<Direction, std::size_t> at;
  for (std::size_t n = 0; n < table.size(); ++n)
    at[{table.wavelength_nm[n], table.theta_i_deg[n], rounded(table.theta_r_deg[n]),
        rounded(table.phi_r_deg[n])}] = n;
  std::map<std::pair<double, std::size_t>, Scatter> scatter;
  for (const auto& [direction, n] : at) {
    const auto& [wavelength_nm, theta_i_deg, theta_r, phi_r] = direction;
    if (phi_r <= 0) continue;
    const auto mirrored = at.find({wavelength_nm, theta_i_deg, theta_r, -phi_r});
    if (mirrored == at.end()) continue;
    const auto& a = table.mueller[n];
    const auto& b = table.mueller[mirrored->second];
    Scatter& here = scatter[{wavelength_nm, angle_bin(table.theta_r_deg[n])}];
    const double difference = 2 * (a[0] - b[0]) / (a[0] + b[0]);
    here.m00 += difference * difference / 2;
    for (std::size_t i = 0; i < 3; ++i)
      for (std::size_t j = 0; j < 3; ++j) {
        if (i + j == 0) continue;
        const double sign = (i == 2) == (j == 2) ? 1 : -1;
        const double d = a[4 * i + j] / a[0] - sign * b[4 * i + j] / b[0];
        here.elements += d * d / 2 / 8;
      }
    ++here.pairs;
  }
  // A subset without mirror pairs keeps what the whole table shows at large angles.
  constexpr double default_m00_u = 0.02, default_element_u = 0.01;
  for (std::size_t n = 0; n < table.size(); ++n) {
    const auto found = scatter.find({table.wavelength_nm[n], angle_bin(table.theta_r_deg[n])});
    const bool enough = found != scatter.end() && found->second.pairs >= 10;
    const double pairs = enough ? static_cast<double>(found->second.pairs) : 1;
    table.m00_relative_u.push_back(enough ? std::sqrt(found->second.m00 / pairs) : default_m00_u);
    table.element_relative_u.push_back(enough ? std::sqrt(found->second.elements / pairs)
                                              : default_element_u);
  }
}

MuellerTable parse(std::string_view text, const std::string& name) {
  MuellerTable table;
  table.keys = {{"sample", "sintered PTFE"},
                {"role", "sample"},
                {"source", "T. A. Germer, Applied Optics 2017 (NIST)"},
                {"uncertainty", "from mirror pairs of the table itself"}};
  read_number_csv(text, name, columns, 0,
                  [&](std::span<const std::string_view>, std::span<const double> row,
                      std::size_t line) { add_row(table, row, name, line); });
  estimate_uncertainties(table);
  return table;
}

}  // namespace

MuellerTable read_nist_ptfe(const std::filesystem::path& path) {
  return parse(read_whole_file(path), path.string());
}

MuellerTable read_nist_ptfe(std::istream& in, const std::string& name) {
  return parse(read_stream(in, name), name);
}

}  // namespace umov::formats
