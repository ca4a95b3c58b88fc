#include "firmware/core/sequencer/sequencer.hpp"

#include "firmware/core/config/design_parameters.hpp"

namespace umov::firmware {
namespace {

/// Numbers of the fields of program_row that are checked beyond their declared range.
constexpr std::int32_t gain_field = 4;

}  // namespace

void Sequencer::configure(const protocol::SetLockin& settings) {
  settings_ = settings;
  detection_ = {.reference = choose_reference(settings.reference_mhz),
                .harmonic = settings.harmonic,
                .phase_offset = phase_from_udeg(settings.phase_udeg)};
}

protocol::ReferenceState Sequencer::reference_state() const {
  using protocol::ReferenceState;
  const ReferenceLock now = reference_now();
  const bool beyond =
      external() && now.locked() && !detectable(now.frequency_mhz(), settings_.harmonic);
  return beyond ? ReferenceState::out_of_range : now.state();
}

bool Sequencer::reference_missing() const {
  if (!external() || !running()) return false;
  return reference_state() != protocol::ReferenceState::locked ||
         acquisition_.outcome() == Acquisition::Outcome::reference_lost;
}

void Sequencer::begin(const protocol::ProgramBegin& program) {
  program_ = program;
  rows_.restart(program.first_row);
  records_.restart(program.first_row);
  waiting_ = false;
  activity_ = Activity::waiting;
}

bool Sequencer::is_same(const protocol::ProgramBegin& program) const {
  return active() && program.program_id == program_.program_id &&
         program.first_row == program_.first_row && program.row_count == program_.row_count;
}

void Sequencer::halt() {
  board_->stop_sampling();
  acquisition_.cancel();
}

void Sequencer::pause() {
  if (!running()) return;
  suspend();
  motion_->stop_all();
  outputs_->cut_light();
}

void Sequencer::suspend() {
  halt();
  if (active()) activity_ = Activity::paused;
}

void Sequencer::resume() {
  if (paused()) activity_ = Activity::waiting;
}

void Sequencer::abort() {
  halt();
  motion_->stop_all();
  end_program();
  rows_.restart(records_.next());
}

void Sequencer::end_program() {
  outputs_->cut_light();
  activity_ = Activity::none;
}

Sequencer::RowVerdict Sequencer::take_row(const protocol::ProgramRow& row) {
  if (!active() || row.index != rows_.next() || rows_.free() == 0 ||
      row.index >= program_.row_count) {
    return {RowAnswer::ignored};
  }
  for (int axis = 0; axis < axis_count; ++axis) {
    if (!motion_->allowed(axis, row.target_udeg[static_cast<std::size_t>(axis)])) {
      return {RowAnswer::outside_limits, axis};
    }
  }
  if (row.gain != protocol::gain_auto && row.gain > AutoRange::top_range) {
    return {RowAnswer::out_of_range, gain_field};
  }
  rows_.push(row);
  return {RowAnswer::taken};
}

void Sequencer::acknowledge(const protocol::RecordAck& ack) {
  if (ack.program_id != program_.program_id) return;
  if (ack.next_index < records_.first_unacknowledged() || ack.next_index > records_.next()) return;
  if (ack.next_index == records_.first_unacknowledged()) {
    records_.send_all_again();
  } else {
    records_.acknowledge(ack.next_index);
  }
}

void Sequencer::start_next_row() {
  if (records_.next() >= program_.row_count) {
    end_program();
    return;
  }
  if (rows_.empty() || records_.full()) return wait();
  waiting_ = false;
  const protocol::ProgramRow& row = rows_.front();
  motion_->take_moved();  // moves before this row are none of its own
  settle_needed_ = outputs_->set_laser(row.laser);
  settle_needed_ |= outputs_->set_shutter(row.shutter_open != 0);
  settle_needed_ |= outputs_->set_range(auto_range_.begin(row.gain));
  motion_->move_all(row.target_udeg);
  activity_ = Activity::moving;
}

/// Nobody knows for how long: not at the sample's cost.
void Sequencer::wait() {
  const std::uint64_t now = board_->time_us();
  if (!waiting_) waiting_since_us_ = now;
  waiting_ = true;
  if (now - waiting_since_us_ >= lit_wait_us) outputs_->cut_light();
}

void Sequencer::start_settling(bool needed) {
  settled_at_us_ = board_->time_us() + (needed ? std::uint64_t{settings_.settle_ms} * 1000 : 0);
  activity_ = Activity::settling;
}

void Sequencer::start_measuring() {
  const std::uint16_t dwell_ms = rows_.front().dwell_ms;
  std::uint32_t phase_step = detection_.reference.phase_step;
  if (external()) {
    const ReferenceLock now = reference_now();
    if (!now.locked()) return;  // lost since the faults were looked at: the next look tells
    acquisition_.begin(detection_, plan_periods(now.frequency_mhz(), dwell_ms, settings_.blocks),
                       auto_range_, now.losses());
    phase_step = 0;  // what chops the light is outside
  } else {
    acquisition_.begin(detection_, plan_record(detection_.reference, dwell_ms, settings_.blocks),
                       auto_range_);
  }
  sampling_since_us_ = board_->time_us();
  activity_ = Activity::measuring;
  acquisition_.sampled_from(board_->start_sampling(phase_step));
}

void Sequencer::on_samples(std::span<const std::uint16_t> signal,
                           std::span<const std::uint16_t> monitor) {
  const ReferenceLock now = acquisition_.external() ? reference_now() : ReferenceLock{};
  if (acquisition_.take(signal, monitor, now)) board_->stop_sampling();
}

ReferenceLock Sequencer::reference_now() const {
  board_->mask_interrupts();
  const ReferenceLock now = *reference_;
  board_->unmask_interrupts();
  return now;
}

void Sequencer::change_range() {
  outputs_->set_range(auto_range_.range());
  start_settling(true);
}

void Sequencer::finish_row() {
  const protocol::ProgramRow& row = rows_.front();
  const LockinResult sums = acquisition_.result();
  protocol::Record record{
      .program_id = program_.program_id,
      .index = row.index,
      .time_us = sampling_since_us_ +
                 std::uint64_t{acquisition_.twice_centre()} * 500'000 / sample_rate_hz,
      .position_steps = {},
      .laser = row.laser,
      .shutter_open = row.shutter_open,
      .gain = static_cast<std::uint8_t>(outputs_->range()),
      .direction = static_cast<std::int8_t>(motion_->detector_direction()),
      .samples = sums.samples,
      .saturated = sums.saturated,
      .signal_x = sums.signal_x,
      .signal_y = sums.signal_y,
      .monitor_x = sums.monitor_x,
      .monitor_y = sums.monitor_y,
      .signal_x_se = sums.signal_x_se,
      .signal_y_se = sums.signal_y_se,
      .monitor_se = sums.monitor_se};
  for (int axis = 0; axis < axis_count; ++axis) {
    record.position_steps[static_cast<std::size_t>(axis)] = motion_->position_steps(axis);
  }
  acquisition_.cancel();
  records_.push(record);
  rows_.pop();
  activity_ = Activity::waiting;
}

void Sequencer::tick() {
  if (activity_ == Activity::measuring) {
    if (acquisition_.outcome() == Acquisition::Outcome::complete &&
        acquisition_.confirmed(reference_now())) {
      finish_row();
    }
    if (acquisition_.outcome() == Acquisition::Outcome::range_changed) change_range();
  }
  if (activity_ == Activity::waiting && !motion_->busy()) start_next_row();
  if (activity_ == Activity::moving && !motion_->busy()) {
    start_settling(settle_needed_ || motion_->take_moved());
  }
  if (activity_ == Activity::settling && board_->time_us() >= settled_at_us_) start_measuring();
}

protocol::State Sequencer::state() const {
  switch (activity_) {
    case Activity::none:
      return protocol::State::idle;
    case Activity::paused:
      return protocol::State::paused;
    case Activity::waiting:
      if (records_.full()) return protocol::State::waiting_for_host;
      if (rows_.empty() && records_.next() < program_.row_count) {
        return protocol::State::waiting_for_rows;
      }
      return protocol::State::scanning;
    default:
      return protocol::State::scanning;
  }
}

}  // namespace umov::firmware
