#include "hil/mcu/elf_file.hpp"

#include <fstream>
#include <iterator>

#include "host/errors/error.hpp"

namespace umov::mcu {
namespace {

class Bytes {
 public:
  Bytes(std::string path, std::vector<std::uint8_t> all)
      : path_(std::move(path)), all_(std::move(all)) {}

  std::uint32_t number(std::size_t offset, std::size_t size) const {
    need(offset, size);
    std::uint32_t value = 0;
    for (std::size_t i = 0; i < size; ++i)
      value |= static_cast<std::uint32_t>(all_[offset + i]) << 8 * i;
    return value;
  }
  std::vector<std::uint8_t> piece(std::size_t offset, std::size_t size) const {
    need(offset, size);
    const auto begin = all_.begin() + static_cast<std::ptrdiff_t>(offset);
    return {begin, begin + static_cast<std::ptrdiff_t>(size)};
  }
  [[noreturn]] void refuse(const char* why) const {
    throw Error(Place{.file = path_}, why,
                "give an image built for the board (umov-stm32f407.elf)");
  }

 private:
  void need(std::size_t offset, std::size_t size) const {
    if (offset > all_.size() || size > all_.size() - offset) refuse("the file is cut off");
  }

  std::string path_;
  std::vector<std::uint8_t> all_;
};

}  // namespace

std::vector<Segment> read_elf(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file)
    throw Error(Place{.file = path}, "can't be read", "build it: cmake --build --preset firmware");
  const Bytes bytes(path, {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()});
  constexpr std::uint32_t magic = 0x464C'457F;
  constexpr std::uint32_t executable = 2, machine_arm = 40, load = 1;
  if (bytes.number(0, 4) != magic || bytes.number(4, 1) != 1 || bytes.number(5, 1) != 1)
    bytes.refuse("no 32-bit little-endian ELF file");
  if (bytes.number(16, 2) != executable || bytes.number(18, 2) != machine_arm)
    bytes.refuse("no ARM executable");
  const std::uint32_t table = bytes.number(28, 4), entry = bytes.number(42, 2),
                      count = bytes.number(44, 2);
  std::vector<Segment> segments;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::size_t header = table + std::size_t{i} * entry;
    const std::uint32_t size = bytes.number(header + 16, 4);
    if (bytes.number(header, 4) != load || size == 0) continue;
    segments.push_back(
        {bytes.number(header + 12, 4), bytes.piece(bytes.number(header + 4, 4), size)});
  }
  if (segments.empty()) bytes.refuse("the file has nothing to load");
  return segments;
}

}  // namespace umov::mcu
