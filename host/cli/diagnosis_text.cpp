#include "host/cli/diagnosis_text.hpp"

#include <algorithm>
#include <string>
#include <vector>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/gap/answer/words.hpp"

namespace umov::cli {
namespace {

/// "one of backlash, detector_zero; dust" of what is named, with what it cannot be told from.
std::string in_short(const gap::Outcome& o) {
  std::vector<std::string> words;
  for (const auto& set : o.ambiguity_sets)
    words.push_back(fmt::format("one of {}", fmt::join(set, ", ")));
  for (const auto& [effect, probability] : o.causes) {
    const bool told = std::none_of(o.ambiguity_sets.begin(), o.ambiguity_sets.end(),
                                   [&effect = effect](const auto& set) {
                                     return std::find(set.begin(), set.end(), effect) != set.end();
                                   });
    if (told) words.push_back(effect);
  }
  return words.empty() ? "nothing named" : fmt::format("{}", fmt::join(words, "; "));
}

}  // namespace

void print_diagnosis(const gap::Diagnosis& d, const gap::AnswerSource& source) {
  for (const gap::FollowUpRound& r : source.follow_ups)
    fmt::print("after the scan \"{}\" ({}): {} -> {}\n", r.menu, r.scan, in_short(r.before),
               in_short(r.after));
  fmt::print("{}\n", gap::verdict_sentence(d));
  fmt::print("\ngap (withheld rows)  before {:.4g}   after {:.4g}   floor {:.2g}\n", d.before.g2,
             d.after.g2, d.floor.g2);
  if (source.likeness) {
    const auto& [before, after] = *source.likeness;
    fmt::print("NCC {:.2f} -> {:.2f} %   NRMSE {:.2f} -> {:.2f} %\n", 100 * before.ncc,
               100 * after.ncc, 100 * before.nrmse, 100 * after.nrmse);
  }
  if (!d.causes.empty())
    fmt::print("\n  {:<28} {:>11} {:>7}  parameters (95 %)\n", "cause", "probability", "share");
  for (const gap::Cause& c : d.causes) {
    fmt::print("  {:<28} {:>11.3f} {:>6.0f} % ",
               c.family.empty() ? c.effect : fmt::format("{} ({})", c.effect, c.family),
               c.probability, 100 * c.share);
    // The coefficients of a series say nothing to a reader; the JSON has them.
    const bool series = gap::is_series(c.parameters.size());
    if (series) fmt::print(" a smooth series of {} terms", c.parameters.size());
    for (const gap::NamedValue& v : c.parameters)
      if (!series)
        fmt::print(" {} {:.4g} [{:.4g}, {:.4g}] {}", v.name, v.interval.value, v.interval.lo,
                   v.interval.hi, v.unit == "1" ? "" : v.unit);
    if (const auto within = gap::within_tolerance(c, source.limits))
      fmt::print(" ({} tolerance)", *within ? "within" : "beyond");
    fmt::print("\n");
  }
  for (const auto& set : d.ambiguity_sets)
    fmt::print("  not to be told apart by this measurement: {}\n", fmt::join(set, ", "));
  const auto cells = [](const char* title, const gap::Where& where) {
    if (where.cells.empty()) return;
    fmt::print("\n{}\n", title);
    for (std::size_t i = 0; i < std::min<std::size_t>(5, where.cells.size()); ++i) {
      const gap::Cell& c = where.cells[i];
      fmt::print("  {} {:g} to {:g} {:<8} z {:+.1f}  p {:.2g}\n", c.axis, c.from, c.to, c.channel,
                 c.z, c.p_global);
    }
  };
  cells("where the simulation misses", d.where);
  cells("what is left", d.unexplained);
  for (const gap::FurtherScan& s : d.next_scan)
    fmt::print("\nnext: {} ({:.0f} min, separation {:.1f} sigma) tells {}\n", s.menu, s.minutes,
               s.expected_separation, fmt::join(gap::separations_in_words(s), ", "));
  if (!source.follow_up_ended.empty()) fmt::print("note: {}\n", source.follow_up_ended);
  for (const std::string& note : source.notes) fmt::print("note: {}\n", note);
}

}  // namespace umov::cli
