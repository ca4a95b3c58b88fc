# Build rules shared by all folders: warnings, sanitizers, one library a folder, one test program a folder.

add_library(umov_options INTERFACE)
target_include_directories(umov_options INTERFACE ${CMAKE_SOURCE_DIR})
target_compile_options(umov_options INTERFACE -Wall -Wextra -Wconversion -Wshadow -Werror)
# GCC 12 sees overlapping copies in `"text" + std::to_string(i)` where there are none (its bug 105651).
target_compile_options(umov_options INTERFACE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-restrict>)
# GLM's swizzle unions do not compile for dual numbers.
target_compile_definitions(umov_options INTERFACE GLM_FORCE_XYZW_ONLY)
if(UMOV_SANITIZE)
  target_compile_options(umov_options INTERFACE -fsanitize=address,undefined -fno-omit-frame-pointer
                                                -fno-sanitize-recover=undefined)
  # With sanitizers GCC 12 sees uninitialised members in <regex> where there are none (its bug 105562).
  target_compile_options(umov_options INTERFACE $<$<COMPILE_LANG_AND_ID:CXX,GNU>:-Wno-maybe-uninitialized>)
  # Coverage of the code under test, without which libFuzzer changes its inputs blindly. Programs that
  # are no fuzz targets do nothing with it: so tests and fuzz targets share their libraries.
  target_compile_options(umov_options INTERFACE $<$<COMPILE_LANG_AND_ID:CXX,Clang>:-fsanitize=fuzzer-no-link>)
  target_link_options(umov_options INTERFACE -fsanitize=address,undefined)
endif()

# For tests and the command line, which spend their time in libraries: a third less time to build.
set(umov_quick_to_build $<$<CONFIG:Release>:-O1>)

# umov_library(NAME [DEPENDS libs…]): a static library of all *.cpp in the current folder.
function(umov_library name)
  cmake_parse_arguments(arg "" "" "DEPENDS;EXCLUDE" ${ARGN})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/*.cpp)
  foreach(file ${arg_EXCLUDE})
    list(REMOVE_ITEM sources ${CMAKE_CURRENT_SOURCE_DIR}/${file})
  endforeach()
  if(sources)
    add_library(${name} STATIC ${sources})
    target_link_libraries(${name} PUBLIC umov_options ${arg_DEPENDS})
  else()
    add_library(${name} INTERFACE)
    target_link_libraries(${name} INTERFACE umov_options ${arg_DEPENDS})
  endif()
endfunction()

# umov_test(FOLDER [DEPENDS libs…] [TIMEOUT s]): test program test_FOLDER of all *.cpp in tests/unit/FOLDER.
function(umov_test folder)
  cmake_parse_arguments(arg "" "TIMEOUT" "DEPENDS" ${ARGN})
  if(NOT arg_TIMEOUT)
    set(arg_TIMEOUT 120)
  endif()
  string(REPLACE "/" "_" name ${folder})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_CURRENT_SOURCE_DIR}/${folder}/*.cpp)
  if(NOT sources)
    return()
  endif()
  add_executable(test_${name} ${sources})
  target_link_libraries(test_${name} PRIVATE umov_options ${arg_DEPENDS} GTest::gtest GTest::gmock
                                             GTest::gtest_main)
  target_compile_options(test_${name} PRIVATE ${umov_quick_to_build})
  target_compile_definitions(test_${name} PRIVATE UMOV_SOURCE_DIR="${CMAKE_SOURCE_DIR}"
                                                  UMOV_TEST_DATA="${CMAKE_SOURCE_DIR}/tests/data")
  gtest_discover_tests(test_${name} TEST_PREFIX "${name}." DISCOVERY_MODE PRE_TEST
                       PROPERTIES TIMEOUT ${arg_TIMEOUT})
endfunction()
