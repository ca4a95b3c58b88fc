#include "firmware/core/controller.hpp"

#include <algorithm>

#include "firmware/core/config/design_parameters.hpp"

namespace umov::firmware {

using protocol::Fault;
using protocol::State;

Controller::Controller(Board& board, PersistentLog& log, const Identity& identity,
                       const AxisTable& axes, SettingsStore* settings)
    : board_(&board),
      log_(&log),
      settings_(settings),
      identity_(identity),
      outputs_(board),
      motion_(board, axes),
      sequencer_(board, motion_, outputs_, reference_),
      safety_(board, log, identity.boot_id),
      link_(board) {}

void Controller::start() {
  outputs_.reset();
  sequencer_.configure(default_lockin);
  load_settings();
  switch (identity_.reset_cause) {
    case ResetCause::power_on:
      break;
    case ResetCause::watchdog:
      return raise(Fault::watchdog, -1);
    case ResetCause::brown_out:
      return raise(Fault::brown_out, -1);
    case ResetCause::processor_fault:
      return raise(Fault::internal, identity_.reset_detail);
  }
}

void Controller::enter_safe_state() {
  outputs_.hold_dark();
  sequencer_.suspend();
  motion_.stop_all();
}

void Controller::raise(Fault fault, std::int32_t detail) {
  // The state is entered for every report, latched already or not: it costs nothing to be sure.
  enter_safe_state();
  safety_.raise(fault, detail);
}

void Controller::raise_from_interrupt(Fault fault, std::int32_t detail) {
  outputs_.hold_dark();
  safety_.raise_from_interrupt(fault, detail);
}

void Controller::on_stall(int axis) {
  stalled_axes_.fetch_or(static_cast<std::uint8_t>(1u << axis), std::memory_order_relaxed);
  raise_from_interrupt(Fault::stall, axis);
}

void Controller::on_late_step(int axis) {
  late_axes_.fetch_or(static_cast<std::uint8_t>(1u << axis), std::memory_order_relaxed);
  raise_from_interrupt(Fault::missed_deadline, axis);
}

void Controller::on_adc_overrun() {
  raise_from_interrupt(Fault::adc_overrun, -1);
}
void Controller::on_interlock_open() {
  raise_from_interrupt(Fault::interlock, -1);
}
void Controller::on_emergency_stop() {
  raise_from_interrupt(Fault::emergency_stop, -1);
}
void Controller::on_overheat() {
  raise_from_interrupt(Fault::over_temperature, -1);
}
void Controller::on_low_supply() {
  raise_from_interrupt(Fault::brown_out, -1);
}

void Controller::watch_deadline() {
  const std::uint64_t now = board_->time_us();
  if (ticked_ && now - last_tick_us_ > tick_limit_us) {
    raise(Fault::missed_deadline, -1);
    // Samples that were lost in that time are its consequence.
    safety_.drop_pending(Fault::adc_overrun);
  }
  last_tick_us_ = now;
  ticked_ = true;
}

void Controller::watch_reference() {
  board_->mask_interrupts();
  reference_.watch(board_->reference_clock());
  board_->unmask_interrupts();
  if (safety_.latched(Fault::reference_lost) || !sequencer_.reference_missing()) return;
  raise(Fault::reference_lost, static_cast<std::int32_t>(sequencer_.reference_state()));
}

bool Controller::persists(Fault fault) const {
  switch (fault) {
    case Fault::interlock:
      return !board_->interlock_closed();
    case Fault::emergency_stop:
      return !board_->emergency_released();
    case Fault::over_temperature:
      return board_->overheated();
    case Fault::brown_out:
      return board_->supply_low();
    case Fault::stall:
      for (int axis = 0; axis < axis_count; ++axis) {
        if (board_->stalled(axis)) return true;
      }
      return false;
    default:
      return false;
  }
}

/// Inputs whose edge no interrupt has seen: at their bad level from the start, or still there after
/// the fault was cleared.
void Controller::look_at_inputs() {
  for (const Fault fault :
       {Fault::interlock, Fault::emergency_stop, Fault::over_temperature, Fault::brown_out}) {
    if (!safety_.latched(fault) && persists(fault)) raise(fault, -1);
  }
  for (int axis = 0; axis < axis_count; ++axis) {
    if (!board_->stalled(axis)) continue;
    motion_.forget_position(axis);
    if (!safety_.latched(Fault::stall)) raise(Fault::stall, axis);
  }
}

void Controller::collect_lost_positions() {
  const unsigned lost = stalled_axes_.exchange(0) | late_axes_.exchange(0);
  for (int axis = 0; axis < axis_count; ++axis) {
    if ((lost >> axis & 1u) != 0) motion_.forget_position(axis);
  }
}

void Controller::collect_faults() {
  Fault fault = Fault::none;
  std::int32_t detail = -1;
  while (safety_.take_pending(fault, detail)) raise(fault, detail);
  collect_lost_positions();
  const MotionFault motion_fault = motion_.take_fault();
  if (motion_fault.fault != Fault::none) raise(motion_fault.fault, motion_fault.axis);
  look_at_inputs();
  // A single move of the host counts, too; a hand controller's and the braking that another fault
  // began do not.
  const bool moves_by_command = motion_.busy() && hand_axis_ < 0 && !safety_.latched();
  const bool host_needed = sequencer_.running() || outputs_.laser_on() || moves_by_command;
  if (host_needed && link_.silent() && !safety_.latched(Fault::link_lost)) {
    raise(Fault::link_lost, -1);
  }
}

void Controller::tick() {
  watch_deadline();
  motion_.tick();
  collect_faults();
  watch_reference();
  follow_hand();
  if (!safety_.latched()) sequencer_.tick();
  send_what_is_due();
}

void Controller::on_link_bytes(std::span<const std::uint8_t> bytes) {
  link_.receive(bytes, [this](const FrameView& frame) { on_frame(frame); });
  send_what_is_due();
}

void Controller::send_what_is_due() {
  // Nobody there: what is sent now would only be in the way of a host that comes.
  if (!session_open_ || link_.silent()) return;
  protocol::FaultEvent event;
  while (safety_.next_report(event) && link_.tell(event)) safety_.mark_reported();
  send_records();
  send_credit();
}

bool Controller::send_more() {
  if (!session_open_ || link_.silent() || !sequencer_.records().unsent()) return false;
  send_records();
  return sequencer_.records().unsent() && link_.has_room<protocol::Record>();
}

void Controller::send_records() {
  RecordRing& records = sequencer_.records();
  const std::uint64_t now = board_->link_time_us();
  if (records.sent_unacknowledged() && now - records_sent_at_us_ >= record_resend_us) {
    records.send_all_again();
  }
  for (int sent = 0; sent < records_per_turn && records.unsent(); ++sent) {
    const bool oldest = !records.sent_unacknowledged();
    if (!link_.tell(records.to_send())) break;
    records.mark_sent();
    if (oldest) records_sent_at_us_ = now;
  }
}

void Controller::send_credit() {
  if (!sequencer_.active()) return;
  const RowRing& rows = sequencer_.rows();
  const std::uint32_t row_count = sequencer_.program().row_count;
  const std::uint32_t free = std::min(rows.free(), row_count - rows.next());
  const protocol::RowCredit credit{sequencer_.program().program_id, rows.next(),
                                   static_cast<std::uint16_t>(free)};
  const std::uint64_t now = board_->link_time_us();
  const std::uint32_t taken = credit.next_row - told_credit_.next_row;
  const std::uint32_t made =
      credit.next_row + credit.free_slots - (told_credit_.next_row + told_credit_.free_slots);
  const bool changed = taken >= credit_batch || made >= credit_batch;
  const bool wanting = free > 0 && now - credit_sent_at_us_ >= credit_resend_us;
  const bool last = rows.next() == row_count && taken > 0;
  if (!credit_due_ && !changed && !wanting && !last) return;
  if (!link_.tell(credit)) return;
  told_credit_ = credit;
  credit_due_ = false;
  credit_sent_at_us_ = now;
}

State Controller::state() const {
  if (safety_.latched()) return State::safe;
  if (motion_.homing()) return State::homing;
  const State program = sequencer_.state();
  const bool moves_alone = program == State::idle || program == State::paused;
  return moves_alone && motion_.busy() ? State::moving : program;
}

bool Controller::resting() const {
  if (motion_.busy()) return false;
  return safety_.latched() || sequencer_.state() != State::scanning;
}

}  // namespace umov::firmware
