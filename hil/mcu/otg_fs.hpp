// USB OTG_FS as a device without DMA (RM0090 34): registers and FIFOs on one side, the transactions
// of a bus on the other. Data toggles and the timing of packets are not modelled: a transaction
// happens at once when the bus asks for it.
#pragma once

#include <array>
#include <deque>
#include <span>
#include <vector>

#include "hil/mcu/peripheral.hpp"

namespace umov::mcu {

/// Answer of the device to a transaction; `none`: nothing is plugged in, or no such endpoint.
enum class UsbAnswer : std::uint8_t { ack, nak, stall, none };

class OtgFs : public Peripheral {
 public:
  explicit OtgFs(InterruptLine interrupt);

  std::uint32_t read(std::uint32_t offset) override;
  void write(std::uint32_t offset, std::uint32_t value) override;

  /// The device shows itself to the host (pull-up on D+).
  bool connected() const;
  std::uint8_t address() const { return static_cast<std::uint8_t>(dcfg_ >> 4 & 0x7Fu); }
  void bus_reset();
  UsbAnswer setup(std::span<const std::uint8_t, 8> packet);
  UsbAnswer out(unsigned endpoint, std::span<const std::uint8_t> bytes);
  /// `packet` gets the bytes when the answer is ack.
  UsbAnswer in(unsigned endpoint, std::vector<std::uint8_t>& packet);

 private:
  static constexpr unsigned endpoint_count = 4;
  static constexpr std::uint32_t fifo_words = 320;

  struct Endpoint {
    std::uint32_t settings = 0;  ///< of CTL: size, active, type, STALL, FIFO number
    std::uint32_t interrupts = 0;
    std::uint32_t size = 0;  ///< TSIZ
    bool enabled = false;    ///< EPENA
    bool nak = false;
    std::deque<std::uint32_t> words;  ///< of an IN endpoint, waiting to be sent
  };
  struct Received {
    std::uint32_t status;
    std::vector<std::uint8_t> bytes;
  };

  std::uint32_t packet_size(unsigned number, const Endpoint& endpoint) const;
  std::uint32_t read_control(const Endpoint& endpoint) const;
  void write_control(Endpoint& endpoint, unsigned number, bool in, std::uint32_t value);
  std::uint32_t read_endpoint(std::uint32_t offset) const;
  void write_endpoint(std::uint32_t offset, std::uint32_t value);
  void write_fifo(unsigned number, std::uint32_t word);
  std::uint32_t pop_status();
  std::uint32_t pop_word();
  void push(unsigned endpoint, std::uint32_t kind, std::span<const std::uint8_t> bytes);
  std::uint32_t receive_room() const;
  std::uint32_t transmit_room(unsigned number) const;
  std::uint32_t pending() const;
  std::uint32_t endpoint_interrupts() const;
  void tell_interrupt();
  void core_reset();

  InterruptLine interrupt_;
  std::uint32_t gahbcfg_ = 0, gusbcfg_ = 0, gintsts_ = 0, gintmsk_ = 0, grxfsiz_ = 0x200,
                gccfg_ = 0;
  std::array<std::uint32_t, endpoint_count> transmit_fifo_{};  ///< depth << 16 | start
  std::uint32_t dcfg_ = 0, dctl_ = 2, dsts_ = 0, diepmsk_ = 0, doepmsk_ = 0, daintmsk_ = 0;
  std::array<Endpoint, endpoint_count> in_{}, out_{};
  std::deque<Received> received_;
  std::deque<std::uint8_t> reading_;  ///< of the entry whose status was popped
  bool global_nak_ = false;
};

}  // namespace umov::mcu
