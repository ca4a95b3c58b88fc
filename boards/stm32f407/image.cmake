# umov-stm32f407.elf and .bin, with sizes and stack checked.
file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
set(script ${CMAKE_CURRENT_SOURCE_DIR}/image.ld)
set(check ${CMAKE_CURRENT_SOURCE_DIR}/tools/check_image.py)

add_executable(umov-stm32f407 ${sources})
set_target_properties(umov-stm32f407 PROPERTIES SUFFIX .elf LINK_DEPENDS ${script})
target_link_libraries(umov-stm32f407 PRIVATE umov_options umov_firmware umov_board_stm32f407_description)
target_link_options(umov-stm32f407 PRIVATE -nostartfiles --specs=nano.specs -T${script} -Wl,--gc-sections
                    -Wl,--fatal-warnings -Wl,-Map=${CMAKE_BINARY_DIR}/umov-stm32f407.map)
add_custom_command(
  TARGET umov-stm32f407 POST_BUILD
  COMMAND ${CMAKE_OBJCOPY} -O binary --remove-section .first_vectors $<TARGET_FILE:umov-stm32f407>
          ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/umov-stm32f407.bin
  COMMAND ${Python3_EXECUTABLE} ${check} --nm ${CMAKE_NM} --elf $<TARGET_FILE:umov-stm32f407>
          --binary ${CMAKE_RUNTIME_OUTPUT_DIRECTORY}/umov-stm32f407.bin --objects ${CMAKE_BINARY_DIR}
  DEPENDS ${check}
  COMMENT "umov-stm32f407: sizes and stack" VERBATIM)
