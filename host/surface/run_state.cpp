#include "host/surface/run_state.hpp"

#include <bit>
#include <cstdint>
#include <cstring>
#include <string_view>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/sha256.hpp"

namespace umov::surface {
namespace {

static_assert(std::endian::native == std::endian::little, "states are little-endian");

constexpr std::string_view first_line = "umov simulation state 1\n";
constexpr std::size_t digits = 64;

std::string digest(std::string_view text) {
  formats::Sha256 hash;
  hash.update(text);
  return hash.hex_digest();
}

template <class Number>
void put(std::string& bytes, Number number) {
  char raw[sizeof number];
  std::memcpy(raw, &number, sizeof number);
  bytes.append(raw, sizeof number);
}

}  // namespace

void save_state(const std::filesystem::path& path, const std::string& run, const RunState& state) {
  std::string body = digest(run);
  put(body, static_cast<std::uint64_t>(state.size()));
  for (const auto& numbers : state) {
    put(body, static_cast<std::uint64_t>(numbers.size()));
    for (const double x : numbers) put(body, x);
  }
  formats::replace_file(path, std::string(first_line) + digest(body) + body);
}

RunState load_state(const std::filesystem::path& path, const std::string& run) {
  const std::string bytes = formats::read_whole_file(path);
  const std::string_view all(bytes);
  const std::size_t start = first_line.size() + digits;
  const Place place{path.string()};
  if (all.size() < start + digits || !all.starts_with(first_line) ||
      digest(all.substr(start)) != all.substr(first_line.size(), digits)) {
    throw Error(place, "is no whole state of a simulation", "begin anew without --resume");
  }
  if (all.substr(start, digits) != digest(run)) {
    throw Error(place, "is of a run with another scene, seed, angles, cells or lays",
                "resume with what it was begun with, or begin anew without --resume");
  }
  const char* next = all.data() + start + digits;
  const char* end = all.data() + all.size();
  const auto take = [&]<class Number>(Number& number) {
    if (end - next < static_cast<std::ptrdiff_t>(sizeof number)) {
      throw Error(place, "ends too soon", "begin anew without --resume");
    }
    std::memcpy(&number, next, sizeof number);
    next += sizeof number;
  };
  std::uint64_t count = 0;
  take(count);
  RunState state;
  for (std::uint64_t i = 0; i < count; ++i) {
    std::uint64_t size = 0;
    take(size);
    if (size > static_cast<std::uint64_t>(end - next) / sizeof(double)) size = 0;
    state.emplace_back(size);
    for (double& x : state.back()) take(x);
  }
  return state;
}

}  // namespace umov::surface
