// What an action that should fail says.
#pragma once

#include <functional>
#include <string>

#include "host/errors/error.hpp"

namespace umov {

/// Text of the umov::Error that `action` throws, "no error" where it throws none.
inline std::string failure_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

}  // namespace umov
