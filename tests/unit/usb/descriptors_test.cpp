// What a host makes of the controller's descriptors, read through the control endpoint.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <map>
#include <set>

#include "firmware/core/usb/descriptors.hpp"
#include "tests/unit/usb/usb_bench.hpp"

namespace umov::test {
namespace {

using ::testing::ElementsAre;

std::uint16_t u16(const Bytes& bytes, std::size_t at) {
  return static_cast<std::uint16_t>(bytes.at(at) | (bytes.at(at + 1) << 8));
}

Bytes descriptor(UsbBench& bench, std::uint8_t type, std::uint8_t index = 0,
                 std::uint16_t length = 1024) {
  return bench.control({0x80, 6, static_cast<std::uint16_t>(type << 8 | index), 0, length}).bytes;
}

std::string text(UsbBench& bench, std::uint8_t index) {
  const Bytes bytes =
      bench.control({0x80, 6, static_cast<std::uint16_t>(0x300 | index), 0x0409, 255}).bytes;
  EXPECT_EQ(bytes.at(0), bytes.size());
  EXPECT_EQ(bytes.at(1), 3);
  std::string out;
  for (std::size_t i = 2; i < bytes.size(); i += 2) {
    EXPECT_EQ(bytes.at(i + 1), 0);
    out.push_back(static_cast<char>(bytes.at(i)));
  }
  return out;
}

TEST(UsbDescriptors, the_device_names_itself_and_its_serial_number) {
  UsbBench bench("EMU-0042");
  const Bytes device = descriptor(bench, 1);
  ASSERT_EQ(device.size(), 18u);
  EXPECT_EQ(u16(device, 8), 0x1209);
  EXPECT_EQ(u16(device, 10), 0x0001);
  EXPECT_EQ(device.at(7), 64);
  EXPECT_EQ(device.at(17), 1);
  EXPECT_EQ(text(bench, device.at(14)), "Umov");
  EXPECT_EQ(text(bench, device.at(15)), "Umov reflectometer controller");
  EXPECT_EQ(text(bench, device.at(16)), "EMU-0042");
  EXPECT_THAT(descriptor(bench, 3, 0), ElementsAre(4, 3, 0x09, 0x04));
}

TEST(UsbDescriptors, a_chip_id_becomes_24_digits_that_differ_with_every_bit) {
  std::set<std::string> seen;
  for (std::size_t bit = 0; bit < 96; ++bit) {
    std::array<std::uint32_t, 3> id{};
    id[bit / 32] = 1u << (bit % 32);
    const auto serial = fu::serial_of_chip(id);
    seen.insert(std::string(serial.begin(), serial.end()));
  }
  EXPECT_EQ(seen.size(), 96u);
  const auto serial = fu::serial_of_chip({0x89ABCDEFu, 0x01234567u, 0xFEDCBA98u});
  EXPECT_EQ(std::string(serial.begin(), serial.end()), "FEDCBA980123456789ABCDEF");
  UsbBench bench(std::string(serial.begin(), serial.end()));
  EXPECT_EQ(text(bench, 3), "FEDCBA980123456789ABCDEF");
}

TEST(UsbDescriptors, the_configuration_holds_four_interfaces_with_their_endpoints) {
  UsbBench bench;
  const Bytes all = descriptor(bench, 2);
  ASSERT_EQ(all.size(), u16(all, 2));
  EXPECT_EQ(all.at(4), 4);
  struct Interface {
    std::vector<std::uint8_t> kind;
    std::vector<std::uint8_t> endpoints;
    Bytes extra;
  };
  std::map<int, Interface> interfaces;
  int current = -1;
  for (std::size_t at = 9; at < all.size(); at += all.at(at)) {
    ASSERT_GE(all.at(at), 2);
    if (all.at(at + 1) == 4) {
      current = all.at(at + 2);
      interfaces[current].kind = {all.at(at + 5), all.at(at + 6), all.at(at + 7)};
      EXPECT_FALSE(text(bench, all.at(at + 8)).empty());
    } else if (all.at(at + 1) == 5) {
      interfaces[current].endpoints.push_back(all.at(at + 2));
    } else {
      interfaces[current].extra.assign(all.begin() + static_cast<std::ptrdiff_t>(at),
                                       all.begin() + static_cast<std::ptrdiff_t>(at + all.at(at)));
    }
  }
  ASSERT_EQ(interfaces.size(), 4u);
  EXPECT_THAT(interfaces[0].kind, ElementsAre(0xff, 0x55, 1));
  EXPECT_THAT(interfaces[0].endpoints, ElementsAre(0x01, 0x81));
  EXPECT_THAT(interfaces[1].kind, ElementsAre(3, 0, 0));
  EXPECT_THAT(interfaces[1].endpoints, ElementsAre(0x82, 0x02));
  EXPECT_THAT(interfaces[2].kind, ElementsAre(3, 0, 0));
  EXPECT_THAT(interfaces[2].endpoints, ElementsAre(0x83));
  EXPECT_THAT(interfaces[3].kind, ElementsAre(0xfe, 1, 1));
  // DFU: can download, upload and detach by itself; version 1.1.
  ASSERT_EQ(interfaces[3].extra.size(), 9u);
  EXPECT_EQ(interfaces[3].extra.at(2), 0x0f);
  EXPECT_EQ(u16(interfaces[3].extra, 7), 0x0110);
}

TEST(UsbDescriptors, each_hid_interface_hands_out_the_report_descriptor_it_announces) {
  UsbBench bench;
  for (const auto& [interface, report_size] :
       std::map<std::uint16_t, std::uint8_t>{{1, std::uint8_t{64}}, {2, std::uint8_t{8}}}) {
    const Bytes hid = bench.control({0x81, 6, 0x2100, interface, 255}).bytes;
    ASSERT_EQ(hid.size(), 9u);
    const Bytes report = bench.control({0x81, 6, 0x2200, interface, 255}).bytes;
    EXPECT_EQ(report.size(), u16(hid, 7));
    // Items of one byte or more: two main items, each of report count × 8 bits.
    std::size_t size_bits = 0, count = 0, input_bits = 0, output_bits = 0;
    int depth = 0;
    for (std::size_t at = 0; at < report.size();) {
      const std::uint8_t prefix = report.at(at);
      const std::size_t length = (prefix & 3) == 3 ? 4 : prefix & 3;
      std::uint32_t value = 0;
      for (std::size_t i = 0; i < length; ++i) {
        value |= static_cast<std::uint32_t>(report.at(at + 1 + i)) << (8 * i);
      }
      switch (prefix & 0xfc) {
        case 0x74:
          size_bits = value;
          break;
        case 0x94:
          count = value;
          break;
        case 0x80:
          input_bits += size_bits * count;
          break;
        case 0x90:
          output_bits += size_bits * count;
          break;
        case 0xa0:
          ++depth;
          break;
        case 0xc0:
          --depth;
          break;
        default:
          break;
      }
      at += 1 + length;
    }
    EXPECT_EQ(depth, 0);
    EXPECT_EQ(input_bits, 8u * report_size);
    EXPECT_EQ(output_bits, 8u * report_size);
  }
}

TEST(UsbDescriptors, windows_finds_winusb_for_the_bulk_and_update_interfaces) {
  UsbBench bench;
  const Bytes bos = descriptor(bench, 15);
  ASSERT_EQ(bos.size(), u16(bos, 2));
  EXPECT_EQ(bos.at(4), 2);
  const std::size_t platform = 5 + bos.at(5);
  ASSERT_EQ(bos.at(platform), 28);
  const std::uint16_t set_size = u16(bos, platform + 24);
  const std::uint8_t code = bos.at(platform + 26);
  const Bytes set = bench.control({0xc0, code, 0, 7, 0x1000}).bytes;
  ASSERT_EQ(set.size(), set_size);
  EXPECT_EQ(u16(set, 8), set_size);
  EXPECT_EQ(u16(set, 10 + 6), set_size - 10);
  std::map<int, std::string> compatible;
  std::string guid;
  int function = -1;
  std::size_t end = 0;
  for (std::size_t at = 18; at < set.size();) {
    const std::uint16_t length = u16(set, at);
    const std::uint16_t type = u16(set, at + 2);
    ASSERT_GE(length, 4);
    if (type == 2) {
      function = set.at(at + 4);
      end = at + u16(set, at + 6);
    } else {
      EXPECT_LE(at + length, end) << "outside its function";
      if (type == 3) {
        compatible[function] = std::string(set.begin() + static_cast<std::ptrdiff_t>(at + 4),
                                           set.begin() + static_cast<std::ptrdiff_t>(at + 10));
      } else {
        ASSERT_EQ(type, 4);
        const std::size_t name = u16(set, at + 6);
        EXPECT_EQ(length, 10 + name + u16(set, at + 8 + name));
        for (std::size_t i = at + 10 + name; i < at + length; i += 2) {
          if (set.at(i) != 0) guid.push_back(static_cast<char>(set.at(i)));
        }
      }
    }
    at += length == 8 && type == 2 ? 8 : length;
  }
  EXPECT_EQ(compatible, (std::map<int, std::string>{{0, "WINUSB"}, {3, "WINUSB"}}));
  EXPECT_EQ(guid.size(), 38u);
}

TEST(UsbDescriptors, a_wrong_configuration_is_caught_while_compiling) {
  auto bytes = fu::configuration;
  const auto changed = [&](std::size_t at, std::uint8_t value) {
    auto copy = bytes;
    copy[at] = value;
    return fu::well_formed_configuration(copy, fu::most_endpoints);
  };
  EXPECT_TRUE(fu::well_formed_configuration(bytes, fu::most_endpoints));
  EXPECT_FALSE(fu::well_formed_configuration(bytes, 2)) << "the hand controller needs endpoint 3";
  EXPECT_FALSE(changed(2, 8)) << "total length";
  EXPECT_FALSE(changed(4, 3)) << "number of interfaces";
  EXPECT_FALSE(changed(9 + 4, 1)) << "an interface with more endpoints than it says";
  EXPECT_FALSE(changed(9 + 4, 3)) << "an interface with fewer endpoints than it says";
  EXPECT_FALSE(changed(18 + 2, 0x81)) << "an endpoint address twice";
  EXPECT_FALSE(changed(18 + 4, 63)) << "no packet size of a bulk endpoint";
}

}  // namespace
}  // namespace umov::test
