#include "host/cli/kept_run.hpp"

#include <algorithm>
#include <utility>

namespace umov::cli {
namespace {

constexpr std::chrono::seconds between_states{60};

}  // namespace

KeptRun::KeptRun(std::filesystem::path file, std::string words, bool resume, bool writes)
    : file_(std::move(file)),
      words_(std::move(words)),
      writes_(writes),
      kept_(std::chrono::steady_clock::now()) {
  if (resume) state_ = surface::load_state(file_, words_);
}

std::vector<double> KeptRun::begun(std::size_t number) const {
  return number < state_.size() ? state_[number] : std::vector<double>{};
}

void KeptRun::put(std::size_t number, const trace::Result& result) {
  state_.resize(std::max(state_.size(), number + 1));
  state_[number] = result.state();
}

void KeptRun::under_way(std::size_t number, const trace::Result& result) {
  if (!writes_ || std::chrono::steady_clock::now() - kept_ < between_states) return;
  put(number, result);
  surface::save_state(file_, words_, state_);
  kept_ = std::chrono::steady_clock::now();
}

void KeptRun::ended(std::size_t number, const trace::Result& result) {
  if (writes_) put(number, result);
}

void KeptRun::finish(bool interrupted) {
  if (!writes_) return;
  if (interrupted) {
    surface::save_state(file_, words_, state_);
  } else {
    std::error_code none;
    std::filesystem::remove(file_, none);
  }
}

}  // namespace umov::cli
