// Prints PROTOCOL.md.
#include <iostream>

#include "protocol/tools/description.hpp"

int main() {
  std::cout << umov::protocol::describe_protocol();
  return std::cout.flush() ? 0 : 1;
}
