// How a program stream takes up or begins its program in a device found in any condition.
#include "host/errors/error.hpp"
#include "host/instrument/link_lost.hpp"
#include "host/instrument/program_control.hpp"
#include "host/instrument/program_stream.hpp"
#include "host/instrument/refusals.hpp"

namespace umov::instrument {
namespace {

using protocol::Fault;
using protocol::Refusal;
using protocol::State;
using std::chrono::microseconds;
using std::chrono::milliseconds;

/// How long a device may take to come to rest after an abort or a fault.
constexpr milliseconds rest_timeout{20000};

}  // namespace

bool ProgramStream::holds_ours(const protocol::Status& status) const {
  return status.program_id == options_.program_id && status.row_count == options_.row_count;
}

protocol::Status ProgramStream::status_without_fault() {
  const std::uint64_t deadline = session_->clock_us() + to_us(rest_timeout);
  bool clearing = false;
  for (;;) {
    const protocol::Status status = session_->request(protocol::GetStatus{});
    const auto fault = static_cast<Fault>(status.fault);
    if (fault == Fault::none) {
      if (clearing) ++counters_.link_lost_cleared;
      return status;
    }
    // That fault says only that we were away; we are back.
    if (fault != Fault::link_lost || session_->clock_us() >= deadline) {
      throw Faulted(session_->name(), status.fault, "");
    }
    clearing = true;
    try {
      session_->request(protocol::ClearFault{status.fault});
      continue;
    } catch (const Unanswered&) {
    } catch (const Refused& refused) {
      // Axes still coming to rest, or a repeated frame of a clear that worked.
      if (refused.refusal() != Refusal::busy && refused.refusal() != Refusal::wrong_state) throw;
    }
    pause_for(milliseconds(50));
  }
}

void ProgramStream::attach(Session& session) {
  session_ = &session;
  needs_attach_ = false;
  complete_ = false;
  row_of_sequence_.clear();
  if (next_index_ == options_.row_count) {
    finish();
    return;
  }
  const protocol::Status status = status_without_fault();
  if (!holds_ours(status)) {
    come_to_rest(status);
    begin_at_first_missing();
    ++counters_.programs_begun;
  } else if (can_go_on(status)) {
    follow(status);
    ++counters_.programs_joined;
    if (static_cast<State>(status.state) == State::paused)
      control_program(session, ProgramAction::resume);
    ask_for_records();
  } else {
    come_to_rest(status);
    begin_at_first_missing();
    ++counters_.programs_begun;
  }
}

bool ProgramStream::can_go_on(const protocol::Status& status) const {
  const bool reaches_back = status.first_unacknowledged <= next_index_;
  if (is_running(status)) return reaches_back && next_index_ <= status.next_record;
  // Ended early: fetch what it still holds, then begin again.
  return reaches_back && next_index_ < status.next_record;
}

void ProgramStream::come_to_rest(protocol::Status status) {
  const std::uint64_t deadline = session_->clock_us() + to_us(rest_timeout);
  while (!is_idle(status) && session_->clock_us() < deadline) {
    if (is_running(status)) control_program(*session_, ProgramAction::abort);
    pause_for(milliseconds(50));
    status = status_without_fault();
  }
  if (!is_idle(status)) {
    throw Error(Place{session_->name()},
                "the controller is " + state_name(status.state) + " and does not come to rest",
                "wait until it is idle (umov device info) or stop it");
  }
}

void ProgramStream::begin_at_first_missing() {
  const protocol::ProgramBegin begin{options_.program_id, next_index_, options_.row_count};
  for (int attempt = 1;; ++attempt) {
    try {
      session_->request(begin);
    } catch (const Unanswered&) {
      if (attempt == status_attempts) throw;
    } catch (const Refused& refused) {
      // A repeated frame of a begin that worked is refused, too; the status tells.
      if (refused.refusal() != Refusal::wrong_state || attempt == status_attempts) throw;
    }
    const protocol::Status status = status_without_fault();
    if (holds_ours(status) && is_running(status) && can_go_on(status)) {
      follow(status);
      return;
    }
    if (attempt >= status_attempts) {
      throw Error(Place{session_->name()},
                  "the controller accepts the scan program but does not run it (it is " +
                      state_name(status.state) + ")",
                  "restart the controller, then resume the scan");
    }
    pause_for(milliseconds(50));
  }
}

void ProgramStream::follow(const protocol::Status& status) {
  const std::uint64_t now = session_->clock_us();
  status_sequence_ = session_->last_sequence();
  wanted_row_ = status.next_row;
  credit_end_ = status.next_row;
  unsent_row_ = status.next_row;
  highest_sent_ = status.next_row;
  device_next_record_ = status.next_record;
  row_progress_us_ = now;
  record_progress_us_ = now;
  last_asked_us_ = 0;
}

void ProgramStream::pause_for(milliseconds duration) {
  // Events of the meantime belong to whatever was running before.
  const std::uint64_t deadline = session_->clock_us() + to_us(duration);
  while (session_->clock_us() < deadline) {
    session_->poll(microseconds(static_cast<microseconds::rep>(deadline - session_->clock_us())));
    while (session_->next_event()) {
    }
  }
}

}  // namespace umov::instrument
