// Started by mpirun: the second rank meets an error of its own while the others wait for it.
#include <cstdio>

#include "host/errors/error.hpp"
#include "host/parallel/ranks/ranks.hpp"

int main() {
  try {
    const umov::Ranks ranks;
    if (ranks.rank() == 1) throw umov::Error("no room on the second rank", "make some");
    ranks.gather({1.0});
    std::puts("all ranks gave their numbers");
    return 0;
  } catch (const umov::Error& error) {
    std::puts(error.what());
    return 1;
  }
}
