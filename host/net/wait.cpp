#include "host/net/wait.hpp"

#include <poll.h>

#include <algorithm>
#include <ctime>

namespace umov::net {

bool wait_for(const Socket& socket, short events, std::chrono::microseconds timeout) {
  const auto us = std::max<std::chrono::microseconds::rep>(timeout.count(), 0);
  const timespec limit{us / 1'000'000, (us % 1'000'000) * 1000};
  pollfd request{socket.descriptor(), events, 0};
  return ppoll(&request, 1, &limit, nullptr) > 0;
}

}  // namespace umov::net
