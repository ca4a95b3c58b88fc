// USB on-the-go full speed, as a device (RM0090 34.16).
#pragma once

#include "boards/stm32f407/registers/access.hpp"
#include "boards/stm32f407/registers/memory_map.hpp"

namespace umov::boards::stm32f407 {

struct OtgGlobalRegisters {
  Register GOTGCTL, GOTGINT, GAHBCFG, GUSBCFG, GRSTCTL, GINTSTS, GINTMSK, GRXSTSR, GRXSTSP, GRXFSIZ,
      DIEPTXF0, HNPTXSTS, reserved0[2], GCCFG, CID, reserved1[48], HPTXFSIZ, DIEPTXF[3];
};
static_assert(sizeof(OtgGlobalRegisters) == 0x110);

struct OtgDeviceRegisters {
  Register DCFG, DCTL, DSTS, reserved0, DIEPMSK, DOEPMSK, DAINT, DAINTMSK, reserved1[2], DVBUSDIS,
      DVBUSPULSE, reserved2, DIEPEMPMSK;
};
static_assert(sizeof(OtgDeviceRegisters) == 0x38);

/// Control, interrupts, size of the transfer and room in the FIFO of one direction of an endpoint.
struct OtgEndpointRegisters {
  Register CTL, reserved0, INT, reserved1, TSIZ, reserved2, TXFSTS, reserved3;
};
static_assert(sizeof(OtgEndpointRegisters) == 0x20);

inline OtgGlobalRegisters& otg() {
  return at<OtgGlobalRegisters>(memory_map::otg_fs);
}
inline OtgDeviceRegisters& otg_device() {
  return at<OtgDeviceRegisters>(memory_map::otg_fs + 0x800);
}
inline OtgEndpointRegisters& otg_in(unsigned endpoint) {
  return at<OtgEndpointRegisters>(memory_map::otg_fs + 0x900 + 0x20 * endpoint);
}
inline OtgEndpointRegisters& otg_out(unsigned endpoint) {
  return at<OtgEndpointRegisters>(memory_map::otg_fs + 0xB00 + 0x20 * endpoint);
}
inline Register& otg_fifo(unsigned endpoint) {
  return at<Register>(memory_map::otg_fs + 0x1000 + 0x1000 * endpoint);
}

namespace otg_bits {
inline constexpr std::uint32_t GINT = bit(0);                                        // GAHBCFG
inline constexpr std::uint32_t PHYSEL = bit(6), TRDT_6 = 6u << 10, FDMOD = bit(30);  // GUSBCFG
inline constexpr std::uint32_t CSRST = bit(0), RXFFLSH = bit(4), TXFFLSH = bit(5),
                               AHBIDL = bit(31);  // GRSTCTL
inline constexpr std::uint32_t TXFNUM_ALL = 16;
constexpr std::uint32_t TXFNUM(unsigned fifo) {
  return fifo << 6;
}
// GINTSTS, GINTMSK
inline constexpr std::uint32_t RXFLVL = bit(4), GONAKEFF = bit(7), USBSUSP = bit(11),
                               USBRST = bit(12), ENUMDNE = bit(13), IEPINT = bit(18),
                               OEPINT = bit(19), WKUINT = bit(31);
inline constexpr std::uint32_t PWRDWN = bit(16), NOVBUSSENS = bit(21);            // GCCFG
inline constexpr std::uint32_t DSPD_FULL = 3, DAD_MASK = 0x7Fu << 4;              // DCFG
inline constexpr std::uint32_t SDIS = bit(1), SGONAK = bit(9), CGONAK = bit(10);  // DCTL
inline constexpr std::uint32_t XFRC = bit(0), EPDISD = bit(1), STUP = bit(3);  // DxEPINT, DxEPMSK
// DxEPCTL
inline constexpr std::uint32_t MPSIZ_MASK = 0x7FF, USBAEP = bit(15), STALL = bit(21),
                               CNAK = bit(26), SNAK = bit(27), SD0PID = bit(28), EPDIS = bit(30),
                               EPENA = bit(31);
constexpr std::uint32_t EPTYP(unsigned type) {
  return type << 18;
}
constexpr std::uint32_t EP_TXFNUM(unsigned fifo) {
  return fifo << 22;
}
// DxEPTSIZ
inline constexpr std::uint32_t STUPCNT_3 = 3u << 29, XFRSIZ_MASK = 0x7'FFFF;
constexpr std::uint32_t PKTCNT(std::uint32_t packets) {
  return packets << 19;
}
/// PKTSTS of GRXSTSP.
inline constexpr std::uint32_t OUT_DATA = 2, OUT_DONE = 3, SETUP_DONE = 4, SETUP_DATA = 6;
}  // namespace otg_bits

}  // namespace umov::boards::stm32f407
