#include "protocol/codec.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "protocol/schema.hpp"

namespace umov::protocol {
namespace {

TEST(Codec, IntegersAreLittleEndianAndPacked) {
  ProgramBegin begin{0x01020304u, 5, 0xa0b0c0d0u};
  std::array<std::uint8_t, wire_size<ProgramBegin>> bytes{};
  ASSERT_TRUE(encode(begin, bytes).ok());
  EXPECT_EQ(bytes, (std::array<std::uint8_t, 12>{4, 3, 2, 1, 5, 0, 0, 0, 0xd0, 0xc0, 0xb0, 0xa0}));
}

TEST(Codec, NegativeNumbersAreTwosComplement) {
  Move move{2, -2};
  std::array<std::uint8_t, wire_size<Move>> bytes{};
  ASSERT_TRUE(encode(move, bytes).ok());
  EXPECT_EQ(bytes, (std::array<std::uint8_t, 5>{2, 0xfe, 0xff, 0xff, 0xff}));
}

TEST(Codec, TheExtremesOfEveryWidthSurvive) {
  Record record;
  record.signal_x = std::numeric_limits<std::int64_t>::min();
  record.signal_y = std::numeric_limits<std::int64_t>::max();
  record.monitor_se = std::numeric_limits<std::uint64_t>::max();
  record.position_steps = {INT32_MIN, INT32_MAX, -1, 0, 1, 256};
  record.direction = -1;
  std::array<std::uint8_t, wire_size<Record>> bytes{};
  ASSERT_TRUE(encode(record, bytes).ok());
  Record again;
  ASSERT_TRUE(decode(bytes, again).ok());
  EXPECT_EQ(again.signal_x, record.signal_x);
  EXPECT_EQ(again.signal_y, record.signal_y);
  EXPECT_EQ(again.monitor_se, record.monitor_se);
  EXPECT_EQ(again.position_steps, record.position_steps);
  EXPECT_EQ(again.direction, -1);
}

TEST(Codec, AFieldOutOfRangeIsRefusedByBothEndsAndNamedByItsNumber) {
  SetLockin settings{100000, 1, 0, 10, 1};  // blocks: at least 2
  std::array<std::uint8_t, wire_size<SetLockin>> bytes{};
  const CodecResult encoded = encode(settings, bytes);
  EXPECT_EQ(encoded.status, CodecStatus::out_of_range);
  EXPECT_EQ(encoded.field, 4);

  settings.blocks = 2;
  ASSERT_TRUE(encode(settings, bytes).ok());
  bytes[4] = 10;  // harmonic: at most 9
  SetLockin before{1, 2, 3, 4, 5};
  const CodecResult decoded = decode(bytes, before);
  EXPECT_EQ(decoded.status, CodecStatus::out_of_range);
  EXPECT_EQ(decoded.field, 1);
  EXPECT_EQ(before.blocks, 5) << "a refused message leaves its target alone";
}

TEST(Codec, ALengthThatIsNotTheMessagesIsRefused) {
  std::vector<std::uint8_t> bytes(wire_size<Status> + 1);
  Status status;
  EXPECT_EQ(decode(bytes, status).status, CodecStatus::bad_length);
  bytes.resize(wire_size<Status> - 1);
  EXPECT_EQ(decode(bytes, status).status, CodecStatus::bad_length);
  EXPECT_EQ(encode(status, bytes).status, CodecStatus::bad_length);
  bytes.resize(wire_size<Status>);
  EXPECT_TRUE(decode(bytes, status).ok());
}

TEST(Codec, ProgramIdsUpToTheGreatestUnsignedAreInRange) {
  std::array<std::uint8_t, wire_size<ProgramBegin>> bytes{};
  EXPECT_TRUE(encode(ProgramBegin{UINT32_MAX, 0, UINT32_MAX}, bytes).ok());
  EXPECT_EQ(encode(ProgramBegin{0, 0, 1}, bytes).field, 0);
}

TEST(Codec, MessagesAreFoundByTheirTypeByte) {
  EXPECT_EQ(message_name(0x20), "record");
  EXPECT_EQ(message_name(0x7f), "");
}

TEST(Codec, TheWireLayoutIsWhatTheDocumentSays) {
  static_assert(wire_size<HelloReply> == 108);
  static_assert(wire_size<Status> == 61);
  static_assert(wire_size<ProgramRow> == 33);
  static_assert(wire_size<RowCredit> == 10);
  static_assert(wire_size<Record> == 108);
  static_assert(wire_size<RecordAck> == 8);
  SUCCEED();
}

TEST(Schema, TheHashIsFnv1a) {
  Fnv1a64 hash;
  EXPECT_EQ(hash.value(), 0xcbf29ce484222325u);
  hash.byte('a');
  EXPECT_EQ(hash.value(), 0xaf63dc4c8601ec8cu);  // published value for "a"
}

TEST(Schema, TheHashIsAConstantOfTheBuild) {
  static_assert(schema_hash == compute_schema_hash());
  EXPECT_NE(schema_hash, 0u);
}

}  // namespace
}  // namespace umov::protocol
