#include "firmware/boot/trial.hpp"

#include "firmware/boot/place_tail.hpp"

namespace umov::firmware::boot {
namespace {

using protocol::RollBackReason;

constexpr std::uint32_t mark_word = 0, first_failure_word = 1, confirmed_word = 4;
constexpr std::uint32_t on_trial = 0x4149'5254;   // "TRIA"
constexpr std::uint32_t confirmed = 0x444F'4F47;  // "GOOD"
/// The reason in the lowest byte.
constexpr std::uint32_t failure = 0x4C49'4100;
static_assert(first_failure_word + Trial::most_failures <= confirmed_word);

}  // namespace

bool Trial::open() const {
  // The confirmation counts from its first bit: a power cut must not take it back.
  return tail_word(*flash_, Place::running, mark_word) == on_trial &&
         tail_word(*flash_, Place::running, confirmed_word) == erased_word;
}

std::uint32_t Trial::failures() const {
  std::uint32_t count = 0;
  while (count < most_failures &&
         tail_word(*flash_, Place::running, first_failure_word + count) != erased_word) {
    ++count;
  }
  return count;
}

RollBackReason Trial::last_failure() const {
  const std::uint32_t count = failures();
  if (count == 0) return RollBackReason::damaged;
  const std::uint32_t word = tail_word(*flash_, Place::running, first_failure_word + count - 1);
  // Cut short while it was written: a failure all the same.
  return (word & ~0xFFu) == failure ? static_cast<RollBackReason>(word & 0xFFu)
                                    : RollBackReason::crash;
}

bool Trial::begin() {
  return write_tail(*flash_, Place::running, mark_word, on_trial);
}

bool Trial::note_failure(Restart why) {
  RollBackReason reason{};
  switch (why) {
    case Restart::power:
    case Restart::asked:
      return true;
    case Restart::watchdog:
      reason = RollBackReason::watchdog;
      break;
    case Restart::crash:
      reason = RollBackReason::crash;
      break;
    case Restart::button:
      reason = RollBackReason::button;
      break;
  }
  const std::uint32_t count = failures();
  if (!open() || count >= most_failures) return true;
  return write_tail(*flash_, Place::running, first_failure_word + count,
                    failure | static_cast<std::uint32_t>(reason));
}

bool Trial::confirm() {
  return !open() || write_tail(*flash_, Place::running, confirmed_word, confirmed);
}

}  // namespace umov::firmware::boot
