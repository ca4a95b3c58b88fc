// The committed description and vectors are what the declarations say, and the vectors decode.
#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "protocol/frame.hpp"
#include "protocol/tools/description.hpp"
#include "protocol/tools/vectors.hpp"

namespace umov::protocol {
namespace {

using Bytes = std::vector<std::uint8_t>;

const std::filesystem::path folder = std::filesystem::path(UMOV_SOURCE_DIR) / "protocol";

std::string file_text(const std::filesystem::path& path) {
  std::ifstream in(path, std::ios::binary);
  EXPECT_TRUE(in) << path;
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

Bytes from_hex(const std::string& text) {
  Bytes bytes;
  for (std::size_t i = 0; i + 1 < text.size(); i += 2) {
    bytes.push_back(static_cast<std::uint8_t>(std::stoi(text.substr(i, 2), nullptr, 16)));
  }
  return bytes;
}

/// The examples of a vector file: key → rest of the line.
std::vector<std::map<std::string, std::string>> examples_in(const std::filesystem::path& path) {
  std::vector<std::map<std::string, std::string>> examples;
  std::istringstream lines(file_text(path));
  bool inside = false;
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') {
      inside = false;
      continue;
    }
    if (!inside) examples.emplace_back();
    inside = true;
    const std::size_t space = line.find(' ');
    examples.back()[line.substr(0, space)] =
        space == std::string::npos ? "" : line.substr(space + 1);
  }
  return examples;
}

template <class T>
void expect_number(std::istringstream& text, T value) {
  if constexpr (std::is_same_v<T, std::uint64_t>) {
    std::uint64_t expected = 0;
    text >> expected;
    EXPECT_EQ(value, expected);
  } else {
    std::int64_t expected = 0;
    text >> expected;
    EXPECT_EQ(std::int64_t{value}, expected);
  }
  EXPECT_TRUE(text);
}

template <class M>
void check_vectors_of() {
  const auto path = folder / "vectors" / (std::string(M::info.name) + ".txt");
  const auto examples = examples_in(path);
  ASSERT_EQ(examples.size(), 5u) << path;
  for (const auto& example : examples) {
    SCOPED_TRACE(path.string() + " sequence " + example.at("sequence"));
    FrameReader reader;
    int seen = 0;
    reader.feed(from_hex(example.at("frame")), [&](const FrameView& frame) {
      ++seen;
      EXPECT_EQ(frame.type, M::info.id);
      EXPECT_EQ(std::to_string(frame.sequence), example.at("sequence"));
      EXPECT_EQ(Bytes(frame.payload.begin(), frame.payload.end()), from_hex(example.at("payload")));
      M message{};
      ASSERT_TRUE(decode(frame.payload, message).ok());
      for_each_field<M>([&](const auto& declared) {
        std::istringstream text(example.at(std::string(declared.name)));
        const auto& value = message.*(declared.member);
        if constexpr (FieldShape<std::remove_cvref_t<decltype(value)>>::is_array) {
          for (const auto element : value) expect_number(text, element);
        } else {
          expect_number(text, value);
        }
      });
    });
    EXPECT_EQ(seen, 1);
  }
}

TEST(GeneratedFiles, TheProtocolDescriptionIsUpToDate) {
  EXPECT_EQ(file_text(folder / "PROTOCOL.md"), describe_protocol())
      << "run: umov_protocol_doc > protocol/PROTOCOL.md";
}

TEST(GeneratedFiles, TheVectorsAreUpToDate) {
  std::size_t count = 0;
  for (const VectorFile& file : make_vectors()) {
    EXPECT_EQ(file_text(folder / "vectors" / file.name), file.text)
        << file.name << ": run: umov_protocol_vectors protocol/vectors";
    ++count;
  }
  std::size_t on_disk = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder / "vectors")) {
    on_disk += entry.path().extension() == ".txt" ? 1 : 0;
  }
  EXPECT_EQ(on_disk, count) << "a vector file belongs to no message";
}

TEST(GeneratedFiles, EveryVectorDecodesToTheValuesWrittenBesideIt) {
  for_each_message([]<class M>() { check_vectors_of<M>(); });
}

TEST(GeneratedFiles, DamagedStreamsYieldTheFramesAndCountsWrittenBesideThem) {
  const auto examples = examples_in(folder / "vectors" / "damaged.txt");
  ASSERT_GE(examples.size(), 7u);
  for (const auto& example : examples) {
    FrameReader reader;
    std::string sequences;
    reader.feed(from_hex(example.at("bytes")), [&](const FrameView& frame) {
      sequences += (sequences.empty() ? "" : " ") + std::to_string(frame.sequence);
    });
    EXPECT_EQ(sequences, example.at("good_sequences"));
    EXPECT_EQ(std::to_string(reader.counters().bad_crc), example.at("bad_crc"));
    EXPECT_EQ(std::to_string(reader.counters().oversize), example.at("oversize"));
    EXPECT_EQ(std::to_string(reader.counters().garbage), example.at("garbage"));
  }
}

TEST(GeneratedFiles, TheDescriptionHasATableForEveryMessage) {
  const std::string text = describe_protocol();
  for_each_message([&]<class M>() {
    EXPECT_NE(text.find("`" + std::string(M::info.name) + "` ("), std::string::npos);
    for_each_field<M>([&](const auto& declared) {
      EXPECT_NE(text.find("| `" + std::string(declared.name) + "` |"), std::string::npos);
    });
  });
}

}  // namespace
}  // namespace umov::protocol
