#include "firmware/core/safety/safety.hpp"

namespace umov::firmware {

using protocol::Fault;

bool Safety::latched(Fault fault) const {
  for (int i = 0; i < order_count_; ++i) {
    if (order_[static_cast<std::size_t>(i)] == fault) return true;
  }
  return false;
}

Fault Safety::first() const {
  return order_count_ > 0 ? order_[0] : Fault::none;
}

bool Safety::raise(Fault fault, std::int32_t detail) {
  if (fault == Fault::none || latched(fault)) return false;
  order_[static_cast<std::size_t>(order_count_++)] = fault;
  const std::uint64_t now = board_->time_us();
  log_->append({now, boot_id_, static_cast<std::uint8_t>(fault), detail});
  // Each fault is in the ring at most once per latching: it holds all that can be latched at once,
  // and one that was cleared before the host was there to be told. Beyond that the oldest are in
  // the log only.
  if (report_count_ == report_capacity) {
    report_first_ = (report_first_ + 1) % report_capacity;
    --report_count_;
  }
  reports_[(report_first_ + report_count_) % report_capacity] = {
      now, static_cast<std::uint8_t>(fault), detail};
  ++report_count_;
  return true;
}

void Safety::raise_from_interrupt(Fault fault, std::int32_t detail) {
  const auto number = static_cast<unsigned>(fault);
  pending_detail_[number].store(detail, std::memory_order_relaxed);
  pending_.fetch_or(1u << number, std::memory_order_release);
}

bool Safety::take_pending(Fault& fault, std::int32_t& detail) {
  const std::uint32_t pending = pending_.load(std::memory_order_acquire);
  if (pending == 0) return false;
  unsigned number = 0;
  while ((pending & (1u << number)) == 0) ++number;
  pending_.fetch_and(~(1u << number), std::memory_order_acq_rel);
  fault = static_cast<Fault>(number);
  detail = pending_detail_[number].load(std::memory_order_relaxed);
  return true;
}

void Safety::clear(Fault fault) {
  int kept = 0;
  for (int i = 0; i < order_count_; ++i) {
    const Fault latched_fault = order_[static_cast<std::size_t>(i)];
    if (latched_fault != fault) order_[static_cast<std::size_t>(kept++)] = latched_fault;
  }
  order_count_ = kept;
}

bool Safety::next_report(protocol::FaultEvent& event) const {
  if (report_count_ == 0) return false;
  event = reports_[report_first_];
  return true;
}

void Safety::mark_reported() {
  report_first_ = (report_first_ + 1) % report_capacity;
  --report_count_;
}

}  // namespace umov::firmware
