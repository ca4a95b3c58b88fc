// Converters, DMA and serial port as they work together.
#include <gtest/gtest.h>

#include <map>
#include <vector>

#include "hil/mcu/adc.hpp"
#include "hil/mcu/dma.hpp"
#include "hil/mcu/usart.hpp"
#include "host/errors/error.hpp"

namespace umov::mcu {
namespace {

constexpr std::uint32_t ifcr_low = 0x08, s0 = 0x10;
constexpr std::uint32_t s_cr = 0, s_ndtr = 4, s_par = 8, s_m0ar = 12;
constexpr std::uint32_t on = 1, ht_tc_interrupts = 0x18, circular = 1u << 8, increment = 1u << 10,
                        words = 2u << 11 | 2u << 13;
constexpr std::uint32_t ccr = 0x304, cr1 = 0x04, cr2 = 0x08, smpr1 = 0x0C, sqr3 = 0x34;
constexpr std::uint32_t pairs = 6 | 1u << 13 | 1u << 16, with_dma = 2u << 14;
constexpr Time interval = 10 * time_per_us;

class SamplingTest : public testing::Test {
 protected:
  SamplingTest() {
    adc.write(ccr, pairs | with_dma);
    adc.write(smpr1, 2u << 3);          // channel 11: 28 cycles
    adc.write(0x100 + smpr1, 2u << 6);  // channel 12
    adc.write(sqr3, 11);
    adc.write(0x100 + sqr3, 12);
    adc.write(cr1, 1u << 26);
    adc.write(cr2, 14u << 24 | 1u << 28 | 1);
    adc.write(0x100 + cr2, 1);
    dma.on_enable([this](int stream) {
      if (stream == 0) adc.on_stream_enabled();
    });
  }
  void start_stream(std::uint32_t count) {
    dma.write(s0 + s_par, 0x4001'2308);
    dma.write(s0 + s_m0ar, 0x2000'0000);
    dma.write(s0 + s_ndtr, count);
    dma.write(s0 + s_cr, circular | increment | words | ht_tc_interrupts);
    dma.write(s0 + s_cr, circular | increment | words | ht_tc_interrupts | on);
  }
  void sample(int count) {
    for (int i = 0; i < count; ++i) {
      ++number;
      adc.on_trigger(14);
      scheduler.run_until(scheduler.now() + interval);
    }
  }

  Scheduler scheduler;
  std::map<std::uint32_t, std::uint32_t> memory;
  std::uint16_t number = 0;
  std::vector<Time> instants;
  bool dma_interrupt = false, adc_interrupt = false;
  Dma dma{
      "DMA2",
      {.read = [this](std::uint32_t address, unsigned) { return adc.read(address - 0x4001'2000); },
       .write = [this](std::uint32_t address, unsigned,
                       std::uint32_t value) { memory[(address - 0x2000'0000) / 4] = value; }},
      [this](int, bool level) { dma_interrupt = level; }};
  Adc adc{scheduler, [] { return Time{4}; },
          [this](unsigned channel) {
            instants.push_back(scheduler.now());
            return static_cast<std::uint16_t>(channel == 11 ? number : 1000 + number);
          },
          [this] { return dma.request(0, 0); }, [this](bool level) { adc_interrupt = level; }};
};

TEST_F(SamplingTest, BothInputsAreSampledAtTheSameInstantOfTheTrigger) {
  start_stream(8);
  sample(1);
  ASSERT_EQ(instants.size(), 2u);
  EXPECT_EQ(instants[0], instants[1]);
  EXPECT_EQ(instants[0], 28u * 16u) << "28 cycles of 84 MHz / 4";
}

TEST_F(SamplingTest, PairsAreStoredInOrderAndBothHalvesAreAnnounced) {
  start_stream(8);
  sample(4);
  EXPECT_EQ(dma.read(0), 16u) << "half transfer";
  EXPECT_TRUE(dma_interrupt);
  dma.write(ifcr_low, 16);
  EXPECT_FALSE(dma_interrupt);
  sample(4);
  EXPECT_EQ(dma.read(0), 32u) << "transfer complete";
  for (std::uint32_t i = 0; i < 8; ++i) EXPECT_EQ(memory[i], (1001 + i) << 16 | (1 + i));
  sample(1);
  EXPECT_EQ(memory[0], 1009u << 16 | 9u) << "round again";
  EXPECT_FALSE(adc_interrupt);
}

TEST_F(SamplingTest, APairThatIsNotFetchedIsAnOverrunAndConversionsStop) {
  sample(2);
  EXPECT_TRUE(adc_interrupt);
  EXPECT_NE(adc.read(0) & 32u, 0u);
  const std::size_t seen = instants.size();
  sample(2);
  EXPECT_EQ(instants.size(), seen);
  adc.write(0, ~32u);
  EXPECT_FALSE(adc_interrupt);
}

TEST_F(SamplingTest, APairLeftOverIsFetchedFirstUnlessTheModeWasLeft) {
  sample(1);
  start_stream(8);
  EXPECT_EQ(memory[0], 1001u << 16 | 1u) << "the request waited";

  dma.write(s0 + s_cr, 0);
  dma.write(ifcr_low, 0x3D);
  memory.clear();
  sample(1);
  adc.write(ccr, pairs);
  adc.write(ccr, pairs | with_dma);
  start_stream(8);
  EXPECT_TRUE(memory.empty());
  sample(1);
  EXPECT_EQ(memory[0], 1003u << 16 | 3u);
}

TEST_F(SamplingTest, ARunningStreamIsNotChangedAndOldFlagsAreNotForgotten) {
  start_stream(2);
  EXPECT_THROW(dma.write(s0 + s_ndtr, 5), Error);
  sample(1);
  dma.write(s0 + s_cr, 0);
  EXPECT_THROW(start_stream(2), Error) << "flags of before are still set";
}

TEST(Usart, ByteAfterByteAtTheSpeedOfTheLine) {
  Scheduler scheduler;
  std::vector<std::pair<Time, std::uint8_t>> sent;
  Usart usart(scheduler, [] { return Time{8}; },
              {.interrupt = [](bool) {},
               .receive_request = [] { return false; },
               .send_request = [] { return false; },
               .on_byte = [&](std::uint8_t b) { sent.emplace_back(scheduler.now(), b); }});
  usart.write(0x08, 42);  // 1 Mbaud of 42 MHz
  usart.write(0x0C, 1u << 13 | 1u << 3 | 1u << 2);
  usart.write(0x04, 'a');
  usart.write(0x04, 'b');
  EXPECT_THROW(usart.write(0x04, 'c'), Error) << "the register is full";
  scheduler.run_until(100 * time_per_us);
  ASSERT_EQ(sent.size(), 2u);
  EXPECT_EQ(sent[0], std::pair(10 * time_per_us, std::uint8_t{'a'}));
  EXPECT_EQ(sent[1], std::pair(20 * time_per_us, std::uint8_t{'b'}));

  const std::vector<std::uint8_t> three = {1, 2, 3};
  usart.deliver(three);
  scheduler.run_until(scheduler.now() + 10 * time_per_us);
  EXPECT_EQ(usart.read(0x04), 1u);
  scheduler.run_until(scheduler.now() + 20 * time_per_us);
  EXPECT_NE(usart.read(0x00) & 8u, 0u) << "overrun: the second was not fetched";
  EXPECT_EQ(usart.read(0x04), 2u);
}

}  // namespace
}  // namespace umov::mcu
