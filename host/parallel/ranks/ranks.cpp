#include "host/parallel/ranks/ranks.hpp"

#include <cstdlib>

#define OMPI_SKIP_MPICXX 1
#include <mpi.h>

#include "host/errors/error.hpp"

namespace umov {

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
  if (running_) MPI_Finalize();
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
