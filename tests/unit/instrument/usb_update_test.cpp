// Waiting for a controller to come back: which one it is, and what is said when it does not.
#include "host/instrument/usb_update.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/unit/failure.hpp"

namespace umov::instrument {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;
using Devices = std::vector<UsbDeviceInfo>;

const UsbDeviceInfo one{"A1", "Umov", "/dev/bus/usb/001/002", true};
const UsbDeviceInfo one_again{"A1", "Umov", "/dev/bus/usb/001/009", true};
const UsbDeviceInfo other{"B2", "Umov", "/dev/bus/usb/001/003", true};
const UsbDeviceInfo closed{"", "", "/dev/bus/usb/001/004", false};

/// What is there at the first look, the second and so on; the last stays.
UsbListing seen(std::vector<Devices> looks) {
  return [looks = std::move(looks), look = std::size_t{0}]() mutable {
    return looks[std::min(look++, looks.size() - 1)];
  };
}

TEST(UsbUpdate, AControllerIsWaitedForUntilItMayBeOpened) {
  EXPECT_TRUE(wait_for_device(seen({{other}, {other, closed}, {other, one}}), "A1", 5s));
  EXPECT_FALSE(wait_for_device(seen({{other}}), "A1", 0s));
}

TEST(UsbUpdate, OneThatMayNotBeOpenedIsToldAsThat) {
  EXPECT_THAT(failure_of([] {
                wait_for_device(seen({{other, closed}}), "A1", 0s);
              }),
              HasSubstr("usb:A1: you may not open the controller at " + closed.node +
                        " (install the rule for udev"));
}

TEST(UsbUpdate, ANewControllerIsNoneThatWasPluggedInBefore) {
  EXPECT_EQ(wait_for_new_device(seen({{other}, {other, closed}, {one, other}}), {other}, 5s).serial,
            "A1");
  EXPECT_EQ(wait_for_new_device(seen({{one_again, other}}), {one}, 5s).serial, "B2")
      << "one that was plugged in again meanwhile is the same";
  EXPECT_THAT(failure_of([] { wait_for_new_device(seen({{other}}), {other}, 0s); }),
              HasSubstr("no controller is plugged in"));
  EXPECT_THAT(failure_of([] {
                wait_for_new_device(seen({{other, closed}}), {other}, 0s);
              }),
              HasSubstr("you may not open"));
  EXPECT_THAT(failure_of([] {
                wait_for_new_device(seen({{one, other}}), {}, 0s);
              }),
              HasSubstr("more than one controller"));
}

}  // namespace
}  // namespace umov::instrument
