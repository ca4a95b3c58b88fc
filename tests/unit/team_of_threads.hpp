// Ranks as threads of this process.
#pragma once

#include <barrier>
#include <cstddef>
#include <thread>
#include <vector>

#include "host/parallel/team.hpp"

namespace umov {

class TeamOfThreads : public Team {
 public:
  struct Meeting {
    explicit Meeting(std::size_t count)
        : arrive(static_cast<std::ptrdiff_t>(count)), own(count), size(count) {}
    std::barrier<> arrive;
    std::vector<std::vector<double>> own;
    std::size_t size;
  };
  TeamOfThreads(Meeting& meeting, std::size_t rank) : meeting_(meeting), rank_(rank) {}
  std::size_t rank() const override { return rank_; }
  std::size_t size() const override { return meeting_.size; }
  std::vector<double> gather(const std::vector<double>& own) const override {
    meeting_.own[rank_] = own;
    meeting_.arrive.arrive_and_wait();
    std::vector<double> all;
    for (const auto& part : meeting_.own) all.insert(all.end(), part.begin(), part.end());
    meeting_.arrive.arrive_and_wait();
    return all;
  }

 private:
  Meeting& meeting_;
  std::size_t rank_;
};

/// Calls work(member) on as many threads, each with its member of one team.
template <class Work>
void as_team(std::size_t ranks, const Work& work) {
  TeamOfThreads::Meeting meeting(ranks);
  std::vector<std::jthread> threads;
  for (std::size_t rank = 0; rank < ranks; ++rank) {
    threads.emplace_back([&, rank] { work(TeamOfThreads(meeting, rank)); });
  }
}

}  // namespace umov
