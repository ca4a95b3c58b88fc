// A controller gone mad: the input decides which well-formed or raw bytes it sends when. Whatever
// it does, the host ends with an umov::Error or goes on; it never crashes, hangs or hands records
// on out of order.
// fuzz-link: umov_instrument
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <memory>
#include <span>
#include <vector>

#include "host/errors/error.hpp"
#include "host/instrument/link_lost.hpp"
#include "host/instrument/program_stream.hpp"
#include "host/instrument/session.hpp"
#include "protocol/schema.hpp"

namespace {

using namespace umov;
using namespace umov::protocol;

/// Answers requests with the right type and sequence but with contents from the input, and slips
/// in messages nobody asked for.
class MadController final : public instrument::Transport {
 public:
  explicit MadController(std::span<const std::uint8_t> input) : input_(input) {}

  void write(std::span<const std::uint8_t> bytes) override {
    clock_us_ += 10;
    from_host_.feed(bytes, [&](const FrameView& frame) { answer(frame); });
  }

  std::size_t read(std::span<std::uint8_t> buffer, std::chrono::microseconds timeout) override {
    clock_us_ += 1 + static_cast<std::uint64_t>(std::max<std::int64_t>(timeout.count(), 0));
    if (to_host_.empty()) {
      if (input_.empty()) throw instrument::LinkLost(name(), "the input has ended");
      speak();
    }
    const std::size_t count = std::min({buffer.size(), to_host_.size(), std::size_t{200}});
    std::copy_n(to_host_.begin(), count, buffer.begin());
    to_host_.erase(to_host_.begin(), to_host_.begin() + static_cast<std::ptrdiff_t>(count));
    return count;
  }

  std::uint64_t clock_us() override { return clock_us_; }
  std::string name() const override { return "mad"; }

 private:
  std::uint8_t take() {
    if (input_.empty()) return 0;
    const std::uint8_t byte = input_.front();
    input_ = input_.subspan(1);
    return byte;
  }

  template <class M>
  void send(std::uint16_t sequence, M message) {
    // Mostly zeros, here and there a byte from the input: plausible numbers.
    std::array<std::uint8_t, wire_size<M>> payload{};
    if (!encode(message, payload).ok()) payload = {};
    for (std::uint8_t changes = take() % 8; changes > 0; --changes) {
      payload[take() % payload.size()] = take();
    }
    std::array<std::uint8_t, max_wire_frame_size> frame{};
    const std::size_t size = FrameWriter::write_raw(M::info.id, sequence, payload, frame);
    to_host_.insert(to_host_.end(), frame.begin(),
                    frame.begin() + static_cast<std::ptrdiff_t>(size));
  }

  void answer(const FrameView& request) {
    switch (request.type) {
      case Hello::info.id: {
        HelloReply reply;
        reply.version = protocol_version;
        reply.schema_hash = schema_hash;
        send(request.sequence, reply);
        break;
      }
      case TimeSync::info.id:
        send(request.sequence, TimeSyncReply{clock_us_, clock_us_, clock_us_});
        break;
      case GetStatus::info.id: {
        Status status;
        status.program_id = 1;
        status.row_count = 40;
        status.state = 3;
        send(request.sequence, status);
        break;
      }
      case ProgramRow::info.id:
      case RecordAck::info.id:
        break;
      default:
        send(request.sequence, Done{request.type});
    }
  }

  void speak() {
    switch (const std::uint8_t what = take(); what % 8) {
      case 0:
        send(what, RowCredit{1, take(), take()});
        break;
      case 1:
        send(what, FaultEvent{0, take(), 0});
        break;
      case 2:
        send(take(), ErrorReply{take(), take(), 0});
        break;
      case 3:
        send(take(), Status{});
        break;
      case 4:
        for (int i = 0; i < 20; ++i) to_host_.push_back(take());
        break;
      default: {
        Record record;
        record.program_id = 1;
        record.index = next_record_;
        if ((what & 0x40) == 0) ++next_record_;
        send(what, record);
      }
    }
  }

  std::span<const std::uint8_t> input_;
  std::vector<std::uint8_t> to_host_;
  FrameReader from_host_;
  std::uint64_t clock_us_ = 0;
  std::uint32_t next_record_ = 0;
};

class OrderedSink final : public instrument::RecordSink {
 public:
  void take(const Record& record) override {
    if (record.index != next_ || record.program_id != 1) std::abort();
    ++next_;
  }
  void secure() override {}

 private:
  std::uint32_t next_ = 0;
};

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  OrderedSink sink;
  instrument::ProgramOptions options;
  options.program_id = 1;
  options.row_count = 40;
  options.records_per_secure = 4;
  try {
    instrument::Session session(
        std::make_unique<MadController>(std::span<const std::uint8_t>(data, size)));
    instrument::ProgramStream stream(
        options,
        [](std::uint32_t) {
          ProgramRow row;
          row.dwell_ms = 1;
          return row;
        },
        sink);
    stream.run(session);
  } catch (const Error&) {
  }
  return 0;
}
