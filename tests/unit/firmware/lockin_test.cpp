#include <gtest/gtest.h>

#include <cmath>
#include <complex>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "firmware/core/config/design_parameters.hpp"
#include "firmware/core/lockin/acquisition.hpp"
#include "firmware/core/lockin/integrator.hpp"
#include "firmware/core/lockin/reference.hpp"
#include "firmware/core/lockin/sine.hpp"

namespace umov::firmware {
namespace {

constexpr double turn = 4294967296.0;
constexpr double two_pi = 2 * std::numbers::pi;

/// Codes of both channels of a record, n counted from the start of sampling.
struct Stream {
  std::vector<std::uint16_t> signal, monitor;
};
Stream make_stream(
    std::uint32_t samples, const std::function<double(std::uint64_t)>& signal,
    const std::function<double(std::uint64_t)>& monitor = [](auto) { return 0.0; }) {
  const auto code = [](double v) {
    return static_cast<std::uint16_t>(std::clamp(std::lround(v + 2048), 0L, 4095L));
  };
  Stream s;
  for (std::uint64_t n = 0; n < samples; ++n) {
    s.signal.push_back(code(signal(n)));
    s.monitor.push_back(code(monitor(n)));
  }
  return s;
}

LockinResult integrate(const Detection& detection, const RecordPlan& plan, const Stream& s,
                       std::size_t chunk = 250) {
  Integrator integrator;
  integrator.begin(detection, plan, 0);
  for (std::size_t i = 0; i < s.signal.size(); i += chunk) {
    const std::size_t n = std::min(chunk, s.signal.size() - i);
    integrator.take({s.signal.data() + i, n}, {s.monitor.data() + i, n});
  }
  EXPECT_TRUE(integrator.complete());
  return integrator.result();
}

/// Amplitude in codes and phase of the result.
std::complex<double> codes(std::int64_t x, std::int64_t y, std::uint32_t samples) {
  const double scale = 2.0 / (static_cast<double>(samples) * sine_amplitude);
  return {static_cast<double>(x) * scale, static_cast<double>(y) * scale};
}

/// Phase of the modulation at sample n as the board makes it, with the half spacing that detection
/// adds.
double phase_at(const Reference& r, std::uint64_t n) {
  return two_pi *
         static_cast<double>(static_cast<std::uint32_t>(n * r.phase_step + r.half_spacing())) /
         turn;
}

bool laser_on(const Reference& r, std::uint64_t n) {
  return static_cast<std::uint32_t>(n * r.phase_step) < 0x80000000u;
}

TEST(Sine, IsTheSineToThreeInTenMillionAndExactlySymmetric) {
  std::mt19937 random(1);
  for (int i = 0; i < 200'000; ++i) {
    const std::uint32_t phase = static_cast<std::uint32_t>(random());
    ASSERT_NEAR(sine_of(phase) / static_cast<double>(fine_amplitude),
                std::sin(two_pi * phase / turn), 3.1e-7);
    ASSERT_EQ(sine_of(phase + 0x80000000u), -sine_of(phase));
    ASSERT_EQ(sine_of(0x80000000u - phase), sine_of(phase));
  }
  EXPECT_EQ(sine_of(0), 0);
  EXPECT_EQ(sine_of(quarter_turn), fine_amplitude);
  EXPECT_EQ(from_fine(std::int64_t{fine_amplitude} * 12345), 32767 * 12345);
  EXPECT_EQ(from_fine(-std::int64_t{fine_amplitude} * 12345), -32767 * 12345);
}

TEST(Reference, IsWithinATenthOfAPercentAndFitsWholePeriods) {
  for (std::uint32_t mhz = 10'000; mhz <= 20'000'000; mhz += mhz / 97 + 13) {
    const Reference r = choose_reference(mhz);
    const double have = 1e8 * r.periods / r.samples;
    ASSERT_NEAR(have / mhz, 1.0, 1.0001e-3) << mhz;
    ASSERT_LE(r.samples, std::max(1000u, static_cast<std::uint32_t>(1.002e8 / mhz))) << mhz;
    const double excess = r.phase_step - turn * r.periods / r.samples;
    ASSERT_GE(excess, 0.0);
    ASSERT_LT(excess, 1.0);
  }
  EXPECT_EQ(choose_reference(1'000'000).samples, 100u);
  EXPECT_EQ(choose_reference(1'000'000).periods, 1u);
}

TEST(Reference, CutsRecordsIntoEqualBlocksNearTheDwell) {
  for (const std::uint32_t mhz : {997'331u, 1'000'000u, 1'234'567u, 330'000u, 7'654'321u}) {
    const Reference r = choose_reference(mhz);
    for (const std::uint32_t dwell : {1u, 5u, 20u, 50u, 333u, 60'000u}) {
      const RecordPlan plan = plan_record(r, dwell, 10);
      ASSERT_GE(plan.blocks, 2u);
      ASSERT_LE(plan.blocks, 10u);
      ASSERT_EQ(plan.block_samples % r.samples, 0u);
      ASSERT_EQ(plan.lead_in % r.samples, 0u);
      const double wanted = dwell * 100.0;
      const double slack = std::max(2.0 * r.samples, wanted / 6);
      ASSERT_NEAR(plan.samples(), wanted, slack) << mhz << " " << dwell;
    }
  }
  EXPECT_EQ(plan_record(choose_reference(1'000'000), 50, 10).samples(), 5000u);
}

TEST(Lockin, FindsAmplitudeAndPhaseOfASine) {
  for (const std::uint32_t mhz : {1'000'000u, 1'013'700u, 777'777u, 5'432'100u}) {
    const Detection d{.reference = choose_reference(mhz)};
    const RecordPlan plan = plan_record(d.reference, 50, 10);
    for (const double phase : {0.0, 0.3, -1.2, 2.5}) {
      std::mt19937_64 random(5);
      std::uniform_real_distribution<> dither(-0.5, 0.5);
      const Stream s = make_stream(
          plan.samples(),
          [&](auto n) { return 900 * std::sin(phase_at(d.reference, n) + phase) + dither(random); },
          [&](auto n) { return 700 * std::sin(phase_at(d.reference, n)) + dither(random); });
      const LockinResult r = integrate(d, plan, s);
      const auto z = codes(r.signal_x, r.signal_y, r.samples);
      ASSERT_NEAR(std::abs(z), 900, 0.05);
      ASSERT_NEAR(std::remainder(std::arg(z) - phase, two_pi), 0, 5e-5);
      ASSERT_NEAR(codes(r.monitor_x, r.monitor_y, r.samples).real(), 700, 0.05);
    }
  }
}

TEST(Lockin, GivesNoQuadratureForTheSampledSquareWaveOfTheLaser) {
  // Bound: pi x 5000 / 2^32, the excess of the phase step (below 1) over a record.
  for (std::uint32_t mhz = 300'000; mhz < 9'000'000; mhz += mhz / 31) {
    const Detection d{.reference = choose_reference(mhz)};
    const RecordPlan plan = plan_record(d.reference, 50, 10);
    const Stream s = make_stream(plan.samples(),
                                 [&](auto n) { return laser_on(d.reference, n) ? 1000.0 : 200.0; });
    const LockinResult r = integrate(d, plan, s);
    const auto z = codes(r.signal_x, r.signal_y, r.samples);
    const double shape =
        std::numbers::pi / d.reference.samples * (d.reference.samples % 2 == 0 ? 1.0 : 0.5);
    // Fundamental of a square wave of samples phases: 4/pi (x / sin x), x = pi / samples.
    ASSERT_NEAR(z.real(), 400 * 4 / std::numbers::pi * shape / std::sin(shape),
                0.4 * 4e-2 + 400 * shape * shape)
        << mhz;
    ASSERT_NEAR(z.imag() / z.real(), 0, 3.7e-6) << mhz << " " << d.reference.samples;
  }
}

TEST(Lockin, HasNoPhaseBiasOverAThousandRecordsAtNonIntegerRatios) {
  for (const std::uint32_t mhz : {1'013'700u, 777'777u, 3'141'592u}) {
    const Detection d{.reference = choose_reference(mhz)};
    const RecordPlan plan = plan_record(d.reference, 50, 10);
    ASSERT_NE(sample_rate_hz * 1000ull % mhz, 0u);
    std::mt19937_64 random(mhz);
    std::uniform_real_distribution<> dither(-0.5, 0.5);
    const double truth = 0.4;
    double sum = 0;
    constexpr int records = 1000;
    std::vector<double> clean(plan.samples());
    for (std::uint32_t n = 0; n < plan.samples(); ++n) {
      clean[n] = 1900 * std::sin(phase_at(d.reference, n) + truth);
    }
    for (int i = 0; i < records; ++i) {
      const Stream s =
          make_stream(plan.samples(), [&](auto n) { return clean[n] + dither(random); });
      const LockinResult r = integrate(d, plan, s);
      sum += std::arg(codes(r.signal_x, r.signal_y, r.samples)) - truth;
    }
    // Dither and rounding scatter the mean by 1.5e-7.
    EXPECT_LT(std::fabs(sum / records), 1e-6) << mhz;
    RecordProperty("phase_bias_rad", std::to_string(sum / records));
    std::printf("phase bias at %.3f Hz: %.2e rad\n", mhz / 1000.0, sum / records);
  }
}

TEST(Lockin, AddsThePhaseOffsetToTheReference) {
  Detection d{.reference = choose_reference(1'000'000)};
  d.phase_offset = phase_from_udeg(30'000'000);
  const RecordPlan plan = plan_record(d.reference, 50, 10);
  const Stream s = make_stream(plan.samples(), [&](auto n) {
    return 1000 * std::sin(phase_at(d.reference, n) + two_pi / 12);
  });
  const LockinResult r = integrate(d, plan, s);
  const auto z = codes(r.signal_x, r.signal_y, r.samples);
  EXPECT_NEAR(z.real(), 1000, 0.2);
  EXPECT_NEAR(z.imag(), 0, 0.1);
}

TEST(Lockin, DetectsTheHarmonicAskedForAndNoOther) {
  for (const int harmonic : {1, 2, 3, 5}) {
    Detection d{.reference = choose_reference(1'013'700)};
    d.harmonic = static_cast<std::uint8_t>(harmonic);
    const RecordPlan plan = plan_record(d.reference, 50, 10);
    std::mt19937_64 random(static_cast<unsigned>(harmonic));
    std::uniform_real_distribution<> dither(-0.5, 0.5);
    const Stream s = make_stream(plan.samples(), [&](auto n) {
      const double p = phase_at(d.reference, n);
      return 400 * std::sin(p) + 300 * std::sin(2 * p) + 200 * std::sin(3 * p) +
             100 * std::sin(5 * p) + dither(random);
    });
    const LockinResult r = integrate(d, plan, s);
    const double expected = harmonic == 1 ? 400 : harmonic == 2 ? 300 : harmonic == 3 ? 200 : 100;
    EXPECT_NEAR(codes(r.signal_x, r.signal_y, r.samples).real(), expected, 0.05);
    EXPECT_NEAR(codes(r.signal_x, r.signal_y, r.samples).imag(), 0, 0.05);
  }
}

TEST(Lockin, IgnoresAConstantLevelExactly) {
  for (const std::uint32_t mhz : {1'000'000u, 1'013'700u, 777'777u, 6'666'666u, 20'000'000u}) {
    const Detection d{.reference = choose_reference(mhz)};
    const RecordPlan plan = plan_record(d.reference, 50, 10);
    const Stream s = make_stream(
        plan.samples(), [](auto) { return 1777.0; }, [](auto) { return -1999.0; });
    const LockinResult r = integrate(d, plan, s);
    EXPECT_EQ(r.signal_x, 0) << mhz;
    EXPECT_EQ(r.signal_y, 0) << mhz;
    EXPECT_EQ(r.monitor_x, 0) << mhz;
    EXPECT_EQ(r.signal_x_se, 0u) << mhz;
  }
}

TEST(Lockin, GivesAnHonestStandardError) {
  // Over many records the scatter of X and Y must be what each record says of itself.
  const Detection d{.reference = choose_reference(1'000'000)};
  const RecordPlan plan = plan_record(d.reference, 20, 10);
  std::mt19937_64 random(11);
  std::normal_distribution<> noise(0, 12);
  double sum = 0, squares = 0, claimed = 0, claimed_monitor = 0, squares_monitor = 0,
         sum_monitor = 0;
  constexpr int records = 1500;
  for (int i = 0; i < records; ++i) {
    const Stream s = make_stream(
        plan.samples(),
        [&](auto n) { return (laser_on(d.reference, n) ? 500 : -500) + noise(random); },
        [&](auto n) { return (laser_on(d.reference, n) ? 300 : -300) + 0.5 * noise(random); });
    const LockinResult r = integrate(d, plan, s);
    const auto x = static_cast<double>(r.signal_x), m = static_cast<double>(r.monitor_x);
    sum += x;
    squares += x * x;
    sum_monitor += m;
    squares_monitor += m * m;
    claimed += std::pow(static_cast<double>(r.signal_x_se), 2);
    claimed_monitor += std::pow(static_cast<double>(r.monitor_se), 2);
  }
  const double variance = (squares - sum * sum / records) / (records - 1);
  const double variance_m = (squares_monitor - sum_monitor * sum_monitor / records) / (records - 1);
  // Relative scatter of the ratio: sqrt(2/1500 + 2/(9 x 1500)) = 0.038.
  EXPECT_NEAR(claimed / records / variance, 1.0, 0.12);
  EXPECT_NEAR(claimed_monitor / records / variance_m, 1.0, 0.12);
}

TEST(Lockin, AgreesToTheLastBitWithSumsInWideIntegers) {
  std::mt19937_64 random(21);
  for (int i = 0; i < 20; ++i) {
    Detection d{.reference =
                    choose_reference(10'000 + static_cast<std::uint32_t>(random() % 15'000'000))};
    d.phase_offset = static_cast<std::uint32_t>(random());
    const RecordPlan plan =
        plan_record(d.reference, 30, 2 + static_cast<std::uint32_t>(random() % 20));
    const Stream s = make_stream(
        plan.samples(), [&](auto) { return static_cast<double>(random() % 4096) - 2048; },
        [&](auto) { return static_cast<double>(random() % 4096) - 2048; });
    using Wide = __int128;
    Wide x = 0, squares = 0;
    for (std::uint32_t b = 0; b < plan.blocks; ++b) {
      Wide product = 0, level = 0, sines = 0;
      for (std::uint32_t k = 0; k < plan.block_samples; ++k) {
        const std::uint64_t n = std::uint64_t{b} * plan.block_samples + k;
        const auto phase = static_cast<std::uint32_t>(n * d.reference.phase_step +
                                                      d.reference.half_spacing() + d.phase_offset);
        const int code = static_cast<int>(s.signal[n]) - 2048;
        product += Wide{code} * sine_of(phase);
        level += code;
        sines += sine_of(phase);
      }
      const Wide half = plan.block_samples / 2;
      const Wide leak = level * sines;
      const Wide fine = product - (leak + (leak >= 0 ? half : -half)) / Wide{plan.block_samples};
      // To the nearest code x sine, halves upwards.
      const Wide block = (fine * sine_amplitude + fine_amplitude / 2) >> fine_bits;
      x += block;
      squares += block * block;
    }
    const Wide scatter = (squares * Wide{plan.blocks} - x * x) / Wide{plan.blocks - 1};
    for (const std::size_t chunk :
         {std::size_t{1}, std::size_t{97}, std::size_t{250}, s.signal.size()}) {
      const LockinResult r = integrate(d, plan, s, chunk);
      ASSERT_EQ(r.signal_x, static_cast<std::int64_t>(x));
      const Wide se = static_cast<Wide>(r.signal_x_se);
      ASSERT_TRUE(se * se <= scatter && (se + 1) * (se + 1) > scatter);
    }
  }
}

TEST(Lockin, KeepsStandardErrorsThatNeedMoreThan64Bits) {
  BlockScatter scatter;
  const std::int64_t big = std::int64_t{1} << 50;
  for (int i = 0; i < 64; ++i) scatter.add(i % 2 == 0 ? big : -big);
  // sqrt(64 x 64 big^2 / 63) = 64 big / sqrt(63)
  EXPECT_NEAR(static_cast<double>(scatter.standard_error()) /
                  (64.0 * static_cast<double>(big) / std::sqrt(63.0)),
              1.0, 1e-12);
}

TEST(Lockin, CountsClippedCodesOfBothChannels) {
  const Detection d{.reference = choose_reference(1'000'000)};
  const RecordPlan plan = plan_record(d.reference, 10, 2);
  Stream s = make_stream(plan.samples(), [](auto) { return 0.0; });
  s.signal[3] = 0;
  s.signal[400] = 4095;
  s.monitor[17] = 4095;
  EXPECT_EQ(integrate(d, plan, s).saturated, 3u);
}

/// A signal seen through the amplifier, one acquisition after another as the sequencer runs them.
struct Ranging {
  AutoRange range;
  int restarts = 0;
  int measure(double signal_codes, std::uint8_t request = protocol::gain_auto) {
    const Detection d{.reference = choose_reference(1'000'000)};
    const RecordPlan plan = plan_record(d.reference, 10, 5);
    int current = range.begin(request);
    Acquisition acquisition;
    for (restarts = 0; restarts < 20; ++restarts) {
      acquisition.begin(d, plan, range);
      const double gain = std::pow(10.0, current);
      const Stream s = make_stream(plan.lead_in + plan.samples(), [&](auto n) {
        return (laser_on(d.reference, n) ? 1 : -1) * signal_codes * gain;
      });
      acquisition.take(s.signal, s.monitor, {});
      if (acquisition.outcome() == Acquisition::Outcome::complete) return current;
      EXPECT_EQ(acquisition.outcome(), Acquisition::Outcome::range_changed);
      current = range.range();
    }
    ADD_FAILURE() << "the range swings";
    return -1;
  }
};

TEST(AutoRange, ClimbsToTheRangeThatFillsTheConverterWithoutClipping) {
  Ranging r;
  EXPECT_EQ(r.measure(1.0), 3);
  EXPECT_EQ(r.restarts, 3);
  EXPECT_EQ(r.measure(1.0), 3);
  EXPECT_EQ(r.restarts, 0);  // remembered
}

TEST(AutoRange, FallsBackWhenASignalClips) {
  Ranging r;
  r.measure(1.0);
  EXPECT_EQ(r.measure(900), 0);
  EXPECT_EQ(r.restarts, 3);
}

TEST(AutoRange, DoesNotSwingNearTheThresholds) {
  for (double level = 0.1; level < 2000; level *= 1.07) {
    Ranging r;
    const int range = r.measure(level);
    EXPECT_LT(level * std::pow(10, range), 2047.5);
    for (int i = 0; i < 3; ++i) {
      EXPECT_EQ(r.measure(level * (1 + 0.02 * i)), range);
      EXPECT_EQ(r.restarts, 0);
    }
  }
}

TEST(AutoRange, LeavesAFixedRangeAloneEvenWhenItClips) {
  Ranging r;
  EXPECT_EQ(r.measure(900, 2), 2);
  EXPECT_EQ(r.restarts, 0);
}

TEST(AutoRange, StepsDownWhenClippingBeginsAfterTheLeadIn) {
  AutoRange range;
  range.begin(protocol::gain_auto);
  range.judge_lead_in(10, false);  // now at range 1
  const Detection d{.reference = choose_reference(1'000'000)};
  const RecordPlan plan = plan_record(d.reference, 10, 5);
  Acquisition acquisition;
  ASSERT_EQ(range.begin(protocol::gain_auto), 1);
  acquisition.begin(d, plan, range);
  Stream s = make_stream(plan.lead_in + plan.samples(), [](auto) { return 500.0; });
  s.signal[plan.lead_in + 300] = 4095;
  EXPECT_TRUE(acquisition.take(s.signal, s.monitor, {}));
  EXPECT_EQ(acquisition.outcome(), Acquisition::Outcome::range_changed);
  EXPECT_EQ(range.range(), 0);
}

}  // namespace
}  // namespace umov::firmware
