#include "host/cli/own_process.hpp"

#include <fcntl.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <csignal>
#include <cstring>
#include <exception>

#include "host/errors/error.hpp"

namespace umov::cli {
namespace {

constexpr int threw = 3;

[[noreturn]] void be_the_child(const std::function<void()>& work, int out) {
  prctl(PR_SET_PDEATHSIG, SIGKILL);
  std::string failure;
  int end = 0;
  try {
    work();
  } catch (const std::exception& error) {
    failure = error.what();
    end = threw;
  }
  for (std::size_t done = 0; done < failure.size();) {
    const ssize_t wrote = write(out, failure.data() + done, failure.size() - done);
    if (wrote < 0 && errno != EINTR) break;
    if (wrote > 0) done += static_cast<std::size_t>(wrote);
  }
  // No destructors: what they hold belongs to the parent.
  _exit(end);
}

std::string read_to_the_end(int in) {
  std::string text;
  char buffer[512];
  for (;;) {
    const ssize_t got = read(in, buffer, sizeof buffer);
    if (got < 0 && errno == EINTR) continue;
    if (got <= 0) return text;
    text.append(buffer, static_cast<std::size_t>(got));
  }
}

}  // namespace

std::optional<std::string> in_own_process(const std::function<void()>& work) {
  int ends[2];
  if (pipe2(ends, O_CLOEXEC) != 0)
    throw Error(std::string("no pipe could be made: ") + std::strerror(errno), "use fewer threads");
  const pid_t child = fork();
  if (child < 0) {
    close(ends[0]);
    close(ends[1]);
    throw Error(std::string("no process could be started: ") + std::strerror(errno),
                "use fewer threads");
  }
  if (child == 0) {
    close(ends[0]);
    be_the_child(work, ends[1]);
  }
  close(ends[1]);
  const std::string failure = read_to_the_end(ends[0]);
  close(ends[0]);
  int status = 0;
  while (waitpid(child, &status, 0) < 0 && errno == EINTR) {
  }
  if (WIFSIGNALED(status)) return strsignal(WTERMSIG(status));
  if (WEXITSTATUS(status) != 0) throw Error(failure, "the cases answered so far are kept");
  return std::nullopt;
}

}  // namespace umov::cli
