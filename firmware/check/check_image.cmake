# Fails when the core refers to heap, exceptions or type information, uses floating point where it
# must not, or is larger than its budget. Prints what it takes.
set(flash_budget 65536)  # bytes of code and constants, USB included: leaves 32 KB of 96 to drivers
set(ram_budget 40960)    # bytes of static RAM: leaves 24 KB of 64 to buffers and stacks
set(stack_budget 1024)   # bytes of a single function's frame

execute_process(COMMAND ${NM} --demangle ${OBJECTS} OUTPUT_VARIABLE symbols COMMAND_ERROR_IS_FATAL ANY)
foreach(word malloc calloc realloc "operator new" "operator delete" __cxa_throw __cxa_allocate_exception
             __cxa_begin_catch __cxa_guard_acquire _Unwind_ "typeinfo for" __aeabi_f __aeabi_d2
             __aeabi_dadd __aeabi_dmul __aeabi_ddiv __aeabi_i2d __aeabi_l2d)
  string(FIND "${symbols}" " ${word}" found)
  if(NOT found EQUAL -1)
    message(FATAL_ERROR "the firmware core refers to ${word}: no heap, exceptions, RTTI or floating "
                        "point in it")
  endif()
endforeach()

execute_process(COMMAND ${OBJDUMP} -d --no-show-raw-insn ${IMAGE} OUTPUT_VARIABLE listing
                COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCH "\tv(add|sub|mul|div|cvt|sqrt|mla|mls|fma|cmp)[a-z]*\\.[^\n]*" float_instruction
             "${listing}")
if(float_instruction)
  message(FATAL_ERROR "the firmware core computes in floating point: ${float_instruction}")
endif()

execute_process(COMMAND ${SIZE} ${IMAGE} OUTPUT_VARIABLE sizes COMMAND_ERROR_IS_FATAL ANY)
string(REGEX MATCH "\n *([0-9]+)[ \t]+([0-9]+)[ \t]+([0-9]+)" line "${sizes}")
math(EXPR flash "${CMAKE_MATCH_1} + ${CMAKE_MATCH_2}")
math(EXPR ram "${CMAKE_MATCH_2} + ${CMAKE_MATCH_3}")

set(deepest 0)
set(deepest_name "")
foreach(object ${OBJECTS})
  string(REGEX REPLACE "\\.o$" ".su" usage ${object})
  file(STRINGS ${usage} lines)
  foreach(entry ${lines})
    if(entry MATCHES "^[^\t]*:([^\t]*)\t([0-9]+)\t(.*)$")
      set(function "${CMAKE_MATCH_1}")
      set(frame ${CMAKE_MATCH_2})
      set(kind "${CMAKE_MATCH_3}")
      if(kind STREQUAL "dynamic")
        message(FATAL_ERROR "unbounded stack frame: ${entry}")
      endif()
      if(frame GREATER deepest)
        set(deepest ${frame})
        set(deepest_name "${function}")
      endif()
    endif()
  endforeach()
endforeach()

message("firmware core on ARM: flash ${flash} of ${flash_budget} B, static RAM ${ram} of ${ram_budget} B, "
        "largest stack frame ${deepest} of ${stack_budget} B (${deepest_name})")
if(flash GREATER flash_budget OR ram GREATER ram_budget OR deepest GREATER stack_budget)
  message(FATAL_ERROR "the firmware core is over its budget")
endif()
