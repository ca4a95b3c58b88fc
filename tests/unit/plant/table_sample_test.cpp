#include "hil/plant/table_sample.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <sstream>

#include "hil/plant/sample_catalog.hpp"
#include "host/errors/error.hpp"

namespace umov::plant {
namespace {

/// A table of a sample on a grid, full Mueller matrix.
std::string tabulate(const Sample& sample, double step_deg) {
  std::ostringstream text;
  text << "# a test table\ntheta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm";
  for (int i = 0; i < 16; ++i) text << ",m" << i / 4 << i % 4;
  text << '\n';
  text.precision(15);
  for (double ti = 0; ti < 80; ti += step_deg) {
    for (double tr = 0; tr < 80; tr += step_deg) {
      for (double phi = 0; phi <= 180; phi += step_deg) {
        for (const double nm : {532.0, 814.0}) {
          text << ti << ',' << tr << ',' << phi << ',' << nm;
          const Mueller m = brdf_at(sample, ti, tr, phi, nm);
          for (int i = 0; i < 16; ++i) text << ',' << optics::element(m, i / 4, i % 4);
          text << '\n';
        }
      }
    }
  }
  return text.str();
}

TEST(TableSample, ReturnsItsEntriesAndInterpolatesBetweenThem) {
  const auto original = make_sample("black-matte");
  const TableSample table = TableSample::from_text(tabulate(*original, 5.0), "matte.csv");
  for (const double phi : {0.0, 40.0, -40.0, 180.0, -120.0}) {
    const Mueller a = brdf_at(*original, 30, 45, phi, 532);
    const Mueller b = brdf_at(table, 30, 45, phi, 532);
    for (int i = 0; i < 16; ++i) {
      EXPECT_NEAR(optics::element(a, i / 4, i % 4), optics::element(b, i / 4, i % 4),
                  1e-9 * optics::element(a, 0, 0))
          << phi << " " << i;
    }
  }
  const double between = optics::element(brdf_at(*original, 32, 41, 17, 532), 0, 0);
  EXPECT_NEAR(optics::element(brdf_at(table, 32, 41, 17, 532), 0, 0), between, 0.03 * between);
}

TEST(TableSample, TakesASignedInPlaneListOfScalars) {
  std::ostringstream text;
  text << "theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,brdf\n";
  for (const int tr : {-60, -30, 0, 30, 60})
    text << "0," << tr << ",0,633," << 0.3 + 0.001 * tr << '\n';
  const TableSample table = TableSample::from_text(text.str(), "plane.csv");
  EXPECT_NEAR(optics::element(brdf_at(table, 0, -30, 0, 633), 0, 0), 0.30, 0.0301);
  EXPECT_NEAR(optics::element(brdf_at(table, 20, -30, 0, 633), 0, 0), 0.27, 1e-12);
  EXPECT_NEAR(optics::element(brdf_at(table, 20, 45, 0, 900), 0, 0), 0.345, 1e-12);
  EXPECT_NEAR(optics::element(brdf_at(table, 20, 0, 0, 633), 0, 0), 0.3, 1e-12);
  EXPECT_EQ(optics::element(brdf_at(table, 20, 45, 0, 633), 1, 1), 0.0);
}

TEST(TableSample, RefusesBadTablesWithPlace) {
  const std::string head = "theta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,brdf\n";
  const auto refused = [](const std::string& text) -> std::pair<std::size_t, std::string> {
    try {
      TableSample::from_text(text, "t.csv");
    } catch (const Error& error) {
      EXPECT_EQ(error.place().file, "t.csv");
      return {error.place().line, error.place().column};
    }
    return {999, "accepted"};
  };
  EXPECT_EQ(refused(head + "0,0,0,633,nan\n"), (std::pair<std::size_t, std::string>(2, "brdf")));
  EXPECT_EQ(refused(head + "0,0,x,633,1\n"), (std::pair<std::size_t, std::string>(2, "phi_r_deg")));
  EXPECT_EQ(refused(head + "0,0,0,633\n").first, 2u);
  EXPECT_EQ(refused(head + "0,95,0,633,1\n").first, 2u);
  EXPECT_EQ(refused(head + "0,0,0,633,1\n0,0,0,633,1\n").first, 3u);
  EXPECT_EQ(refused("theta_i_deg,theta_r,phi_r_deg,wavelength_nm,brdf\n").second, "theta_r_deg");
  EXPECT_EQ(refused(head).first, 0u);
  // A hole: 2 × 2 angles with one corner missing.
  EXPECT_EQ(refused(head + "0,10,0,633,1\n0,20,0,633,1\n10,10,0,633,1\n").first, 0u);
}

}  // namespace
}  // namespace umov::plant
