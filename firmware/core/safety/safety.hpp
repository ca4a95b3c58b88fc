// Faults: latched, reported once, logged, cleared only on request.
#pragma once

#include <array>
#include <atomic>
#include <cstdint>

#include "firmware/core/port.hpp"
#include "protocol/messages.hpp"

namespace umov::firmware {

inline constexpr int fault_count = static_cast<int>(protocol::Fault::reference_lost) + 1;

/// Book of faults. What the safe state is, the controller knows.
/// Contexts: raise_from_interrupt() anywhere, everything else in the main loop.
class Safety {
 public:
  Safety(Board& board, PersistentLog& log, std::uint32_t boot_id)
      : board_(&board), log_(&log), boot_id_(boot_id) {}

  /// Latches a fault and logs it. False when it was latched already: nothing is reported again.
  bool raise(protocol::Fault fault, std::int32_t detail);
  /// Notes a fault found in an interrupt; take_pending() hands it to the main loop.
  void raise_from_interrupt(protocol::Fault fault, std::int32_t detail);
  /// Takes one fault noted in an interrupt; false when there is none.
  bool take_pending(protocol::Fault& fault, std::int32_t& detail);
  /// Whether a fault noted in an interrupt waits to be taken.
  bool pending() const { return pending_.load(std::memory_order_acquire) != 0; }
  /// Forgets one noted in an interrupt: it was the consequence of another.
  void drop_pending(protocol::Fault fault) {
    pending_.fetch_and(~(1u << static_cast<unsigned>(fault)), std::memory_order_acq_rel);
  }

  bool latched() const { return order_count_ > 0; }
  bool latched(protocol::Fault fault) const;
  /// The oldest latched fault, or none.
  protocol::Fault first() const;
  /// Forgets a latched fault.
  void clear(protocol::Fault fault);

  /// The oldest fault not yet told to the host; false when all are.
  bool next_report(protocol::FaultEvent& event) const;
  void mark_reported();

 private:
  Board* board_;
  PersistentLog* log_;
  std::uint32_t boot_id_;
  std::array<protocol::Fault, fault_count> order_{};  // latched, oldest first
  int order_count_ = 0;
  static constexpr unsigned report_capacity = fault_count;
  std::array<protocol::FaultEvent, report_capacity> reports_{};  // ring of faults not yet told
  unsigned report_first_ = 0;
  unsigned report_count_ = 0;
  std::atomic<std::uint32_t> pending_{0};
  std::array<std::atomic<std::int32_t>, fault_count> pending_detail_{};
};

}  // namespace umov::firmware
