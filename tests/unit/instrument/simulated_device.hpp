// A controller's end of the protocol in virtual time, small enough to be checked by eye: eight
// rows, eight records, one measurement after the other. It follows PROTOCOL.md and nothing else.
#pragma once

#include <array>
#include <cstdint>
#include <cstring>
#include <deque>
#include <functional>
#include <optional>
#include <string_view>
#include <vector>

#include "protocol/frame.hpp"
#include "protocol/messages.hpp"
#include "protocol/schema.hpp"

namespace umov::instrument::testing {

using namespace umov::protocol;
using Bytes = std::vector<std::uint8_t>;

inline Name make_name(std::string_view text) {
  Name name{};
  std::memcpy(name.data(), text.data(), std::min(text.size(), name.size()));
  return name;
}

class SimulatedDevice {
 public:
  static constexpr std::size_t row_slots = 8;
  static constexpr std::size_t record_slots = 8;

  // What a test may set.
  std::uint16_t version = protocol_version;
  std::uint64_t hash = schema_hash;
  std::uint64_t measure_us = 500;
  std::uint64_t clock_offset_us = 1'000'000;
  double clock_rate = 1.0;
  bool mute = false;                              ///< answers nothing
  std::optional<Name> owner;                      ///< somebody else holds it: answers busy
  std::int32_t greatest_target_udeg = INT32_MAX;  ///< soft limit of every axis
  int clears_refused = 0;  ///< clear_fault is answered busy this often: axes still move
  bool forgetful = false;  ///< accepts programs and forgets them at once
  /// Sees every acknowledgement that frees records.
  std::function<void(std::uint32_t next_index)> on_ack;

  // What a test may look at.
  std::array<int, 256> requests{};            ///< messages received, by type
  std::deque<std::uint64_t> status_times_us;  ///< host clock at every get_status
  Status status{};
  bool session_open = false;

  void receive(std::span<const std::uint8_t> bytes) {
    bool rows_arrived = false;
    reader_.feed(bytes, [&](const FrameView& frame) { handle(frame, rows_arrived); });
    if (rows_arrived) send_credit();
  }

  /// Lets virtual time pass.
  void step(std::uint64_t us) {
    now_us_ += us;
    measure_when_due();
    if (state() == State::waiting_for_rows && now_us_ - last_credit_us_ >= 100'000) send_credit();
  }

  std::uint64_t now_us() const { return now_us_; }

  /// Bytes for the host, frame by frame.
  std::deque<Bytes> sent;

  void latch(Fault fault, bool announce = true) {
    status.fault = static_cast<std::uint8_t>(fault);
    if (program_active_) program_active_ = false;
    set_state(State::safe);
    if (announce && session_open) send(next_own(), FaultEvent{device_us(), status.fault, -1});
  }

  /// Power cut: forgets everything.
  void restart() {
    rows_.clear();
    ring_.clear();
    status = {};
    program_active_ = false;
    session_open = false;
    ++boot_id_;
    reader_.reset();
  }

  /// Ends the program as a front-panel button would.
  void end_program() {
    program_active_ = false;
    set_state(State::idle);
  }

 private:
  State state() const { return static_cast<State>(status.state); }
  void set_state(State state) { status.state = static_cast<std::uint8_t>(state); }
  std::uint16_t next_own() { return own_sequence_++; }
  std::uint64_t device_us() const {
    return clock_offset_us + static_cast<std::uint64_t>(clock_rate * static_cast<double>(now_us_));
  }

  template <class M>
  void send(std::uint16_t sequence, const M& message) {
    if (mute) return;
    Bytes frame(max_wire_frame_size);
    frame.resize(FrameWriter::write(sequence, message, frame));
    sent.push_back(std::move(frame));
  }

  void refuse(const FrameView& frame, Refusal why, int detail = -1) {
    send(frame.sequence, ErrorReply{frame.type, static_cast<std::uint8_t>(why), detail});
  }

  void done(const FrameView& frame) { send(frame.sequence, Done{frame.type}); }

  /// Decodes and hands on, or refuses.
  template <class M, class Handler>
  void with(const FrameView& frame, Handler&& handler) {
    M message{};
    const CodecResult result = decode(frame.payload, message);
    if (result.ok()) {
      handler(message);
    } else {
      refuse(frame,
             result.status == CodecStatus::bad_length ? Refusal::bad_length : Refusal::out_of_range,
             result.field);
    }
  }

  void handle(const FrameView& frame, bool& rows_arrived) {
    ++requests[frame.type];
    if (frame.type == Hello::info.id) {
      if (owner) {
        send(frame.sequence, Busy{*owner});
        return;
      }
      with<Hello>(frame, [&](const Hello& hello) {
        session_open = hello.version == version && hello.schema_hash == hash;
        HelloReply reply;
        reply.version = version;
        reply.schema_hash = hash;
        reply.device_name = make_name("simulated");
        reply.boot_id = boot_id_;
        send(frame.sequence, reply);
      });
      return;
    }
    if (!session_open) return refuse(frame, Refusal::schema_mismatch);
    switch (frame.type) {
      case TimeSync::info.id:
        with<TimeSync>(frame, [&](const TimeSync& sync) {
          send(frame.sequence, TimeSyncReply{sync.host_time_us, device_us(), device_us()});
        });
        break;
      case GetStatus::info.id:
        status_times_us.push_back(now_us_);
        status.time_us = device_us();
        send(frame.sequence, status);
        break;
      case ProgramBegin::info.id:
        with<ProgramBegin>(frame, [&](const ProgramBegin& begin) { begin_program(frame, begin); });
        break;
      case ProgramRow::info.id:
        with<ProgramRow>(frame, [&](const ProgramRow& row) { take_row(frame, row, rows_arrived); });
        break;
      case ProgramControl::info.id:
        with<ProgramControl>(frame, [&](const ProgramControl& c) { control(frame, c.action); });
        break;
      case RecordAck::info.id:
        with<RecordAck>(frame, [&](const RecordAck& ack) { acknowledge(ack); });
        break;
      case ClearFault::info.id:
        with<ClearFault>(frame, [&](const ClearFault& clear) {
          if (clears_refused > 0) {
            --clears_refused;
            return refuse(frame, Refusal::busy);
          }
          if (clear.fault != status.fault) return refuse(frame, Refusal::wrong_state);
          status.fault = 0;
          set_state(State::idle);
          done(frame);
        });
        break;
      case Move::info.id:
        with<Move>(frame, [&](const Move& move) { refuse(frame, Refusal::not_homed, move.axis); });
        break;
      case Stop::info.id:
        done(frame);
        break;
      default:
        refuse(frame, Refusal::unknown_message);
    }
  }

  void begin_program(const FrameView& frame, const ProgramBegin& begin) {
    if (program_active_) return refuse(frame, Refusal::wrong_state);
    if (status.fault != 0) return refuse(frame, Refusal::fault_active);
    if (forgetful) return done(frame);
    rows_.clear();
    ring_.clear();
    status.program_id = begin.program_id;
    status.row_count = begin.row_count;
    status.next_row = begin.first_row;
    status.first_unacknowledged = begin.first_row;
    status.next_record = begin.first_row;
    program_active_ = true;
    set_state(State::waiting_for_rows);
    done(frame);
    send_credit();
  }

  void take_row(const FrameView& frame, const ProgramRow& row, bool& rows_arrived) {
    if (!program_active_) return refuse(frame, Refusal::wrong_state);
    rows_arrived = true;
    if (row.index != status.next_row || rows_.size() >= row_slots) return;
    for (const std::int32_t target : row.target_udeg) {
      if (target > greatest_target_udeg) return refuse(frame, Refusal::outside_limits, 1);
    }
    if (rows_.empty()) measuring_since_us_ = now_us_;
    rows_.push_back(row);
    ++status.next_row;
    if (state() == State::waiting_for_rows) set_state(State::scanning);
  }

  void send_credit() {
    last_credit_us_ = now_us_;
    const auto left = status.row_count - status.next_row;
    const auto free = std::min<std::size_t>(row_slots - rows_.size(), left);
    send(next_own(),
         RowCredit{status.program_id, status.next_row, static_cast<std::uint16_t>(free)});
  }

  void control(const FrameView& frame, std::uint8_t action) {
    if (!program_active_) return refuse(frame, Refusal::wrong_state);
    if (action == 0) set_state(State::paused);
    if (action == 1 && state() == State::paused) set_state(State::scanning);
    if (action == 2) end_program();
    measuring_since_us_ = now_us_;
    done(frame);
  }

  void acknowledge(const RecordAck& ack) {
    if (ack.program_id != status.program_id) return;
    if (ack.next_index < status.first_unacknowledged || ack.next_index > status.next_record) return;
    if (ack.next_index == status.first_unacknowledged) {
      for (const Record& record : ring_) send(next_own(), record);
      return;
    }
    while (!ring_.empty() && ring_.front().index < ack.next_index) ring_.pop_front();
    status.first_unacknowledged = ack.next_index;
    if (on_ack) on_ack(ack.next_index);
    if (state() == State::waiting_for_host) {
      set_state(State::scanning);
      measuring_since_us_ = now_us_;
    }
    finish_when_complete();
  }

  void finish_when_complete() {
    if (program_active_ && status.first_unacknowledged == status.row_count) end_program();
  }

  void measure_when_due() {
    while (program_active_ && status.fault == 0) {
      if (state() != State::scanning) return;
      if (status.next_record == status.row_count) return;
      if (rows_.empty()) return set_state(State::waiting_for_rows);
      if (ring_.size() >= record_slots) return set_state(State::waiting_for_host);
      if (now_us_ - measuring_since_us_ < measure_us) return;
      measuring_since_us_ += measure_us;
      const ProgramRow row = rows_.front();
      rows_.pop_front();
      Record record;
      record.program_id = status.program_id;
      record.index = row.index;
      record.time_us = device_us();
      record.position_steps = row.target_udeg;
      record.laser = row.laser;
      record.signal_x = std::int64_t{row.index} * 1'000'003;
      ring_.push_back(record);
      status.next_record = row.index + 1;
      send(next_own(), record);
      if (rows_.size() % (row_slots / 4) == 0) send_credit();
    }
  }

  FrameReader reader_;
  std::deque<ProgramRow> rows_;
  std::deque<Record> ring_;
  std::uint64_t now_us_ = 0;
  std::uint64_t measuring_since_us_ = 0;
  std::uint64_t last_credit_us_ = 0;
  std::uint32_t boot_id_ = 1;
  std::uint16_t own_sequence_ = 0;
  bool program_active_ = false;
};

}  // namespace umov::instrument::testing
