#include "host/cli/diagnosis_text.hpp"

#include <algorithm>

#include <fmt/format.h>
#include <fmt/ranges.h>

namespace umov::cli {
namespace {

/// The effect with what cannot be told from it.
std::string with_rivals(const std::string& effect, const gap::Diagnosis& d) {
  for (const auto& set : d.ambiguity_sets)
    if (std::find(set.begin(), set.end(), effect) != set.end())
      return fmt::format("one of {}", fmt::join(set, ", "));
  return effect;
}

std::string share_text(const gap::Interval& closed) {
  return fmt::format("{:.0f} % of the gap ({:.0f} to {:.0f} %)", 100 * closed.value,
                     100 * closed.lo, 100 * closed.hi);
}

}  // namespace

std::string verdict_sentence(const gap::Diagnosis& d) {
  switch (d.verdict) {
    case gap::Verdict::none_needed:
      return "The simulation agrees with the measurement within its noise: no effect is needed.";
    case gap::Verdict::unexplained:
      return fmt::format(
          "The simulation misses the measurement by {:.2g} % of the signal, and no effect in the "
          "catalogue explains it.",
          d.before.percent);
    default:
      break;
  }
  std::vector<std::string> names;
  for (const gap::Cause& c : d.causes) {
    const std::string name = with_rivals(c.effect, d);
    if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  return fmt::format("{} closes {}{}", fmt::join(names, " with "), share_text(d.closed_fraction),
                     d.verdict == gap::Verdict::explained ? "; nothing significant is left."
                                                          : "; something significant is left.");
}

void print_diagnosis(const gap::Diagnosis& d, const std::vector<std::string>& notes) {
  fmt::print("{}\n", verdict_sentence(d));
  fmt::print("\ngap (withheld rows)  before {:.4g}   after {:.4g}   floor {:.2g}\n", d.before.g2,
             d.after.g2, d.floor.g2);
  if (!d.causes.empty())
    fmt::print("\n  {:<28} {:>11} {:>7}  parameters (95 %)\n", "cause", "probability", "share");
  for (const gap::Cause& c : d.causes) {
    fmt::print("  {:<28} {:>11.3f} {:>6.0f} % ",
               c.family.empty() ? c.effect : fmt::format("{} ({})", c.effect, c.family),
               c.probability, 100 * c.share);
    for (const gap::NamedValue& v : c.parameters)
      fmt::print(" {} {:.4g} [{:.4g}, {:.4g}] {}", v.name, v.interval.value, v.interval.lo,
                 v.interval.hi, v.unit == "1" ? "" : v.unit);
    fmt::print("\n");
  }
  for (const auto& set : d.ambiguity_sets)
    fmt::print("  not to be told apart by this scan: {}\n", fmt::join(set, ", "));
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
    fmt::print("\nnext: {} ({:.0f} min, separation {:.1f} sigma)\n", s.menu, s.minutes,
               s.expected_separation);
  for (const std::string& note : notes) fmt::print("note: {}\n", note);
}

}  // namespace umov::cli
