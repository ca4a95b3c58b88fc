// The host's half of a running scan program: feeds rows, takes records, survives the link.
#pragma once

#include <chrono>
#include <cstdint>
#include <functional>
#include <map>
#include <string>

#include "host/instrument/session.hpp"
#include "protocol/messages.hpp"

namespace umov::instrument {

/// Where records go. Called in the order of indices, each index once.
class RecordSink {
 public:
  virtual ~RecordSink() = default;
  /// Takes the next record. An exception ends the program stream; the record is taken as not safe.
  virtual void take(const protocol::Record& record) = 0;
  /// Returns when everything taken so far would survive a power cut (fsync). Only then is it
  /// acknowledged to the device, which may forget it.
  virtual void secure() = 0;
};

/// Gives the program row of an index; called again for the same index when rows are sent again.
using RowSource = std::function<protocol::ProgramRow(std::uint32_t index)>;

struct ProgramOptions {
  std::uint32_t program_id = 0;           ///< hash of the plan, not 0
  std::uint32_t row_count = 0;            ///< rows of the whole program, at least 1
  std::uint32_t first_missing = 0;        ///< first record not yet safe; > 0 when a scan is resumed
  std::uint32_t records_per_secure = 16;  ///< records taken before secure() is called (fewer when
                                          ///< the device's memory turns out smaller) …
  std::chrono::milliseconds secure_after{10000};  ///< … unless the first of them waits this long
  std::chrono::milliseconds resend_after{500};    ///< silence after which rows or acks are repeated
};

/// What went over the link beyond the necessary.
struct StreamCounters {
  std::uint64_t records_taken = 0;
  std::uint64_t duplicate_records = 0;
  std::uint64_t stale_records = 0;  ///< of another program
  std::uint64_t rows_sent = 0;
  std::uint64_t rows_sent_again = 0;
  std::uint64_t programs_begun = 0;
  std::uint64_t programs_joined = 0;    ///< found running at attach()
  std::uint64_t link_lost_cleared = 0;  ///< times that fault was found latched and cleared
};

/// Lives as long as the scan, over any number of sessions:
///
///     ProgramStream stream(options, rows, sink);
///     for (;;) {
///       try { Session session(connect()); stream.run(session); break; }
///       catch (const LinkLost&) { /* wait, then connect again */ }
///     }
class ProgramStream {
 public:
  /// Throws umov::Error when options are not usable (no id, no rows, first_missing beyond the end).
  ProgramStream(ProgramOptions options, RowSource rows, RecordSink& sink);

  /// Goes on with the program if the device still has it, else begins it at the first missing
  /// record. Clears a latched link_lost; throws Faulted for any other fault, LinkLost, Refused.
  void attach(Session& session);

  /// Works for at most `timeout` of transport clock after attach(). True when every record is safe
  /// and acknowledged. Throws Faulted (fault, row, remedy), Refused (a row was not acceptable),
  /// LinkLost; what was taken before is secured first.
  bool advance(std::chrono::microseconds timeout);

  /// attach() and advance() to the end. `keep_going(stream)` is asked between steps; false pauses
  /// the device and returns false. True when complete.
  bool run(Session& session, const std::function<bool(const ProgramStream&)>& keep_going = {});

  /// Secures and acknowledges what has arrived and pauses the device (Ctrl-C).
  void pause();

  /// Index of the next record wanted: all below it have been taken.
  std::uint32_t next_index() const { return next_index_; }
  std::uint32_t row_count() const { return options_.row_count; }
  bool complete() const { return complete_; }
  const StreamCounters& counters() const { return counters_; }

 private:
  bool holds_ours(const protocol::Status& status) const;
  bool can_go_on(const protocol::Status& status) const;
  protocol::Status status_without_fault();
  void come_to_rest(protocol::Status status);
  void begin_at_first_missing();
  void follow(const protocol::Status& status);
  void pause_for(std::chrono::milliseconds duration);

  void work_until(std::uint64_t deadline_us);
  void on(const protocol::Record& record);
  void on(const protocol::RowCredit& credit);
  void on(const protocol::FaultEvent& fault);
  void on(const Heartbeat& heartbeat);
  void on(const StreamRefusal& refusal);
  void take(const protocol::Record& record);
  [[noreturn]] void stop_for_fault(const protocol::Status& status);

  void send_rows();
  void send_row(std::uint32_t index);
  void secure();
  void acknowledge();
  void secure_when_due();
  void ask_for_what_is_missing();
  void ask_for_records();
  void finish();

  ProgramOptions options_;
  RowSource rows_;
  RecordSink* sink_;
  Session* session_ = nullptr;
  StreamCounters counters_;
  std::uint16_t status_sequence_ = 0;  ///< heartbeats up to this one are of the past
  bool needs_attach_ = true;
  int attaches_since_record_ = 0;
  bool complete_ = false;

  // Records
  std::uint32_t next_index_;                         ///< next record for the sink
  std::uint32_t secured_below_;                      ///< records below are safe
  std::map<std::uint32_t, protocol::Record> early_;  ///< arrived before their predecessors
  std::uint32_t device_next_record_ = 0;             ///< the device has measured those below
  std::uint64_t unsecured_since_us_ = 0;
  std::uint64_t record_progress_us_ = 0;
  std::uint64_t last_asked_us_ = 0;
  std::chrono::milliseconds ask_wait_{50};  ///< before the next request for missing records
  bool device_lacks_room_ = false;

  // Rows
  std::uint32_t wanted_row_ = 0;    ///< next_row of the device
  std::uint32_t credit_end_ = 0;    ///< first row there is no room for
  std::uint32_t unsent_row_ = 0;    ///< first row not sent since the last repetition
  std::uint32_t highest_sent_ = 0;  ///< one past the highest row ever sent
  std::map<std::uint16_t, std::uint32_t> row_of_sequence_;
  std::uint64_t row_progress_us_ = 0;
  bool device_lacks_rows_ = false;
};

}  // namespace umov::instrument
