# The image, built beside the host's programs where the cross compiler is. Without a compiler cache:
# that would keep the objects, not the call graph beside them, which the check of the stack reads.
find_program(ARM_CXX arm-none-eabi-g++)
if(NOT ARM_CXX)
  message(STATUS "no arm-none-eabi-g++: the STM32F407 image and its tests are left out")
  return()
endif()

include(ExternalProject)
set(tree ${CMAKE_BINARY_DIR}/firmware)
ExternalProject_Add(umov_stm32f407_image
  SOURCE_DIR ${CMAKE_SOURCE_DIR}
  BINARY_DIR ${tree}
  CMAKE_ARGS -DCMAKE_TOOLCHAIN_FILE=${CMAKE_SOURCE_DIR}/cmake/arm-none-eabi.cmake
             -DCMAKE_BUILD_TYPE=Release
  CMAKE_GENERATOR ${CMAKE_GENERATOR}
  BUILD_ALWAYS ON
  BUILD_COMMAND ${CMAKE_COMMAND} --build ${tree}
  BUILD_BYPRODUCTS ${tree}/bin/umov-stm32f407.elf ${tree}/bin/umov-stm32f407-boot.elf
  INSTALL_COMMAND ""
  USES_TERMINAL_BUILD ON)
set(UMOV_STM32F407_ELF ${tree}/bin/umov-stm32f407.elf CACHE INTERNAL "the image that is flashed")
set(UMOV_STM32F407_BOOT_ELF ${tree}/bin/umov-stm32f407-boot.elf CACHE INTERNAL "its boot loader")
