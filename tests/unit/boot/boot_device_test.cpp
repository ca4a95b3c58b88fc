// What the boot loader says of itself, and how it takes standard requests.
#include <gtest/gtest.h>

#include "tests/unit/boot/dfu_bench.hpp"

namespace umov {
namespace {

using test::DfuBench;
using test::RamFlash;

class BootDeviceOnUsb : public testing::Test {
 protected:
  const test::Keys keys_{1};
  const firmware::boot::Trust trust_{test::board_name, keys_.key};
  RamFlash flash_{4096};
  DfuBench bench_{flash_, trust_};
};

TEST_F(BootDeviceOnUsb, HasEveryStringThatItsDescriptorsAndStatusesName) {
  EXPECT_EQ(bench_.text(1), "Umov");
  EXPECT_EQ(bench_.text(2), "Umov firmware update (development key)");
  EXPECT_EQ(bench_.text(3), "T1");
  EXPECT_EQ(bench_.text(4), "Umov image");
  EXPECT_EQ(bench_.text(11), "the flash memory fails");
  EXPECT_EQ(bench_.text(15), "the flash memory fails where the image belongs");
  for (std::uint8_t index = 1; index <= 15; ++index) EXPECT_NE(bench_.text(index), "");
  EXPECT_EQ(bench_.control(0x80, 6, 0x0300, 4, {}).bytes, (test::Bytes{4, 3, 9, 4}));
  for (const std::uint16_t value :
       {std::uint16_t{0x0310}, std::uint16_t{0x0311}, std::uint16_t{0x03FF}}) {
    EXPECT_EQ(bench_.control(0x80, 6, value, 255, {}).status, usbip::urb_status::stalled);
  }
}

TEST_F(BootDeviceOnUsb, SaysSoWhereItTrustsAKeyOfItsOwn) {
  usbip::StackPort port;
  firmware::boot::BootDevice device(port, flash_, trust_, {'T', '1'}, false);
  port.bind(device);
  device.start();
  port.bus_reset();
  test::Bytes product;
  usbip::Bus bus(port,
                 [&](const usbip::Urb& done, std::int32_t, std::size_t) { product = done.bytes; });
  bus.submit(test::control_urb({0x80, 6, 0x0302, 0x409, 255}, {}));
  bus.run();
  EXPECT_EQ(product,
            test::Bytes(firmware::boot::product_text.begin(), firmware::boot::product_text.end()));
}

TEST_F(BootDeviceOnUsb, RefusesStandardRequestsOfTheWrongShape) {
  const auto stalled = [&](std::uint8_t type, std::uint8_t request, std::uint16_t value,
                           std::uint16_t length = 0) {
    return bench_.control(type, request, value, length, test::Bytes((type & 0x80) ? 0 : length))
               .status == usbip::urb_status::stalled;
  };
  EXPECT_TRUE(stalled(0x00, 9, 1, 2)) << "SET_CONFIGURATION with data";
  EXPECT_TRUE(stalled(0x80, 9, 1, 2)) << "and to the host";
  EXPECT_TRUE(stalled(0x00, 8, 0)) << "GET_CONFIGURATION without a question";
  EXPECT_TRUE(stalled(0x00, 6, 0x0100)) << "GET_DESCRIPTOR, too";
  EXPECT_TRUE(stalled(0x80, 6, 0x0101, 18)) << "there is one device descriptor";
  EXPECT_TRUE(stalled(0x80, 6, 0x0600, 10)) << "full speed is all there is";
  EXPECT_TRUE(stalled(0x82, 6, 0x0100, 18)) << "an endpoint has none";
  EXPECT_TRUE(stalled(0x01, 11, 2)) << "two settings";
  EXPECT_TRUE(stalled(0x02, 3, 0)) << "no endpoint to halt";
  EXPECT_EQ(bench_.control(0x80, 8, 0, 1, {}).bytes, test::Bytes{1}) << "still configured";
  EXPECT_EQ(bench_.control(0x80, 6, 0x0100, 18, {}).bytes.size(), 18u);
}

}  // namespace
}  // namespace umov
