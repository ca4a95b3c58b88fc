// The loop that follows an external reference, and detection against it.
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <functional>
#include <numbers>
#include <vector>

#include "firmware/core/lockin/period_integrator.hpp"
#include "firmware/core/lockin/reference_lock.hpp"
#include "firmware/core/lockin/sine.hpp"
#include "tests/unit/outside_reference.hpp"

namespace umov::firmware {
namespace {

using protocol::ReferenceState;
using test::OutsideReference;

constexpr double turn = 4294967296.0;
constexpr double two_pi = 2 * std::numbers::pi;

/// Jitter may put the first edge before the time zero: the counter's ticks go round.
std::uint32_t tick_of(double time_s) {
  return static_cast<std::uint32_t>(static_cast<std::int64_t>(time_s * reference_clock_hz));
}

/// Edges of a reference, as they are captured.
class Edges {
 public:
  explicit Edges(const OutsideReference& reference) : reference_(reference) {}
  /// The next edge; its moment.
  double feed(ReferenceLock& lock) {
    last_s_ = reference_.edge_s(next_++);
    lock.on_edge(tick_of(last_s_));
    return last_s_;
  }

 private:
  const OutsideReference& reference_;
  std::uint64_t next_ = 1;
  double last_s_ = 0;
};

/// Phase of the lock less that of the reference at a moment, radians. The lock does not know which
/// turn is the first.
double phase_error(const ReferenceLock& lock, const OutsideReference& reference, double time_s) {
  const std::uint32_t tick = tick_of(time_s);
  const double at = std::floor(time_s * reference_clock_hz) / reference_clock_hz;
  const double found = static_cast<double>(lock.line().turns_at(tick)) / turn;
  return two_pi * std::remainder(found - reference.turns(at), 1.0);
}

TEST(ReferenceLock, LocksWithinTwentyPeriodsAndFindsTheFrequency) {
  for (const double hz : {10.0, 37.3, 437.0, 1013.7, 9973.0, 19'990.0}) {
    const OutsideReference reference{.frequency_hz = hz};
    Edges edges(reference);
    ReferenceLock lock;
    int count = 0;
    while (!lock.locked() && count < 100) {
      EXPECT_EQ(lock.frequency_mhz(), 0u);
      edges.feed(lock);
      ++count;
    }
    EXPECT_LE(count - 1, 20) << hz << ": periods";
    for (int i = 0; i < 40; ++i) edges.feed(lock);
    EXPECT_NEAR(lock.frequency_mhz(), 1000 * hz, 1 + 5e-4 * hz) << hz;
    EXPECT_EQ(lock.state(), ReferenceState::locked);
  }
}

/// The least-squares line through the edges, by its textbook sums in floating point.
TEST(ReferenceLock, IsTheLeastSquaresLineUntilOldEdgesFade) {
  const OutsideReference reference{.frequency_hz = 333.3, .jitter_rad = 5e-3};
  ReferenceLock lock;
  Edges edges(reference);
  std::vector<double> times;
  for (std::uint32_t n = 1; n <= ReferenceLock::memory; ++n) {
    times.push_back(std::floor(edges.feed(lock) * reference_clock_hz) + 0.5);
    if (n < 3) continue;
    double sk = 0, st = 0, skk = 0, skt = 0;
    for (std::uint32_t k = 0; k < n; ++k) {
      sk += k;
      skk += double(k) * k;
      st += times[k] - times[0];
      skt += k * (times[k] - times[0]);
    }
    const double period = (n * skt - sk * st) / (n * skk - sk * sk);
    const double last = (st - period * sk) / n + period * (n - 1) + times[0];
    const PhaseLine& line = lock.line();
    EXPECT_NEAR(static_cast<double>(line.period) / 65536, period, 0.01) << n;
    EXPECT_NEAR(line.tick + line.part / 65536.0, last, 0.02) << n;
  }
}

TEST(ReferenceLock, HoldsWithinTenThousandthOfARadian) {
  struct Case {
    double hz, wander;
  };
  for (const Case c : {Case{11.3, 1e-5}, Case{37.3, 1e-5}, Case{437, 1e-5}, Case{1013.7, 1e-4},
                       Case{4973, 1e-4}, Case{19'973, 1e-4}}) {
    const OutsideReference reference{.frequency_hz = c.hz, .wander = c.wander};
    Edges edges(reference);
    ReferenceLock lock;
    double squares = 0;
    int count = 0;
    for (int i = 0; i < 5000; ++i) {
      const double now = edges.feed(lock);
      if (!lock.locked()) continue;
      // Where samples are looked at: up to 2.5 ms before the last edge, or up to a period after.
      for (const double at : {now, now - 1.3e-3, now + 0.5 / c.hz}) {
        const double error = phase_error(lock, reference, at);
        squares += error * error;
        ++count;
      }
    }
    const double rms = std::sqrt(squares / count);
    std::printf("%8.1f Hz, wander %.0e: %.2g rad rms\n", c.hz, c.wander, rms);
    EXPECT_GT(count, 14'000);
    EXPECT_LT(rms, 1e-4) << c.hz;
  }
}

class Jitter : public testing::TestWithParam<std::pair<double, double>> {};

TEST_P(Jitter, ReachesThePhaseByTheShareOfTheMemory) {
  const auto [hz, share] = GetParam();
  const OutsideReference reference{.frequency_hz = hz, .jitter_rad = 3.5e-3};
  Edges edges(reference);
  ReferenceLock lock;
  double squares = 0;
  int count = 0;
  for (int i = 0; i < 20'000; ++i) {
    const double now = edges.feed(lock);
    if (i < 100) continue;
    const double error = phase_error(lock, reference, now);
    squares += error * error;
    ++count;
  }
  EXPECT_NEAR(std::sqrt(squares / count) / reference.jitter_rad, share, 0.02);
}

/// Of a filter with the gains a and b the phase has the variance (2a² + b (2 - 3a)) /
/// (a (4 - 2a - b)) of the edges' (P. R. Kalata, IEEE Trans. Aerosp. Electron. Syst. 20, 1984).
double share_of(double n) {
  const double a = 2 * (2 * n - 1) / (n * (n + 1)), b = 6 / (n * (n + 1));
  return std::sqrt((2 * a * a + b * (2 - 3 * a)) / (a * (4 - 2 * a - b)));
}
INSTANTIATE_TEST_SUITE_P(ReferenceLock, Jitter,
                         testing::Values(std::pair{437.0, share_of(32)},
                                         std::pair{20.0, share_of(12)}));

TEST(ReferenceLock, BridgesMissingAndStrayEdges) {
  const OutsideReference reference{.frequency_hz = 1000};
  ReferenceLock lock;
  for (std::uint64_t n = 1; n < 400; ++n) {
    if (n > 100 && n % 7 == 0) continue;
    lock.on_edge(tick_of(reference.edge_s(n)));
    if (n > 100 && n % 11 == 0) lock.on_edge(tick_of(reference.edge_s(n) + 0.4e-3));
  }
  EXPECT_TRUE(lock.locked());
  EXPECT_EQ(lock.losses(), 0u);
  EXPECT_LT(std::abs(phase_error(lock, reference, reference.edge_s(400))), 1e-4);
}

/// Losses of a lock whose edges 101 to 100 + `count` come late by a quarter of a period, or not at
/// all.
std::uint32_t losses_after(std::uint64_t count, bool late) {
  const OutsideReference reference{.frequency_hz = 1000};
  ReferenceLock lock;
  for (std::uint64_t n = 1; n < 200; ++n) {
    const bool troubled = n > 100 && n <= 100 + count;
    if (troubled && !late) continue;
    const double at = reference.edge_s(n) + (troubled ? 0.25e-3 : 0);
    lock.watch(tick_of(at - 1e-6));
    lock.on_edge(tick_of(at));
  }
  EXPECT_TRUE(lock.locked()) << "at the end, again or still";
  EXPECT_LT(std::abs(phase_error(lock, reference, reference.edge_s(200))), 1e-4);
  return lock.losses();
}

TEST(ReferenceLock, OutlastsThreeInARowAndIsLostAtTheFourth) {
  for (const bool late : {false, true}) {
    EXPECT_EQ(losses_after(3, late), 0u) << late;
    EXPECT_EQ(losses_after(4, late), 1u) << late;
  }
}

/// The limit that the documentation states: nobody can tell a small jump from jitter.
TEST(ReferenceLock, FollowsAJumpOfThePhaseBelowAnEighthOfATurnAndLosesAGreaterOne) {
  for (const double jump : {-0.15, -0.1, 0.1, 0.15}) {
    const OutsideReference reference{.frequency_hz = 1000};
    ReferenceLock lock;
    for (std::uint64_t n = 1; n <= 300; ++n) {
      const double at = reference.edge_s(n) + (n > 100 ? jump * 1e-3 : 0);
      lock.watch(tick_of(at - 1e-6));
      lock.on_edge(tick_of(at));
    }
    EXPECT_EQ(lock.losses(), std::abs(jump) < 0.125 ? 0u : 1u) << jump;
    const double error = phase_error(lock, reference, reference.edge_s(300));
    EXPECT_NEAR(std::remainder(error + two_pi * jump, two_pi), 0, 1e-3) << jump;
  }
}

TEST(ReferenceLock, LosesAReferenceThatStopsJumpsOrLeavesTheRange) {
  ReferenceLock lock;
  const auto lock_on = [&](const OutsideReference& reference, double from_s) {
    for (double t = from_s; t < from_s + 40 / reference.frequency_hz;) {
      t = reference.next_edge_s(t);
      lock.on_edge(tick_of(t));
      lock.watch(tick_of(t + 1e-6));
    }
  };
  const OutsideReference first{.frequency_hz = 1000}, other{.frequency_hz = 1400};
  EXPECT_EQ(lock.state(), ReferenceState::absent);
  lock_on(first, 0.1);
  EXPECT_EQ(lock.state(), ReferenceState::locked);
  lock.watch(tick_of(0.142));
  EXPECT_EQ(lock.state(), ReferenceState::locked) << "two periods without an edge";
  lock.watch(tick_of(0.146));
  EXPECT_EQ(lock.state(), ReferenceState::absent);
  EXPECT_EQ(lock.losses(), 1u);

  lock_on(first, 0.2);
  EXPECT_EQ(lock.state(), ReferenceState::locked);
  lock_on(other, 0.2401);
  EXPECT_EQ(lock.state(), ReferenceState::locked);
  EXPECT_EQ(lock.losses(), 2u) << "locked anew";
  EXPECT_NEAR(lock.frequency_mhz(), 1'400'000, 20);

  for (const double hz : {5.0, 25'000.0}) {
    lock_on({.frequency_hz = hz}, 1.0);
    EXPECT_EQ(lock.state(), ReferenceState::out_of_range) << hz;
  }
  for (std::uint32_t i = 0; i < 200; ++i) {  // edges without a period
    lock.on_edge(tick_of(20.0 + 1e-3 * i + (i % 2 == 0 ? 0 : 0.3e-3)));
  }
  EXPECT_EQ(lock.state(), ReferenceState::unsteady);
}

TEST(ReferenceLock, GoesOnWhereTheClockWraps) {
  const OutsideReference reference{.frequency_hz = 437};
  const double wrap_s = 4294967296.0 / reference_clock_hz;
  ReferenceLock lock;
  double t = wrap_s - 0.1;
  while (t < wrap_s + 0.1) {
    t = reference.next_edge_s(t);
    lock.on_edge(tick_of(t));
    lock.watch(tick_of(t + 1e-4));
  }
  EXPECT_EQ(lock.losses(), 0u);
  EXPECT_LT(std::abs(phase_error(lock, reference, t)), 1e-4);
}

/// A record of a signal of known shape against a reference of known phase.
LockinResult measure(double hz, double first_turns, double dwell_ms, std::uint8_t harmonic,
                     const std::function<double(double)>& wave) {
  const double turns_a_sample = hz / sample_rate_hz;
  PeriodIntegrator integrator;
  integrator.begin({.harmonic = harmonic},
                   plan_periods(static_cast<std::uint32_t>(std::lround(1000 * hz)),
                                static_cast<std::uint32_t>(dwell_ms), 10));
  const auto step = static_cast<std::uint32_t>(std::lround(turns_a_sample * turn));
  std::vector<std::uint16_t> signal(250), monitor(250, 2048);
  for (std::uint64_t n = 0; !integrator.complete(); n += signal.size()) {
    for (std::size_t i = 0; i < signal.size(); ++i) {
      const double phase = first_turns + turns_a_sample * static_cast<double>(n + i);
      // Dithered: else quantisation repeats with the period.
      const double dither = std::fmod(0.618033988749895 * static_cast<double>(n + i), 1.0) - 0.5;
      signal[i] = static_cast<std::uint16_t>(std::lround(2048 + wave(phase) + dither));
    }
    const double here = first_turns + turns_a_sample * static_cast<double>(n);
    integrator.take(signal, monitor, static_cast<std::uint64_t>(here * turn), step);
  }
  return integrator.result();
}

TEST(PeriodIntegrator, FindsAmplitudeAndPhaseWhereverARecordBeginsAndEnds) {
  for (const double hz : {437.0, 1013.7, 3141.592, 9973.0}) {
    double worst_phase = 0, worst_amplitude = 0;
    for (int begin = 0; begin < 100; ++begin) {
      const double phase_rad = 0.3;
      const LockinResult r = measure(hz, 5 + 0.01 * begin, 32, 1, [&](double turns) {
        return 1500 * std::sin(two_pi * turns + phase_rad) + 200;
      });
      const double scale = 2.0 / (static_cast<double>(r.samples) * sine_amplitude);
      const double x = scale * static_cast<double>(r.signal_x);
      const double y = scale * static_cast<double>(r.signal_y);
      worst_phase = std::max(worst_phase, std::abs(std::atan2(y, x) - phase_rad));
      worst_amplitude = std::max(worst_amplitude, std::abs(std::hypot(x, y) / 1500 - 1));
    }
    std::printf("%8.1f Hz: worst of 100 records of 32 ms %.2g rad, amplitude %.2g\n", hz,
                worst_phase, worst_amplitude);
    EXPECT_LT(worst_phase, 5e-5) << hz;
    EXPECT_LT(worst_amplitude, 5e-5) << hz;
  }
}

TEST(PeriodIntegrator, DetectsHarmonicsAndNothingElse) {
  for (std::uint8_t harmonic = 1; harmonic <= 3; ++harmonic) {
    const LockinResult r = measure(1013.7, 3.37, 100, harmonic, [](double turns) {
      return 1000 * std::sin(two_pi * turns) + 400 * std::cos(two_pi * 2 * turns);
    });
    const double scale = 2.0 / (static_cast<double>(r.samples) * sine_amplitude);
    EXPECT_NEAR(scale * static_cast<double>(r.signal_x), harmonic == 1 ? 1000 : 0, 0.05);
    EXPECT_NEAR(scale * static_cast<double>(r.signal_y), harmonic == 2 ? 400 : 0, 0.05);
  }
}

TEST(PeriodIntegrator, PlansWholePeriodsNearTheDwell) {
  EXPECT_EQ(plan_periods(1'000'000, 50, 10).blocks, 10u);
  EXPECT_EQ(plan_periods(1'000'000, 50, 10).block_periods, 5u);
  EXPECT_EQ(plan_periods(10'000, 1, 10).blocks, 2u);
  EXPECT_EQ(plan_periods(10'000, 1, 10).lead_in, 10'000u);
  EXPECT_EQ(plan_periods(20'000'000, 1, 64).lead_in, 64u);
}

}  // namespace
}  // namespace umov::firmware
