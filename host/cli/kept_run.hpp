// A run of several simulations whose state is kept beside its output, to go on from after Ctrl-C.
#pragma once

#include <chrono>
#include <filesystem>
#include <string>
#include <vector>

#include "host/surface/run_state.hpp"
#include "host/trace/simulation.hpp"

namespace umov::cli {

class KeptRun {
 public:
  /// `words` say what is simulated; `resume` takes up the state that a run of the same words left
  /// in `file`. Only who `writes` (one of the ranks, with an output) keeps one. Throws umov::Error.
  KeptRun(std::filesystem::path file, std::string words, bool resume, bool writes);

  /// The state in which simulation `number` was left; empty: it has not begun.
  std::vector<double> begun(std::size_t number) const;
  /// `number` is on its way: kept once a minute.
  void under_way(std::size_t number, const trace::Result& result);
  /// `number` has ended, or was stopped.
  void ended(std::size_t number, const trace::Result& result);
  /// All has ended: with `interrupted` the file is written, else removed.
  void finish(bool interrupted);

 private:
  void put(std::size_t number, const trace::Result& result);

  std::filesystem::path file_;
  std::string words_;
  bool writes_;
  surface::RunState state_;
  std::chrono::steady_clock::time_point kept_;
};

}  // namespace umov::cli
