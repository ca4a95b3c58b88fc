// Which of how many processes this one is, where mpirun has started several.
#pragma once

#include <exception>
#include <vector>

#include "host/parallel/team.hpp"

namespace umov {

/// While one lives, MPI is running, if mpirun (or a batch system's launcher that speaks PMI) has
/// started the program; else MPI is never called, rank() is 0 and size() 1. One at a time, in the
/// main thread. The destructor waits for the other ranks to come to theirs; on its way out of an
/// error only for some seconds, after which the launcher ends them all.
class Ranks : public Team {
 public:
  /// Throws umov::Error where MPI cannot start.
  Ranks();
  ~Ranks() override;
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  std::size_t rank() const override { return rank_; }
  std::size_t size() const override { return size_; }

  /// All ranks must call it, from their main threads. Throws umov::Error where the numbers do not
  /// come through.
  std::vector<double> gather(const std::vector<double>& own) const override;

  /// Threads to compute with, where `asked` for 0: all cores of a process alone, one of a rank.
  int threads(int asked) const { return asked == 0 && size_ > 1 ? 1 : asked; }

  /// Was this process started as one of several?
  static bool launched();

 private:
  std::size_t rank_ = 0, size_ = 1;
  bool running_ = false;
  int exceptions_ = std::uncaught_exceptions();  ///< under way when it came to be
};

}  // namespace umov
