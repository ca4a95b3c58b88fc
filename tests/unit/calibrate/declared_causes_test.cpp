// Angles of a bench: as a fit shows them, as a reduction takes them, and as doubts of points.
#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "host/calibrate/alignment.hpp"
#include "host/calibrate/reduce.hpp"
#include "tests/unit/calibrate/synthetic_scan.hpp"

namespace umov::calibrate {
namespace {

using namespace test;

double gloss(double theta_i, double theta_r) {
  return 0.1 + 2 * std::exp(-std::pow((theta_r - theta_i) / 8, 2));
}

/// As an arm measures it that stands `zero` degrees beyond where it was sent.
Brdf beside(double zero, const std::function<double(double, double)>& f) {
  return [=](double theta_i, double theta_r, double, double, double analyzer) {
    return (std::isnan(analyzer) ? 1.0 : 0.5) * f(theta_i, theta_r + zero) *
           std::cos((theta_r + zero) * degree) / std::cos(theta_r * degree);
  };
}

struct Bench {
  explicit Bench(double zero_deg) {
    Instrument quiet;
    quiet.relative = 1e-5;
    quiet.adc_v = 1e-7;
    Plan plan;
    plan.theta_i = {20, 35, 50};
    plan.step = 2;
    white = make_white(quiet, 0.9, plan, 1);
    auto tile = make_scan(
        quiet, beside(zero_deg, [](double, double) { return 0.9 / std::numbers::pi; }), plan, 1);
    white.x_v = tile.x_v;
    white.y_v = tile.y_v;
    sample = make_scan(quiet, beside(zero_deg, gloss), plan, 2);
  }
  Calibration calibrated(const DeclaredDoubts& declared) const {
    const StandardScan standard{white, ReferenceStandard::from_keys(white), "tile", ""};
    CalibrateOptions options;
    options.declared = declared;
    return calibrate(std::span(&standard, 1), {}, options);
  }
  formats::ScanTable white, sample;
};

TEST(Alignment, IsReadFromTheDoubtsOfAFitAndAddsUp) {
  formats::FitResult fit;
  fit.factors = {{"gain 532 nm", 3.0, 1.0},
                 {"detector zero", -0.5, 0.1},
                 {"incidence zero", 2.0, 0.1},
                 {"sample lean", 1.0, 0.2}};
  DeclaredDoubts declared;
  declared.theta_i_zero_u_deg = 0.1;
  declared.theta_r_zero_u_deg = 0.2;
  declared.sample_lean_u_deg = 0.05;
  Alignment found = alignment_found(fit, declared);
  EXPECT_DOUBLE_EQ(found.theta_i_deg(), 0.25);
  EXPECT_DOUBLE_EQ(found.theta_r_deg(), -0.15);
  found += found;
  EXPECT_DOUBLE_EQ(found.theta_i_deg(), 0.5);
  fit.factors.clear();
  EXPECT_EQ(alignment_found(fit, declared).theta_i_deg(), 0);
}

TEST(Alignment, PutsPointsAtTheirTrueAnglesAndTheStandardsTooIntoTheirValues) {
  constexpr double zero_deg = 0.2;
  const Bench bench(zero_deg);
  DeclaredDoubts declared;
  declared.theta_r_zero_u_deg = 0.1;
  const Calibration calibration = bench.calibrated(declared);
  ReduceOptions options;
  options.alignment.theta_r_zero_deg = zero_deg;
  const auto right = reduce(bench.sample, calibration, options).table.points;
  const auto wrong = reduce(bench.sample, calibration).table.points;
  double left = 0, before = 0, count = 0;
  for (std::size_t i = 0; i < right.size(); ++i) {
    if (right.used[i] == 0 || std::abs(wrong.theta_r_deg[i]) > 75) continue;
    EXPECT_NEAR(right.theta_r_deg[i], wrong.theta_r_deg[i] + zero_deg, 1e-12);
    const auto off = [](const formats::BrdfTable::Points& p, std::size_t k) {
      return p.brdf_per_sr[k] / gloss(p.theta_i_deg[k], p.theta_r_deg[k]) - 1;
    };
    left += std::pow(off(right, i), 2);
    before += std::pow(off(wrong, i), 2);
    count += 1;
  }
  EXPECT_LT(std::sqrt(left / count), 1.5e-3);
  EXPECT_GT(std::sqrt(before / count), 1e-2);
}

TEST(DeclaredCauses, DerivativesFromAShapeAreThoseOfTheLobe) {
  const Bench bench(0);
  DeclaredDoubts declared;
  declared.theta_i_zero_u_deg = 0.01;
  const Calibration calibration = bench.calibrated(declared);
  ReduceOptions options;
  options.shape = [](double theta_i, double theta_r, double, double, double, double) {
    return gloss(theta_i, theta_r);
  };
  const auto from_shape = reduce(bench.sample, calibration, options);
  const auto from_points = reduce(bench.sample, calibration);
  const auto& p = from_shape.table.points;
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double off = p.theta_r_deg[i] - p.theta_i_deg[i];
    if (std::abs(off) > 10) continue;
    const double slope = 2 * (gloss(p.theta_i_deg[i], p.theta_r_deg[i]) - 0.1) * 2 * off / 64 / 2;
    EXPECT_NEAR(from_shape.origin[i].by_incidence_per_sr_deg, slope, 2e-3);
    EXPECT_NEAR(from_points.origin[i].by_incidence_per_sr_deg, slope, 0.02);
  }
}

TEST(DeclaredCauses, SayWhatPointsShare) {
  Bench bench(0);
  for (std::size_t i = 0; i < bench.sample.size(); ++i)
    bench.sample.direction[i] = bench.sample.theta_i_deg[i] == 35 ? -1 : 1;
  DeclaredDoubts declared;
  declared.theta_r_play_u_deg = 0.02;
  declared.position_u_deg = 0.01;
  declared.source_relative_u = 0.003;
  declared.sample_lean_u_deg = 0.05;
  declared.theta_r_eccentricity_u_deg = 0.02;
  const auto reduction = reduce(bench.sample, bench.calibrated(declared));
  const auto& p = reduction.table.points;
  const auto factor = [&](const std::string& name) -> const std::vector<double>* {
    for (const auto& f : reduction.table.factors)
      if (f.name == name) return &f.per_point;
    return nullptr;
  };
  for (const char* name : {"detector play", "detector eccentricity 1", "detector eccentricity 2",
                           "sample lean", "incidence stop 35", "source 532 nm"})
    EXPECT_NE(factor(name), nullptr) << name;
  const auto *stop = factor("detector stop 40"), *source = factor("source 532 nm 50"),
             *play = factor("detector play");
  ASSERT_TRUE(stop != nullptr && source != nullptr && play != nullptr);
  std::set<double> at;
  for (std::size_t i = 0; i < p.size(); ++i) {
    if ((*stop)[i] != 0) at.insert(p.theta_r_deg[i]);
    EXPECT_NEAR((*source)[i], p.theta_i_deg[i] == 50 ? 0.003 * p.brdf_per_sr[i] : 0.0, 1e-12);
    // On the steep flank; the standard's share is small there.
    const double off = p.theta_r_deg[i] - p.theta_i_deg[i];
    if (off != -6 || reduction.origin[i].by_detector_per_sr_deg == 0) continue;
    EXPECT_EQ((*play)[i] > 0, p.theta_i_deg[i] == 35) << p.theta_i_deg[i];
  }
  EXPECT_EQ(at, std::set<double>{40});
}

}  // namespace
}  // namespace umov::calibrate
