#include "boards/stm32f407/clock.hpp"

#include "boards/stm32f407/registers/flash.hpp"
#include "boards/stm32f407/registers/rcc.hpp"
#include "boards/stm32f407/registers/watchdog.hpp"

namespace umov::boards::stm32f407 {
namespace {

// Crystal / M = 1 MHz into the PLL, x N = 336 MHz, / P = the core's clock, / Q = 48 MHz for USB.
constexpr std::uint32_t pll_m = crystal_hz / 1'000'000;
constexpr std::uint32_t pll_p = 2;
constexpr std::uint32_t pll_n = core_hz / 1'000'000 * pll_p;
constexpr std::uint32_t pll_q = pll_n / 48;
static_assert(pll_m * 1'000'000 == crystal_hz && pll_n / pll_p * 1'000'000 == core_hz);
static_assert(pll_m >= 2 && pll_m <= 63 && pll_n >= 50 && pll_n <= 432 && pll_q * 48 == pll_n);
static_assert(core_hz <= 168'000'000 && core_hz > 150'000'000,
              "five wait states are right for 150 to 168 MHz at 2.7 to 3.6 V");

}  // namespace

void start_clocks() {
  using namespace rcc_bits;
  RccRegisters& r = rcc();
  set_bits(r.APB1ENR, PWREN);
  set_bits(pwr().CR, pwr_bits::VOS_SCALE_1);
  set_bits(r.CR, HSEON);
  while ((r.CR & HSERDY) == 0) {
  }
  r.PLLCFGR = pll_m | pll_n << 6 | (pll_p / 2 - 1) << 16 | PLLSRC_HSE | pll_q << 24;
  set_bits(r.CR, PLLON);
  while ((r.CR & PLLRDY) == 0) {
  }
  flash_interface().ACR =
      flash_bits::LATENCY_5 | flash_bits::PRFTEN | flash_bits::ICEN | flash_bits::DCEN;
  r.CFGR = PPRE1_DIV4 | PPRE2_DIV2 | SW_PLL;
  while ((r.CFGR & SWS_MASK) != SWS_PLL) {
  }
  set_bits(r.AHB1ENR, GPIO_ALL | DMA1EN | DMA2EN);
  set_bits(r.AHB2ENR, OTGFSEN);
  set_bits(r.APB1ENR, TIM2EN | TIM5EN | USART2EN);
  set_bits(r.APB2ENR, TIM1EN | TIM8EN | ADC1EN | ADC2EN | SYSCFGEN);
}

void stop_clocks() {
  using namespace rcc_bits;
  RccRegisters& r = rcc();
  r.CFGR = 0;
  while ((r.CFGR & SWS_MASK) != 0) {
  }
  clear_bits(r.CR, PLLON);
  while ((r.CR & PLLRDY) != 0) {
  }
  flash_interface().ACR = 0;
  r.AHB1ENR = CCMDATARAMEN;
  r.AHB2ENR = 0;
  r.APB1ENR = 0;
  r.APB2ENR = 0;
}

}  // namespace umov::boards::stm32f407
