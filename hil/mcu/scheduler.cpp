#include "hil/mcu/scheduler.hpp"

#include <algorithm>
#include <utility>

namespace umov::mcu {

Scheduler::Slot Scheduler::add(std::function<void()> action) {
  events_.push_back({never, std::move(action)});
  return events_.size() - 1;
}

void Scheduler::set(Slot slot, Time at) {
  events_[slot].at = at;
  find_next();
}

void Scheduler::find_next() {
  next_ = never;
  for (Slot slot = 0; slot < events_.size(); ++slot) {
    if (events_[slot].at < next_) {
      next_ = events_[slot].at;
      next_slot_ = slot;
    }
  }
}

void Scheduler::run_until(Time limit) {
  while (next_ <= limit) {
    // An event set for a moment that has gone by happens at once.
    now_ = std::max(now_, next_);
    Event& event = events_[next_slot_];
    event.at = never;
    find_next();
    event.action();
  }
  now_ = std::max(now_, limit);
}

}  // namespace umov::mcu
