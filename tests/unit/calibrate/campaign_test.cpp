#include "host/calibrate/campaign.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "host/calibrate/calibration_file.hpp"
#include "host/calibrate/reduce.hpp"
#include "host/errors/error.hpp"
#include "host/formats/scan_h5.hpp"
#include "tests/unit/calibrate/synthetic_scan.hpp"

namespace umov::calibrate {
namespace {

namespace fs = std::filesystem;
using namespace test;
using ::testing::HasSubstr;

CampaignScan named(formats::ScanTable table, const std::string& name, const std::string& role) {
  table.set_key("role", role);
  table.set_key("sample", name);
  return {std::move(table), name + ".h5", name, role, name};
}

Instrument bench() {
  Instrument instrument;
  instrument.kappa_per_v = 0.02;
  instrument.range_error = [](double gain) {
    return gain == 100 ? 2e-3 : gain == 1000 ? 5e-3 : 0.0;
  };
  instrument.stray_per_sr = [](double) { return 3e-3; };
  instrument.dark_v = [](double) { return 4e-6; };
  instrument.source_relative = 1e-3;
  return instrument;
}

/// .02 under a lobe of 12 at 30 deg: signals from .6 mV to .6 V.
Brdf gloss() {
  return depolarising([](double theta_r, double) {
    return 0.02 + 12.0 * std::exp(-std::pow((theta_r - 30) / 8.0, 2));
  });
}

CampaignScan white_scan(std::uint64_t seed) {
  Plan plan;
  plan.theta_i = {0, 30, 60};
  plan.step = 6;
  auto white = make_white(bench(), 0.9, plan, seed, 0.002);
  add_closed(white, bench(), {10, 100, 1000}, 12, seed);
  return named(white, "tile", "white");
}

CampaignScan gloss_scan(std::uint64_t seed) {
  Plan plan;
  plan.theta_i = {30};
  plan.step = 3;
  auto scan = make_scan(bench(), gloss(), plan, seed + 100);
  for (int repeat = 0; repeat < 4; ++repeat)
    for (double power : {0.3, 0.1}) {
      Instrument dimmed = bench();
      dimmed.power = power;
      append(
          scan,
          make_scan(dimmed, gloss(), plan,
                    seed + 7000 + 10 * static_cast<std::uint64_t>(repeat) + (power > 0.2 ? 1 : 2)),
          "nd");
    }
  Plan empty;
  empty.gain = 1000;
  add_no_sample(scan, bench(), empty, seed);
  add_closed(scan, bench(), {10, 100, 1000}, 12, seed + 5);
  return named(scan, "gloss", "sample");
}

CampaignOptions options() {
  CampaignOptions result;
  result.linearity.kappa_tolerance_per_v = 0.05;
  result.stray.tolerance_per_sr = 1e-2;
  return result;
}

TEST(Campaign, TakesAllErrorsOfTheInstrumentOutOfASample) {
  // Nonlinearity, ranges, stray light and dark signal at once: the points must scatter about the
  // truth as their uncertainties say, weak and strong ones.
  double chi2 = 0, count = 0, kappa2 = 0;
  const int seeds = 12;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const std::vector<CampaignScan> scans = {white_scan(seed), gloss_scan(seed)};
    const Campaign campaign = evaluate_campaign(scans, options());
    const auto& law = campaign.calibration.nonlinearity;
    EXPECT_TRUE(law.measured);
    kappa2 += std::pow((law.kappa_per_v - 0.02) / law.kappa_u_per_v, 2) / seeds;
    EXPECT_NEAR(campaign.calibration.stray.level(532, 20, 0), 3e-3,
                5 * campaign.calibration.stray.level_u(532, 20, 0));
    const auto table = reduce(scans[1].table, campaign.calibration).table;
    for (std::size_t i = 0; i < table.points.size(); ++i) {
      if (table.points.used[i] == 0) continue;
      const double truth = gloss()(30, table.points.theta_r_deg[i], 532, open_axis, open_axis);
      double variance = std::pow(table.points.brdf_u[i], 2);
      for (const auto& factor : table.factors) variance += std::pow(factor.per_point[i], 2);
      chi2 += std::pow(table.points.brdf_per_sr[i] - truth, 2) / variance;
      count += 1;
    }
  }
  RecordProperty("point_chi2", std::to_string(chi2 / count));
  RecordProperty("kappa_chi2", std::to_string(kappa2));
  EXPECT_GT(chi2 / count, 0.6);
  EXPECT_LT(chi2 / count, 1.4);
  EXPECT_LT(kappa2, 2.2);
}

TEST(Campaign, WithAWhiteScanAloneWorksAndSaysWhatIsMissing) {
  Plan plan;
  const std::vector<CampaignScan> scans = {
      named(make_white(Instrument{}, 0.9, plan, 1), "tile", "white")};
  const Campaign campaign = evaluate_campaign(scans, CampaignOptions{});
  ASSERT_EQ(campaign.calibration.wavelengths.size(), 1U);
  std::string all;
  for (const std::string& what : campaign.missing) all += what + "\n";
  for (const char* word : {"polariser", "dark signal", "linearity", "stray light", "reciprocity"})
    EXPECT_THAT(all, HasSubstr(word));
  EXPECT_EQ(campaign.calibration.nonlinearity.kappa_per_v, 0.0);
  EXPECT_EQ(campaign.calibration.stray.even_per_sr[0], 0.0);
}

TEST(Campaign, SurvivesItsFileWithAllThatReduceNeeds) {
  const std::vector<CampaignScan> scans = {white_scan(1), gloss_scan(1)};
  CampaignOptions settings = options();
  settings.declared.theta_i_zero_u_deg = 0.03;
  settings.declared.aperture_half_angle_deg = 0.3;
  settings.declared.sample_lean_u_deg = 0.05;
  settings.declared.theta_r_eccentricity_u_deg = 0.02;
  settings.declared.theta_r_play_u_deg = 0.02;
  settings.declared.position_u_deg = 0.01;
  settings.declared.source_relative_u = 0.003;
  const Calibration calibration = evaluate_campaign(scans, settings).calibration;
  ASSERT_FALSE(calibration.reciprocity.empty());
  const std::string file = ::testing::TempDir() + "/campaign-cal.h5";
  write_calibration(file, calibration, {});
  const Calibration back = read_calibration(file);
  const auto before = reduce(scans[1].table, calibration).table,
             after = reduce(scans[1].table, back).table;
  // The phase is kept with twelve digits.
  const auto expect_same = [](const std::vector<double>& a, const std::vector<double>& b) {
    ASSERT_EQ(a.size(), b.size());
    for (std::size_t i = 0; i < a.size(); ++i)
      EXPECT_NEAR(a[i], b[i], 1e-9 * std::abs(a[i]) + 1e-14);
  };
  expect_same(before.points.brdf_per_sr, after.points.brdf_per_sr);
  ASSERT_EQ(before.factors.size(), after.factors.size());
  for (std::size_t k = 0; k < before.factors.size(); ++k) {
    EXPECT_EQ(before.factors[k].name, after.factors[k].name);
    expect_same(before.factors[k].per_point, after.factors[k].per_point);
  }
  EXPECT_EQ(back.reciprocity.size(), calibration.reciprocity.size());
  EXPECT_EQ(back.reciprocity[0].mean_absolute, calibration.reciprocity[0].mean_absolute);
  EXPECT_EQ(back.nonlinearity.kappa_per_v, calibration.nonlinearity.kappa_per_v);
  EXPECT_EQ(back.stray.covariance, calibration.stray.covariance);
}

/// What `work` throws.
std::string message_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& error) {
    return error.what();
  }
  return "nothing was thrown";
}

TEST(Campaign, RefusesContradictionsWithFileAndRemedy) {
  const auto checked = [](std::vector<CampaignScan> scans) {
    return message_of([&] { check_campaign_scans(scans, CampaignOptions{}); });
  };
  const CampaignScan white = white_scan(1), sample = gloss_scan(1);
  CampaignScan no_role = sample;
  no_role.role = "";
  EXPECT_THAT(checked({white, no_role}), HasSubstr("gloss.h5: the scan has no key `role`"));
  CampaignScan odd = sample;
  odd.role = "weiss";
  EXPECT_THAT(checked({white, odd}), HasSubstr("`weiss`"));
  CampaignScan copy = white;
  copy.file = "copy.h5";
  EXPECT_THAT(checked({white, copy}), HasSubstr("copy.h5: is the same measurement as tile.h5"));
  EXPECT_THAT(checked({sample}), HasSubstr("role `white`"));
  CampaignScan dark = sample;
  dark.role = "dark";
  dark.file = "dark.h5";
  dark.sha256 = "d";
  EXPECT_THAT(checked({white, dark}), HasSubstr("have the shutter open"));
  CampaignScan mirror = sample, second = sample;
  mirror.role = second.role = "mirror";
  second.sha256 = "s";
  EXPECT_THAT(checked({white, mirror, second}), HasSubstr("second mirror scan"));
  CampaignScan other = sample;
  for (double& wavelength : other.table.wavelength_nm) wavelength = 700;
  EXPECT_THAT(checked({white, other}), HasSubstr("gloss.h5: the scan has 700 nm"));
  CampaignScan elsewhere = sample, here = white;
  here.table.set_key("device", "bench A");
  elsewhere.table.set_key("device", "bench B");
  EXPECT_THAT(checked({here, elsewhere}), HasSubstr("each instrument with its own scans"));
  EXPECT_EQ(checked({white, sample}), "nothing was thrown");
  CampaignOptions wrong;
  wrong.standard = "tyle";
  EXPECT_THAT(message_of([&] {
                standard_of({white, sample}, wrong);
              }),
              HasSubstr("choose one of: tile"));
}

class CampaignFile : public ::testing::Test {
 protected:
  CampaignFile() : folder_(fs::path(::testing::TempDir()) / "campaign-file") {
    fs::remove_all(folder_);
    fs::create_directories(folder_ / "scans");
  }
  CampaignOptions read(const std::string& text) {
    std::ofstream(folder_ / "campaign.toml") << text;
    return read_campaign(folder_ / "campaign.toml");
  }
  std::string refusal(const std::string& text) {
    return message_of([&] { read(text); });
  }
  fs::path folder_;
};

TEST_F(CampaignFile, FindsScansByPatternBesideItself) {
  for (const char* name : {"a.h5", "b.h5"})
    formats::write_scan_h5(folder_ / "scans" / name,
                           (name[0] == 'a' ? white_scan(1) : gloss_scan(1)).table, {});
  std::ofstream(folder_ / "scans" / "notes.txt") << "no scan";
  const auto settings = read("scans = [\"scans/?.h5\"]\nstandard = \"tile\"\n");
  const auto scans = read_campaign_scans(settings);
  ASSERT_EQ(scans.size(), 2U);
  EXPECT_EQ(scans[0].name, "tile");
  EXPECT_EQ(scans[1].role, "sample");
  EXPECT_EQ(standard_of(scans, settings), 0U);
  EXPECT_THAT(message_of([&] { files_of(folder_ / "scans" / "*.csv"); }),
              HasSubstr("no file matches"));
}

TEST_F(CampaignFile, RefusesWhatItDoesNotKnowWithLineAndRemedy) {
  EXPECT_THAT(refusal("standrad = \"x\"\n"), HasSubstr("campaign.toml:1:standrad"));
  EXPECT_THAT(refusal("\n[tolerance]\namplifier_range = -1\n"),
              HasSubstr("campaign.toml:3:tolerance.amplifier_range"));
  EXPECT_THAT(refusal("max_degree = 2.5\n"), HasSubstr("whole number"));
  EXPECT_THAT(refusal("detector_bias = \"maybe\"\n"), HasSubstr("auto, on, off"));
  EXPECT_THAT(refusal("scans = []\n"), HasSubstr("no list of files"));
  EXPECT_THAT(refusal("[compare]\nx = \"SRS-98\"\n"), HasSubstr("SRS-99, SRS-70, SRS-50"));
  EXPECT_THAT(refusal("scans = [\n"), HasSubstr("campaign.toml"));
  EXPECT_THAT(refusal("[=]\n"), HasSubstr("not valid TOML"));
}

TEST_F(CampaignFile, OfTheExamplesIsReadAsItStands) {
  const auto settings = read_campaign(UMOV_SOURCE_DIR "/examples/campaign/campaign.toml");
  EXPECT_EQ(settings.standard, "white 99");
  EXPECT_TRUE(settings.shape_from_reciprocity);
  EXPECT_EQ(settings.compare.size(), 3U);
  EXPECT_GT(settings.declared.theta_r_zero_u_deg, 0);
}

}  // namespace
}  // namespace umov::calibrate
