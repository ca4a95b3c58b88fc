// Ctrl-C: long commands ask whether to stop, leave valid files and say how to go on.
#pragma once

#include <atomic>
#include <stdexcept>

namespace umov::cli {

/// Thrown by a command that was interrupted after it made its files valid; exit code 130.
class Interrupted : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// Set by SIGINT and SIGTERM once `catch_interrupts` was called. A second signal ends the program.
std::atomic<bool>& interrupt_flag();
void catch_interrupts();

}  // namespace umov::cli
