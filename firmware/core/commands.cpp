// What the controller does with each message of the host.
#include "firmware/core/config/design_parameters.hpp"
#include "firmware/core/controller.hpp"
#include "firmware/core/lockin/sine.hpp"
#include "protocol/schema.hpp"

namespace umov::firmware {

using protocol::Fault;
using protocol::Refusal;
using protocol::State;

template <class M>
void Controller::dispatch(const FrameView& frame) {
  M message;
  const protocol::CodecResult result = protocol::decode(frame.payload, message);
  switch (result.status) {
    case protocol::CodecStatus::ok:
      handle(frame, message);
      break;
    case protocol::CodecStatus::bad_length:
      refuse(frame, Refusal::bad_length);
      break;
    case protocol::CodecStatus::out_of_range:
      refuse(frame, Refusal::out_of_range, result.field);
      break;
  }
}

void Controller::on_frame(const FrameView& frame) {
  if (!session_open_ && frame.type != protocol::Hello::info.id) {
    refuse(frame, Refusal::schema_mismatch);
    return;
  }
  if (frame.type != protocol::Hello::info.id) host_answered_ = true;
  bool known = false;
  protocol::for_each_message([&]<class M>() {
    if constexpr (M::info.sender == protocol::Sender::host) {
      if (frame.type == M::info.id) {
        known = true;
        dispatch<M>(frame);
      }
    }
  });
  if (!known) refuse(frame, Refusal::unknown_message);
}

bool Controller::refused_by_fault(const FrameView& frame) {
  if (!safety_.latched()) return false;
  refuse(frame, Refusal::fault_active, static_cast<std::int32_t>(safety_.first()));
  return true;
}

bool Controller::refused_without_reference(const FrameView& frame) {
  if (!sequencer_.external()) return false;
  const protocol::ReferenceState state = sequencer_.reference_state();
  if (state == protocol::ReferenceState::locked) return false;
  refuse(frame, Refusal::no_reference, static_cast<std::int32_t>(state));
  return true;
}

bool Controller::refused_unless_homed(const FrameView& frame) {
  for (int axis = 0; axis < axis_count; ++axis) {
    if ((motion_.homed_mask() & (1u << axis)) != 0) continue;
    refuse(frame, Refusal::not_homed, axis);
    return true;
  }
  return false;
}

void Controller::handle(const FrameView& frame, const protocol::Hello& message) {
  session_open_ =
      message.version == protocol::protocol_version && message.schema_hash == protocol::schema_hash;
  link_.reply(frame.sequence, protocol::HelloReply{.version = protocol::protocol_version,
                                                   .schema_hash = protocol::schema_hash,
                                                   .device_name = identity_.device_name,
                                                   .serial = identity_.serial,
                                                   .firmware_hash = identity_.firmware_hash,
                                                   .boot_id = identity_.boot_id,
                                                   .sample_rate_hz = sample_rate_hz,
                                                   .adc_step_nv = adc_step_nv,
                                                   .adc_codes = adc_codes,
                                                   .sine_amplitude = sine_amplitude,
                                                   .gains = gains,
                                                   .wavelengths_nm = wavelengths_nm,
                                                   .filter_od_milli = filter_od_milli});
  credit_due_ = true;
  sequencer_.records().send_all_again();
}

void Controller::handle(const FrameView& frame, const protocol::TimeSync& message) {
  const std::uint64_t now = board_->time_us();
  link_.reply(frame.sequence, protocol::TimeSyncReply{message.host_time_us, now, now});
}

void Controller::handle(const FrameView& frame, const protocol::GetStatus&) {
  protocol::Status status{
      .time_us = board_->time_us(),
      .state = static_cast<std::uint8_t>(state()),
      .fault = static_cast<std::uint8_t>(safety_.first()),
      .interlock_closed = board_->interlock_closed() ? std::uint8_t{1} : std::uint8_t{0},
      .homed_mask = motion_.homed_mask(),
      .program_id = sequencer_.program().program_id,
      .row_count = sequencer_.program().row_count,
      .next_row = sequencer_.rows().next(),
      .first_unacknowledged = sequencer_.records().first_unacknowledged(),
      .next_record = sequencer_.records().next(),
      .position_udeg = {},
      .reference_state = static_cast<std::uint8_t>(sequencer_.reference_state()),
      .reference_mhz = sequencer_.reference_now().frequency_mhz()};
  for (int axis = 0; axis < axis_count; ++axis) {
    status.position_udeg[static_cast<std::size_t>(axis)] = motion_.position_udeg(axis);
  }
  link_.reply(frame.sequence, status);
}

void Controller::reply_axis(const FrameView& frame, int axis) {
  const AxisSettings& s = motion_.settings(axis);
  link_.reply(frame.sequence, protocol::AxisInfo{.axis = static_cast<std::uint8_t>(axis),
                                                 .steps_per_turn = s.steps_per_turn,
                                                 .min_udeg = s.min_udeg,
                                                 .max_udeg = s.max_udeg,
                                                 .speed_mdeg_s = s.speed_mdeg_s,
                                                 .acceleration_mdeg_s2 = s.acceleration_mdeg_s2,
                                                 .jerk_mdeg_s3 = s.jerk_mdeg_s3,
                                                 .take_up_udeg = s.take_up_udeg});
}

void Controller::handle(const FrameView& frame, const protocol::GetAxis& message) {
  reply_axis(frame, message.axis);
}

void Controller::handle(const FrameView& frame, const protocol::SetAxis& message) {
  if (sequencer_.active() || motion_.busy()) return refuse(frame, Refusal::wrong_state);
  if (!motion_.change_settings(message)) return refuse(frame, Refusal::out_of_range, message.axis);
  reply_axis(frame, message.axis);
}

void Controller::handle(const FrameView& frame, const protocol::SetLockin& message) {
  if (sequencer_.active() || motion_.busy()) return refuse(frame, Refusal::wrong_state);
  constexpr std::int32_t harmonic_field = 1;
  if (!lockin_allowed(message)) {
    return refuse(frame, Refusal::out_of_range, harmonic_field);
  }
  sequencer_.configure(message);
  accept(frame);
}

void Controller::handle(const FrameView& frame, const protocol::ProgramBegin& message) {
  if (refused_by_fault(frame)) return;
  if (sequencer_.is_same(message)) {  // its answer got lost: the program goes on
    credit_due_ = true;
    return accept(frame);
  }
  if (sequencer_.active()) return refuse(frame, Refusal::wrong_state);
  if (motion_.homing()) return refuse(frame, Refusal::busy);
  if (refused_unless_homed(frame) || refused_without_reference(frame)) return;
  constexpr std::int32_t first_row_field = 1;
  if (message.first_row >= message.row_count) {
    return refuse(frame, Refusal::out_of_range, first_row_field);
  }
  sequencer_.begin(message);
  credit_due_ = true;
  accept(frame);
}

void Controller::handle(const FrameView& frame, const protocol::ProgramRow& message) {
  const Sequencer::RowVerdict verdict = sequencer_.take_row(message);
  switch (verdict.answer) {
    case Sequencer::RowAnswer::taken:
      break;
    case Sequencer::RowAnswer::ignored:
      credit_due_ = true;
      break;
    case Sequencer::RowAnswer::outside_limits:
      refuse(frame, Refusal::outside_limits, verdict.detail);
      break;
    case Sequencer::RowAnswer::out_of_range:
      refuse(frame, Refusal::out_of_range, verdict.detail);
      break;
  }
}

void Controller::handle(const FrameView& frame, const protocol::ProgramControl& message) {
  constexpr std::uint8_t pause = 0, resume = 1;
  if (!sequencer_.active()) return refuse(frame, Refusal::wrong_state);
  if (message.action == pause) {
    sequencer_.pause();
  } else if (message.action == resume) {
    if (refused_by_fault(frame) || refused_unless_homed(frame) ||
        refused_without_reference(frame)) {
      return;
    }
    sequencer_.resume();
    credit_due_ = true;
  } else {
    sequencer_.abort();
  }
  accept(frame);
}

void Controller::handle(const FrameView&, const protocol::RecordAck& message) {
  sequencer_.acknowledge(message);
  records_sent_at_us_ = board_->link_time_us();
}

void Controller::handle(const FrameView& frame, const protocol::Home& message) {
  if (refused_by_fault(frame)) return;
  if (sequencer_.running()) return refuse(frame, Refusal::wrong_state);
  if (motion_.busy()) return refuse(frame, Refusal::busy);
  motion_.home(message.axis_mask);
  accept(frame);
}

void Controller::handle(const FrameView& frame, const protocol::Move& message) {
  if (refused_by_fault(frame)) return;
  if (sequencer_.running()) return refuse(frame, Refusal::wrong_state);
  if (motion_.busy()) return refuse(frame, Refusal::busy);
  if ((motion_.homed_mask() & (1u << message.axis)) == 0) {
    return refuse(frame, Refusal::not_homed, message.axis);
  }
  if (!motion_.allowed(message.axis, message.target_udeg)) {
    return refuse(frame, Refusal::outside_limits, message.axis);
  }
  motion_.move(message.axis, message.target_udeg);
  accept(frame);
}

void Controller::handle(const FrameView& frame, const protocol::Stop& message) {
  if (message.emergency != 0) {
    raise(Fault::emergency_stop, -1);
  } else {
    hand_axis_ = -1;
    sequencer_.pause();
    motion_.stop_all();
  }
  accept(frame);
}

void Controller::handle(const FrameView& frame, const protocol::ClearFault& message) {
  const auto fault = static_cast<Fault>(message.fault);
  if (!safety_.latched(fault)) return refuse(frame, Refusal::wrong_state);
  if (motion_.busy()) return refuse(frame, Refusal::busy);  // still coming to rest
  if (persists(fault)) return refuse(frame, Refusal::fault_active, message.fault);
  safety_.clear(fault);
  if (!safety_.latched()) {
    outputs_.allow_light();
    if (safety_.pending()) outputs_.hold_dark();  // a new one came in between
  }
  accept(frame);
}

void Controller::handle(const FrameView& frame, const protocol::ReadLog& message) {
  LoggedFault entry;
  if (!log_->read(message.index, entry)) entry = LoggedFault{};
  link_.reply(frame.sequence, protocol::LogEntry{.index = message.index,
                                                 .count = log_->count(),
                                                 .time_us = entry.time_us,
                                                 .boot_id = entry.boot_id,
                                                 .fault = entry.fault,
                                                 .detail = entry.detail});
}

}  // namespace umov::firmware
