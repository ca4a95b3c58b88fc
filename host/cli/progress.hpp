// Progress on the terminal: a line with bar, rate and time left, at most ten times a second.
#pragma once

#include <chrono>
#include <string>

namespace umov::cli {

/// Writes to stderr; on a terminal it redraws one line, elsewhere it prints a line every ten
/// seconds. Silent for the first second (short work needs no bar) and when `quiet`.
class Progress {
 public:
  Progress(std::string what, bool quiet);
  ~Progress();
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  /// `done` of `total` units; `note` is appended (such as the present angle).
  void update(double done, double total, const std::string& note = {});
  /// Ends the line.
  void finish();

 private:
  std::string what_;
  bool quiet_;
  bool terminal_;
  bool drawn_ = false;
  std::chrono::steady_clock::time_point start_;
  std::chrono::steady_clock::time_point last_;
};

}  // namespace umov::cli
