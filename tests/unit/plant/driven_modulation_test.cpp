// A modulation that is wired up instead of told gives the same codes.
#include <gtest/gtest.h>

#include <array>

#include "hil/plant/driven_modulation.hpp"
#include "hil/plant/plant.hpp"
#include "hil/plant/sample_catalog.hpp"

namespace umov::plant {
namespace {

constexpr std::uint32_t phase_step = 42'949'673;  // 1 kHz at 100 kS/s

Plant lit_plant(PlantConfig config) {
  PlantSetup setup;
  setup.config = std::move(config);
  setup.sample = make_sample("white-99");
  setup.seed = 5;
  Plant plant(std::move(setup));
  plant.set_laser(1, true, 0.0);
  plant.set_shutter(true, 0.0);
  plant.set_gain(1, 0.0);
  return plant;
}

/// Samples in which the two ways differ, from `from` on.
int differing(const PlantConfig& config, std::uint64_t from) {
  Plant told = lit_plant(config), driven = lit_plant(config);
  told.set_reference(phase_step);
  constexpr std::size_t count = 1000;
  std::array<std::uint16_t, count> signal{}, monitor{};
  told.sample(2.5, 1e5, 0, signal, monitor);
  int different = 0;
  for (std::uint64_t n = 0; n < count; ++n) {
    const bool light = static_cast<std::uint32_t>(n * phase_step) < 0x8000'0000u;
    std::uint16_t s = 0, m = 0;
    driven.sample_driven(2.5, 1e5, n, light, s, m);
    if (n >= from && (s != signal[n] || m != monitor[n])) ++different;
  }
  return different;
}

TEST(DrivenModulation, GivesTheSameCodesAsTheReferenceOnAnIdealBench) {
  EXPECT_EQ(differing(ideal_config(), 0), 0);
}

TEST(DrivenModulation, GivesTheSameCodesOnARealisticBenchOnceAPeriodIsKnown) {
  EXPECT_EQ(differing(preset_config("realistic"), 200), 0);
}

TEST(DrivenModulation, ALagNeedsAPeriodAndANewStreamForgetsIt) {
  DrivenModulation modulation;
  const auto level = [](std::uint64_t n) { return n % 8 < 4; };
  for (std::uint64_t n = 0; n < 17; ++n) {
    const bool ahead = modulation.quarter_ahead(n, level(n));
    if (n < 16) {
      EXPECT_EQ(ahead, level(n)) << n;
    } else {
      EXPECT_EQ(ahead, level(n + 2)) << n;
    }
  }
  EXPECT_EQ(modulation.quarter_ahead(0, true), true);
  EXPECT_EQ(modulation.quarter_ahead(1, false), false);
}

}  // namespace
}  // namespace umov::plant
