#include "host/cli/operator.hpp"

#include <poll.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <utility>

#include <fmt/format.h>

#include "host/cli/interrupt.hpp"
#include "host/errors/error.hpp"

namespace umov::cli {
namespace {

/// Waits for a line on stdin; false after Ctrl-C.
bool wait_for_enter() {
  for (;;) {
    if (interrupt_flag().load()) return false;
    pollfd input{STDIN_FILENO, POLLIN, 0};
    constexpr int look_again_ms = 100;
    if (poll(&input, 1, look_again_ms) <= 0) continue;
    char letter = 0;
    const auto count = read(STDIN_FILENO, &letter, 1);
    if (count < 0 && errno == EINTR) continue;
    if (count <= 0)
      throw Error("nobody answered the question about the set-up",
                  "go on with --resume at a terminal, or measure the blocks one by one (--block)");
    if (letter == '\n') return true;
  }
}

}  // namespace

scan::Arranger ask_operator(std::function<void()> before) {
  return [before = std::move(before)](const scan::ArrangementRequest& request) {
    before();
    const bool afterwards = request.blocks.empty();
    fmt::print(stderr, "\n{}\n",
               afterwards ? "All rows are measured. To undo the change:"
                          : fmt::format("Change of the set-up, for {}:", request.blocks));
    for (const auto& sentence : scan::instructions(request)) fmt::print(stderr, "  {}\n", sentence);
    if (afterwards) return true;
    fmt::print(stderr, "Enter when it is done, Ctrl-C to stop here: ");
    std::fflush(stderr);
    return wait_for_enter();
  };
}

bool operator_at_terminal() {
  return isatty(STDIN_FILENO) == 1 && isatty(STDERR_FILENO) == 1;
}

}  // namespace umov::cli
