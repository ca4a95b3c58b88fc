// Work that may end a process without ending the program.
#pragma once

#include <functional>
#include <optional>
#include <string>

namespace umov::cli {

/// Runs `work` in a child process and waits for it. Empty where it came to its end; else why it did
/// not ("Segmentation fault"). What it throws is thrown here as umov::Error. The child ends with
/// this process, however that ends. `work` gives results through files alone.
std::optional<std::string> in_own_process(const std::function<void()>& work);

}  // namespace umov::cli
