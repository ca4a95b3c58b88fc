#include "host/calibrate/calibration.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "host/calibrate/reduce.hpp"
#include "host/errors/error.hpp"
#include "tests/unit/calibrate/synthetic_scan.hpp"

namespace umov::calibrate {
namespace {

using namespace test;

const std::vector<std::pair<double, double>> all_states = {{0, 0},   {0, 90}, {0, open_axis},
                                                           {90, 90}, {90, 0}, {90, open_axis}};

Calibration calibrate_one(const formats::ScanTable& white, const CalibrateOptions& options = {}) {
  const StandardScan standard{white, ReferenceStandard::from_keys(white), "white", ""};
  return calibrate(std::span(&standard, 1), {}, options);
}

TEST(Calibrate, GainOfEachWavelengthIsRecoveredWithHonestUncertainty) {
  Instrument instrument;
  Plan plan;
  plan.wavelengths = {532, 633, 814};
  double chi2 = 0;
  const int seeds = 60;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const Calibration c = calibrate_one(make_white(instrument, 0.99, plan, seed));
    ASSERT_EQ(c.wavelengths.size(), 3U);
    for (const auto& w : c.wavelengths) {
      const double u = std::sqrt(w.covariance(0, 0));
      EXPECT_LT(u, 2e-3);
      chi2 +=
          std::pow(std::log(w.gain_constant_v / instrument.gain_constant[w.wavelength_nm]) / u, 2) /
          (3 * seeds);
    }
  }
  RecordProperty("gain_pull_chi2", std::to_string(chi2));
  EXPECT_GT(chi2, 0.7);
  EXPECT_LT(chi2, 1.35);
}

TEST(Calibrate, AFlatInstrumentFunctionIsNotFittedIntoTheNoise) {
  Instrument instrument;
  Plan plan;
  plan.step = 2;
  int flat = 0;
  double worst = 0;
  for (std::uint64_t seed = 1; seed <= 50; ++seed) {
    const auto c = calibrate_one(make_white(instrument, 0.99, plan, seed));
    double departure = 0;
    for (double t = -84; t <= 84; t += 4)
      departure = std::max(departure, std::abs(c.wavelengths[0].instrument_function.value(t) - 1));
    flat += departure < 5e-4;
    worst = std::max(worst, departure);
  }
  EXPECT_GE(flat, 45);
  EXPECT_LT(worst, 0.006);
}

TEST(Calibrate, AnInstrumentFunctionThatRisesAtGrazingAnglesIsRecovered) {
  Instrument instrument;
  instrument.instrument_function = [](double t) {
    const double x = t / 85;
    return 1 + 0.12 * std::pow(x, 6) + 0.01 * x;
  };
  Plan plan;
  plan.step = 2;
  double chi2 = 0, worst = 0;
  const int seeds = 40;
  const std::vector<double> where = {-80, -60, -30, 40, 70, 84};
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    const auto w = calibrate_one(make_white(instrument, 0.99, plan, seed)).wavelengths[0];
    const auto n = static_cast<Eigen::Index>(w.instrument_function.degrees.size());
    ASSERT_GE(n, 3);
    for (double t : where) {
      const double error =
          std::log(w.instrument_function.value(t) / instrument.instrument_function(t));
      const Eigen::VectorXd basis = w.instrument_function.basis(t);
      const double u = std::sqrt(basis.dot(w.covariance.block(1, 1, n, n) * basis));
      chi2 += error * error / (u * u) / (seeds * static_cast<double>(where.size()));
      worst = std::max(worst, std::abs(error));
    }
  }
  RecordProperty("instrument_function_pull_chi2", std::to_string(chi2));
  EXPECT_LT(worst, 0.012);
  EXPECT_GT(chi2, 0.6);
  EXPECT_LT(chi2, 1.6);
}

TEST(Calibrate, AOneSidedScanGivesASymmetricInstrumentFunctionWithinItsReach) {
  Instrument instrument;
  instrument.instrument_function = [](double t) { return 1 + 0.1 * std::pow(t / 85, 4); };
  Plan plan;
  plan.from = 4;
  plan.to = 80;
  plan.step = 2;
  const auto w = calibrate_one(make_white(instrument, 0.99, plan, 3)).wavelengths[0];
  EXPECT_NEAR(w.instrument_function.value(-70), instrument.instrument_function(70), 0.006);
  EXPECT_TRUE(w.instrument_function.covers(-80));
  EXPECT_FALSE(w.instrument_function.covers(82));
  for (int d : w.instrument_function.degrees) EXPECT_EQ(d % 2, 0);
}

TEST(Calibrate, DarkPhaseAndRangeErrorsDoNotReachTheGain) {
  Instrument instrument;
  instrument.dark_v = [](double) { return 2e-4; };
  instrument.phase_rad = 2 * degree;
  double chi2 = 0;
  const int seeds = 40;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    auto white = make_white(instrument, 0.99, Plan{}, seed);
    add_closed(white, instrument, {10, 100}, 20, seed);
    const Calibration c = calibrate_one(white);
    double variance = c.wavelengths[0].covariance(0, 0);
    for (const Systematic& s : c.systematics)
      if (s.kind == Systematic::Kind::dark) variance += s.shift[0](0) * s.shift[0](0);
    chi2 += std::pow(std::log(c.wavelengths[0].gain_constant_v / 600), 2) / variance / seeds;
    EXPECT_NEAR(c.wavelengths[0].phase_rad, 2 * degree, 1e-3);
  }
  EXPECT_GT(chi2, 0.5);
  EXPECT_LT(chi2, 1.6);
}

TEST(Calibrate, DetectorBiasIsFoundWhereItExistsAndLeftOutWhereItDoesNot) {
  Plan plan;
  plan.states = all_states;
  Instrument biased;
  biased.bias = -0.03;
  // The standard keeps 3 % of linear polarisation, which P incidence alone could not tell from
  // bias.
  const auto keeps = polarising([](double) { return 0.99 / std::numbers::pi; }, 0, 0, 0.03);
  double chi2 = 0;
  const int seeds = 30;
  for (std::uint64_t seed = 1; seed <= seeds; ++seed) {
    auto white = make_white(biased, 0.99, plan, seed);
    const auto scan = make_scan(biased, keeps, plan, seed);
    white.x_v = scan.x_v;
    const auto w = calibrate_one(white).wavelengths[0];
    EXPECT_TRUE(w.bias_active);
    chi2 += std::pow((w.detector_bias + 0.03) / w.detector_bias_u, 2) / seeds;
    EXPECT_NEAR(w.gain_constant_v, 600, 1.5);
  }
  EXPECT_GT(chi2, 0.5);
  EXPECT_LT(chi2, 1.7);

  int active = 0;
  for (std::uint64_t seed = 1; seed <= 30; ++seed)
    active += calibrate_one(make_white(Instrument{}, 0.99, plan, seed)).wavelengths[0].bias_active;
  EXPECT_LE(active, 1);

  plan.states = {{0, 0}, {0, 90}};
  const auto w = calibrate_one(make_white(Instrument{}, 0.99, plan, 5)).wavelengths[0];
  EXPECT_GT(w.detector_bias_u, 0.02) << "P incidence alone leaves bias and the standard together";

  CalibrateOptions off;
  off.bias = CalibrateOptions::Bias::off;
  const auto asserted = calibrate_one(make_white(biased, 0.99, plan, 5), off).wavelengths[0];
  EXPECT_FALSE(asserted.bias_active);
  EXPECT_EQ(asserted.detector_bias_u, 0);
  const auto white = make_white(Instrument{}, 0.99, Plan{}, 5);
  EXPECT_EQ(calibrate_one(white).wavelengths[0].detector_bias_u,
            ReferenceStandard::from_keys(white).polarization_u())
      << "one analyser state leaves what the standard's own polarisation may be";
  CalibrateOptions on;
  on.bias = CalibrateOptions::Bias::on;
  EXPECT_THROW(calibrate_one(make_white(biased, 0.99, Plan{}, 5), on), Error);
}

TEST(Calibrate, ATabulatedStandardThatIsNotLambertianLeavesTheInstrumentFunctionFlat) {
  // The size of real sintered PTFE: 1.06 of 1/pi near the normal, .82 at 80 degrees.
  const auto real = depolarising(
      [](double t, double) { return (1.06 - 0.24 * std::pow(t / 80, 2)) / std::numbers::pi; });
  formats::BrdfTable table;
  for (double wavelength : {500.0, 560.0})
    for (double theta_i : {0.0, 30.0})
      for (double t = -86; t <= 86; t += 1) {
        auto& p = table.points;
        p.theta_i_deg.push_back(theta_i);
        p.theta_r_deg.push_back(t);
        p.phi_r_deg.push_back(0);
        p.wavelength_nm.push_back(wavelength);
        p.polarizer_deg.push_back(open_axis);
        p.analyzer_deg.push_back(open_axis);
        p.brdf_per_sr.push_back(real(0, t, 532, open_axis, open_axis));
        p.brdf_u.push_back(0.003 * p.brdf_per_sr.back());
        p.used.push_back(1);
      }
  Instrument instrument;
  Plan plan;
  plan.step = 2;
  plan.theta_i = {0, 20};
  auto white = make_scan(instrument, real, plan, 8);
  white.set_key("role", "white");
  const auto reference = ReferenceStandard::from_table(table, white);
  EXPECT_NEAR(reference.relative_u(532), 0.003, 1e-12);
  EXPECT_FALSE(reference.brdf(40, 0, 0, 532, open_axis, open_axis)) << "incidence outside";
  EXPECT_FALSE(reference.brdf(0, 88, 0, 532, open_axis, open_axis)) << "exit angle outside";
  EXPECT_FALSE(reference.brdf(0, 10, 0, 633, open_axis, open_axis)) << "wavelength outside";
  EXPECT_NEAR(*reference.brdf(10, 20.5, 0, 532, 0, 90),
              0.5 * real(0, 20.5, 532, open_axis, open_axis), 1e-5);
  const StandardScan standard{white, reference, "ptfe-like", ""};
  const auto w = calibrate(std::span(&standard, 1)).wavelengths[0];
  EXPECT_NEAR(w.gain_constant_v / 600, 1, 1e-3);
  for (double t : {-80.0, -40.0, 60.0, 84.0}) EXPECT_NEAR(w.instrument_function.value(t), 1, 0.004);

  // The same scan with nothing but its reflectance: the shape goes into IF, as [R]'s method would.
  white.set_key("reference_dhr_532", "0.98");
  const auto naive = calibrate_one(white).wavelengths[0].instrument_function;
  EXPECT_GT(naive.value(80), 1.2);
}

TEST(Calibrate, AStandardWithoutATableCarriesTheDoubtOfItsShapeAndPolarisation) {
  // Brighter near the normal than Lambert's law, as real tiles are, and polarising a little.
  const auto tile = polarising(
      [](double t) { return 0.99 / std::numbers::pi * (1 + 0.15 * ReferenceStandard::shape(t)); },
      0, 0.008, 0.03);
  Plan plan;
  plan.step = 2;
  plan.states = all_states;
  auto white = make_scan(Instrument{}, tile, plan, 12);
  white.set_key("reference_dhr_532", "0.99");
  const Calibration c = calibrate_one(white);
  EXPECT_FALSE(c.wavelengths[0].bias_active) << "the standard's own polarisation is no bias";
  EXPECT_GT(c.shape_u, 0.1);
  const auto table = reduce(make_scan(Instrument{}, lambertian(0.4), Plan{}, 3), c).table;
  const formats::BrdfTable::Factor* shape = nullptr;
  for (const auto& factor : table.factors)
    if (factor.name == "reference shape") shape = &factor;
  ASSERT_NE(shape, nullptr);
  for (std::size_t i = 0; i < table.points.size(); ++i) {
    const double error = table.points.brdf_per_sr[i] - 0.4 / std::numbers::pi;
    EXPECT_LT(std::abs(error), 1.6 * std::abs(shape->per_point[i]) + 0.01 * 0.4);
  }
  // The shape keeps the reflectance, so a diffuse sample's reflectance hardly suffers.
  ASSERT_EQ(table.dhr.dhr.size(), 1U);
  EXPECT_NEAR(table.dhr.dhr[0], 0.4, 0.006);
  EXPECT_LT(table.dhr.dhr_u[0], 0.01);
}

TEST(Calibrate, OutliersAmongTheStandardsRecordsAreLeftOut) {
  Instrument instrument;
  auto white = make_white(instrument, 0.99, Plan{}, 3);
  white.x_v[7] *= 1.5;
  white.x_v[20] *= 0.6;
  const auto w = calibrate_one(white).wavelengths[0];
  EXPECT_EQ(w.rejected, 2U);
  EXPECT_NEAR(w.gain_constant_v / 600, 1, 3e-3);
}

TEST(Calibrate, TheDetectorsShadowIsLeftOutAndPassedOnToTheReduction) {
  Instrument instrument;
  Plan plan;
  plan.step = 2;
  auto white = make_white(instrument, 0.99, plan, 3);
  auto sample = make_scan(instrument, lambertian(0.4), plan, 4);
  for (auto* scan : {&white, &sample})
    for (std::size_t i = 0; i < scan->size(); ++i)
      if (std::abs(scan->theta_r_deg[i]) < 1) scan->x_v[i] = 1e-7;
  const Calibration c = calibrate_one(white);
  EXPECT_NEAR(c.wavelengths[0].gain_constant_v / 600, 1, 2e-3);
  EXPECT_NEAR(c.retro_shadow_deg, 2.0, 1e-9) << "up to the nearest good record";
  const Reduction reduction = reduce(sample, c);
  EXPECT_EQ(reduction.summary.in_shadow, 1U);
  EXPECT_NEAR(reduction.table.dhr.dhr.at(0), 0.4, 0.002);
  EXPECT_TRUE(std::any_of(
      reduction.summary.notes.begin(), reduction.summary.notes.end(), [](const std::string& note) {
        return note.find("mirror direction lies in the shadow") != std::string::npos;
      }));
}

TEST(Calibrate, OtherStandardsAreCheckedAgainstTheirStatedReflectance) {
  Instrument instrument;
  Plan plan;
  plan.wavelengths = {532, 633};
  plan.step = 2;
  std::vector<StandardScan> standards;
  for (double rho : {0.99, 0.70, 0.50}) {
    const auto scan =
        make_white(instrument, rho, plan, static_cast<std::uint64_t>(100 * rho), 0.005);
    standards.push_back({scan, ReferenceStandard::from_keys(scan), "SRS", "00"});
  }
  const Calibration c = calibrate(standards);
  ASSERT_EQ(c.checks.size(), 6U);
  for (const StandardCheck& check : c.checks) {
    EXPECT_NEAR(check.computed / check.stated, 1, 0.006) << check.stated;
    EXPECT_GT(check.computed_u / check.computed, 0.004) << "the reference's uncertainty is in it";
    EXPECT_EQ(check.used_for_gain, check.stated > 0.9);
  }
  CalibrateOptions third;
  third.standard = 2;
  EXPECT_NEAR(calibrate(standards, {}, third).wavelengths[0].gain_constant_v / 600, 1, 2e-3);
}

TEST(Calibrate, BadInputIsRefusedWithARemedy) {
  Instrument instrument;
  auto white = make_white(instrument, 0.99, Plan{}, 3);
  EXPECT_THROW(calibrate({}), Error);
  auto missing = make_scan(instrument, lambertian(0.99), Plan{}, 3);
  try {
    ReferenceStandard::from_keys(missing);
    FAIL();
  } catch (const Error& error) {
    EXPECT_NE(error.problem().find("reference_dhr_532"), std::string::npos);
    EXPECT_FALSE(error.remedy().empty());
  }
  missing.set_key("reference_dhr_532", "99");
  EXPECT_THROW(ReferenceStandard::from_keys(missing), Error) << "per cent";
  EXPECT_THROW(ReferenceStandard::from_table({}, white), Error);
  white.saturated.assign(white.size(), 1);
  EXPECT_THROW(calibrate_one(white), Error);
}

TEST(Calibrate, HeaderKeysStandInForACalibration) {
  auto scan = make_scan(Instrument{}, lambertian(0.5), Plan{}, 2);
  EXPECT_THROW(calibration_from_header(scan), Error);
  scan.set_key("gain_constant_532", "600");
  scan.set_key("gain_constant_relative_u", "0.02");
  const Calibration c = calibration_from_header(scan);
  EXPECT_EQ(c.at(532.2).gain_constant_v, 600);
  EXPECT_NEAR(c.at(532).covariance(0, 0), 4e-4, 1e-12);
  EXPECT_THROW(c.at(633), Error);
  scan.set_key("gain_constant_532", "-1");
  EXPECT_THROW(calibration_from_header(scan), Error);
}

}  // namespace
}  // namespace umov::calibrate
