// The page: its data, what happens to hostile names, and parts that are not there.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <fstream>
#include <map>
#include <nlohmann/json.hpp>
#include "host/errors/error.hpp"
#include "host/report/report.hpp"
#include "tests/unit/report/synthetic.hpp"

namespace umov::report {
namespace {

using nlohmann::json;
using ::testing::HasSubstr;

const Options options{"A title", "umov test", "umov report brdf.h5 fit.json",
                      "2026-01-02T03:04:05Z"};

json data_of(const std::vector<Sample>& samples) {
  return json::parse(page_data(samples, options));
}

/// Text between the tags of the data element, as a browser would find it.
std::string data_element(const std::string& html) {
  const std::string open = R"(id="umov-data">)";
  const auto from = html.find(open) + open.size();
  return html.substr(from, html.find("</script", from) - from);
}

const json& find_curve(const json& set, double nm, double theta, const std::string& state) {
  for (const json& c : set["curves"])
    if (c["wavelength_nm"] == nm && c["theta_i_deg"] == theta && c.value("state", state) == state)
      return c;
  throw std::runtime_error("no such curve");
}

TEST(Page, holds_its_data_as_json_that_reads_back) {
  const std::string html = page({synthetic::red_gloss()}, options);
  const json data = json::parse(data_element(html));
  EXPECT_EQ(data["title"], "A title");
  EXPECT_EQ(data["samples"].size(), 1u);
  EXPECT_EQ(data, data_of({synthetic::red_gloss()}));
}

TEST(Page, asks_nothing_of_the_network_and_carries_the_licence_of_plotly) {
  const std::string html = page({synthetic::diffuse_standard()}, options);
  EXPECT_THAT(html.substr(0, 4000), HasSubstr("default-src 'none'"));
  EXPECT_THAT(html, HasSubstr("Copyright 2012-2021, Plotly, Inc."));
  EXPECT_EQ(html.find("<script src"), std::string::npos);
  EXPECT_EQ(html.find("<link rel=\"stylesheet"), std::string::npos);
  EXPECT_EQ(html.find("{{"), html.find("{{", html.find("id=\"umov-data\"")))
      << "a slot of the template was left open";
  EXPECT_GT(html.size(), 3'000'000u) << "plotly.js is not inside";
}

TEST(Page, shows_a_hostile_sample_name_as_text) {
  const std::string name = "</script><script>alert('x')</script><!-- \"&\xE2\x80\xA8";
  Options hostile = options;
  hostile.title = name;
  hostile.program = "\"><img src=x onerror=alert(1)>";
  const std::string html = page({synthetic::red_gloss(name)}, hostile);
  EXPECT_EQ(html.find("<script>alert"), std::string::npos);
  EXPECT_EQ(html.find("<img"), std::string::npos);
  const json data = json::parse(data_element(html));
  EXPECT_EQ(data["samples"][0]["name"], name);
  EXPECT_EQ(data["title"], name);
  EXPECT_THAT(html, HasSubstr("<title>&lt;/script&gt;"));
}

TEST(Page, survives_header_values_that_are_no_utf8) {
  Sample sample = synthetic::diffuse_standard();
  sample.brdf->file.table.keys.emplace_back("operator", "J\xFCrgen");
  const json data = data_of({sample});
  EXPECT_THAT(data.dump(), HasSubstr("J\xEF\xBF\xBDrgen"));
}

TEST(PageData, brdf_curves_hold_every_used_point_of_the_plane_with_its_total_uncertainty) {
  const Sample sample = synthetic::red_gloss();
  const json data = data_of({sample});
  const json& brdf = data["samples"][0]["brdf"];
  std::size_t shown = 0, flagged = 0;
  for (const json& c : brdf["curves"]) {
    shown += c["x"].size();
    if (c.contains("flagged")) flagged += c["flagged"]["x"].size();
    EXPECT_EQ(c["x"].size(), c["y"].size());
    EXPECT_EQ(c["x"].size(), c["u"].size());
    EXPECT_TRUE(c.contains("model"));
  }
  const auto& used = sample.brdf->file.table.points.used;
  EXPECT_EQ(shown, static_cast<std::size_t>(std::count(used.begin(), used.end(), 1)));
  EXPECT_EQ(flagged, used.size() - shown);
  // 0.8 % noise and 1 % gain, in quadrature.
  const json& curve = find_curve(brdf, 633, 30, "P,U");
  const std::size_t middle = curve["x"].size() / 2;
  EXPECT_NEAR(curve["u"][middle].get<double>() / curve["y"][middle].get<double>(),
              std::hypot(0.008, 0.01), 8e-4);
}

TEST(PageData, the_retro_side_of_a_table_with_azimuth_180_is_negative) {
  const json data = data_of({synthetic::diffuse_standard()});
  const json& curve = find_curve(data["samples"][0]["brdf"], 532, 45, "U,U");
  EXPECT_EQ(curve["x"].front(), -75);
  EXPECT_EQ(curve["x"].back(), 75);
  EXPECT_EQ(curve["x"].size(), 16u);
}

TEST(PageData, the_model_line_meets_the_measurement) {
  const json data = data_of({synthetic::red_gloss()});
  const json& curve = find_curve(data["samples"][0]["brdf"], 532, 45, "S,S");
  const auto mx = curve["model"]["x"].get<std::vector<double>>();
  const auto my = curve["model"]["y"].get<std::vector<double>>();
  std::size_t compared = 0;
  for (std::size_t i = 0; i < curve["x"].size(); ++i) {
    const auto at = std::find(mx.begin(), mx.end(), curve["x"][i].get<double>());
    if (at == mx.end()) continue;
    const double model = my[static_cast<std::size_t>(at - mx.begin())];
    EXPECT_NEAR(curve["y"][i].get<double>(), model, 5 * curve["u"][i].get<double>());
    ++compared;
  }
  EXPECT_GT(compared, 60u);
}

TEST(PageData, residuals_of_the_true_model_scatter_by_one) {
  const json data = data_of({synthetic::red_gloss()});
  double sum = 0;
  std::size_t n = 0;
  for (const json& group : data["samples"][0]["residuals"]["groups"])
    for (const double z : group["z"]) sum += z * z, ++n;
  ASSERT_GT(n, 3000u);
  // The gains of the factors are taken out; left over is the noise.
  EXPECT_NEAR(sum / static_cast<double>(n), 1.0, 0.06);
}

TEST(PageData, prediction_out_of_the_plane_is_judged_apart_from_the_plane) {
  const json data = data_of({synthetic::diffuse_standard()});
  const json& statistics = data["samples"][0]["prediction"]["statistics"];
  ASSERT_EQ(statistics.size(), 2u);
  const auto percent = [](const json& text) { return std::stod(text.get<std::string>()); };
  EXPECT_EQ(statistics[0]["in_plane"]["points"], "48");
  EXPECT_EQ(statistics[0]["out_of_plane"]["points"], "384");
  EXPECT_NEAR(percent(statistics[0]["out_of_plane"]["median"]), 1.96, 0.15);
  EXPECT_LT(percent(statistics[0]["in_plane"]["median"]), 0.4);
  EXPECT_THAT(statistics[0]["out_of_plane"]["mean"].get<std::string>(), HasSubstr("−1.9"));
}

TEST(PageData, a_measurement_in_the_plane_alone_has_no_prediction_section) {
  EXPECT_FALSE(data_of({synthetic::red_gloss()})["samples"][0].contains("prediction"));
}

TEST(PageData, k_n_has_the_rows_of_the_paper_in_its_order) {
  const json data = data_of({synthetic::red_gloss()});
  const json& fit = data["samples"][0]["fit"];
  std::vector<std::string> names;
  for (const json& row : fit["k_n"]) names.push_back(row["name"]);
  EXPECT_THAT(names, ::testing::ElementsAre("k_dd", "k_uds", "k_udf", "k_fs"));
  EXPECT_EQ(fit["k_n"][1]["cells"][1]["text"], "0.4860 ± 0.0024");
  for (const json& row : fit["parameters"])
    EXPECT_EQ(row["name"].get<std::string>().find("k_"), std::string::npos);
}

TEST(PageData, a_model_without_four_k_has_only_a_parameter_table) {
  const json data = data_of({synthetic::diffuse_standard()});
  const json& fit = data["samples"][0]["fit"];
  EXPECT_FALSE(fit.contains("k_n"));
  EXPECT_EQ(fit["parameters"].size(), 2u);
  EXPECT_EQ(fit["parameters"][0]["unit"], "sr⁻¹");
}

TEST(PageData, numbers_that_cannot_stand_alone_are_marked) {
  const json data = data_of({synthetic::red_gloss()});
  std::map<std::string, json> rows;
  for (const json& row : data["samples"][0]["fit"]["parameters"]) rows[row["name"]] = row;
  EXPECT_EQ(rows["kappa"]["cells"][0]["mark"], "lower");
  EXPECT_EQ(rows["kappa"]["cells"][0]["text"], "< 0.021");
  EXPECT_FALSE(rows["kappa"]["cells"][1].contains("mark"));
  EXPECT_EQ(rows["sigma_um"]["cells"][0]["mark"], "weak");
}

TEST(PageData, correlations_are_normalised) {
  const json data = data_of({synthetic::red_gloss()});
  const json& c = data["samples"][0]["fit"]["correlation"];
  EXPECT_EQ(c["values"][0], 1);
  EXPECT_EQ(c["values"][1 * 5 + 2], 0.998);
  EXPECT_EQ(c["values"][4 * 5 + 3], -0.93);
}

TEST(PageData, the_lobe_is_the_fitted_model_on_a_grid) {
  const Sample sample = synthetic::red_gloss();
  const json data = data_of({sample});
  const json& lobe = data["samples"][0]["lobe"];
  ASSERT_EQ(lobe["grids"].size(), 4u);
  for (const json& grid : lobe["grids"]) {
    const std::size_t n = grid["theta_deg"].size() * grid["phi_deg"].size();
    for (const char* nm : {"532", "633", "814"}) {
      ASSERT_EQ(grid["brdf"][nm].size(), n);
      ASSERT_EQ(grid["dolp"][nm].size(), n);
    }
    EXPECT_EQ(grid["phi_deg"].front(), 0);
    EXPECT_EQ(grid["phi_deg"].back(), 180);
  }
  // The largest value lies at the mirror direction.
  const json& grid = lobe["grids"][1];
  const auto f = grid["brdf"]["532"].get<std::vector<double>>();
  const auto peak = static_cast<std::size_t>(std::max_element(f.begin(), f.end()) - f.begin());
  EXPECT_NEAR(grid["theta_deg"][peak / grid["phi_deg"].size()].get<double>(), 30, 1.1);
  EXPECT_EQ(peak % grid["phi_deg"].size(), 0u);
}

TEST(PageData, key_numbers_name_dhr_and_dolp_at_the_mirror_direction) {
  const json data = data_of({synthetic::red_gloss()});
  const json& key = data["samples"][0]["key"];
  EXPECT_EQ(key["rows"][0]["name"], "DHR measured, θi = 0°");
  EXPECT_EQ(key["rows"][0]["cells"][1], "0.5311 ± 0.0078");
  EXPECT_EQ(key["rows"][2]["name"], "DOLP in the mirror direction, θi = 30°");
  EXPECT_THAT(key["rows"][2]["cells"][0].get<std::string>(), ::testing::StartsWith("0.9"));
}

TEST(PageData, a_measurement_without_a_fit_shows_what_it_has) {
  Sample sample = synthetic::red_gloss();
  sample.fit.reset();
  const json one = data_of({sample})["samples"][0];
  EXPECT_TRUE(one.contains("brdf"));
  EXPECT_TRUE(one.contains("dolp"));
  EXPECT_TRUE(one.contains("dhr"));
  for (const char* part : {"fit", "lobe", "residuals", "prediction"})
    EXPECT_FALSE(one.contains(part)) << part;
  for (const json& c : one["brdf"]["curves"]) EXPECT_FALSE(c.contains("model"));
}

TEST(PageData, a_fit_without_its_measurement_shows_the_model_alone) {
  Sample sample = synthetic::red_gloss();
  sample.brdf.reset();
  const json one = data_of({sample})["samples"][0];
  EXPECT_TRUE(one.contains("fit"));
  EXPECT_TRUE(one.contains("lobe"));
  EXPECT_FALSE(one.contains("residuals"));
  EXPECT_EQ(one["brdf"]["states"].size(), 1u);
  EXPECT_EQ(one["brdf"]["theta_i_deg"], json({0, 30, 60}));
}

TEST(PageData, a_scan_or_calibration_alone_makes_a_section) {
  Sample scan, cal;
  scan.scans.push_back(synthetic::raw_scan());
  cal.calibration = synthetic::calibration();
  const json data = data_of({scan, cal});
  const json& raw = data["samples"][0]["scans"][0];
  EXPECT_EQ(raw["series"].size(), 3u);
  EXPECT_EQ(raw["ranges"].size(), 4u);
  EXPECT_THAT(raw["summary"].get<std::string>(), HasSubstr("flip (records 10 to 20)"));
  EXPECT_EQ(raw["saturated"]["time_s"].size(),
            (synthetic::raw_scan().file.table.size() + 905) / 911);
  const json& c = data["samples"][1]["calibration"];
  EXPECT_EQ(c["curves"].size(), 3u);
  EXPECT_EQ(c["wavelengths_nm"], json({532, 633, 814}));
}

TEST(PageData, wavelengths_that_were_not_fitted_are_named) {
  Sample sample = synthetic::diffuse_standard();
  auto& fit = sample.fit->fit;
  fit.wavelengths_nm = {532};
  for (auto& parameter : fit.parameters) parameter.estimates.resize(1);
  const json one = data_of({sample})["samples"][0];
  EXPECT_THAT(one["warnings"].dump(), HasSubstr("Measured but not fitted: 633 nm"));
  EXPECT_FALSE(find_curve(one["brdf"], 633, 45, "U,U").contains("model"));
  EXPECT_EQ(one["prediction"]["wavelengths_nm"], json({532}));
}

TEST(PageData, one_point_and_an_empty_scan_are_shown_as_such) {
  const json one = data_of({synthetic::nearly_nothing()})["samples"][0];
  EXPECT_EQ(one["wavelengths_nm"], json({632.8}));
  EXPECT_EQ(one["brdf"]["states"][0]["polarizer"], "45°");
  EXPECT_EQ(one["brdf"]["curves"][0]["y"], json({-1e-5}));
  EXPECT_FALSE(one.contains("dolp"));
  EXPECT_THAT(one["scans"][0]["summary"].get<std::string>(), HasSubstr("0 records"));
}

TEST(PageData, a_measurement_without_points_has_no_curves) {
  Sample sample = synthetic::nearly_nothing();
  sample.brdf->file.table = {};
  const json one = data_of({sample})["samples"][0];
  EXPECT_FALSE(one.contains("brdf"));
  EXPECT_EQ(one["wavelengths_nm"], json::array());
}

TEST(PageData, a_fit_with_an_unknown_model_is_refused_by_name) {
  Sample sample = synthetic::diffuse_standard();
  sample.fit->fit.model = "torrance-cook";
  try {
    data_of({sample});
    FAIL() << "accepted";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("torrance-cook"));
  }
}

// Not a check by itself: the browser test lets this write a page with everything on it.
TEST(Page, writes_a_page_for_the_browser) {
  const char* path = std::getenv("UMOV_REPORT_PAGE");
  if (path == nullptr) GTEST_SKIP() << "UMOV_REPORT_PAGE names no file";
  Sample gloss = synthetic::red_gloss("red gloss <script>alert(1)</script>");
  gloss.name = gloss.brdf->file.table.keys.front().second;
  gloss.scans.push_back(synthetic::raw_scan());
  gloss.calibration = synthetic::calibration();
  std::ofstream out(path, std::ios::binary);
  out << page({gloss, synthetic::diffuse_standard(), synthetic::nearly_nothing()}, options);
  ASSERT_TRUE(out.good());
}

}  // namespace
}  // namespace umov::report
