// What the HID transport says when something is wrong. hidapi's functions are replaced by ones that
// do as told: its shared library's are found after those of the program.
#include "host/instrument/hid_transport.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <hidapi.h>
#include <sys/file.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <cerrno>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>
#include <thread>
#include <vector>

#include "host/errors/error.hpp"
#include "host/instrument/link_lost.hpp"
#include "protocol/usb.hpp"

namespace {

/// What is plugged in, and how it behaves.
struct FakeHid {
  struct Device {
    std::wstring serial;
    std::string node;
    std::wstring manufacturer = L"Umov";
    int interface = umov::protocol::usb::interface::reports;
  };
  std::vector<Device> devices;
  bool opens = true;
  std::atomic<bool> reads_fail{false};
  std::atomic<int> write_error{0};
  std::vector<std::array<unsigned char, 64>> written;
};
FakeHid* fake = nullptr;
int handle_place = 0;

}  // namespace

extern "C" {

hid_device_info* hid_enumerate(unsigned short, unsigned short) {
  hid_device_info* first = nullptr;
  for (auto device = fake->devices.rbegin(); device != fake->devices.rend(); ++device) {
    auto* entry = new hid_device_info{};
    entry->path = device->node.data();
    entry->serial_number = device->serial.data();
    entry->manufacturer_string = device->manufacturer.data();
    entry->interface_number = device->interface;
    entry->next = first;
    first = entry;
  }
  return first;
}
void hid_free_enumeration(hid_device_info* first) {
  while (first != nullptr) delete std::exchange(first, first->next);
}
hid_device* hid_open_path(const char*) {
  return fake->opens ? reinterpret_cast<hid_device*>(&handle_place) : nullptr;
}
void hid_close(hid_device*) {}
int hid_write(hid_device*, const unsigned char* report, std::size_t size) {
  if (fake->write_error != 0) {
    errno = fake->write_error;
    return -1;
  }
  std::array<unsigned char, 64> bytes{};
  std::memcpy(bytes.data(), report + 1, size - 1);
  fake->written.push_back(bytes);
  return static_cast<int>(size);
}
int hid_read_timeout(hid_device*, unsigned char*, std::size_t, int) {
  std::this_thread::sleep_for(std::chrono::milliseconds(1));
  return fake->reads_fail ? -1 : 0;
}
int hid_send_feature_report(hid_device*, const unsigned char*, std::size_t size) {
  return static_cast<int>(size);
}
}

namespace umov::instrument {
namespace {

using testing::HasSubstr;

class HidTransport : public testing::Test {
 protected:
  void SetUp() override {
    fake = &hid_;
    plug_in(L"A1");
  }
  void TearDown() override {
    for (const auto& device : hid_.devices) std::filesystem::remove(device.node);
    fake = nullptr;
  }
  /// Its node is a file of its own: what is asked of it besides reports is to be there, to open and
  /// to be locked.
  void plug_in(const std::wstring& serial) {
    const std::string node =
        std::filesystem::temp_directory_path() /
        ("umov-hidraw-" + std::to_string(getpid()) + "-" + std::to_string(hid_.devices.size()));
    std::ofstream(node) << "";
    hid_.devices.push_back({.serial = serial, .node = node});
  }
  const std::string& node() const { return hid_.devices.front().node; }
  /// Problem and remedy of the error that opening gives.
  static std::string error_of(const std::string& serial) {
    try {
      connect_hid(serial);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  }
  FakeHid hid_;
};

TEST_F(HidTransport, OpensTheOneThereIsAndPadsReports) {
  const auto link = connect_hid("");
  EXPECT_EQ(link->name(), "hid:A1");
  link->write(std::vector<std::uint8_t>(70, 7));
  ASSERT_EQ(hid_.written.size(), 2u);
  EXPECT_EQ(hid_.written[0][63], 7);
  EXPECT_EQ(hid_.written[1][5], 7);
  EXPECT_EQ(hid_.written[1][6], 0);
  std::array<std::uint8_t, 8> buffer{};
  EXPECT_EQ(link->read(buffer, std::chrono::milliseconds(2)), 0u);
}

TEST_F(HidTransport, NothingOrTheWrongOnePluggedIn) {
  EXPECT_THAT(error_of("B2"), HasSubstr("hid:B2: that controller is not plugged in"));
  EXPECT_THAT(error_of("B2"), HasSubstr("plugged in are: hid:A1"));
  plug_in(L"C3");
  EXPECT_THAT(error_of(""), HasSubstr("more than one controller is plugged in"));
  EXPECT_THAT(error_of(""), HasSubstr("name one of them: hid:A1, hid:C3"));
  hid_.devices[0].manufacturer = L"Somebody else";
  hid_.devices[1].interface = 0;
  EXPECT_THAT(error_of(""), HasSubstr("no controller is plugged in"));
  EXPECT_THAT(error_of(""), HasSubstr("umov device list"));
}

TEST_F(HidTransport, OneThatIsInUseIsRefused) {
  const int holder = ::open(node().c_str(), O_RDWR | O_CLOEXEC);
  ASSERT_EQ(::flock(holder, LOCK_EX), 0);
  EXPECT_THAT(error_of("A1"), HasSubstr("hid:A1: another program has opened the controller"));
  ::close(holder);
  const auto link = connect_hid("A1");
  EXPECT_THAT(error_of("A1"), HasSubstr("end that program first"));
}

TEST_F(HidTransport, OneWhoseReportsCannotBeOpenedIsNamedByItsNode) {
  hid_.opens = false;
  EXPECT_THAT(error_of("A1"), HasSubstr("hid:A1: can't open " + node() + " for reports"));
  EXPECT_THAT(error_of("A1"), HasSubstr("check cable and power"));
}

TEST_F(HidTransport, OneThatIsUnpluggedIsToldAsThat) {
  const auto link = connect_hid("A1");
  std::filesystem::remove(node());
  hid_.write_error = ENODEV;
  hid_.reads_fail = true;
  const std::vector<std::uint8_t> bytes(3);
  EXPECT_THROW(
      try { link->write(bytes); } catch (const LinkLost& lost) {
        EXPECT_THAT(lost.what(), HasSubstr("connection lost: the controller was unplugged"));
        throw;
      },
      LinkLost);
  std::array<std::uint8_t, 8> buffer{};
  EXPECT_THROW(
      try { link->read(buffer, std::chrono::seconds(5)); } catch (const LinkLost& lost) {
        EXPECT_THAT(lost.what(), HasSubstr("the controller was unplugged"));
        throw;
      },
      LinkLost);
}

TEST_F(HidTransport, ErrorsOfOneThatIsStillThereAreTheSystems) {
  const auto link = connect_hid("A1");
  hid_.write_error = EIO;
  const std::vector<std::uint8_t> bytes(3);
  EXPECT_THROW(
      try { link->write(bytes); } catch (const LinkLost& lost) {
        EXPECT_THAT(lost.what(), HasSubstr("connection lost: Input/output error"));
        EXPECT_THAT(lost.what(), HasSubstr("--resume"));
        throw;
      },
      LinkLost);
  hid_.reads_fail = true;
  std::array<std::uint8_t, 8> buffer{};
  EXPECT_THROW(
      try { link->read(buffer, std::chrono::seconds(5)); } catch (const LinkLost& lost) {
        EXPECT_THAT(lost.what(), HasSubstr("connection lost: its reports can't be read any more"));
        throw;
      },
      LinkLost);
}

}  // namespace
}  // namespace umov::instrument
