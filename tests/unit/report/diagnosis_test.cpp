// The page of a diagnosis, from a small one made by hand.
#include <cmath>
#include <memory>
#include <string>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include "host/optics/angles.hpp"
#include "host/report/diagnosis_page.hpp"
#include "tests/unit/failure.hpp"

namespace umov::report {
namespace {

using gap::scan::Picture;
using gap::scan::Record;
using nlohmann::json;
using ::testing::HasSubstr;

/// Two wavelengths, P → P and P → S, three incidences, every `step_deg` of θr, and one row out of
/// the plane. The base misses by 2 % of the signal in P → P; the best explanation does not.
Picture picture(double step_deg) {
  Picture p;
  p.wavelengths_nm = {532, 633};
  const auto add = [&](std::size_t w, bool crossed, double theta_i, double theta_r, double phi) {
    Record r{};
    r.theta_i = optics::radians(theta_i);
    r.theta_r = optics::radians(theta_r);
    r.phi_r = optics::radians(phi);
    r.wavelength = w;
    r.analyzer = crossed ? optics::radians(90) : 0;
    r.direction = 1;
    r.gain = 1;
    r.monitor_v = 1;
    r.shutter_open = true;
    r.iris_fraction = 1;
    p.records.push_back(r);
    const double signal = crossed ? 0.01 : 1 + std::cos(r.theta_r);
    const double gap = crossed ? 0 : 0.02 * signal;
    p.best.x_v.push_back(signal);
    p.base.x_v.push_back(signal - gap);
    p.measured.x_v.push_back(signal);
    p.sigma.x_v.push_back(0.005 * signal);
    for (auto* s : {&p.best, &p.base, &p.measured}) s->y_v.push_back(0);
    p.sigma.y_v.push_back(0.001);
  };
  for (const double theta_i : {10.0, 30.0, 50.0})
    for (const bool crossed : {false, true})
      for (const std::size_t w : {0, 1})
        for (double t = -80; t <= 80; t += step_deg) add(w, crossed, theta_i, t, 0);
  for (double t = 10; t <= 80; t += step_deg) add(0, false, 30, t, 90);
  gap::scan::Contribution c;
  c.effect = {"polarizer_leakage",
              "polarisation",
              "Light leaks.",
              "Malus",
              {{"extinction", "1", "power ratio", 0, 0, 1, 1e-3}}};
  c.named = true;
  c.delta_chi2 = 1234;
  for (std::size_t i = 0; i < p.records.size(); ++i)
    c.refitted.x_v.push_back(p.best.x_v[i] - p.base.x_v[i]);
  c.refitted.y_v.assign(p.records.size(), 0.0);
  c.held = c.refitted;
  p.contributions.push_back(c);
  p.alternatives.push_back({"polarizer_leakage",
                            {"polarizer_rotation",
                             "polarisation",
                             "An axis is turned.",
                             "Malus",
                             {{"angle_deg", "deg", "axis minus command"}}},
                            {{"angle_deg", "deg", {0.9, 0.8, 1.0}}}});
  return p;
}

gap::scan::ScanDiagnosis diagnosis(double step_deg = 4) {
  gap::scan::ScanDiagnosis result;
  gap::Diagnosis& d = result.answer;
  d.verdict = gap::Verdict::explained;
  d.before = {16, 2};
  d.after = {0.01, 0.05};
  d.floor = {0.002, 0.02};
  d.bounds = gap::GapBounds{{{16, 14, 18}, {2, 1.8, 2.2}},
                            {{0.01, -0.01, 0.03}, {0.05, 0, 0.09}},
                            {{0.002, -0.02, 0.02}, {0.02, 0, 0.07}}};
  d.closed_fraction = {0.99, 0.97, 1.01};
  d.causes.push_back(
      {"polarizer_leakage", "", 0.6, 1.0, {{"extinction", "1", {2.46e-4, 2.32e-4, 2.60e-4}}}});
  d.ambiguity_sets = {{"polarizer_leakage", "polarizer_rotation"}};
  d.probabilities = {{"polarizer_leakage", 0.6},
                     {"polarizer_rotation", 0.38},
                     {"dust", 0.04},
                     {"backlash", 0.001}};
  d.next_scan.push_back({"pm45", {{"polarizer_leakage", "polarizer_rotation"}}, 12.3, 14.2});
  d.where.cells.push_back({"theta_r_deg",
                           "deg",
                           40,
                           45,
                           "0/90 Y",
                           {{"polarizer", "P"}, {"analyzer", "S"}, {"component", "y"}},
                           {1, 2},
                           8.1,
                           0.0025});
  result.next_plan = "menu = \"pm45\"\n";
  result.picture = std::make_shared<const Picture>(picture(step_deg));
  return result;
}

DiagnosisInput input_of(const gap::scan::ScanDiagnosis& result) {
  DiagnosisInput input;
  input.diagnosis = &result;
  input.source.records = result.picture ? result.picture->records.size() : 0;
  input.source.used = input.source.records;
  input.source.version = "test";
  input.source.model = "microfacet+nef";
  input.sample = "red <script>alert(1)</script>";
  input.files = {"scan.csv"};
  input.created = "2026-01-02T03:04:05Z";
  return input;
}

json data_of(const gap::scan::ScanDiagnosis& result) {
  return json::parse(diagnosis_data(input_of(result)));
}

TEST(DiagnosisPage, draws_what_a_scan_cannot_tell_apart_as_one_bar) {
  const json data = data_of(diagnosis());
  const json& bars = data["causes"]["bars"];
  ASSERT_EQ(bars.size(), 2u);
  EXPECT_EQ(bars[0]["label"], "one of polarizer leakage, polarizer rotation");
  EXPECT_NEAR(bars[0]["probability"].get<double>(), 0.98, 1e-9);
  EXPECT_EQ(bars[0]["share"], 1.0);
  EXPECT_TRUE(bars[0]["named"]);
  EXPECT_EQ(bars[1]["label"], "dust");
  EXPECT_FALSE(bars[1]["named"]);
  const json& rows = data["causes"]["parameters"];
  ASSERT_EQ(rows.size(), 2u);
  EXPECT_EQ(rows[0][2], "0.000246");
  EXPECT_EQ(rows[0][3], "0.000232 to 0.00026");
  EXPECT_EQ(rows[1][0], "or polarizer rotation");
}

TEST(DiagnosisPage, says_the_verdict_and_the_next_scan_in_words) {
  const json data = data_of(diagnosis());
  EXPECT_EQ(data["sentence"],
            "One of polarizer leakage, polarizer rotation closes 99 % of the gap (97 to 100 %); "
            "nothing significant is left.");
  EXPECT_THAT(data["next"][0]["words"].get<std::string>(), HasSubstr("±45°"));
  EXPECT_EQ(data["next"][0]["separates"][0], "polarizer leakage from polarizer rotation");
  EXPECT_EQ(data["next"][0]["minutes"], "14");
  EXPECT_EQ(data["where"]["cells"][0][2], "P → S, quadrature");
}

TEST(DiagnosisPage, maps_have_a_panel_for_each_wavelength_and_channel_in_sigma_and_per_cent) {
  const json data = data_of(diagnosis());
  const json& sets = data["maps"]["sets"];
  ASSERT_EQ(sets.size(), 2u);
  EXPECT_EQ(sets[0]["panels"].size(), 4u);
  EXPECT_EQ(sets[0]["rows"], json({"10°", "30°", "50°"}));
  EXPECT_EQ(sets[1]["rows"], json({"φr = 90°, θi = 30°"}));
  const json& parallel = sets[0]["panels"][0];
  EXPECT_EQ(parallel["channel"], "P → P");
  const json& fine = parallel["x"]["fine"];
  // 2 % missed at .5 % noise is four sigma, and nothing afterwards.
  for (std::size_t c = 0; c < fine["before"][0].size(); ++c) {
    EXPECT_NEAR(fine["before"][0][c].get<double>(), 4, 1e-6);
    EXPECT_EQ(fine["after"][0][c], 0.0);
    EXPECT_NEAR(fine["before"][0][c].get<double>() * fine["scale"][0][c].get<double>(), 2, 1e-6);
  }
  // Joined neighbours stand out by the root of their number, and mean the same per cent.
  const json& coarse = parallel["x"]["coarse"];
  EXPECT_GT(coarse["before"][0][5].get<double>(), 5);
  EXPECT_NEAR(coarse["before"][0][5].get<double>() * coarse["scale"][0][5].get<double>(), 2, 0.01);
  EXPECT_EQ(sets[0]["panels"][1]["x"]["fine"]["before"][0].size(),
            sets[0]["theta_r_deg"]["fine"].size());
}

TEST(DiagnosisPage, shows_a_signature_where_it_is_strongest) {
  const json data = data_of(diagnosis());
  ASSERT_EQ(data["signatures"].size(), 1u);
  const json& line = data["signatures"][0]["lines"][0];
  EXPECT_THAT(line["label"].get<std::string>(), HasSubstr("P → P"));
  for (const json& z : line["refitted"]["line"]) EXPECT_NEAR(z.get<double>(), 4, 1e-6);
  EXPECT_EQ(line["refitted"]["points"].size(), line["x"].size());
}

TEST(DiagnosisPage, stays_small_however_many_records_there_are) {
  const auto many = diagnosis(0.05);
  ASSERT_GT(many.picture->records.size(), 35'000u);
  EXPECT_LT(diagnosis_page(input_of(many)).size(), 8'000'000u);
  EXPECT_LT(diagnosis_data(input_of(many)).size(), 400'000u);
}

TEST(DiagnosisPage, keeps_names_out_of_the_markup_and_needs_a_picture) {
  const auto result = diagnosis();
  const std::string page = diagnosis_page(input_of(result));
  EXPECT_EQ(page.find("<script>alert"), std::string::npos);
  EXPECT_THAT(page.substr(0, 4000), HasSubstr("default-src 'none'"));
  gap::scan::ScanDiagnosis without = diagnosis();
  without.picture.reset();
  EXPECT_THAT(failure_of([&] { diagnosis_data(input_of(without)); }), HasSubstr("picture"));
}

TEST(DiagnosisPage, has_no_causes_where_nothing_is_needed) {
  gap::scan::ScanDiagnosis result = diagnosis();
  gap::Diagnosis& d = result.answer;
  d.verdict = gap::Verdict::none_needed;
  d.causes.clear();
  d.ambiguity_sets.clear();
  d.next_scan.clear();
  d.probabilities.clear();
  Picture plain = *result.picture;
  plain.contributions.clear();
  result.picture = std::make_shared<const Picture>(std::move(plain));
  const json data = data_of(result);
  EXPECT_TRUE(data["causes"]["bars"].empty());
  EXPECT_TRUE(data["signatures"].empty());
  EXPECT_FALSE(data["explained"]);
  EXPECT_THAT(data["sentence"].get<std::string>(), HasSubstr("no effect is needed"));
}

}  // namespace
}  // namespace umov::report
