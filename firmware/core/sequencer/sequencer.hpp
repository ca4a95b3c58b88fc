// Runs a scan program: rows in order, one record each, never dropped, never doubled.
#pragma once

#include <cstdint>
#include <span>

#include "firmware/core/lockin/acquisition.hpp"
#include "firmware/core/lockin/reference_lock.hpp"
#include "firmware/core/motion/motion.hpp"
#include "firmware/core/port.hpp"
#include "firmware/core/sequencer/optics_outputs.hpp"
#include "firmware/core/sequencer/record_ring.hpp"
#include "firmware/core/sequencer/row_ring.hpp"
#include "protocol/messages.hpp"

namespace umov::firmware {

/// A row is moved to, waited for, measured, and only then taken out of the ring, in the same
/// instant in which its record goes in. Whatever interrupts it (pause, fault, host away) leaves it
/// in the ring, and it is measured again from the start. Contexts: on_samples() in the sample
/// interrupt, everything else in the main loop.
class Sequencer {
 public:
  Sequencer(Board& board, Motion& motion, OpticsOutputs& outputs, const ReferenceLock& reference)
      : board_(&board), motion_(&motion), outputs_(&outputs), reference_(&reference) {}

  void configure(const protocol::SetLockin& settings);
  const protocol::SetLockin& settings() const { return settings_; }
  /// Whether detection is against an external reference.
  bool external() const {
    return settings_.source == static_cast<std::uint8_t>(protocol::ReferenceSource::external);
  }
  /// The external reference as it stands between two edges. Also in the sample interrupt.
  ReferenceLock reference_now() const;
  /// What comes in at the reference input, as far as this detection can use it.
  protocol::ReferenceState reference_state() const;
  /// A program runs whose reference is not there, or was not for a moment of the record in
  /// progress.
  bool reference_missing() const;

  /// Forgets the program, rows and records held and begins this one.
  void begin(const protocol::ProgramBegin& program);
  /// Whether a program runs, waits or is paused.
  bool active() const { return activity_ != Activity::none; }
  bool paused() const { return activity_ == Activity::paused; }
  /// Running or waiting: moves and shines of itself.
  bool running() const { return active() && !paused(); }
  /// Whether `program` is the one that is active, as it was begun.
  bool is_same(const protocol::ProgramBegin& program) const;

  /// Halts at the row in progress, which will be measured again. Dark until it is resumed: a host
  /// may pause and go away. The row then waits for the laser to settle like after any change.
  void pause();
  void resume();
  /// Ends the program; records not yet acknowledged are kept.
  void abort();
  /// A fault: like pause(), but leaves motion and light to the safe state.
  void suspend();

  enum class RowAnswer : std::uint8_t { taken, ignored, outside_limits, out_of_range };
  struct RowVerdict {
    RowAnswer answer = RowAnswer::taken;
    std::int32_t detail = -1;  ///< axis or field
  };
  RowVerdict take_row(const protocol::ProgramRow& row);

  /// See PROTOCOL.md, "Records".
  void acknowledge(const protocol::RecordAck& ack);

  /// Once a millisecond.
  void tick();
  void on_samples(std::span<const std::uint16_t> signal, std::span<const std::uint16_t> monitor);

  protocol::State state() const;
  const protocol::ProgramBegin& program() const { return program_; }
  const RowRing& rows() const { return rows_; }
  RecordRing& records() { return records_; }
  const RecordRing& records() const { return records_; }

 private:
  enum class Activity : std::uint8_t { none, waiting, moving, settling, measuring, paused };

  void halt();
  void start_next_row();
  void wait();
  void start_settling(bool needed);
  void start_measuring();
  void finish_row();
  void change_range();
  void end_program();

  Board* board_;
  Motion* motion_;
  OpticsOutputs* outputs_;
  const ReferenceLock* reference_;
  RowRing rows_{};
  RecordRing records_{};
  protocol::ProgramBegin program_{};
  protocol::SetLockin settings_ = default_lockin;
  Detection detection_{};
  AutoRange auto_range_{};
  Acquisition acquisition_{};
  Activity activity_ = Activity::none;
  bool waiting_ = false;  ///< for rows or for room
  std::uint64_t waiting_since_us_ = 0;
  bool settle_needed_ = false;
  std::uint64_t settled_at_us_ = 0;
  std::uint64_t sampling_since_us_ = 0;
};

}  // namespace umov::firmware
