# cmake -D OUTPUT=… -D ROOT=… -P source_hash.cmake: writes the hash of protocol/ and firmware/core/.
file(GLOB_RECURSE sources RELATIVE ${ROOT} ${ROOT}/firmware/core/*.cpp ${ROOT}/firmware/core/*.hpp
     ${ROOT}/protocol/*.hpp)
list(SORT sources)
set(all "")
foreach(source ${sources})
  file(SHA256 ${ROOT}/${source} digest)
  string(APPEND all "${source} ${digest}\n")
endforeach()
string(SHA256 digest "${all}")
string(SUBSTRING ${digest} 0 16 short)
set(text "// Written by firmware/source_hash.cmake.
#pragma once

#include <cstdint>

namespace umov::firmware {

/// First 64 bits of SHA-256 over names and digests of the sources of protocol/ and firmware/core/.
inline constexpr std::uint64_t source_hash = 0x${short};

}  // namespace umov::firmware
")
set(old "")
if(EXISTS ${OUTPUT})
  file(READ ${OUTPUT} old)
endif()
if(old STREQUAL text)
  file(TOUCH ${OUTPUT})
else()
  file(WRITE ${OUTPUT} "${text}")
endif()
