#include <gtest/gtest.h>

#include <cstdio>
#include <filesystem>
#include <fstream>
#include <set>

#include "hil/plant/parameter_list.hpp"
#include "hil/plant/sample_catalog.hpp"
#include "host/errors/error.hpp"

namespace umov::plant {
namespace {

TEST(Parameters, HaveDistinctNamesUnitsMeaningsAndPresetsWithinTheirRanges) {
  for (const char* preset : {"ideal", "realistic"}) {
    PlantConfig config = preset_config(preset);
    std::set<std::string> names;
    for (const Parameter& p : parameters(config)) {
      EXPECT_TRUE(names.insert(p.name).second) << p.name;
      EXPECT_FALSE(p.unit.empty()) << p.name;
      EXPECT_FALSE(p.meaning.empty()) << p.name;
      EXPECT_GE(*p.value, p.low) << p.name;
      EXPECT_LE(*p.value, p.high) << p.name;
    }
  }
}

TEST(Parameters, CoverTheWholeTree) {
  // Every double of the tree is listed once: setting them all leaves no byte of the struct as it
  // was.
  PlantConfig config = ideal_config();
  EXPECT_EQ(parameters(config).size() * sizeof(double), sizeof(PlantConfig));
}

TEST(IdealPreset, HasNoImperfectionButTheStatedNoise) {
  PlantConfig config = ideal_config();
  const std::set<std::string> scales = {
      "gear_cycles", "gear_ratio", "wavelength_nm", "gain_constant_v", "monitor_v", "warmup_tau_s",
      "solid_angle_sr", "stray_forward_width_deg", "settle_tau_s", "full_scale_v", "noise_v",
      "input_noise_v", "output_noise_v", "edge_nm", "transmittance",
      // What an imperfection of size zero would look like.
      "windup_travel_deg", "filter_axis_deg", "window_axis_deg", "angle_deg", "wander_period_s",
      "period_s", "g", "single_scattering_albedo", "slope_rms", "contact_angle_deg", "lobe_slope",
      "retro_width_deg", "fringe_thickness_um", "beam_offset_mm", "edge_share", "stops_s"};
  for (const Parameter& p : parameters(config)) {
    const std::string leaf = p.name.substr(p.name.rfind('.') + 1);
    if (!scales.contains(leaf)) {
      EXPECT_EQ(*p.value, 0.0) << p.name;
    }
  }
}

TEST(Override, SetsOneValueByName) {
  const std::vector<std::string> overrides = {"axis.detector.zero_deg=0.25",
                                              "laser.814.drift_per_hour=-1e-3"};
  const PlantConfig config = make_config("ideal", overrides);
  EXPECT_EQ(config.axis[1].zero_deg, 0.25);
  EXPECT_EQ(config.laser[2].drift_per_hour, -1e-3);
  EXPECT_EQ(config.axis[0].zero_deg, 0.0);
}

TEST(Override, RefusesUnknownNamesWithTheNearestKnownOne) {
  PlantConfig config = ideal_config();
  try {
    apply_override(config, "axis.detectr.zero_deg=1");
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(error.remedy().find("axis.detector.zero_deg"), std::string::npos);
  }
  EXPECT_THROW(apply_override(config, "axis.detector.zero_deg"), Error);
  EXPECT_THROW(apply_override(config, "axis.detector.zero_deg=much"), Error);
  EXPECT_THROW(apply_override(config, "axis.detector.zero_deg=nan"), Error);
  EXPECT_THROW(apply_override(config, "axis.detector.zero_deg=1e9"), Error);
  EXPECT_THROW(apply_override(config, "polarizer.extinction=-0.1"), Error);
  EXPECT_THROW(preset_config("perfect"), Error);
}

TEST(ConfigFile, StartsFromItsPresetAndSetsTables) {
  const PlantConfig config = config_from_toml(
      "preset = \"realistic\"\n[axis.detector]\nzero_deg = 1\n[collection]\nhalf_angle_deg = 0.0\n",
      "bench.toml");
  const PlantConfig realistic = realistic_config();
  EXPECT_EQ(config.axis[1].zero_deg, 1.0);
  EXPECT_EQ(config.collection.half_angle_deg, 0.0);
  EXPECT_EQ(config.axis[0].zero_deg, realistic.axis[0].zero_deg);
}

TEST(ConfigFile, RefusesUnknownKeysTextsAndRangesWithFileAndLine) {
  const auto refused_at = [](const char* text) -> std::size_t {
    try {
      config_from_toml(text, "bench.toml");
    } catch (const Error& error) {
      EXPECT_EQ(error.place().file, "bench.toml");
      return error.place().line;
    }
    return 0;
  };
  EXPECT_EQ(refused_at("preset = \"ideal\"\n\n[axis.detector]\nzero = 1\n"), 4u);
  EXPECT_EQ(refused_at("[axis.detector]\nzero_deg = \"big\"\n"), 2u);
  EXPECT_EQ(refused_at("[axis.detector]\nzero_deg = true\n"), 2u);
  EXPECT_EQ(refused_at("[polarizer]\n\nextinction = 2.0\n"), 3u);
  EXPECT_EQ(refused_at("preset = \"perfect\"\n"), 1u);
  EXPECT_EQ(refused_at("[axis.detector\nzero_deg = 1\n"), 1u);
  EXPECT_EQ(refused_at("[axis.detector]\nzero_deg = 1\n"), 0u);
  EXPECT_THROW(config_from_file("/nowhere/bench.toml"), Error);
}

TEST(Examples, AreAcceptedAsTheyAre) {
  const PlantConfig config =
      config_from_file(UMOV_SOURCE_DIR "/examples/instruments/knocked-bench.toml");
  EXPECT_EQ(config.axis[1].zero_deg, 0.35);
  EXPECT_EQ(config.axis[0].zero_deg, realistic_config().axis[0].zero_deg);
  const auto paint = make_sample(UMOV_SOURCE_DIR "/examples/samples/green-satin.toml");
  EXPECT_DOUBLE_EQ(truth_value(*paint, "k_uds", 532), 0.30);
  EXPECT_LT(dhr(*paint, 75.0, 814).unpolarized, 1.0);
}

TEST(Readme, ListsEveryParameterWithItsPresetValues) {
  std::ifstream file(UMOV_SOURCE_DIR "/hil/plant/PARAMETERS.md");
  std::string text((std::istreambuf_iterator<char>(file)), {});
  EXPECT_NE(text.find(parameter_reference()), std::string::npos)
      << "PARAMETERS.md is out of date; its table must read\n"
      << parameter_reference();
}

}  // namespace
}  // namespace umov::plant
