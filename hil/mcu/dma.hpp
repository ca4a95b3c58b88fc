// A DMA controller (RM0090 10): eight streams, direct mode, single buffer, single transfers.
#pragma once

#include <array>

#include "hil/mcu/peripheral.hpp"

namespace umov::mcu {

/// What a DMA controller does on the bus; both may throw umov::Error for an address without memory.
struct BusMaster {
  std::function<std::uint32_t(std::uint32_t address, unsigned bytes)> read;
  std::function<void(std::uint32_t address, unsigned bytes, std::uint32_t value)> write;
};

/// A transfer takes no time; arbitration is the order of the requests.
class Dma : public Peripheral {
 public:
  Dma(const char* name, BusMaster bus, std::function<void(int stream, bool level)> interrupt);

  std::uint32_t read(std::uint32_t offset) override;
  void write(std::uint32_t offset, std::uint32_t value) override;
  /// A peripheral wired to `channel` of `stream` asks for one transfer; false when the stream is
  /// off or listens to another channel.
  bool request(int stream, unsigned channel);
  /// The bus refuses the next transfer of a stream that is on, as memory that is not there would:
  /// the stream goes off and its error flag comes (RM0090 10.3.19). False where it is off.
  bool fail(int stream);
  /// `on_enable(stream)` is called when a stream is switched on: requests held by a peripheral are
  /// served then.
  void on_enable(std::function<void(int stream)> call) { on_enable_ = std::move(call); }

 private:
  struct Stream {
    std::uint32_t cr = 0, ndtr = 0, par = 0, m0ar = 0, fcr = 0x21;
    std::uint32_t length = 0;  ///< NDTR when enabled
    std::uint32_t flags = 0;   ///< as in ISR: FE 0, DME 2, TE 3, HT 4, TC 5
  };
  void set_control(int number, std::uint32_t value);
  void transfer(Stream& s);
  void tell_interrupt(int number);

  const char* name_;
  BusMaster bus_;
  std::function<void(int, bool)> interrupt_;
  std::function<void(int)> on_enable_;
  std::array<Stream, 8> streams_{};
};

}  // namespace umov::mcu
