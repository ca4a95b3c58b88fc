// The bench without a controller: what it measures is what the plant expects, with the noise that
// is stated.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "hil/blind/bench.hpp"
#include "hil/blind/record_noise.hpp"
#include "hil/plant/sample_catalog.hpp"

namespace umov::blind {
namespace {

CasePlan small_plan(Style style = Style::one_way) {
  CasePlan plan;
  plan.style = style;
  plan.theta_i_deg = {20, 50};
  plan.theta_r_step_deg = 8.0;
  plan.states = {{0, 0}, {0, 90}, {90, 90}};
  return plan;
}

plant::PlantConfig noisy() {
  plant::PlantConfig config = plant::ideal_config();
  config.amplifier.input_noise_v = 1e-5;
  config.modulation.jitter_deg = 0.1;
  for (plant::LaserConfig& l : config.laser) l.jitter = 0.012;
  return config;
}

std::shared_ptr<const plant::Sample> sample() {
  return plant::make_sample("red-gloss");
}

TEST(Bench, MeasuresWhatThePlantExpectsWithinTheStatedNoise) {
  const auto blocks = own_blocks(small_plan());
  const Acquisition acquisition;
  Bench quiet(noisy(), sample(), 5, acquisition), loud(noisy(), sample(), 5, acquisition);
  const auto clean = quiet.clean(blocks);
  const auto table = loud.measure(blocks);
  ASSERT_EQ(clean.size(), table.size());
  const RecordNoise noise(noisy(), acquisition);
  double x2 = 0.0, y2 = 0.0, worst = 0.0;
  for (std::size_t i = 0; i < clean.size(); ++i) {
    const RecordVariance variance = noise.of(blocks[0].rows[i].laser, clean[i]);
    const double scale = clean[i].monitor_v / table.monitor_v[i];
    const double zx = (table.x_v[i] * scale - clean[i].x_v) / std::sqrt(variance.x_v2);
    const double zy = (table.y_v[i] * scale - clean[i].y_v) / std::sqrt(variance.y_v2);
    x2 += zx * zx;
    y2 += zy * zy;
    worst = std::max({worst, std::abs(zx), std::abs(zy)});
    EXPECT_EQ(table.gain[i], std::pow(10.0, clean[i].range));
  }
  const auto n = static_cast<double>(clean.size());
  const double five_sigma = 5.0 * std::sqrt(2.0 / n);
  EXPECT_NEAR(x2 / n, 1.0, five_sigma);
  EXPECT_NEAR(y2 / n, 1.0, five_sigma);
  EXPECT_LT(worst, 5.5);
}

TEST(Bench, StatesStandardErrorsThatTheScatterOfRecordsBearsOut) {
  RowBlock block;
  block.name = "main";
  for (int i = 0; i < 300; ++i) block.rows.push_back({30, 10, 0, 1, {0, 0}, true, 0, 1});
  Bench bench(noisy(), sample(), 9, {});
  const auto table = bench.measure({&block, 1});
  double x = 0.0, x2 = 0.0, se2 = 0.0;
  for (std::size_t i = 0; i < table.size(); ++i) {
    const double ratio = table.x_v[i] / table.monitor_v[i];
    x += ratio / 300.0;
    x2 += ratio * ratio / 300.0;
    se2 += std::pow(table.x_se_v[i] / table.monitor_v[i], 2.0) / 300.0;
  }
  EXPECT_NEAR(std::sqrt(se2 / (x2 - x * x)), 1.0, 0.06);
}

TEST(Bench, ArrivesInTheSenseThatTheRecordStates) {
  for (const Style style : {Style::one_way, Style::serpentine}) {
    plant::PlantConfig config = plant::ideal_config();
    config.axis[1].backlash_deg = 0.4;
    const auto blocks = own_blocks(small_plan(style));
    Bench played(config, sample(), 5, {}), good(plant::ideal_config(), sample(), 5, {});
    const auto with = played.clean(blocks);
    const auto without = good.clean(blocks);
    const auto table = Bench(config, sample(), 5, {}).measure(blocks);
    const auto& rows = blocks[0].rows;
    int down = 0;
    for (std::size_t i = 0; i < rows.size(); ++i) {
      // A line that begins where the last one ended begins without a move.
      const bool moved = i == 0 || rows[i].theta_r_deg != rows[i - 1].theta_r_deg;
      EXPECT_EQ(table.direction[i], moved ? rows[i].approach : table.direction[i - 1]);
      down += table.direction[i] < 0;
      // Arriving upwards the stage lags below: on the rising side of the lobe the signal is
      // smaller.
      if (moved && rows[i].theta_i_deg == 50 && rows[i].theta_r_deg == 40 &&
          rows[i].state.analyzer_deg == 90 && rows[i].state.polarizer_deg == 90) {
        EXPECT_LT((with[i].x_v - without[i].x_v) * rows[i].approach, 0.0);
      }
    }
    EXPECT_EQ(down > 0, style == Style::serpentine);
  }
}

TEST(Bench, ChoosesTheHighestRangeThatDoesNotClip) {
  plant::PlantConfig config = plant::ideal_config();
  const auto blocks = own_blocks(small_plan());
  const auto table = Bench(config, sample(), 5, {}).measure(blocks);
  std::vector<int> seen;
  for (std::size_t i = 0; i < table.size(); ++i) {
    EXPECT_EQ(table.saturated[i], 0);
    EXPECT_LT(table.x_v[i] * table.gain[i], 2.1);
    seen.push_back(static_cast<int>(table.gain[i]));
  }
  std::sort(seen.begin(), seen.end());
  seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
  EXPECT_GE(seen.size(), 3u);
}

TEST(Bench, ClosedShutterGivesNoLightAndDensityShowsInTheMonitor) {
  CasePlan plan = small_plan();
  const std::vector<RowBlock> blocks = {menu_block(plan, "shutter"), menu_block(plan, "nd")};
  const auto table = Bench(noisy(), sample(), 5, {}).measure(blocks);
  double least = 10.0;
  double most = 0.0;
  for (std::size_t i = 0; i < table.size(); ++i) {
    if (table.shutter_open[i] == 0) {
      EXPECT_LT(std::abs(table.x_v[i]), 1e-5);
      continue;
    }
    least = std::min(least, table.monitor_v[i]);
    most = std::max(most, table.monitor_v[i]);
  }
  EXPECT_NEAR(most / least, 100.0, 12.0);
  EXPECT_EQ(table.blocks.size(), 2u);
  EXPECT_EQ(table.blocks[1].first, table.blocks[0].last + 1);
}

TEST(Bench, GivesTheSameRecordsTwice) {
  const auto blocks = own_blocks(small_plan());
  const auto a = Bench(noisy(), sample(), 5, {}).measure(blocks);
  const auto b = Bench(noisy(), sample(), 5, {}).measure(blocks);
  const auto c = Bench(noisy(), sample(), 6, {}).measure(blocks);
  EXPECT_EQ(a.x_v, b.x_v);
  EXPECT_EQ(a.y_se_v, b.y_se_v);
  EXPECT_NE(a.x_v, c.x_v);
}

TEST(Menu, RefusesWhatIsNotOnIt) {
  EXPECT_THROW(menu_block(small_plan(), "ultrasound"), std::exception);
  for (const auto menu : menu_names)
    EXPECT_FALSE(menu_block(small_plan(), menu).rows.empty()) << menu;
}

}  // namespace
}  // namespace umov::blind
