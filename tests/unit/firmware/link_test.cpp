#include <gtest/gtest.h>

#include "tests/unit/firmware/bench.hpp"

namespace umov::test {
namespace {

TEST(Link, AnswersNothingButHelloBeforeTheSessionIsOpen) {
  SmallWorld world;
  Bench bench(world);
  EXPECT_EQ(bench.refusal_of(pr::GetStatus{}), pr::Refusal::schema_mismatch);
  ASSERT_TRUE(bench.hello());
  EXPECT_EQ(bench.refusal_of(pr::GetStatus{}), pr::Refusal::none);
}

TEST(Link, AnswersAHelloOfAnotherSchemaButKeepsTheSessionClosed) {
  SmallWorld world;
  Bench bench(world);
  const auto reply =
      bench.ask(pr::Hello{.version = pr::protocol_version, .schema_hash = 1, .host_name = {}});
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->schema_hash, pr::schema_hash);
  EXPECT_EQ(bench.refusal_of(pr::GetStatus{}), pr::Refusal::schema_mismatch);
}

TEST(Link, TellsTheScalesOfItsNumbers) {
  SmallWorld world;
  Bench bench(world, {.serial = "A17", .boot_id = 42, .link_time_us = {}, .log = nullptr});
  const auto reply = bench.ask(
      pr::Hello{.version = pr::protocol_version, .schema_hash = pr::schema_hash, .host_name = {}});
  ASSERT_TRUE(reply);
  EXPECT_EQ(reply->sample_rate_hz, 100'000u);
  EXPECT_EQ(reply->adc_codes, 4096);
  EXPECT_EQ(reply->sine_amplitude, 32767);
  EXPECT_EQ(reply->boot_id, 42u);
  EXPECT_STREQ(reply->serial.data(), "A17");
  EXPECT_NE(reply->firmware_hash, 0u);
}

TEST(Link, RefusesUnknownMessagesWrongLengthsAndFieldsOutOfRange) {
  SmallWorld world;
  Bench bench(world);
  ASSERT_TRUE(bench.hello());
  const auto refusal = [&](std::uint8_t type, std::vector<std::uint8_t> payload) {
    std::array<std::uint8_t, pr::max_wire_frame_size> frame;
    const std::size_t size = pr::FrameWriter::write_raw(type, 999, payload, frame);
    bench.board.deliver(std::span<const std::uint8_t>(frame.data(), size));
    bench.listen();
    pr::ErrorReply reply;
    EXPECT_TRUE(pr::decode(bench.heard.replies[999].second, reply).ok());
    EXPECT_EQ(reply.request, type);
    return static_cast<pr::Refusal>(reply.code);
  };
  EXPECT_EQ(refusal(0x7e, {}), pr::Refusal::unknown_message);
  EXPECT_EQ(refusal(pr::Record::info.id, {}), pr::Refusal::unknown_message);  // a device's message
  EXPECT_EQ(refusal(pr::GetAxis::info.id, {1, 2}), pr::Refusal::bad_length);
  EXPECT_EQ(refusal(pr::GetAxis::info.id, {6}), pr::Refusal::out_of_range);
}

TEST(Link, RefusesAHarmonicBeyondHalfTheSampleRate) {
  SmallWorld world;
  Bench bench(world);
  ASSERT_TRUE(bench.hello());
  EXPECT_EQ(bench.refusal_of(pr::SetLockin{20'000'000, 3, 0, 10, 10}), pr::Refusal::out_of_range);
  EXPECT_EQ(bench.refusal_of(pr::SetLockin{20'000'000, 2, 0, 10, 10}), pr::Refusal::none);
}

TEST(Link, ReadsThroughNoise) {
  SmallWorld world;
  Bench bench(world);
  ASSERT_TRUE(bench.hello());
  std::mt19937 random(9);
  for (int i = 0; i < 300; ++i) {
    std::vector<std::uint8_t> noise(random() % 300);
    for (auto& byte : noise) byte = static_cast<std::uint8_t>(random());
    noise.push_back(0);
    bench.board.deliver(noise);
    bench.listen();
    ASSERT_TRUE(bench.ask(pr::GetStatus{}));
  }
}

TEST(Link, HoldsBackWhatDoesNotFitAHostThatDoesNotRead) {
  SmallWorld world;
  Bench bench(world);
  ASSERT_TRUE(bench.hello());
  ASSERT_TRUE(bench.home_all());
  ASSERT_TRUE(bench.ask(pr::ProgramBegin{7, 0, 190}));
  for (int n = 0; n < 200; ++n) {  // feeds rows blindly, never reads
    for (std::uint32_t i = 0; i < 190; ++i) bench.send(Bench::row(i));
    bench.board.run_for(100'000);
  }
  bench.listen();
  bench.heard = {};
  EXPECT_EQ(bench.status().next_record, 190u);
  bench.send(pr::RecordAck{7, 0});
  for (int i = 0; i < 20; ++i) {
    bench.board.run_for(1'000);
    bench.listen();
  }
  std::set<std::uint32_t> rows;
  for (const pr::Record& r : bench.heard.records) rows.insert(r.index);
  EXPECT_EQ(rows.size(), 190u);
}

}  // namespace
}  // namespace umov::test
