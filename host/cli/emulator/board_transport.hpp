// A serial line to an emulated board in this process: time passes in it while the host waits.
#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "host/instrument/transport.hpp"

namespace umov::emulator {

/// `Instrument::board()` has deliver(), run_until_output(), take_output() and now_us().
template <class Instrument>
class BoardTransport final : public instrument::Transport {
 public:
  BoardTransport(std::shared_ptr<Instrument> instrument, std::string name)
      : instrument_(std::move(instrument)), name_(std::move(name)) {}

  void write(std::span<const std::uint8_t> bytes) override { instrument_->board().deliver(bytes); }

  std::size_t read(std::span<std::uint8_t> buffer, std::chrono::microseconds timeout) override {
    auto& board = instrument_->board();
    if (used_ == output_.size()) {
      output_.clear();
      used_ = 0;
      board.run_until_output(
          static_cast<std::uint64_t>(std::max<std::int64_t>(timeout.count(), 1)));
      board.take_output(output_);
    }
    const std::size_t n = std::min(buffer.size(), output_.size() - used_);
    std::copy_n(output_.begin() + static_cast<std::ptrdiff_t>(used_), n, buffer.begin());
    used_ += n;
    return n;
  }

  std::uint64_t clock_us() override { return instrument_->board().now_us(); }
  std::string name() const override { return name_; }

 private:
  std::shared_ptr<Instrument> instrument_;
  std::string name_;
  std::vector<std::uint8_t> output_;
  std::size_t used_ = 0;
};

}  // namespace umov::emulator
