#include "host/parallel/ranks/ranks.hpp"

#include <chrono>
#include <cstdlib>
#include <exception>
#include <thread>

#define OMPI_SKIP_MPICXX 1
#include <mpi.h>

#include "host/errors/error.hpp"

namespace umov {
namespace {

/// How long a rank in trouble waits for the others: they may still have a file to write.
constexpr std::chrono::seconds patience{10};

/// Do all ranks come to this place: in time, where one may be in trouble, else whenever they do?
bool all_come(bool in_time) {
  MPI_Request arrival = MPI_REQUEST_NULL;
  if (MPI_Ibarrier(MPI_COMM_WORLD, &arrival) != MPI_SUCCESS) return false;
  const auto deadline = std::chrono::steady_clock::now() + patience;
  for (int here = 0;;) {
    if (MPI_Test(&arrival, &here, MPI_STATUS_IGNORE) != MPI_SUCCESS) return false;
    if (here) return true;
    if (in_time && std::chrono::steady_clock::now() > deadline) return false;
    std::this_thread::sleep_for(std::chrono::milliseconds(10));
  }
}

}  // namespace

bool Ranks::launched() {
  // Set by Open MPI's mpirun, and by the launchers of MPICH, Intel MPI and Slurm.
  for (const char* name : {"OMPI_COMM_WORLD_SIZE", "PMI_SIZE", "PMIX_RANK"})
    if (std::getenv(name)) return true;
  return false;
}

Ranks::Ranks() {
  if (!launched()) return;
  int already = 0;
  MPI_Initialized(&already);
  int granted = MPI_THREAD_SINGLE;
  // Threads of a rank compute; only the main thread calls MPI.
  if (!already && MPI_Init_thread(nullptr, nullptr, MPI_THREAD_FUNNELED, &granted) != MPI_SUCCESS) {
    throw Error("MPI could not be started", "start the program with the mpirun it was built with");
  }
  running_ = !already;
  int rank = 0;
  int size = 1;
  MPI_Comm_rank(MPI_COMM_WORLD, &rank);
  MPI_Comm_size(MPI_COMM_WORLD, &size);
  rank_ = static_cast<std::size_t>(rank);
  size_ = static_cast<std::size_t>(size);
}

Ranks::~Ranks() {
  if (!running_) return;
  // An error may throw out one rank while the others wait for it in gather(). All that end well or
  // meet the same error or are stopped arrive here; where they do not, this one leaves without a
  // farewell, so that its message is heard and the launcher ends the others.
  const bool thrown_out = std::uncaught_exceptions() > exceptions_;
  if (size_ > 1 && !all_come(thrown_out)) return;
  MPI_Finalize();
}

std::vector<double> Ranks::gather(const std::vector<double>& own) const {
  if (size_ == 1) return own;
  std::vector<double> all(own.size() * size_);
  const int count = static_cast<int>(own.size());
  if (MPI_Allgather(own.data(), count, MPI_DOUBLE, all.data(), count, MPI_DOUBLE, MPI_COMM_WORLD) !=
      MPI_SUCCESS) {
    throw Error("the ranks do not hear of each other", "start them again; --resume goes on");
  }
  return all;
}

}  // namespace umov
