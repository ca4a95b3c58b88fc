#include "boards/stm32f407/watchdog.hpp"

#include "boards/stm32f407/registers/watchdog.hpp"

namespace umov::boards::stm32f407 {
namespace {

/// Counts of the watchdog, a millisecond each: 32 kHz / 32, of which 17 to 47 kHz are possible.
constexpr std::uint32_t prescaler_32 = 3, main_loop_counts = 250, longest_counts = 0xFFF;

bool main_loop_watched = false;

void set_limit(std::uint32_t counts) {
  IwdgRegisters& w = iwdg();
  w.KR = iwdg_keys::UNLOCK;
  w.PR = prescaler_32;
  w.RLR = counts;
  while (w.SR != 0) {
  }
  w.KR = iwdg_keys::RELOAD;
}

}  // namespace

void watch_start() {
  iwdg().KR = iwdg_keys::START;
  set_limit(longest_counts);
}

void watch_main_loop() {
  iwdg().KR = iwdg_keys::START;
  set_limit(main_loop_counts);
  main_loop_watched = true;
}

void feed_watchdog() {
  iwdg().KR = iwdg_keys::RELOAD;
}

LongWork::LongWork() {
  if (main_loop_watched) set_limit(longest_counts);
}
LongWork::~LongWork() {
  if (main_loop_watched) set_limit(main_loop_counts);
}

}  // namespace umov::boards::stm32f407
