// Base addresses (RM0090 rev 19, table 1). tests/unit/stm32f407 compares them with what QEMU's
// netduinoplus2 machine shows.
#pragma once

#include <cstdint>

namespace umov::boards::stm32f407::memory_map {

inline constexpr std::uintptr_t flash = 0x0800'0000;
inline constexpr std::uintptr_t sram = 0x2000'0000;

inline constexpr std::uintptr_t tim2 = 0x4000'0000;
inline constexpr std::uintptr_t tim5 = 0x4000'0C00;
inline constexpr std::uintptr_t iwdg = 0x4000'3000;
inline constexpr std::uintptr_t usart2 = 0x4000'4400;
inline constexpr std::uintptr_t pwr = 0x4000'7000;
inline constexpr std::uintptr_t tim1 = 0x4001'0000;
inline constexpr std::uintptr_t tim8 = 0x4001'0400;
inline constexpr std::uintptr_t adc1 = 0x4001'2000;
inline constexpr std::uintptr_t adc2 = 0x4001'2100;
inline constexpr std::uintptr_t adc_common = 0x4001'2300;
inline constexpr std::uintptr_t syscfg = 0x4001'3800;
inline constexpr std::uintptr_t exti = 0x4001'3C00;
inline constexpr std::uintptr_t gpioa = 0x4002'0000;
inline constexpr std::uintptr_t gpio_spacing = 0x400;
inline constexpr std::uintptr_t rcc = 0x4002'3800;
inline constexpr std::uintptr_t flash_interface = 0x4002'3C00;
inline constexpr std::uintptr_t dma1 = 0x4002'6000;
inline constexpr std::uintptr_t dma2 = 0x4002'6400;
inline constexpr std::uintptr_t otg_fs = 0x5000'0000;

/// 96-bit unique device identifier (RM0090 39.1).
inline constexpr std::uintptr_t unique_id = 0x1FFF'7A10;

/// System control space of the Cortex-M4 (PM0214 4).
inline constexpr std::uintptr_t systick = 0xE000'E010;
inline constexpr std::uintptr_t nvic = 0xE000'E100;
inline constexpr std::uintptr_t scb = 0xE000'ED00;

}  // namespace umov::boards::stm32f407::memory_map
