#include "hil/plant/noise.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <cmath>
#include <vector>

#include "bench.hpp"
#include "hil/plant/waveform.hpp"

namespace umov::plant::test {
namespace {

TEST(Gaussian, HasTheMomentsAndTheTailsOfTheNormalDistribution) {
  constexpr int n = 4'000'000;
  double m1 = 0, m2 = 0, m3 = 0, m4 = 0;
  std::array<int, 5> beyond{};
  for (int i = 0; i < n; ++i) {
    const double z = gaussian_of(42, static_cast<std::uint64_t>(i));
    m1 += z;
    m2 += z * z;
    m3 += z * z * z;
    m4 += z * z * z * z;
    for (std::size_t k = 1; k < 5; ++k) beyond[k] += std::abs(z) > static_cast<double>(k);
  }
  EXPECT_NEAR(m1 / n, 0.0, 5.0 / std::sqrt(n));
  EXPECT_NEAR(m2 / n, 1.0, 5.0 * std::sqrt(2.0 / n) + 1e-4);
  EXPECT_NEAR(m3 / n, 0.0, 5.0 * std::sqrt(15.0 / n));
  EXPECT_NEAR(m4 / n, 3.0, 5.0 * std::sqrt(96.0 / n) + 1e-3);
  for (std::size_t k = 1; k < 5; ++k) {
    const double p = std::erfc(static_cast<double>(k) / std::sqrt(2.0));
    EXPECT_NEAR(beyond[k], n * p, 5.0 * std::sqrt(n * p)) << k;
  }
}

/// Codes of a dark, long record.
std::vector<double> dark_codes(const PlantConfig& config, int range, std::size_t n) {
  Bench bench(config, "white-99");
  bench.gain(range);
  std::vector<std::uint16_t> signal(n), monitor(n);
  bench.plant().sample(50.0, sample_rate_hz, 0, signal, monitor);
  return {signal.begin(), signal.end()};
}

double variance(const std::vector<double>& v) {
  double mean = 0;
  for (const double x : v) mean += x / static_cast<double>(v.size());
  double sum = 0;
  for (const double x : v) sum += (x - mean) * (x - mean);
  return sum / static_cast<double>(v.size());
}

TEST(AdcNoise, HasTheStatedSizeInEveryRangeAndDithersTheCodes) {
  for (int range = 0; range < 4; ++range) {
    const auto codes = dark_codes(ideal_config(), range, 200'000);
    const double gain = std::pow(10.0, range);
    const double sigma_codes = std::hypot(5e-4, 2e-6 * gain) * 4096.0 / 3.3;
    EXPECT_GE(sigma_codes, 0.5);
    const double expected = sigma_codes * sigma_codes + 1.0 / 12.0;
    EXPECT_NEAR(variance(codes) / expected, 1.0, 0.02) << range;
  }
}

TEST(AdcNoise, IsWhite) {
  const auto codes = dark_codes(ideal_config(), 3, 200'000);
  const double v = variance(codes);
  for (const std::size_t lag : {1u, 2u, 3u, 7u, 50u, 100u, 128u, 250u}) {
    double sum = 0;
    for (std::size_t i = 0; i + lag < codes.size(); ++i) {
      sum += (codes[i] - 2048.0) * (codes[i + lag] - 2048.0);
    }
    EXPECT_NEAR(sum / static_cast<double>(codes.size()) / v, 0.0,
                5.0 / std::sqrt(static_cast<double>(codes.size())))
        << lag;
  }
}

TEST(AdcNoise, OfSignalAndMonitorAreIndependent) {
  Bench bench(ideal_config(), "white-99");
  constexpr std::size_t n = 200'000;
  std::vector<std::uint16_t> signal(n), monitor(n);
  bench.plant().sample(50.0, sample_rate_hz, 0, signal, monitor);
  double sum = 0, ss = 0, mm = 0;
  for (std::size_t i = 0; i < n; ++i) {
    const double s = signal[i] - 2048.0, m = monitor[i] - 2048.0;
    sum += s * m;
    ss += s * s;
    mm += m * m;
  }
  EXPECT_NEAR(sum / std::sqrt(ss * mm), 0.0, 5.0 / std::sqrt(static_cast<double>(n)));
}

TEST(Quantisation, DoesNotBiasASignalMuchSmallerThanOneCode) {
  // A fundamental of a tenth of a code, averaged over many periods.
  PlantConfig config = ideal_config();
  config.amplifier.pickup_v = 0.1 * 3.3 / 4096.0;
  Bench bench(config, "white-99");
  const LockinResult r = bench.measure(4000);
  EXPECT_NEAR(r.x_v, config.amplifier.pickup_v, 5.0 * bench.standard_error(4000));
}

TEST(ShotNoise, VarianceGrowsWithTheLightAndOnlyWhileItIsOn) {
  PlantConfig config = ideal_config();
  config.detector.shot_noise_v = 2e-6;
  Bench bench(config, "lambertian-99");
  bench.laser(1);
  bench.gain(1);
  const auto halves = [&](double theta_r) {
    bench.geometry(0.0, theta_r);
    constexpr std::size_t n = 400'000;
    std::vector<std::uint16_t> signal(n), monitor(n);
    bench.wait(10.0);
    bench.plant().sample(bench.time_s(), sample_rate_hz, 0, signal, monitor);
    std::vector<double> lit, dark;
    for (std::size_t i = 0; i < n; ++i) (i % 100 < 50 ? lit : dark).push_back(signal[i]);
    return std::pair(variance(lit), variance(dark));
  };
  for (const double theta_r : {0.0, 60.0}) {
    const auto [lit, dark] = halves(theta_r);
    const double volts = bench.plant().expected(bench.time_s()).x_v;
    const double codes = 4096.0 / 3.3;
    EXPECT_NEAR(lit - dark, 100.0 * 2e-6 * volts * codes * codes, 0.03 * lit) << theta_r;
  }
}

TEST(PowerNoise, CancelsAgainstTheMonitor) {
  PlantConfig config = ideal_config();
  for (LaserConfig& l : config.laser) {
    l.sample_noise = 0.02;
    l.power_noise = 0.03;
  }
  Bench bench(config, "white-99");
  bench.geometry(10, 30);
  bench.laser(1);
  bench.gain(1);
  double ratio_var = 0, power_var = 0, ratio_mean = 0, power_mean = 0;
  constexpr int n = 200;
  std::vector<double> ratio, power;
  for (int i = 0; i < n; ++i) {
    bench.wait(37.0);
    const LockinResult r = bench.measure();
    ratio.push_back(r.x_v / r.monitor_v);
    power.push_back(r.monitor_v);
    ratio_mean += ratio.back() / n;
    power_mean += power.back() / n;
  }
  for (int i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    ratio_var += std::pow(ratio[k] / ratio_mean - 1.0, 2.0) / n;
    power_var += std::pow(power[k] / power_mean - 1.0, 2.0) / n;
  }
  EXPECT_GT(std::sqrt(power_var), 0.015);
  EXPECT_LT(std::sqrt(power_var), 0.045);
  EXPECT_LT(std::sqrt(ratio_var), 3e-4);
}

TEST(UnseenNoise, StaysInTheRatioWithItsRms) {
  PlantConfig config = ideal_config();
  config.laser[1].unseen_noise = 0.01;
  Bench bench(config, "white-99");
  bench.laser(1);
  const double monitor = bench.plant().expected(0.0).monitor_v;
  double sum = 0, squares = 0;
  constexpr int n = 4000;
  for (int i = 0; i < n; ++i) {
    const ExpectedSignal e = bench.plant().expected(1000.0 * i);
    EXPECT_EQ(e.monitor_v, monitor);
    sum += e.x_v;
    squares += e.x_v * e.x_v;
  }
  const double mean = sum / n;
  EXPECT_NEAR(std::sqrt(squares / n - mean * mean) / mean, 0.01, 0.001);
}

TEST(Sampling, IsTheSameHoweverAStreamIsCutIntoBlocks) {
  const auto run = [](std::size_t block) {
    Bench bench(realistic_config(), "red-gloss", 11);
    bench.geometry(30, 28);
    bench.laser(0);
    bench.gain(1);
    constexpr std::size_t n = 5000;
    std::vector<std::uint16_t> signal(n), monitor(n);
    for (std::size_t from = 0; from < n; from += block) {
      const std::size_t count = std::min(block, n - from);
      bench.plant().sample(33.25, sample_rate_hz, from, std::span(signal).subspan(from, count),
                           std::span(monitor).subspan(from, count));
    }
    signal.insert(signal.end(), monitor.begin(), monitor.end());
    return signal;
  };
  const auto whole = run(5000);
  EXPECT_EQ(whole, run(250));
  EXPECT_EQ(whole, run(1));
  EXPECT_EQ(whole, run(77));
}

TEST(Sampling, FollowsTheSeedAndNothingElse) {
  const auto run = [](std::uint64_t seed) {
    Bench bench(realistic_config(), "white-50", seed);
    bench.geometry(20, 10);
    bench.laser(2);
    std::vector<std::uint16_t> signal(1000), monitor(1000);
    bench.plant().sample(5.0, sample_rate_hz, 0, signal, monitor);
    return signal;
  };
  EXPECT_EQ(run(3), run(3));
  EXPECT_NE(run(3), run(4));
}

TEST(Sampling, ClipsAtTheEndsOfTheCodeRange) {
  Bench bench(ideal_config(), "white-99");
  bench.geometry(10, 10);
  bench.laser(1);
  bench.polarization(open, open);
  bench.gain(3);
  const LockinResult r = bench.measure();
  EXPECT_EQ(r.clipped, 5000);
}

TEST(SquareWave, IsHighWhileThePhaseIsBelowHalfATurn) {
  ChannelWave wave;
  wave.in_phase = 100.0;
  const std::uint32_t step = 0x13579bdfu;
  std::vector<std::uint16_t> signal(1000), monitor(1000);
  synthesize(wave, ChannelWave{}, NoiseKeys{}, step, 5, signal, monitor);
  for (std::size_t i = 0; i < signal.size(); ++i) {
    const std::uint32_t phase = static_cast<std::uint32_t>((i + 5) * step);
    EXPECT_EQ(signal[i], phase < 0x80000000u ? 2148 : 1948);
    EXPECT_EQ(monitor[i], 2048);
  }
}

TEST(Sampling, TakesFifteenMillionPairsInUnderFiveSeconds) {
  Bench bench(realistic_config(), "red-gloss");
  bench.geometry(30, 28);
  bench.laser(0);
  std::vector<std::uint16_t> signal(250), monitor(250);
  const auto begin = std::chrono::steady_clock::now();
  constexpr int blocks = 6000;
  for (int i = 0; i < blocks; ++i) {
    bench.plant().sample(10.0, sample_rate_hz, static_cast<std::uint64_t>(i) * 250, signal,
                         monitor);
  }
  const double seconds =
      std::chrono::duration<double>(std::chrono::steady_clock::now() - begin).count();
  const double per_15_million = seconds * 15e6 / (blocks * 250.0);
  RecordProperty("seconds_per_15_million_pairs", std::to_string(per_15_million));
  std::printf("15 million pairs would take %.2f s\n", per_15_million);
#if defined(NDEBUG) && !defined(__SANITIZE_ADDRESS__)
  EXPECT_LT(per_15_million, 5.0);
#endif
}

}  // namespace
}  // namespace umov::plant::test
