// What the boot loader says of itself on USB: one interface in DFU mode, with two settings.
#pragma once

#include <array>
#include <span>

#include "firmware/boot/dfu_target.hpp"
#include "firmware/core/usb/descriptor_builder.hpp"
#include "firmware/core/usb/ms_os_20.hpp"
#include "firmware/core/usb/standard_requests.hpp"
#include "protocol/usb.hpp"

namespace umov::firmware::boot {

namespace string_index {
inline constexpr std::uint8_t manufacturer = 1;
inline constexpr std::uint8_t product = 2;
inline constexpr std::uint8_t serial = usb::serial_index;
inline constexpr std::uint8_t newer = 4;
inline constexpr std::uint8_t older_too = 5;
inline constexpr std::uint8_t no_image = DfuTarget::first_reason_string;
inline constexpr std::uint8_t wrong_board = no_image + 1;
inline constexpr std::uint8_t older = no_image + 2;
inline constexpr std::uint8_t damaged = no_image + 3;
inline constexpr std::uint8_t bad_signature = no_image + 4;
inline constexpr std::uint8_t flash_failed = no_image + 5;
inline constexpr std::uint8_t not_kept = no_image + 6;
inline constexpr std::uint8_t empty = no_image + 7;
inline constexpr std::uint8_t failed_trial = no_image + 8;
inline constexpr std::uint8_t worn_out = no_image + 9;
}  // namespace string_index

inline constexpr auto manufacturer_text = usb::string_descriptor("Umov");
inline constexpr auto product_text = usb::string_descriptor("Umov firmware update");
/// A boot loader that trusts the key which everybody has.
inline constexpr auto development_text =
    usb::string_descriptor("Umov firmware update (development key)");
inline constexpr auto newer_text = usb::string_descriptor("Umov image");
inline constexpr auto older_too_text = usb::string_descriptor("Umov image, older ones too");
inline constexpr auto no_image_text =
    usb::string_descriptor("the file is no image of a controller, or not all of it");
inline constexpr auto wrong_board_text = usb::string_descriptor("the image is for another board");
inline constexpr auto older_text =
    usb::string_descriptor("the image is older than the one that runs");
inline constexpr auto damaged_text = usb::string_descriptor("the image is damaged");
inline constexpr auto bad_signature_text =
    usb::string_descriptor("the image is not signed with the key of this board");
inline constexpr auto flash_failed_text = usb::string_descriptor("the flash memory fails");
inline constexpr auto not_kept_text =
    usb::string_descriptor("installed, but the image before it could not be kept: flash fails");
inline constexpr auto empty_text = usb::string_descriptor("there is no good image in it");
inline constexpr auto failed_trial_text =
    usb::string_descriptor("its image failed its trial, and there is none to go back to");
inline constexpr auto worn_out_text =
    usb::string_descriptor("the flash memory fails where the image belongs");
inline constexpr usb::Bytes<4> language_ids = {
    4, static_cast<std::uint8_t>(usb::DescriptorType::string), 0x09, 0x04};

inline constexpr usb::Bytes<18> device_descriptor = {
    18,
    static_cast<std::uint8_t>(usb::DescriptorType::device),
    0x10,
    0x02,  // USB 2.1: there is a BOS descriptor
    0,
    0,
    0,  // class: see the interface
    usb::max_packet_bytes,
    usb::low_byte(protocol::usb::vendor_id),
    usb::high_byte(protocol::usb::vendor_id),
    usb::low_byte(protocol::usb::update_product_id),
    usb::high_byte(protocol::usb::update_product_id),
    0x00,
    0x01,
    string_index::manufacturer,
    string_index::product,
    string_index::serial,
    1,
};

/// DFU 1.1, 4.2.3: class 254, subclass 1, protocol 2.
inline constexpr usb::InterfaceClass dfu_mode_class = {0xfe, 0x01, 0x02};
/// Downloads, uploads, answers after manifestation.
inline constexpr std::uint8_t dfu_attributes = 0x07;
inline constexpr usb::Bytes<9> dfu_descriptor =
    usb::dfu_functional(dfu_attributes, 1000, dfu::transfer_bytes);

/// Setting 0 refuses images older than the one that runs, setting 1 takes them.
inline constexpr auto configuration = [] {
  auto older_too = usb::interface_descriptor(0, 0, dfu_mode_class, string_index::older_too);
  older_too[3] = 1;  // bAlternateSetting
  auto all = usb::configuration_descriptor(
      usb::join(usb::interface_descriptor(0, 0, dfu_mode_class, string_index::newer), older_too,
                dfu_descriptor),
      0x40, 100);
  all[4] = 1;  // settings of one interface
  return all;
}();

/// Windows then uses WinUSB. A device that is no composite one has no subsets.
inline constexpr auto windows_descriptors = [] {
  constexpr std::size_t size = 10 + usb::ms_os_20::winusb.size();
  return usb::join(usb::ms_os_20::head(10, usb::ms_os_20::Type::set_header),
                   usb::ms_os_20::windows_version,
                   usb::Bytes<2>{usb::low_byte(size), usb::high_byte(size)}, usb::ms_os_20::winusb);
}();

inline constexpr auto bos_descriptor = [] {
  constexpr auto capability = usb::ms_os_20::platform_capability(windows_descriptors.size());
  constexpr std::size_t size = capability.size() + 5;
  return usb::join(usb::Bytes<5>{5, static_cast<std::uint8_t>(usb::DescriptorType::bos),
                                 usb::low_byte(size), usb::high_byte(size), 1},
                   capability);
}();

/// By index; the serial number is the device's own.
constexpr std::array<std::span<const std::uint8_t>, 16> strings_with(
    std::span<const std::uint8_t> product) {
  return {language_ids,       manufacturer_text, product,          {},         newer_text,
          older_too_text,     no_image_text,     wrong_board_text, older_text, damaged_text,
          bad_signature_text, flash_failed_text, not_kept_text,    empty_text, failed_trial_text,
          worn_out_text};
}
inline constexpr auto strings = strings_with(product_text);
inline constexpr auto development_strings = strings_with(development_text);
static_assert(strings.size() == string_index::worn_out + 1u &&
              strings[string_index::serial].empty());

inline constexpr usb::DescriptorTable descriptor_table = {device_descriptor, configuration,
                                                          bos_descriptor, strings};
inline constexpr usb::DescriptorTable development_table = {device_descriptor, configuration,
                                                           bos_descriptor, development_strings};

}  // namespace umov::firmware::boot
