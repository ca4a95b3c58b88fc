#include "protocol/tools/vectors.hpp"

#include <array>
#include <cstdio>
#include <limits>
#include <span>

#include "protocol/frame.hpp"
#include "protocol/schema.hpp"

namespace umov::protocol {
namespace {

std::string hex(std::span<const std::uint8_t> bytes) {
  std::string text;
  for (const std::uint8_t byte : bytes) {
    char digits[3];
    std::snprintf(digits, sizeof digits, "%02x", byte);
    text += digits;
  }
  return text;
}

/// SplitMix64: the same numbers everywhere.
class Mixer {
 public:
  explicit Mixer(std::uint64_t seed) : state_(seed) {}
  std::uint64_t next() {
    state_ += 0x9e3779b97f4a7c15u;
    std::uint64_t z = state_;
    z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9u;
    z = (z ^ (z >> 27)) * 0x94d049bb133111ebu;
    return z ^ (z >> 31);
  }

 private:
  std::uint64_t state_;
};

enum class Filling { least, greatest, mixed };

template <class T>
T fill(Filling filling, std::int64_t min, std::int64_t max, Mixer& mixer) {
  using Limits = std::numeric_limits<T>;
  const bool any = min >= max;
  if constexpr (std::is_same_v<T, char>) {
    if (filling == Filling::least) return '\0';
    if (filling == Filling::greatest) return '~';
    return static_cast<char>('a' + mixer.next() % 26);
  } else {
    const T low = any ? Limits::min() : static_cast<T>(min);
    const T high = any ? Limits::max() : static_cast<T>(max);
    if (filling == Filling::least) return low;
    if (filling == Filling::greatest) return high;
    const std::uint64_t bits = mixer.next();
    // Small numbers and zeros are as common as large ones: they exercise the byte stuffing.
    const std::uint64_t shrunk = bits >> ((bits & 7u) * 8u);
    if (any) return static_cast<T>(shrunk);
    const auto span = static_cast<std::uint64_t>(max - min);
    const std::uint64_t offset =
        span == std::numeric_limits<std::uint64_t>::max() ? shrunk : shrunk % (span + 1);
    return static_cast<T>(min + static_cast<std::int64_t>(offset));
  }
}

template <class M>
M example(Filling filling, std::uint64_t seed) {
  M message{};
  Mixer mixer(seed);
  for_each_field<M>([&](const auto& declared) {
    auto& value = message.*(declared.member);
    using Value = std::remove_cvref_t<decltype(value)>;
    if constexpr (FieldShape<Value>::is_array) {
      for (auto& element : value) {
        element =
            fill<typename FieldShape<Value>::Element>(filling, declared.min, declared.max, mixer);
      }
    } else {
      value = fill<Value>(filling, declared.min, declared.max, mixer);
    }
  });
  return message;
}

template <class T>
std::string number_text(T value) {
  if constexpr (std::is_same_v<T, char>) {
    return std::to_string(static_cast<unsigned>(static_cast<unsigned char>(value)));
  } else {
    return std::to_string(value);
  }
}

template <class M>
std::string vector_text(const M& message, std::uint16_t sequence) {
  std::string text = "\nsequence " + std::to_string(sequence) + "\n";
  for_each_field<M>([&](const auto& declared) {
    const auto& value = message.*(declared.member);
    text += std::string(declared.name);
    if constexpr (FieldShape<std::remove_cvref_t<decltype(value)>>::is_array) {
      for (const auto element : value) text += " " + number_text(element);
    } else {
      text += " " + number_text(value);
    }
    text += "\n";
  });
  std::array<std::uint8_t, wire_size<M>> payload{};
  std::array<std::uint8_t, wire_frame_size<M>> frame{};
  encode(message, payload);
  const std::size_t size = FrameWriter::write(sequence, message, frame);
  return text + "payload " + hex(payload) + "\nframe " +
         hex(std::span<const std::uint8_t>(frame).first(size)) + "\n";
}

template <class M>
VectorFile message_file() {
  std::string text = "# " + std::string(M::info.name) + ", type " + std::to_string(M::info.id) +
                     ". Written by umov_protocol_vectors; numbers decimal, bytes hexadecimal.\n";
  const std::uint64_t seed = M::info.id;
  text += vector_text(example<M>(Filling::least, seed), 0);
  text += vector_text(example<M>(Filling::greatest, seed), 0xffff);
  for (std::uint16_t i = 0; i < 3; ++i) {
    text += vector_text(example<M>(Filling::mixed, seed * 16u + i),
                        static_cast<std::uint16_t>(1 + 0x1234 * i));
  }
  return {std::string(M::info.name) + ".txt", text};
}

using Bytes = std::vector<std::uint8_t>;

Bytes frame_of(std::uint16_t sequence) {
  Bytes frame(max_wire_frame_size);
  frame.resize(FrameWriter::write(sequence, RecordAck{7, sequence}, frame));
  return frame;
}

void append(Bytes& to, const Bytes& more) {
  to.insert(to.end(), more.begin(), more.end());
}

/// Bytes with what is wrong with them and the sequence numbers of the frames that survive.
std::string damaged_text(const std::string& what, const Bytes& bytes,
                         const std::string& sequences) {
  FrameReader reader;
  reader.feed(bytes, [](const FrameView&) {});
  const FrameCounters& counters = reader.counters();
  return "\n# " + what + "\nbytes " + hex(bytes) + "\ngood_sequences" + sequences + "\nbad_crc " +
         std::to_string(counters.bad_crc) + "\noversize " + std::to_string(counters.oversize) +
         "\ngarbage " + std::to_string(counters.garbage) + "\n";
}

VectorFile damaged_file() {
  std::string text =
      "# Damaged streams. Written by umov_protocol_vectors. Each begins with a fresh reader and "
      "gives the\n"
      "# sequence numbers of the record_ack frames that come through, and how many were dropped "
      "and why.\n";
  const Bytes first = frame_of(1);
  const Bytes second = frame_of(2);

  Bytes stream = first;
  stream[1] ^= 0x10;
  append(stream, second);
  text += damaged_text("one bit of the first frame flipped", stream, " 2");

  stream = first;
  stream[0] = 0xf0;
  append(stream, second);
  text += damaged_text("first code byte points beyond the frame", stream, " 2");

  stream.assign(first.begin(), first.begin() + 6);
  stream.push_back(0);
  append(stream, second);
  text += damaged_text("first frame cut short", stream, " 2");

  stream.assign(first.begin(), first.end() - 1);
  append(stream, second);
  append(stream, frame_of(3));
  text += damaged_text("delimiter between the first two frames lost", stream, " 3");

  stream = {0, 0, 0};
  append(stream, first);
  append(stream, {0, 0});
  append(stream, second);
  text += damaged_text("padding between frames", stream, " 1 2");

  stream.assign(400, 0x55);
  stream.push_back(0);
  append(stream, second);
  text += damaged_text("noise longer than any frame", stream, " 2");

  stream = {0x02, 0x11, 0x00};
  append(stream, second);
  text += damaged_text("frame too short for its head and CRC", stream, " 2");
  return {"damaged.txt", text};
}

}  // namespace

std::vector<VectorFile> make_vectors() {
  std::vector<VectorFile> files;
  for_each_message([&]<class M>() { files.push_back(message_file<M>()); });
  files.push_back(damaged_file());
  return files;
}

}  // namespace umov::protocol
