// Writes the test vectors into a folder.
#include <filesystem>
#include <fstream>
#include <iostream>

#include "protocol/tools/vectors.hpp"

int main(int argc, char** argv) {
  if (argc != 2) {
    std::cerr << "usage: umov_protocol_vectors FOLDER\n";
    return 2;
  }
  const std::filesystem::path folder = argv[1];
  for (const auto& file : umov::protocol::make_vectors()) {
    std::ofstream out(folder / file.name, std::ios::binary);
    out << file.text;
    if (!out.flush()) {
      std::cerr << "cannot write " << (folder / file.name).string() << "\n";
      return 1;
    }
  }
  return 0;
}
