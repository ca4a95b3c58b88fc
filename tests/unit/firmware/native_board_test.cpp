#include <gtest/gtest.h>

#include <cstdio>
#include <ctime>

#include "tests/unit/firmware/bench.hpp"

namespace umov::test {
namespace {

/// A world whose samples cost nothing to make.
class CheapWorld : public SmallWorld {
 public:
  void sample(double, double, std::uint64_t first, std::span<std::uint16_t> signal,
              std::span<std::uint16_t> monitor) override {
    auto phase = static_cast<std::uint32_t>(first) * step_per_sample;
    for (std::size_t i = 0; i < signal.size(); ++i) {
      signal[i] = phase < 0x80000000u ? 3000 : 1000;
      monitor[i] = phase < 0x80000000u ? 3100 : 900;
      phase += step_per_sample;
    }
    samples_made += signal.size();
  }
};

TEST(NativeBoard, RunsAThousandRecordsOfFiftyMillisecondsInAFewSeconds) {
  CheapWorld world;
  Bench bench(world);
  ASSERT_TRUE(bench.hello());
  ASSERT_TRUE(bench.home_all());
  constexpr std::uint32_t rows = 1000;
  const std::clock_t begin = std::clock();
  const std::uint64_t begin_us = bench.board.now_us();
  ASSERT_TRUE(bench.ask(pr::ProgramBegin{7, 0, rows}));
  std::uint32_t got = 0;
  while (got < rows) {
    bench.board.run_until_output(20'000);
    bench.listen();
    for (; !bench.heard.records.empty(); bench.heard.records.pop_front()) {
      if (bench.heard.records.front().index == got) ++got;
    }
    bench.send(pr::RecordAck{7, got});
    for (; !bench.heard.credits.empty(); bench.heard.credits.pop_front()) {
      const pr::RowCredit c = bench.heard.credits.front();
      for (std::uint32_t i = c.next_row; i < c.next_row + c.free_slots; ++i) {
        pr::ProgramRow row = Bench::row(i);
        row.dwell_ms = 50;
        row.target_udeg[1] = static_cast<std::int32_t>(i % 81) * 2'000'000 - 80'000'000;
        row.target_udeg[4] = i / 81 % 2 == 0 ? 0 : pr::open_position;
        bench.send(row);
      }
    }
  }
  const double cpu_s = static_cast<double>(std::clock() - begin) / CLOCKS_PER_SEC;
  std::int64_t steps = 0;
  for (const std::int64_t n : world.steps) steps += n;
  std::printf("%u records: %.0f s of virtual time in %.2f s, %.1f M sample pairs, %.1f M steps\n",
              rows, static_cast<double>(bench.board.now_us() - begin_us) * 1e-6, cpu_s,
              static_cast<double>(world.samples_made) * 1e-6, static_cast<double>(steps) * 1e-6);
#if !defined(__SANITIZE_ADDRESS__) && defined(NDEBUG)
  EXPECT_LT(cpu_s, 8.0 / 3.0);
#endif
}

TEST(NativeBoard, LetsVirtualTimePassWithoutAnEvent) {
  SmallWorld world;
  Bench bench(world);
  EXPECT_TRUE(bench.board.resting());
  bench.board.run_for(123'456);
  EXPECT_EQ(bench.board.now_us(), 123'456u);
  EXPECT_FALSE(bench.board.run_until_output(1'000));
  EXPECT_EQ(bench.board.now_us(), 124'456u);
}

}  // namespace
}  // namespace umov::test
