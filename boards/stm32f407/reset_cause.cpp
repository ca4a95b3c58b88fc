#include "boards/stm32f407/reset_cause.hpp"

#include "boards/stm32f407/registers/rcc.hpp"
#include "boards/stm32f407/registers/watchdog.hpp"

namespace umov::boards::stm32f407 {

firmware::ResetCause take_reset_cause() {
  using namespace rcc_bits;
  const std::uint32_t flags = rcc().CSR;
  set_bits(rcc().CSR, RMVF);
  if ((flags & PORRSTF) != 0) return firmware::ResetCause::power_on;
  if ((flags & IWDGRSTF) != 0) return firmware::ResetCause::watchdog;
  if ((flags & BORRSTF) != 0) return firmware::ResetCause::brown_out;
  return firmware::ResetCause::power_on;
}

void start_watchdog() {
  IwdgRegisters& w = iwdg();
  w.KR = iwdg_keys::START;
  w.KR = iwdg_keys::UNLOCK;
  w.PR = 3;  // 32 kHz / 32: a count is a millisecond
  w.RLR = 250;
  while (w.SR != 0) {
  }
  w.KR = iwdg_keys::RELOAD;
}

void feed_watchdog() {
  iwdg().KR = iwdg_keys::RELOAD;
}

}  // namespace umov::boards::stm32f407
