// The image that is flashed, on the emulated chip, against the same core as a host process: the
// same scan gives the same records to the last bit, up to the moments.
#include <gtest/gtest.h>

#include "host/cli/emulator/emulated_instrument.hpp"
#include "host/cli/emulator/mcu/mcu_instrument.hpp"
#include "protocol/codec.hpp"
#include "tests/unit/mcu_board/noisy_stages.hpp"
#include "tests/unit/mcu_board/scan_run.hpp"

namespace umov {
namespace {

using protocol::ProgramRow;
using protocol::Record;

constexpr double out_of_beam = 1e9;  ///< polariser or analyser out of the beam

/// A record's bytes as they are sent, with the moment left out.
std::vector<std::uint8_t> bytes_without_time(Record record) {
  record.time_us = 0;
  std::vector<std::uint8_t> bytes(protocol::wire_size<Record>);
  EXPECT_TRUE(protocol::encode(record, bytes).ok());
  return bytes;
}

/// What two records differ in, by the names of the fields; empty when in nothing but the moment.
std::string difference(Record flashed, Record native) {
  if (bytes_without_time(flashed) == bytes_without_time(native)) return "";
  std::string text = "record " + std::to_string(native.index) + ":";
  const auto compare = [&](const char* name, auto a, auto b) {
    if (a != b) text += std::string(" ") + name + " " + std::to_string(a) + "/" + std::to_string(b);
  };
  for (std::size_t i = 0; i < 6; ++i)
    compare("position", flashed.position_steps[i], native.position_steps[i]);
  compare("gain", int{flashed.gain}, int{native.gain});
  compare("direction", int{flashed.direction}, int{native.direction});
  compare("samples", flashed.samples, native.samples);
  compare("saturated", flashed.saturated, native.saturated);
  compare("signal_x", flashed.signal_x, native.signal_x);
  compare("signal_y", flashed.signal_y, native.signal_y);
  compare("monitor_x", flashed.monitor_x, native.monitor_x);
  compare("monitor_y", flashed.monitor_y, native.monitor_y);
  compare("signal_x_se", flashed.signal_x_se, native.signal_x_se);
  compare("signal_y_se", flashed.signal_y_se, native.signal_y_se);
  compare("monitor_se", flashed.monitor_se, native.monitor_se);
  return text;
}

ProgramRow row(std::uint32_t index, std::array<double, 6> degrees, std::uint8_t laser, bool open,
               std::uint8_t gain, std::uint16_t dwell_ms) {
  ProgramRow r{.index = index,
               .target_udeg = {},
               .laser = laser,
               .shutter_open = open ? std::uint8_t{1} : std::uint8_t{0},
               .gain = gain,
               .dwell_ms = dwell_ms};
  for (std::size_t i = 0; i < 6; ++i) {
    r.target_udeg[i] = degrees[i] == out_of_beam ? protocol::open_position
                                                 : static_cast<std::int32_t>(degrees[i] * 1e6);
  }
  return r;
}

/// All axes, all lasers, fixed and automatic ranges, both senses of the detector arm, a dark row,
/// a row that moves nothing.
std::vector<ProgramRow> small_scan() {
  constexpr std::uint8_t automatic = protocol::gain_auto;
  std::vector<ProgramRow> rows = {
      row(0, {5, 6, 0, 0, 0, 0}, 1, true, automatic, 10),
      row(1, {5, 7.5, 0, 0, 90, 0}, 2, true, automatic, 20),
      row(2, {5, 4, 1, 45, 90, 0}, 3, true, 3, 15),
      row(3, {5, 4, 1, 45, 90, 0}, 3, false, 3, 10),
      row(4, {5, 4, 1, 45, 90, 0}, 2, true, 0, 50),
      row(5, {2.125, -3, -1, -45, 0, 60}, 1, true, automatic, 10),
      row(6, {0, 0.5, 0, out_of_beam, out_of_beam, 0}, 1, true, automatic, 10),
  };
  return rows;
}

void expect_same(const std::vector<Record>& flashed, const std::vector<Record>& native) {
  ASSERT_EQ(native.size(), small_scan().size());
  ASSERT_EQ(flashed.size(), native.size());
  for (std::size_t i = 0; i < native.size(); ++i) EXPECT_EQ(difference(flashed[i], native[i]), "");
}

/// The plant's noise depends on the moment a stream begins, which is what two boards do not share.
const std::vector<std::string> without_noise = {"amplifier.output_noise_v=0",
                                                "amplifier.input_noise_v=0", "monitor.noise_v=0"};

TEST(GoldenScan, TheFlashedImageGivesTheRecordsOfTheNativeCoreOnThePlant) {
  const emulator::BenchOptions bench{
      .sample = "red-gloss", .plant_file = {}, .settings = without_noise};
  const auto native = test::run_rows(emulator::make_embedded(bench), small_scan());
  const auto instrument = std::make_shared<emulator::McuInstrument>(
      bench, mcu::McuBoardOptions{.image = UMOV_STM32F407_ELF});
  const auto flashed = test::run_rows(emulator::connect_serial(instrument), small_scan());
  expect_same(flashed, native);
  EXPECT_GT(native[0].signal_x, 1'000'000) << "there was light";
  EXPECT_LT(std::abs(native[3].signal_x), native[0].signal_x / 100) << "and a dark row";
  EXPECT_EQ(instrument->board().chip().watchdog_resets(), 0u);
  std::printf("%.1f s of virtual time, %.0f million instructions\n",
              static_cast<double>(instrument->board().now_us()) * 1e-6,
              static_cast<double>(instrument->board().chip().instructions()) * 1e-6);
}

TEST(GoldenScan, NoiseSaturationAndRangesAreTheSameToo) {
  test::NoisyWorld world;
  test::NoisyBench bench;
  boards::native::NativeBoard native_board(world);
  mcu::McuBoard mcu_board(bench, {.image = UMOV_STM32F407_ELF});
  const auto native = test::run_rows(test::connect(native_board), small_scan());
  const auto flashed = test::run_rows(test::connect(mcu_board), small_scan());
  expect_same(flashed, native);
  for (std::size_t axis = 0; axis < 6; ++axis)
    EXPECT_EQ(bench.stages.position[axis], world.stages.position[axis]) << axis;
  EXPECT_GT(native[2].saturated, 0u) << "a range too high for the light";
  EXPECT_GT(native[0].signal_x_se, 0u);
}

}  // namespace
}  // namespace umov
