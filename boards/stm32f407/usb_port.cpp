#include "boards/stm32f407/usb_port.hpp"

#include <algorithm>

#include "boards/stm32f407/board_description.hpp"
#include "boards/stm32f407/pins.hpp"
#include "boards/stm32f407/registers/otg_fs.hpp"
#include "boards/stm32f407/step_outputs.hpp"

namespace umov::boards::stm32f407 {
namespace {

using namespace otg_bits;
using firmware::usb::endpoint_number;
using firmware::usb::EndpointAddress;
using firmware::usb::is_in;

// The 320 words of FIFO memory: received packets of all endpoints, then one FIFO for each IN
// endpoint. Endpoint 1 carries the protocol in transfers of 512 bytes.
constexpr std::array<std::uint32_t, 4> transmit_words = {16, 128, 16, 16};
constexpr std::uint32_t receive_words = 128;
static_assert(receive_words + transmit_words[0] + transmit_words[1] + transmit_words[2] +
                  transmit_words[3] <=
              320);

constexpr std::uint32_t events_used =
    RXFLVL | USBSUSP | USBRST | ENUMDNE | IEPINT | OEPINT | WKUINT;

void wait_us(std::uint32_t duration_us) {
  const std::uint32_t begin = step_clock();
  while (step_clock() - begin < duration_us * (firmware::step_timer_hz / 1'000'000)) {
  }
}

/// Waits until `done()`, at most `longest_wait_us`: all of these take some clocks of 48 MHz while
/// the cable's clock runs. Should it not, the host sees a device that does not answer and resets
/// it, which begins anew; the program goes on meanwhile.
template <class Done>
void wait_for(Done&& done) {
  constexpr std::uint32_t longest_wait_us = 100;
  const std::uint32_t begin = step_clock();
  while (!done() &&
         step_clock() - begin < longest_wait_us * (firmware::step_timer_hz / 1'000'000)) {
  }
}

void flush_transmit(std::uint32_t fifo) {
  otg().GRSTCTL = TXFFLSH | fifo << 6;
  wait_for([] { return (otg().GRSTCTL & TXFFLSH) == 0; });
}

void flush_receive() {
  otg().GRSTCTL = RXFFLSH;
  wait_for([] { return (otg().GRSTCTL & RXFFLSH) == 0; });
}

}  // namespace

void UsbPort::set_up() {
  configure_alternate(usb_dm_pin, 10);
  configure_alternate(usb_dp_pin, 10);
  OtgGlobalRegisters& g = otg();
  g.GAHBCFG = 0;
  g.GUSBCFG = PHYSEL;
  wait_for([] { return (otg().GRSTCTL & AHBIDL) != 0; });
  g.GRSTCTL = CSRST;
  wait_for([] { return (otg().GRSTCTL & CSRST) == 0; });
  g.GUSBCFG = PHYSEL | FDMOD | TRDT_6;
  wait_us(25'000);  // RM0090 34.16.2: until the device mode is in force
  g.GCCFG = PWRDWN | NOVBUSSENS;
  otg_device().DCTL = SDIS;
  otg_device().DCFG = DSPD_FULL;
  g.GRXFSIZ = receive_words;
  std::uint32_t start = receive_words;
  g.DIEPTXF0 = transmit_words[0] << 16 | start;
  for (unsigned i = 1; i < endpoint_count; ++i) {
    start += transmit_words[i - 1];
    g.DIEPTXF[i - 1] = transmit_words[i] << 16 | start;
  }
  otg_device().DIEPMSK = XFRC;
  otg_device().DOEPMSK = XFRC | STUP;
  otg_device().DAINTMSK = 0x000F'000F;
  begin_anew();
  g.GINTSTS = 0xFFFF'FFFF;
  g.GINTMSK = events_used;
  g.GAHBCFG = GINT;
}

void UsbPort::on_interrupt() {
  otg().GAHBCFG = 0;
}

void UsbPort::connect() {
  clear_bits(otg_device().DCTL, SDIS);
}
void UsbPort::disconnect() {
  set_bits(otg_device().DCTL, SDIS);
}

void UsbPort::set_address(std::uint8_t address) {
  change_bits(otg_device().DCFG, DAD_MASK, static_cast<std::uint32_t>(address) << 4);
}

/// After a reset on the bus: no transfer, nothing in the FIFOs, endpoint 0 ready for SETUP.
void UsbPort::begin_anew() {
  for (unsigned i = 0; i < endpoint_count; ++i) {
    abandon_in(i);
    receiving_[i] = {};
    otg_out(i).CTL = SNAK;
    otg_in(i).INT = 0xFF;
    otg_out(i).INT = 0xFF;
  }
  flush_transmit(TXFNUM_ALL);
  flush_receive();
  set_address(0);
  prepare_setup();
}

/// SETUP reaches endpoint 0 whatever it does, and the core clears EPENA before it reports the end
/// of that phase (RM0090 34.16.4, DOEPCTL0). Before a reset's first SETUP it may be set still: OUT
/// 0 cannot be disabled, and its counters may not be written then.
void UsbPort::prepare_setup() {
  if ((otg_out(0).CTL & EPENA) == 0) otg_out(0).TSIZ = STUPCNT_3 | PKTCNT(1) | 64;
}

void UsbPort::poll(firmware::usb::PortEvents& events) {
  OtgGlobalRegisters& g = otg();
  // Bounded: a host that never pauses must not keep the tick waiting.
  constexpr int most_rounds = 32;
  for (int round = 0; round < most_rounds; ++round) {
    const std::uint32_t due = g.GINTSTS & events_used;
    if (due == 0) break;
    if ((due & USBRST) != 0) {
      g.GINTSTS = USBRST;
      begin_anew();
      events.on_reset();
      continue;
    }
    if ((due & ENUMDNE) != 0) g.GINTSTS = ENUMDNE;
    if ((due & USBSUSP) != 0) {
      g.GINTSTS = USBSUSP;
      events.on_suspend();
    }
    if ((due & WKUINT) != 0) {
      g.GINTSTS = WKUINT;
      events.on_resume();
    }
    // IN first: a status stage that the host has taken is told before the SETUP that may have come
    // after it, which ends whatever is under way.
    if ((due & IEPINT) != 0) look_at_in(events);
    if ((due & RXFLVL) != 0) take_received();
    if ((due & OEPINT) != 0) look_at_out(events);
  }
  g.GAHBCFG = GINT;
}

void UsbPort::read_fifo(std::span<std::uint8_t> into, std::size_t size) {
  for (std::size_t i = 0; i < size; i += 4) {
    const std::uint32_t word = otg_fifo(0);
    for (std::size_t b = 0; b < 4 && i + b < size && i + b < into.size(); ++b) {
      into[i + b] = static_cast<std::uint8_t>(word >> 8 * b);
    }
  }
}

/// Takes one entry out of the receive FIFO.
void UsbPort::take_received() {
  const std::uint32_t status = otg().GRXSTSP;
  const unsigned endpoint = status & 15u;
  const std::size_t size = status >> 4 & 0x7FFu;
  const std::uint32_t kind = status >> 17 & 15u;
  if (kind == SETUP_DATA) return read_fifo(setup_, size);
  if (kind != OUT_DATA || endpoint >= endpoint_count) return;
  Receiving& r = receiving_[endpoint];
  read_fifo(
      r.active ? r.buffer.subspan(std::min(r.size, r.buffer.size())) : std::span<std::uint8_t>{},
      size);
  r.size += size;
}

void UsbPort::look_at_out(firmware::usb::PortEvents& events) {
  for (unsigned i = 0; i < endpoint_count; ++i) {
    const std::uint32_t what = otg_out(i).INT;
    otg_out(i).INT = what & (XFRC | STUP);
    if (i == 0 && (what & STUP) != 0) {
      // A new request ends the one before.
      abandon_in(0);
      otg_in(0).INT = XFRC;
      receiving_[0] = {};
      prepare_setup();
      events.on_setup(setup_);
      continue;
    }
    if ((what & XFRC) == 0 || !receiving_[i].active) continue;
    receiving_[i].active = false;
    if (i == 0) prepare_setup();
    events.on_received(static_cast<EndpointAddress>(i),
                       std::min(receiving_[i].size, receiving_[i].buffer.size()));
  }
}

void UsbPort::look_at_in(firmware::usb::PortEvents& events) {
  for (unsigned i = 0; i < endpoint_count; ++i) {
    const std::uint32_t what = otg_in(i).INT;
    otg_in(i).INT = what & XFRC;
    if ((what & XFRC) == 0 || !sending_[i].active) continue;
    if (!sending_[i].rest.empty()) {
      send_next(i);
      continue;
    }
    sending_[i].active = false;
    events.on_sent(static_cast<EndpointAddress>(i | firmware::usb::direction_in));
  }
}

void UsbPort::open_endpoint(EndpointAddress address, firmware::usb::EndpointType type,
                            std::uint16_t max_packet) {
  const unsigned n = endpoint_number(address);
  const std::uint32_t control =
      USBAEP | EPTYP(static_cast<unsigned>(type)) | SD0PID | SNAK | (max_packet & MPSIZ_MASK);
  if (is_in(address)) {
    abandon_in(n);
    in_packet_[n] = max_packet;
    otg_in(n).CTL = control | EP_TXFNUM(n);
  } else {
    abandon_out(n);
    otg_out(n).CTL = control;
  }
}

void UsbPort::close_endpoint(EndpointAddress address) {
  const unsigned n = endpoint_number(address);
  if (is_in(address)) {
    abandon_in(n);
    otg_in(n).CTL = SNAK;
  } else {
    abandon_out(n);
    otg_out(n).CTL = SNAK;
  }
}

void UsbPort::send(EndpointAddress address, std::span<const std::uint8_t> bytes) {
  const unsigned n = endpoint_number(address);
  sending_[n] = {bytes, true};
  send_next(n);
}

void UsbPort::send_next(unsigned endpoint) {
  Sending& s = sending_[endpoint];
  const std::size_t whole =
      transmit_words[endpoint] * 4 / in_packet_[endpoint] * in_packet_[endpoint];
  const auto bytes = s.rest.first(std::min<std::size_t>(s.rest.size(), whole));
  s.rest = s.rest.subspan(bytes.size());
  const auto size = static_cast<std::uint32_t>(bytes.size());
  const std::uint32_t packets =
      size == 0 ? 1 : (size + in_packet_[endpoint] - 1) / in_packet_[endpoint];
  OtgEndpointRegisters& in = otg_in(endpoint);
  in.TSIZ = PKTCNT(packets) | size;
  set_bits(in.CTL, EPENA | CNAK);
  for (std::uint32_t i = 0; i < size; i += 4) {
    std::uint32_t word = 0;
    for (std::uint32_t b = 0; b < 4 && i + b < size; ++b) {
      word |= static_cast<std::uint32_t>(bytes[i + b]) << 8 * b;
    }
    otg_fifo(endpoint) = word;
  }
}

void UsbPort::receive(EndpointAddress address, std::span<std::uint8_t> buffer) {
  const unsigned n = endpoint_number(address);
  OtgEndpointRegisters& out = otg_out(n);
  receiving_[n] = {buffer, 0, true};
  if (n == 0) {
    prepare_setup();
  } else {
    const std::uint32_t packet = out.CTL & MPSIZ_MASK;
    const auto size = static_cast<std::uint32_t>(buffer.size());
    out.TSIZ = PKTCNT(size / packet) | size;
  }
  set_bits(out.CTL, EPENA | CNAK);
}

void UsbPort::stall(EndpointAddress address) {
  const unsigned n = endpoint_number(address);
  if (n == 0) {
    set_bits(otg_in(0).CTL, STALL);
    set_bits(otg_out(0).CTL, STALL);
  } else if (is_in(address)) {
    abandon_in(n);
    set_bits(otg_in(n).CTL, STALL);
  } else {
    abandon_out(n);
    set_bits(otg_out(n).CTL, STALL);
  }
}

void UsbPort::clear_stall(EndpointAddress address) {
  const unsigned n = endpoint_number(address);
  if (n == 0) return;
  if (is_in(address)) {
    abandon_in(n);
    change_bits(otg_in(n).CTL, STALL, SD0PID);
  } else {
    abandon_out(n);
    change_bits(otg_out(n).CTL, STALL, SD0PID);
  }
}

/// RM0090 34.17.5, "disabling an IN endpoint".
void UsbPort::abandon_in(unsigned endpoint) {
  sending_[endpoint] = {};
  OtgEndpointRegisters& in = otg_in(endpoint);
  if ((in.CTL & EPENA) == 0) return;
  set_bits(in.CTL, SNAK);
  set_bits(in.CTL, EPDIS | SNAK);
  wait_for([&] { return (in.CTL & EPENA) == 0; });
  in.INT = EPDISD | XFRC;
  flush_transmit(endpoint);
}

/// RM0090 34.17.4, "disabling an OUT endpoint": no packets for any while that goes on.
void UsbPort::abandon_out(unsigned endpoint) {
  receiving_[endpoint] = {};
  OtgEndpointRegisters& out = otg_out(endpoint);
  if ((out.CTL & EPENA) == 0) return;
  set_bits(otg_device().DCTL, SGONAK);
  wait_for([&] {
    if ((otg().GINTSTS & RXFLVL) != 0) take_received();
    return (otg().GINTSTS & GONAKEFF) != 0;
  });
  set_bits(out.CTL, EPDIS | SNAK);
  wait_for([&] { return (out.CTL & EPENA) == 0; });
  out.INT = EPDISD | XFRC;
  set_bits(otg_device().DCTL, CGONAK);
}

}  // namespace umov::boards::stm32f407
