// Which of how many processes this one is, where mpirun has started several.
#pragma once

#include <vector>

namespace umov {

/// While one lives, MPI is running, if mpirun (or a batch system's launcher that speaks PMI) has
/// started the program; else MPI is never called, rank() is 0 and size() 1. One at a time, in the
/// main thread. The destructor waits for the other ranks to come to theirs.
class Ranks {
 public:
  /// Throws umov::Error where MPI cannot start.
  Ranks();
  ~Ranks();
  Ranks(const Ranks&) = delete;
  Ranks& operator=(const Ranks&) = delete;

  int rank() const { return rank_; }
  int size() const { return size_; }

  /// Each rank gives as many numbers; each gets those of all, in the order of ranks. All ranks must
  /// call it, from their main threads. Throws umov::Error where the numbers do not come through.
  std::vector<double> gather(const std::vector<double>& own) const;

  /// Was this process started as one of several?
  static bool launched();

 private:
  int rank_ = 0, size_ = 1;
  bool running_ = false;
};

}  // namespace umov
