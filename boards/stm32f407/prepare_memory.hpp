// Memory as a program finds it when it begins: by the symbols of the linker script (image.ld,
// boot/boot.ld).
#pragma once

#include <cstdint>

extern "C" {
extern std::uint32_t image_data_load[], image_data_begin[], image_data_end[];
extern std::uint32_t image_bss_begin[], image_bss_end[];
extern std::uint32_t image_stack_top[];
using Constructor = void (*)();
extern Constructor __init_array_start[], __init_array_end[];
}

namespace umov::boards::stm32f407 {

/// Copies .data, clears .bss, constructs what is static. Between reset and main, on the stack that
/// the vector table names; uses nothing static before it is there.
[[gnu::always_inline]] inline void prepare_memory() {
  const std::uint32_t* from = image_data_load;
  for (std::uint32_t* to = image_data_begin; to < image_data_end;) *to++ = *from++;
  for (std::uint32_t* to = image_bss_begin; to < image_bss_end;) *to++ = 0;
  for (Constructor* c = __init_array_start; c < __init_array_end; ++c) (*c)();
}

}  // namespace umov::boards::stm32f407
