// Which controller on USB is meant, and what is said when it can't be had.
#include "host/instrument/usb_devices.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <csignal>
#include <cstdlib>
#include <filesystem>
#include <functional>

#include "host/errors/error.hpp"

namespace umov::instrument {
namespace {

using ::testing::HasSubstr;

const UsbDeviceInfo one{"A1", "Umov", "/dev/bus/usb/001/002", true};
const UsbDeviceInfo other{"B2", "Umov", "/dev/bus/usb/001/003", true};
const UsbDeviceInfo closed{"", "", "/dev/bus/usb/001/004", false};

std::string failure_of(const std::function<void()>& act) {
  try {
    act();
  } catch (const Error& error) {
    return error.what();
  }
  return "no error";
}

TEST(UsbDevices, TheOnlyOneNeedsNoName) {
  EXPECT_EQ(choose_device({one}, "usb", "").node, one.node);
  EXPECT_EQ(choose_device({one, other}, "usb", "B2").node, other.node);
  EXPECT_EQ(choose_device({one, closed}, "usb", "").node, one.node)
      << "what may not be opened is not in the way";
}

TEST(UsbDevices, AnErrorNamesWhatIsThere) {
  const auto failure = [](std::vector<UsbDeviceInfo> found, const std::string& serial) {
    return failure_of([&] { choose_device(found, "hid", serial); });
  };
  EXPECT_THAT(failure({}, ""), HasSubstr("hid: no controller is plugged in"));
  EXPECT_THAT(failure({one, other}, ""), HasSubstr("name one of them: hid:A1, hid:B2"));
  EXPECT_THAT(failure({one}, "C3"), HasSubstr("hid:C3: that controller is not plugged in"));
  EXPECT_THAT(failure({one}, "C3"), HasSubstr("plugged in are: hid:A1"));
  EXPECT_THAT(failure({closed}, "A1"), HasSubstr("you may not open the controller at " +
                                                 closed.node + " (install the rule for udev"));
}

TEST(UsbDevices, TheProcessThatHoldsANodeIsNamed) {
  std::string path = std::filesystem::temp_directory_path() / "umov-holder-XXXXXX";
  const int descriptor = ::mkstemp(path.data());
  ASSERT_GE(descriptor, 0);
  EXPECT_EQ(holder_of(path.c_str()), "") << "oneself is not meant";
  const pid_t child = ::fork();
  if (child == 0) {
    for (;;) ::pause();
  }
  ::close(descriptor);
  EXPECT_THAT(holder_of(path.c_str()), HasSubstr("(process " + std::to_string(child) + ")"));
  EXPECT_THAT(failure_of([&] { throw_busy("usb:A1", path.c_str()); }),
              HasSubstr("usb:A1: the controller is in use by test_instrument"));
  ::kill(child, SIGKILL);
  ::waitpid(child, nullptr, 0);
  EXPECT_THAT(failure_of([&] { throw_busy("usb:A1", path.c_str()); }),
              HasSubstr("another program has opened the controller"));
  ::unlink(path.c_str());
}

TEST(UsbDevices, TheRuleForUdevIsAboutTheIdsOfTheFirmware) {
  const std::string rule = udev_rule();
  EXPECT_THAT(rule, HasSubstr("ATTR{idVendor}==\"1209\", ATTR{idProduct}==\"0001\""));
  EXPECT_THAT(rule, HasSubstr("ATTR{idProduct}==\"0002\"")) << "the boot loader";
  EXPECT_THAT(rule, HasSubstr("ATTR{idVendor}==\"0483\", ATTR{idProduct}==\"df11\"")) << "ST's ROM";
  EXPECT_THAT(rule, HasSubstr("KERNEL==\"hidraw*\""));
  EXPECT_THAT(rule, HasSubstr("ATTR{manufacturer}==\"Umov\""));
}

}  // namespace
}  // namespace umov::instrument
