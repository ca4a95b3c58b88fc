#include "host/instrument/program_stream.hpp"

#include <algorithm>
#include <limits>
#include <utility>

#include "host/errors/error.hpp"
#include "host/instrument/program_control.hpp"
#include "host/instrument/refusals.hpp"

namespace umov::instrument {
namespace {

using protocol::Fault;
using protocol::Refusal;
using protocol::State;
using std::chrono::microseconds;
using std::chrono::milliseconds;

constexpr milliseconds poll_slice{50};
/// Least time between two requests to send the missing records again. It doubles while nothing new
/// comes: on a slow pipe the answer to the first is still on its way, and what is sent again to the
/// second one stands in the way of everything else.
constexpr milliseconds ask_again_after{50};
constexpr milliseconds longest_ask_again{800};
/// A device that has its rows needs no probing; this is for credits that were lost.
constexpr int probe_intervals = 10;
/// How long records measured before a fault may take to arrive.
constexpr milliseconds drain_timeout{1000};
/// Times the device may stop the program of its own accord without a record in between.
constexpr int most_attaches = 30;
/// Records that may wait for a lost predecessor.
constexpr std::size_t most_early_records = 1024;

}  // namespace

ProgramStream::ProgramStream(ProgramOptions options, RowSource rows, RecordSink& sink)
    : options_(options),
      rows_(std::move(rows)),
      sink_(&sink),
      next_index_(options.first_missing),
      secured_below_(options.first_missing) {
  if (options_.program_id == 0 || options_.row_count == 0 || !rows_) {
    throw Error("a scan program needs an id other than 0 and at least one row",
                "give the plan at least one measurement");
  }
  if (options_.first_missing > options_.row_count) {
    throw Error("the scan has " + std::to_string(options_.first_missing) +
                    " records already, its plan only " + std::to_string(options_.row_count) +
                    " rows",
                "resume it with the plan it was begun with");
  }
  options_.records_per_secure = std::max(options_.records_per_secure, 1u);
}

// ---- running --------------------------------------------------------------------------------

bool ProgramStream::run(Session& session,
                        const std::function<bool(const ProgramStream&)>& keep_going) {
  attach(session);
  while (!complete_) {
    if (keep_going && !keep_going(*this)) {
      pause();
      return false;
    }
    advance(milliseconds(100));
  }
  return true;
}

bool ProgramStream::advance(microseconds timeout) {
  if (session_ == nullptr) throw Error("the scan program is not attached", "call attach() first");
  try {
    work_until(session_->clock_us() +
               static_cast<std::uint64_t>(std::max<microseconds::rep>(timeout.count(), 0)));
  } catch (const Error&) {
    needs_attach_ = true;
    secure();
    throw;
  }
  return complete_;
}

void ProgramStream::work_until(std::uint64_t deadline_us) {
  while (!complete_) {
    if (needs_attach_) {
      if (++attaches_since_record_ > most_attaches) {
        throw Error(Place{session_->name()},
                    "the controller dropped the scan program again and again before row " +
                        std::to_string(next_index_),
                    "see umov device log, restart the controller, then resume the scan");
      }
      attach(*session_);
    }
    if (complete_) return;
    const std::uint64_t now = session_->clock_us();
    const std::uint64_t left = deadline_us > now ? deadline_us - now : 0;
    session_->poll(microseconds(static_cast<microseconds::rep>(std::min(left, to_us(poll_slice)))));
    while (const auto event = session_->next_event()) {
      std::visit([this](const auto& message) { on(message); }, *event);
    }
    if (next_index_ == options_.row_count) {
      finish();
      return;
    }
    secure_when_due();
    send_rows();
    ask_for_what_is_missing();
    if (session_->clock_us() >= deadline_us) return;
  }
}

void ProgramStream::on(const protocol::Record& record) {
  if (record.program_id != options_.program_id) {
    ++counters_.stale_records;
    return;
  }
  if (record.index < next_index_ || record.index >= options_.row_count) {
    ++counters_.duplicate_records;
    return;
  }
  if (record.index > next_index_) {
    if (early_.size() < most_early_records) early_.insert_or_assign(record.index, record);
    return;
  }
  take(record);
  while (!early_.empty() && early_.begin()->first <= next_index_) {
    const protocol::Record next = early_.begin()->second;
    early_.erase(early_.begin());
    if (next.index == next_index_) take(next);
  }
}

void ProgramStream::take(const protocol::Record& record) {
  if (next_index_ == secured_below_) unsecured_since_us_ = session_->clock_us();
  sink_->take(record);
  ++next_index_;
  ++counters_.records_taken;
  attaches_since_record_ = 0;
  device_next_record_ = std::max(device_next_record_, next_index_);
  record_progress_us_ = session_->clock_us();
  ask_wait_ = ask_again_after;
}

void ProgramStream::on(const protocol::RowCredit& credit) {
  if (credit.program_id != options_.program_id) return;
  if (credit.next_row < wanted_row_ || credit.next_row > highest_sent_) return;
  if (credit.next_row > wanted_row_) row_progress_us_ = session_->clock_us();
  wanted_row_ = credit.next_row;
  const std::uint64_t end = std::uint64_t{credit.next_row} + credit.free_slots;
  credit_end_ = static_cast<std::uint32_t>(std::min<std::uint64_t>(end, options_.row_count));
  unsent_row_ = std::max(unsent_row_, wanted_row_);
}

void ProgramStream::on(const Heartbeat& heartbeat) {
  // Answers to questions from before we attached, or before the last answer, tell of another time.
  if (static_cast<std::int16_t>(heartbeat.sequence - status_sequence_) <= 0) return;
  status_sequence_ = heartbeat.sequence;
  const protocol::Status& status = heartbeat.status;
  if (static_cast<Fault>(status.fault) == Fault::link_lost) {
    needs_attach_ = true;
    return;
  }
  if (status.fault != 0) stop_for_fault(status);
  if (!holds_ours(status) || status.first_unacknowledged > next_index_) {
    needs_attach_ = true;
    return;
  }
  device_next_record_ = std::max(device_next_record_, status.next_record);
  const auto state = static_cast<State>(status.state);
  const bool ended_early = state == State::idle && status.next_record < options_.row_count &&
                           next_index_ >= status.next_record;
  if (ended_early || state == State::paused) {
    needs_attach_ = true;
    return;
  }
  if (status.next_row > wanted_row_ && status.next_row <= highest_sent_) {
    wanted_row_ = status.next_row;
    credit_end_ = std::max(credit_end_, wanted_row_);
    unsent_row_ = std::max(unsent_row_, wanted_row_);
    row_progress_us_ = session_->clock_us();
  }
  device_lacks_rows_ = state == State::waiting_for_rows;
  if (device_lacks_rows_ && status.next_row < wanted_row_) {
    needs_attach_ = true;  // it began anew behind our back
    return;
  }
  device_lacks_room_ = state == State::waiting_for_host;
}

void ProgramStream::on(const protocol::FaultEvent&) {
  // It may be old news that were delayed: the status tells what is latched now.
  const protocol::Status status = session_->request(protocol::GetStatus{});
  if (static_cast<Fault>(status.fault) == Fault::link_lost) {
    needs_attach_ = true;
  } else if (status.fault != 0) {
    stop_for_fault(status);
  }
}

void ProgramStream::on(const StreamRefusal& refusal) {
  if (refusal.reply.request != protocol::ProgramRow::info.id) return;  // heartbeats tell the rest
  const auto row = row_of_sequence_.find(refusal.sequence);
  if (row == row_of_sequence_.end()) return;  // sent before we attached
  switch (static_cast<Refusal>(refusal.reply.code)) {
    case Refusal::wrong_state:
    case Refusal::fault_active:
    case Refusal::stale_program:
    case Refusal::busy:
      // Not the row's fault: something happened to the program. Look what.
      needs_attach_ = true;
      return;
    default:
      throw Refused(session_->name(), "row " + std::to_string(row->second) + " of the plan",
                    refusal.reply);
  }
}

void ProgramStream::stop_for_fault(const protocol::Status& status) {
  // Records measured before the fault are still on their way.
  device_next_record_ = std::max(device_next_record_, status.next_record);
  const std::uint64_t deadline = session_->clock_us() + to_us(drain_timeout);
  while (next_index_ < device_next_record_ && session_->clock_us() < deadline) {
    ask_for_what_is_missing();
    session_->poll(poll_slice);
    while (const auto event = session_->next_event()) {
      if (const auto* record = std::get_if<protocol::Record>(&*event)) on(*record);
    }
  }
  if (next_index_ > secured_below_) {
    secure();
    acknowledge();
  }
  throw Faulted(session_->name(), status.fault, "at row " + std::to_string(status.next_record));
}

// ---- sending --------------------------------------------------------------------------------

void ProgramStream::send_rows() {
  if (wanted_row_ >= options_.row_count) return;
  const std::uint64_t now = session_->clock_us();
  const std::uint64_t silence = now - row_progress_us_;
  const std::uint64_t resend_us = to_us(options_.resend_after);
  const bool unanswered = unsent_row_ > wanted_row_;
  const std::uint64_t patience =
      unanswered || device_lacks_rows_ ? resend_us : resend_us * probe_intervals;
  if (silence >= patience) {
    counters_.rows_sent_again += unsent_row_ - wanted_row_;
    unsent_row_ = wanted_row_;
    send_row(unsent_row_++);
    row_progress_us_ = now;
  }
  while (unsent_row_ < credit_end_) send_row(unsent_row_++);
}

void ProgramStream::send_row(std::uint32_t index) {
  protocol::ProgramRow row = rows_(index);
  row.index = index;
  row_of_sequence_[session_->send(row)] = index;
  highest_sent_ = std::max(highest_sent_, index + 1);
  ++counters_.rows_sent;
}

void ProgramStream::secure() {
  if (next_index_ == secured_below_) return;
  sink_->secure();
  secured_below_ = next_index_;
}

void ProgramStream::acknowledge() {
  session_->send(protocol::RecordAck{options_.program_id, secured_below_});
}

void ProgramStream::secure_when_due() {
  const std::uint32_t waiting = next_index_ - secured_below_;
  if (waiting == 0) return;
  const bool too_long = session_->clock_us() - unsecured_since_us_ >= to_us(options_.secure_after);
  if (waiting < options_.records_per_secure && !too_long && !device_lacks_room_) return;
  // A device that fills up before a batch is complete has a small memory: do not make it wait
  // again.
  if (device_lacks_room_) options_.records_per_secure = std::max(waiting / 2, 1u);
  secure();
  acknowledge();
  device_lacks_room_ = false;
}

void ProgramStream::ask_for_what_is_missing() {
  const std::uint64_t now = session_->clock_us();
  const bool gap = !early_.empty();
  const bool overdue = device_next_record_ > next_index_ &&
                       now - record_progress_us_ >= to_us(options_.resend_after);
  // Full although we have acknowledged all we know of: that acknowledgement was lost.
  const bool blocked = device_lacks_room_;
  if (!gap && !overdue && !blocked) return;
  if (now - last_asked_us_ < to_us(ask_wait_)) return;
  ask_wait_ = std::min(2 * ask_wait_, longest_ask_again);
  ask_for_records();
  device_lacks_room_ = false;
}

void ProgramStream::ask_for_records() {
  const bool advances = next_index_ != secured_below_;
  secure();
  // The first acknowledgement frees what arrived; one that frees nothing asks for the rest.
  if (advances) acknowledge();
  acknowledge();
  last_asked_us_ = session_->clock_us();
}

void ProgramStream::pause() {
  if (session_ == nullptr) return;
  secure();
  acknowledge();
  control_program(*session_, ProgramAction::pause);
  needs_attach_ = true;
}

void ProgramStream::finish() {
  secure();
  // All records are safe here whatever the device remembers; free its memory with good manners.
  for (int attempt = 0; attempt < status_attempts; ++attempt) {
    acknowledge();
    const protocol::Status status = session_->request(protocol::GetStatus{});
    if (!holds_ours(status) || status.first_unacknowledged >= options_.row_count) break;
    if (is_running(status) && status.next_record < options_.row_count) {
      control_program(*session_, ProgramAction::abort);
      break;
    }
    pause_for(milliseconds(20));
  }
  early_.clear();
  complete_ = true;
}

}  // namespace umov::instrument
