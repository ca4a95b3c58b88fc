# umov-stm32f407.elf, .bin and .dfu, signed, and its boot loader, with sizes and stack checked.
set(UMOV_SIGNING_KEY ${CMAKE_SOURCE_DIR}/firmware/boot/development.key
    CACHE FILEPATH "key that signs the image and that the boot loader trusts")
set(sign ${CMAKE_SOURCE_DIR}/firmware/boot/tools/sign_image.py)
set(check ${CMAKE_CURRENT_SOURCE_DIR}/tools/check_image.py)
set(out ${CMAKE_RUNTIME_OUTPUT_DIRECTORY})
set(objects ${CMAKE_BINARY_DIR}/firmware)

file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
set(script ${CMAKE_CURRENT_SOURCE_DIR}/image.ld)
add_executable(umov-stm32f407 ${sources})
set_target_properties(umov-stm32f407 PROPERTIES SUFFIX .elf LINK_DEPENDS "${script};${sign};${UMOV_SIGNING_KEY}")
target_link_libraries(umov-stm32f407 PRIVATE umov_options umov_boot umov_firmware umov_board_stm32f407_description)
target_link_options(umov-stm32f407 PRIVATE -nostartfiles --specs=nano.specs -T${script} -Wl,--gc-sections
                    -Wl,--fatal-warnings -Wl,-Map=${CMAKE_BINARY_DIR}/umov-stm32f407.map)
# The header goes into the ELF file, too: a programmer may write that one under the boot loader.
add_custom_command(
  TARGET umov-stm32f407 POST_BUILD
  COMMAND ${CMAKE_OBJCOPY} -O binary --remove-section .first_vectors $<TARGET_FILE:umov-stm32f407>
          ${CMAKE_BINARY_DIR}/umov-stm32f407.unsigned
  COMMAND ${Python3_EXECUTABLE} ${sign} sign --key ${UMOV_SIGNING_KEY} --board "umov stm32f407"
          --version ${PROJECT_VERSION} --source-hash ${generated}/firmware/source_hash.hpp
          --binary ${out}/umov-stm32f407.bin --dfu ${out}/umov-stm32f407.dfu
          --header ${CMAKE_BINARY_DIR}/umov-stm32f407.header ${CMAKE_BINARY_DIR}/umov-stm32f407.unsigned
  COMMAND ${CMAKE_OBJCOPY} --update-section .image_header=${CMAKE_BINARY_DIR}/umov-stm32f407.header
          $<TARGET_FILE:umov-stm32f407>
  COMMAND ${Python3_EXECUTABLE} ${check} --nm ${CMAKE_NM} --elf $<TARGET_FILE:umov-stm32f407>
          --binary ${out}/umov-stm32f407.bin
          --objects ${objects} ${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/umov-stm32f407.dir
  DEPENDS ${check} ${sign}
  COMMENT "umov-stm32f407: signature, sizes and stack" VERBATIM)

set(trusted ${generated}/firmware/boot/signing_key.hpp)
file(MAKE_DIRECTORY ${generated}/firmware/boot)
add_custom_command(
  OUTPUT ${trusted}
  COMMAND ${Python3_EXECUTABLE} ${sign} trust --key ${UMOV_SIGNING_KEY} --header ${trusted}
  DEPENDS ${sign} ${UMOV_SIGNING_KEY}
  COMMENT "Key that the boot loader trusts" VERBATIM)
file(GLOB boot_sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/boot/*.cpp)
set(boot_script ${CMAKE_CURRENT_SOURCE_DIR}/boot/boot.ld)
add_executable(umov-stm32f407-boot ${boot_sources} ${trusted} clock.cpp flash_memory.cpp usb_port.cpp
               watchdog.cpp)
set_target_properties(umov-stm32f407-boot PROPERTIES SUFFIX .elf LINK_DEPENDS ${boot_script})
target_link_libraries(umov-stm32f407-boot PRIVATE umov_options umov_boot umov_board_stm32f407_description)
target_link_options(umov-stm32f407-boot PRIVATE -nostartfiles --specs=nano.specs -T${boot_script} -Wl,--gc-sections
                    -Wl,--fatal-warnings -Wl,-Map=${CMAKE_BINARY_DIR}/umov-stm32f407-boot.map)
add_custom_command(
  TARGET umov-stm32f407-boot POST_BUILD
  COMMAND ${CMAKE_OBJCOPY} -O binary $<TARGET_FILE:umov-stm32f407-boot> ${out}/umov-stm32f407-boot.bin
  COMMAND ${Python3_EXECUTABLE} ${check} --boot --nm ${CMAKE_NM} --elf $<TARGET_FILE:umov-stm32f407-boot>
          --binary ${out}/umov-stm32f407-boot.bin
          --objects ${objects} ${CMAKE_CURRENT_BINARY_DIR}/CMakeFiles/umov-stm32f407-boot.dir
  DEPENDS ${check}
  COMMENT "umov-stm32f407-boot: sizes and stack" VERBATIM)
