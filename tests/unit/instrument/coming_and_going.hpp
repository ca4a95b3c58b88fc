// A program on a controller whose host comes and goes.
#pragma once

#include <gtest/gtest.h>

#include <chrono>
#include <cstdint>
#include <functional>
#include <memory>

#include "host/instrument/program_stream.hpp"
#include "host/instrument/session.hpp"

namespace umov::instrument::testing {

/// Runs `rows` rows; after each `rows_a_visit` or a few more the host leaves without a word and
/// comes back by `connect`. Every record must come once and in turn. Returns how often the host
/// connected.
inline int run_with_a_host_that_comes_and_goes(
    const std::function<std::unique_ptr<Transport>()>& connect, std::uint32_t rows,
    std::uint32_t rows_a_visit) {
  class Sink final : public RecordSink {
   public:
    void take(const protocol::Record& record) override { EXPECT_EQ(record.index, next++); }
    void secure() override {}
    std::uint32_t next = 0;
  } sink;
  ProgramOptions options;
  options.program_id = 5;
  options.row_count = rows;
  options.records_per_secure = 4;
  ProgramStream stream(
      options,
      [](std::uint32_t) {
        protocol::ProgramRow row;
        row.dwell_ms = 1;
        return row;
      },
      sink);
  int visits = 0;
  for (std::uint32_t goal = rows_a_visit; !stream.complete(); goal += rows_a_visit) {
    Session session(connect());
    ++visits;
    stream.attach(session);
    while (!stream.complete() && stream.next_index() < goal) {
      stream.advance(std::chrono::milliseconds(1));
    }
  }
  EXPECT_EQ(sink.next, rows);
  return visits;
}

}  // namespace umov::instrument::testing
