// Processes that share one piece of work, and tasks shared by them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "host/parallel/for_each_index.hpp"

namespace umov {

/// All members must ask for the same work, in the same order.
class Team {
 public:
  virtual ~Team() = default;
  virtual std::size_t rank() const = 0;
  virtual std::size_t size() const = 0;
  /// Each rank gives as many numbers; each gets those of all, in the order of ranks.
  virtual std::vector<double> gather(const std::vector<double>& own) const = 0;
};

/// Is it true on any rank? Without a team: here.
inline bool on_any_rank(const Team* team, bool own) {
  if (team == nullptr || team->size() == 1) return own;
  for (const double one : team->gather({own ? 1.0 : 0.0})) own = own || one != 0.0;
  return own;
}

/// Calls task(i, out) for i = 0 … count − 1, each once, on `threads` threads of each rank; `out`
/// has room for `numbers` numbers, 0 at first. Every rank gets those of all tasks, in the order of
/// tasks, so that the result depends neither on threads nor on ranks. Without a team the process
/// does everything.
template <class Task>
std::vector<double> for_each_index_of_team(std::size_t count, std::size_t numbers, int threads,
                                           const Team* team, const Task& task) {
  const std::size_t ranks = team == nullptr ? 1 : team->size();
  const std::size_t rank = team == nullptr ? 0 : team->rank();
  // Ranks with one task less send a slot of zeros.
  const std::size_t slots = (count + ranks - 1) / ranks;
  std::vector<double> own(slots * numbers, 0.0);
  const std::size_t own_tasks = count > rank ? (count - rank - 1) / ranks + 1 : 0;
  for_each_index(own_tasks, threads, [&](std::size_t slot) {
    task(rank + slot * ranks, std::span<double>(own).subspan(slot * numbers, numbers));
  });
  if (ranks == 1) return own;
  const std::vector<double> all = team->gather(own);
  std::vector<double> ordered;
  ordered.reserve(count * numbers);
  for (std::size_t i = 0; i < count; ++i) {
    const auto from =
        all.begin() + static_cast<std::ptrdiff_t>(((i % ranks) * slots + i / ranks) * numbers);
    ordered.insert(ordered.end(), from, from + static_cast<std::ptrdiff_t>(numbers));
  }
  return ordered;
}

}  // namespace umov
