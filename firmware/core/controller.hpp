// The controller: motion, lock-in, sequencer, safety and link put together behind a handful of
// entry points that a board calls.
#pragma once

#include <atomic>
#include <cstdint>
#include <span>

#include "firmware/core/config/saved_settings.hpp"
#include "firmware/core/link/link.hpp"
#include "firmware/core/motion/motion.hpp"
#include "firmware/core/port.hpp"
#include "firmware/core/safety/safety.hpp"
#include "firmware/core/sequencer/optics_outputs.hpp"
#include "firmware/core/sequencer/sequencer.hpp"
#include "protocol/messages.hpp"

namespace umov::firmware {

/// What a hand controller shows.
struct HandView {
  protocol::State state = protocol::State::idle;
  protocol::Fault fault = protocol::Fault::none;
  std::uint8_t homed_mask = 0;
  std::int32_t position_udeg = 0;
};

/// One a board, statically allocated; board, log and settings must outlive it. Without a store of
/// settings the built-in ones hold after each start, and saving is refused.
/// Contexts (firmware/README.md): on_step_timer() in the timer interrupts, on_samples() in the
/// sample interrupt, on_stall() to on_low_supply() in any interrupt; start(), tick() and
/// on_link_bytes() in the main loop.
class Controller {
 public:
  Controller(Board& board, PersistentLog& log, const Identity& identity,
             const AxisTable& axes = default_axes, SettingsStore* settings = nullptr);

  /// Once, when the hardware is ready: dark, gain 1, saved settings in force, faults of the last
  /// reset latched.
  void start();
  /// Each millisecond.
  void tick();
  /// Bytes from the host, in chunks of any size.
  void on_link_bytes(std::span<const std::uint8_t> bytes);
  /// As often as a board's main loop likes: sends more of what waits. True when there is more that
  /// the link has room for.
  bool send_more();
  /// A step is due; ticks to the next, 0 = none.
  std::uint32_t on_step_timer(int axis) { return motion_.on_step_timer(axis); }
  /// Codes of both channels, equal lengths, in the order sampled.
  void on_samples(std::span<const std::uint16_t> signal, std::span<const std::uint16_t> monitor) {
    sequencer_.on_samples(signal, monitor);
  }
  /// Rising edge of the reference input at this tick of the reference clock; from an interrupt.
  void on_reference_edge(std::uint32_t tick) { reference_.on_edge(tick); }
  /// The driver of an axis reports lost steps.
  void on_stall(int axis);
  /// Samples were lost.
  void on_adc_overrun();
  /// A step came so late that its axis may not have followed.
  void on_late_step(int axis);
  /// The input has left its good level, if only for a moment.
  void on_interlock_open();
  void on_emergency_stop();
  void on_overheat();
  void on_low_supply();

  /// The user should know of something about the image that runs: what the boot loader has done
  /// with it, or that its trial cannot end. Once each, after start(), main loop.
  void on_boot_note(protocol::Fault fault, std::int32_t detail) { raise(fault, detail); }
  /// A host has asked for something in a session since the start: it had the answer to its hello.
  bool host_answered() const { return host_answered_; }

  /// A hand controller at the instrument turns an axis by so much, microdegrees, from where it is
  /// going. Steps that come while it moves add up. Nothing happens while a fault is latched, a
  /// program runs, axes move by command, the axis is not homed, or beyond its soft limits. Needs no
  /// session: whoever turns the knob stands there.
  void jog(int axis, std::int32_t by_udeg);
  /// The hand controller's stop: pauses the program, stops all axes; emergency: safe state.
  void stop_by_hand(bool emergency);
  HandView hand_view(int axis) const;

  const Motion& motion() const { return motion_; }
  const Sequencer& sequencer() const { return sequencer_; }
  /// Nothing moves, nothing is measured and nothing is waited for but the host.
  bool resting() const;

 private:
  using FrameView = protocol::FrameView;

  // controller.cpp
  void raise(protocol::Fault fault, std::int32_t detail);
  void raise_from_interrupt(protocol::Fault fault, std::int32_t detail);
  void enter_safe_state();
  void collect_faults();
  void collect_lost_positions();
  void look_at_inputs();
  /// What caused the fault is still there.
  bool persists(protocol::Fault fault) const;
  void watch_deadline();
  void watch_reference();
  bool refused_without_reference(const FrameView& frame);
  void send_what_is_due();
  void send_records();
  void send_credit();
  protocol::State state() const;

  // hand.cpp
  void follow_hand();

  // settings.cpp
  static bool lockin_allowed(const protocol::SetLockin& lockin);
  SavedSettings settings_in_force() const;
  bool take_over(const SavedSettings& settings);
  void load_settings();
  void handle(const FrameView& frame, const protocol::GetLockin& message);
  void handle(const FrameView& frame, const protocol::SaveSettings& message);

  // commands.cpp
  void on_frame(const FrameView& frame);
  template <class M>
  void dispatch(const FrameView& frame);
  void handle(const FrameView& frame, const protocol::Hello& message);
  void handle(const FrameView& frame, const protocol::TimeSync& message);
  void handle(const FrameView& frame, const protocol::GetStatus& message);
  void handle(const FrameView& frame, const protocol::GetAxis& message);
  void handle(const FrameView& frame, const protocol::SetAxis& message);
  void handle(const FrameView& frame, const protocol::SetLockin& message);
  void handle(const FrameView& frame, const protocol::ProgramBegin& message);
  void handle(const FrameView& frame, const protocol::ProgramRow& message);
  void handle(const FrameView& frame, const protocol::ProgramControl& message);
  void handle(const FrameView& frame, const protocol::RecordAck& message);
  void handle(const FrameView& frame, const protocol::Home& message);
  void handle(const FrameView& frame, const protocol::Move& message);
  void handle(const FrameView& frame, const protocol::Stop& message);
  void handle(const FrameView& frame, const protocol::ClearFault& message);
  void handle(const FrameView& frame, const protocol::ReadLog& message);
  void refuse(const FrameView& frame, protocol::Refusal reason, std::int32_t detail = -1) {
    link_.refuse(frame.sequence, frame.type, reason, detail);
  }
  void accept(const FrameView& frame) { link_.accept(frame.sequence, frame.type); }
  bool refused_by_fault(const FrameView& frame);
  bool refused_unless_homed(const FrameView& frame);
  void reply_axis(const FrameView& frame, int axis);

  Board* board_;
  PersistentLog* log_;
  SettingsStore* settings_;
  Identity identity_;
  OpticsOutputs outputs_;
  Motion motion_;
  ReferenceLock reference_;
  Sequencer sequencer_;
  Safety safety_;
  Link link_;
  SavedSettings built_in_{};
  std::atomic<std::uint8_t> stalled_axes_{0};
  std::atomic<std::uint8_t> late_axes_{0};
  bool session_open_ = false;
  bool host_answered_ = false;
  bool credit_due_ = false;
  bool ticked_ = false;
  std::uint64_t last_tick_us_ = 0;
  std::uint64_t records_sent_at_us_ = 0;
  std::uint64_t credit_sent_at_us_ = 0;
  protocol::RowCredit told_credit_{};
  int hand_axis_ = -1;                 ///< axis that the hand controller moves, -1: none
  std::int64_t hand_target_udeg_ = 0;  ///< where it shall end
};

static_assert(sizeof(Controller) <= ram_budget_bytes);

}  // namespace umov::firmware
