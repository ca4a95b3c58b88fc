// The register map's base addresses against an independent source: the memory tree that QEMU shows
// for its netduinoplus2 machine (an STM32F405).
#include <gtest/gtest.h>

#include <cstdint>
#include <fstream>
#include <map>
#include <sstream>
#include <string>

#include "boards/stm32f407/registers/memory_map.hpp"

namespace umov {
namespace {

namespace mm = boards::stm32f407::memory_map;

/// Name of every region by its first address; the name of timers and ports is that of their kind.
std::map<std::uint64_t, std::string> qemu_regions() {
  std::ifstream file(UMOV_TEST_DATA "/stm32f4/qemu_netduinoplus2_mtree.txt");
  std::map<std::uint64_t, std::string> regions;
  for (std::string line; std::getline(file, line);) {
    const auto dash = line.find('-');
    const auto colon = line.rfind("): ");
    if (line.empty() || line[0] == '#' || dash == std::string::npos || colon == std::string::npos)
      continue;
    std::istringstream first(line.substr(0, dash));
    std::uint64_t address = 0;
    first >> std::hex >> address;
    regions[address] = line.substr(colon + 3);
  }
  return regions;
}

TEST(MemoryMap, AgreesWithAnIndependentOne) {
  const auto regions = qemu_regions();
  ASSERT_GT(regions.size(), 50u);
  const std::map<std::uint64_t, std::string> ours = {
      {mm::flash, "STM32F405.flash"},
      {mm::sram, "STM32F405.sram"},
      {mm::tim2, "stm32f2xx_timer"},
      {mm::tim5, "stm32f2xx_timer"},
      {mm::iwdg, "IWDG"},
      {mm::usart2, "stm32f2xx-usart"},
      {mm::pwr, "PWR"},
      {mm::tim1, "timer[1]"},
      {mm::tim8, "timer[8]"},
      {mm::adc1, "stm32f2xx-adc"},
      {mm::adc2, "stm32f2xx-adc"},
      {mm::adc_common, "stm32f2xx-adc"},
      {mm::syscfg, "stm32f4xx-syscfg"},
      {mm::exti, "stm32f4xx-exti"},
      {mm::gpioa, "GPIOA"},
      {mm::gpioa + mm::gpio_spacing, "GPIOB"},
      {mm::gpioa + 2 * mm::gpio_spacing, "GPIOC"},
      {mm::gpioa + 3 * mm::gpio_spacing, "GPIOD"},
      {mm::gpioa + 4 * mm::gpio_spacing, "GPIOE"},
      {mm::rcc, "RCC"},
      {mm::flash_interface, "Flash Int"},
      {mm::dma1, "DMA1"},
      {mm::dma2, "DMA2"},
      {mm::otg_fs, "USB OTG FS"},
      {mm::systick, "v7m_systick"},
  };
  for (const auto& [address, name] : ours) {
    ASSERT_TRUE(regions.contains(address)) << std::hex << address << " " << name;
    EXPECT_EQ(regions.at(address), name) << std::hex << address;
  }
}

}  // namespace
}  // namespace umov
