// What a page shows of a diagnosis: predictions and contributions of every record.
#include <algorithm>
#include <cmath>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "host/formats/scan_csv.hpp"
#include "host/gap/engine/folds.hpp"
#include "host/gap/engine/gap_bounds.hpp"
#include "host/gap/engine/refit.hpp"
#include "host/gap/scan/effect_list.hpp"
#include "host/gap/scan/picture.hpp"

namespace umov::gap::scan {
namespace {

constexpr std::size_t saturated_record = 5;

formats::ScanTable scan() {
  formats::ScanTable table = formats::read_scan_csv(std::filesystem::path(UMOV_TEST_DATA) /
                                                    "foreign_scans" / "scan_07_part.csv");
  table.saturated[saturated_record] = 1;
  return table;
}

const ScanModel& model() {
  static const ScanModel shared({scan()});
  return shared;
}

/// An answer with these effects, as a diagnosis would give it: fitted, the first one named.
Diagnosis answer_with(const std::vector<EffectId>& effects) {
  Diagnosis d;
  Explanation start = base_explanation(model());
  const Whitening first(model().noise(model().observations().value));
  const Refit rough = refit(model(), start, first);
  d.search.whitening = std::make_shared<Whitening>(model().noise(rough.mean));
  const Refit base = refit(model(), rough.explanation, *d.search.whitening);
  start = base.explanation;
  for (const EffectId id : effects)
    start = with_effect(start, number(id), model().effects()[number(id)].probes[0][0]);
  const Refit best = refit(model(), start, *d.search.whitening);
  d.search.hypotheses = {{best}, {base}};
  d.search.base = 1;
  for (std::size_t i = 0; i < model().base().size(); ++i) {
    const double value = best.explanation.base[i];
    d.base.push_back({model().base()[i].name, "1", {value, value, value}});
  }
  d.causes.push_back({model().effects()[number(effects.front())].name, "", 1, 1, {}});
  d.before = {base.chi2 / static_cast<double>(base.residual.size()) - 1, 1};
  d.after = {best.chi2 / static_cast<double>(best.residual.size()) - 1, 0.5};
  d.floor = {0.002, 0.1};
  d.base_whitening = d.search.whitening;
  d.best = best;
  d.bounds = gap_bounds(model(), d, 1000, 1);
  return d;
}

const Diagnosis& two_effects_answer() {
  static const Diagnosis answer = answer_with({EffectId::detector_zero, EffectId::laser_drift});
  return answer;
}

const Picture& two_effects() {
  static const Picture picture = picture_of(model(), two_effects_answer(), 1);
  return picture;
}

TEST(Picture, holds_every_record_in_volts_saturated_ones_too) {
  const Picture& p = two_effects();
  const formats::ScanTable table = scan();
  ASSERT_EQ(p.records.size(), table.size());
  EXPECT_EQ(model().used(), table.size() - 1);
  EXPECT_TRUE(p.records[saturated_record].saturated);
  for (const auto* s : {&p.measured, &p.base, &p.best, &p.sigma}) {
    ASSERT_EQ(s->x_v.size(), table.size());
    ASSERT_EQ(s->y_v.size(), table.size());
  }
  for (std::size_t i = 0; i < table.size(); ++i) {
    EXPECT_EQ(p.measured.x_v[i], table.x_v[i]);
    EXPECT_EQ(p.measured.y_v[i], table.y_v[i]);
    EXPECT_GT(p.sigma.x_v[i], 0);
    // The base is a fair model of this scan: predictions are volts as the records are.
    EXPECT_LT(std::abs(p.best.x_v[i] - table.x_v[i]),
              0.2 * std::abs(table.x_v[i]) + 20 * p.sigma.x_v[i])
        << i;
  }
}

TEST(Picture, contributions_of_small_effects_add_up_to_what_all_of_them_change) {
  const Diagnosis d = answer_with({EffectId::detector_zero, EffectId::laser_drift});
  const Picture& p = two_effects();
  ASSERT_EQ(p.contributions.size(), 2u);
  EXPECT_TRUE(p.contributions[0].named);
  EXPECT_FALSE(p.contributions[1].named);
  Explanation none = d.best.explanation;
  EXPECT_EQ(none.effects.size(), 2u);
  none = without_effect(without_effect(none, number(EffectId::detector_zero)),
                        number(EffectId::laser_drift));
  std::vector<Record> all = model().records().records;
  for (Record& r : all) r.saturated = false;
  Eigen::VectorXd plain;
  model().with_records(all).predict(none, plain, nullptr);
  double largest = 0, worst = 0;
  for (std::size_t i = 0; i < p.records.size(); ++i) {
    const double whole = p.best.x_v[i] - plain[static_cast<Eigen::Index>(i)];
    const double sum = p.contributions[0].held.x_v[i] + p.contributions[1].held.x_v[i];
    largest = std::max(largest, std::abs(whole) / p.sigma.x_v[i]);
    worst = std::max(worst, std::abs(whole - sum) / p.sigma.x_v[i]);
  }
  EXPECT_GT(largest, 0.01);
  EXPECT_LT(worst, 0.02 * largest);
}

TEST(Picture, one_effect_explains_all_that_is_between_base_and_best) {
  const Picture p = picture_of(model(), answer_with({EffectId::detector_zero}), 1);
  ASSERT_EQ(p.contributions.size(), 1u);
  const Contribution& c = p.contributions[0];
  EXPECT_EQ(c.effect.name, "detector_zero");
  EXPECT_GE(c.delta_chi2, 0);
  for (std::size_t i = 0; i < p.records.size(); ++i) {
    EXPECT_NEAR(c.refitted.x_v[i], p.best.x_v[i] - p.base.x_v[i], 0.05 * p.sigma.x_v[i]) << i;
    EXPECT_NEAR(c.refitted.y_v[i], p.best.y_v[i] - p.base.y_v[i], 0.05 * p.sigma.y_v[i]) << i;
  }
}

TEST(Picture, sizes_of_the_gap_lie_within_their_intervals) {
  const GapBounds& b = *two_effects_answer().bounds;
  for (const GapInterval* i : {&b.before, &b.after, &b.floor}) {
    EXPECT_LE(i->g2.lo, i->g2.value);
    EXPECT_GE(i->g2.hi, i->g2.value);
    EXPECT_LT(i->g2.lo, i->g2.hi);
    EXPECT_LE(i->percent.lo, i->percent.hi);
  }
  const double n = static_cast<double>(model().observations().value.size());
  EXPECT_NEAR(b.floor.g2.hi - b.floor.g2.lo, 2 * 1.96 * std::sqrt(2 / n), 1e-4);
  // Rows differ more among each other than single noise values do.
  EXPECT_GT(b.before.g2.hi - b.before.g2.lo, 0.5 * (b.floor.g2.hi - b.floor.g2.lo));
}

}  // namespace
}  // namespace umov::gap::scan
