// A score by effect, by style of plan, by material; what is taken for what.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/gap/benchmark/score.hpp"

namespace umov::gap::benchmark {

struct Count {
  std::size_t hits = 0, n = 0;
  void add(bool hit) {
    ++n;
    if (hit) ++hits;
  }
};

struct EffectRow {
  std::string effect;
  Count plain, up_to_set;  ///< top-1 of single and confounded cases with it, any ρ
  Count up_to_set_10;      ///< of those with ρ ≥ 10
  Count right;             ///< claims of it, crowds left out, that are true up to their set
  Count interval;          ///< of its principal parameter
};
std::vector<EffectRow> by_effect(const std::vector<Entry>& entries);

struct GroupRow {
  std::string group;
  Count top1;    ///< single effects, ρ ≥ 10, up to the set
  Count alarms;  ///< where there is none
  Count flags;   ///< few known effects called unknown
};
std::vector<GroupRow> by_style(const std::vector<Entry>& entries);
std::vector<GroupRow> by_material(const std::vector<Entry>& entries);

/// What a single effect of ρ ≥ 7 was taken for; `named` is empty where nothing was claimed.
struct Confusion {
  std::string effect, named;
  std::size_t count = 0, in_set = 0;
};
/// Most frequent first.
std::vector<Confusion> confusions(const std::vector<Entry>& entries);

/// Cases whose only effect the diagnoser had to do without.
struct LeftOutRow {
  std::string effect;
  std::size_t n = 0;
  std::size_t flagged = 0;   ///< unexplained, or explained in part
  std::size_t mimicked = 0;  ///< explained, by other effects
  std::size_t absorbed = 0;  ///< explained by a richer reflectance alone
  std::size_t unseen = 0;    ///< none needed, or not diagnosed
  std::vector<std::string> mimics;
};
std::vector<LeftOutRow> left_out(const std::vector<Entry>& entries);

}  // namespace umov::gap::benchmark
