// A scan program run through a transport by the host's own client, for comparing instruments.
#pragma once

#include <algorithm>
#include <chrono>
#include <memory>
#include <vector>

#include "host/instrument/program_stream.hpp"
#include "host/instrument/session.hpp"
#include "protocol/messages.hpp"

namespace umov::test {

/// The pipe to a board of this process, native or emulated: virtual time passes in read().
template <class Board>
class BoardTransport final : public instrument::Transport {
 public:
  explicit BoardTransport(Board& board) : board_(&board) {}
  void write(std::span<const std::uint8_t> bytes) override { board_->deliver(bytes); }
  std::size_t read(std::span<std::uint8_t> buffer, std::chrono::microseconds timeout) override {
    if (bytes_.empty()) {
      board_->run_until_output(
          static_cast<std::uint64_t>(std::max<std::int64_t>(timeout.count(), 1)));
      board_->take_output(bytes_);
    }
    const std::size_t n = std::min(buffer.size(), bytes_.size());
    std::copy_n(bytes_.begin(), n, buffer.begin());
    bytes_.erase(bytes_.begin(), bytes_.begin() + static_cast<std::ptrdiff_t>(n));
    return n;
  }
  std::uint64_t clock_us() override { return board_->now_us(); }
  std::string name() const override { return "board"; }

 private:
  Board* board_;
  std::vector<std::uint8_t> bytes_;
};

template <class Board>
std::unique_ptr<instrument::Transport> connect(Board& board) {
  return std::make_unique<BoardTransport<Board>>(board);
}

/// Keeps the records.
class Records final : public instrument::RecordSink {
 public:
  void take(const protocol::Record& record) override { all.push_back(record); }
  void secure() override {}
  std::vector<protocol::Record> all;
};

/// Homes all axes; throws what the session throws.
inline void home_all(instrument::Session& session) {
  session.request(protocol::Home{.axis_mask = 63});
  for (int i = 0; i < 2000; ++i) {
    session.poll(std::chrono::milliseconds(50));
    while (session.next_event()) {
    }
    const auto status = session.request(protocol::GetStatus{});
    if (status.homed_mask == 63 && status.state == 0) return;
  }
}

/// Homes, then measures the rows.
inline std::vector<protocol::Record> run_rows(std::unique_ptr<instrument::Transport> transport,
                                              const std::vector<protocol::ProgramRow>& rows) {
  instrument::Session session(std::move(transport));
  home_all(session);
  Records records;
  instrument::ProgramStream stream(
      {.program_id = 0x51, .row_count = static_cast<std::uint32_t>(rows.size())},
      [&](std::uint32_t index) { return rows[index]; }, records);
  stream.run(session);
  return records.all;
}

}  // namespace umov::test
