#include "host/instrument/device_names.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "host/errors/error.hpp"
#include "host/instrument/firmware_image.hpp"
#include "host/instrument/refusals.hpp"
#include "protocol/boot_note.hpp"
#include "protocol/messages.hpp"

namespace umov::instrument {
namespace {

using ::testing::HasSubstr;

std::string failure_of(const std::string& text) {
  try {
    parse_device_name(text);
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(DeviceNames, TheEmulatorAndTcpAddressesAreUnderstood) {
  EXPECT_EQ(parse_device_name("emulator").kind, DeviceKind::emulator);
  const DeviceName tcp = parse_device_name("tcp:bench.local:5025");
  EXPECT_EQ(tcp.kind, DeviceKind::tcp);
  EXPECT_EQ(tcp.host, "bench.local");
  EXPECT_EQ(tcp.port, 5025);
  EXPECT_EQ(tcp.text, "tcp:bench.local:5025");
  EXPECT_EQ(parse_device_name("tcp:[::1]:80").host, "::1");
}

TEST(DeviceNames, ControllersOnUsbAreNamedByTheirSerialNumberOrNotAtAll) {
  EXPECT_EQ(parse_device_name("usb").kind, DeviceKind::usb);
  EXPECT_EQ(parse_device_name("usb").serial, "");
  EXPECT_EQ(parse_device_name("usb:EMU-0042").serial, "EMU-0042");
  EXPECT_EQ(parse_device_name("hid:A:B").kind, DeviceKind::hid);
  EXPECT_EQ(parse_device_name("hid:A:B").serial, "A:B");
  EXPECT_THAT(failure_of("usb:"), HasSubstr("serial number is missing"));
}

TEST(DeviceNames, ASerialLineIsAPathAndPerhapsASpeed) {
  const DeviceName line = parse_device_name("serial:/dev/ttyACM0");
  EXPECT_EQ(line.kind, DeviceKind::serial);
  EXPECT_EQ(line.path, "/dev/ttyACM0");
  EXPECT_EQ(line.baud, 1'000'000u);
  EXPECT_EQ(parse_device_name("serial:/dev/ttyUSB1?baud=115200").baud, 115'200u);
  EXPECT_THAT(failure_of("serial"), HasSubstr("the path is missing"));
  EXPECT_THAT(failure_of("serial:?baud=9600"), HasSubstr("the path is missing"));
  EXPECT_THAT(failure_of("serial:/dev/x?baud=fast"), HasSubstr("'fast' is no speed"));
  EXPECT_THAT(failure_of("serial:/dev/x?parity=odd"), HasSubstr("no option 'parity=odd'"));
}

TEST(DeviceNames, UnknownOnesAreToldWhatThereIs) {
  EXPECT_THAT(failure_of("usbx"), HasSubstr("unknown device 'usbx'"));
  EXPECT_THAT(failure_of(""),
              HasSubstr("unknown device '' (available are: emulator, usb[:SERIAL]"));
}

TEST(DeviceNames, ABadAddressSaysWhatIsWrongWithIt) {
  EXPECT_THAT(failure_of("tcp"), HasSubstr("host and port are missing"));
  EXPECT_THAT(failure_of("tcp:localhost"), HasSubstr("the port is missing"));
  EXPECT_THAT(failure_of("tcp::5025"), HasSubstr("the host is missing"));
  EXPECT_THAT(failure_of("tcp:a:0"), HasSubstr("from 1 to 65535"));
  EXPECT_THAT(failure_of("tcp:a:65536"), HasSubstr("from 1 to 65535"));
  EXPECT_THAT(failure_of("tcp:a:50x"), HasSubstr("'50x'"));
  EXPECT_THAT(failure_of("tcp:::1:80"), HasSubstr("needs brackets"));
}

TEST(Refusals, EveryFaultHasAMeaningAndARemedyOfItsOwn) {
  for (int fault = 1; fault <= static_cast<int>(protocol::Fault::reference_lost); ++fault) {
    const auto code = static_cast<std::uint8_t>(fault);
    EXPECT_THAT(fault_remedy(code), ::testing::Not(::testing::IsEmpty()));
    for (int other = 0; other < fault; ++other) {
      EXPECT_NE(fault_meaning(code), fault_meaning(static_cast<std::uint8_t>(other)));
      EXPECT_NE(fault_name(code), fault_name(static_cast<std::uint8_t>(other)));
    }
  }
  EXPECT_EQ(fault_name(200), "fault 200");
}

TEST(Refusals, ARollBackIsToldWithVersionAndReason) {
  using protocol::RollBackReason;
  constexpr auto rolled_back = static_cast<std::uint8_t>(protocol::Fault::rolled_back);
  const auto text_of = [](RollBackReason reason, std::uint32_t version) {
    return fault_detail(rolled_back, protocol::roll_back_detail(reason, version));
  };
  EXPECT_EQ(text_of(RollBackReason::watchdog, version_from_text("0.9.1")),
            "image 0.9.1 failed its trial: the watchdog had to restart it");
  EXPECT_EQ(text_of(RollBackReason::crash, version_from_text("255.255.255")),
            "image 255.255.255 failed its trial: it crashed");
  EXPECT_EQ(text_of(RollBackReason::button, version_from_text("1.0.0")),
            "image 1.0.0 failed its trial: it was reset by hand");
  EXPECT_EQ(text_of(RollBackReason::damaged, 0), "image failed its check at a start");
  EXPECT_EQ(fault_detail(static_cast<std::uint8_t>(protocol::Fault::stall), 3), "3");
  constexpr auto internal = static_cast<std::uint8_t>(protocol::Fault::internal);
  EXPECT_EQ(fault_detail(internal, 0x0802'1234), "134353460") << "where a processor fault was";
  EXPECT_EQ(fault_detail(internal, protocol::trial_not_confirmed),
            "the image has proved itself, but flash does not take the note: it stays on trial");
}

TEST(Refusals, ALostReferenceIsToldInWords) {
  using protocol::ReferenceState;
  const auto text_of = [](ReferenceState state) {
    return fault_detail(static_cast<std::uint8_t>(protocol::Fault::reference_lost),
                        static_cast<std::int32_t>(state));
  };
  EXPECT_EQ(text_of(ReferenceState::absent), "no edges come in at its reference input");
  EXPECT_THAT(text_of(ReferenceState::unsteady), HasSubstr("do not come at a steady period"));
  EXPECT_THAT(text_of(ReferenceState::out_of_range), HasSubstr("slower than 10 Hz"));
  EXPECT_EQ(text_of(ReferenceState::locked), "it was away for a moment and came back");
}

TEST(Refusals, EveryRefusalIsPutIntoWords) {
  for (int code = 0; code <= static_cast<int>(protocol::Refusal::stale_program) + 1; ++code) {
    const Refused refused("d", "move", {0x31, static_cast<std::uint8_t>(code), 1});
    EXPECT_THAT(refused.what(), HasSubstr("d: the controller refuses move: "));
    EXPECT_FALSE(refused.remedy().empty());
  }
}

}  // namespace
}  // namespace umov::instrument
