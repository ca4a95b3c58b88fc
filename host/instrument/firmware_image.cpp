#include "host/instrument/firmware_image.hpp"

#include <fcntl.h>
#include <sodium.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <charconv>
#include <cstring>
#include <fstream>
#include <iterator>

#include "host/errors/error.hpp"
#include "protocol/usb.hpp"

namespace umov::instrument {
namespace {

using protocol::ImageHeader;

constexpr std::size_t suffix_bytes = 16;
constexpr const char* image_remedy =
    "give umov-BOARD.bin or .dfu of a firmware build (cmake --build --preset firmware)";

void start_sodium() {
  if (sodium_init() < 0) {
    throw Error("libsodium can't be started", "check the installation of libsodium");
  }
}

/// CRC-32 of IEEE 802.3 without its final inversion, as DFU 1.1, appendix B has it.
std::uint32_t suffix_crc(std::span<const std::uint8_t> bytes) {
  std::uint32_t crc = 0xFFFF'FFFF;
  for (const std::uint8_t byte : bytes) {
    crc ^= byte;
    for (int bit = 0; bit < 8; ++bit) crc = crc >> 1 ^ ((crc & 1u) != 0 ? 0xEDB8'8320u : 0u);
  }
  return crc;
}

std::uint32_t u32_at(std::span<const std::uint8_t> bytes, std::size_t at) {
  return bytes[at] | static_cast<std::uint32_t>(bytes[at + 1]) << 8 |
         static_cast<std::uint32_t>(bytes[at + 2]) << 16 |
         static_cast<std::uint32_t>(bytes[at + 3]) << 24;
}

/// Takes the suffix off, if there is one.
void strip_suffix(const std::string& path, std::vector<std::uint8_t>& bytes) {
  if (bytes.size() < suffix_bytes) return;
  const std::size_t at = bytes.size() - suffix_bytes;
  if (std::memcmp(bytes.data() + at + 8, "UFD", 3) != 0) return;
  const std::span<const std::uint8_t> all(bytes);
  if (suffix_crc(all.first(bytes.size() - 4)) != u32_at(all, bytes.size() - 4)) {
    throw Error(Place{.file = path}, "the CRC of the DFU file is wrong", "fetch or build it again");
  }
  bytes.resize(at);
}

std::vector<std::uint8_t> signed_part(const FirmwareImage& image) {
  std::vector<std::uint8_t> message(ImageHeader::signed_bytes + image.header.program_bytes);
  std::copy_n(image.bytes.begin(), ImageHeader::signed_bytes, message.begin());
  std::copy_n(image.bytes.begin() + ImageHeader::bytes, image.header.program_bytes,
              message.begin() + ImageHeader::signed_bytes);
  return message;
}

}  // namespace

FirmwareImage read_firmware_image(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  if (!file) throw Error(Place{.file = path}, "can't be read", image_remedy);
  FirmwareImage image;
  image.bytes.assign(std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>());
  strip_suffix(path, image.bytes);
  if (!protocol::read_image_header(image.bytes, image.header)) {
    throw Error(Place{.file = path}, "no image of a controller's program", image_remedy);
  }
  if (image.bytes.size() != image.header.image_bytes()) {
    throw Error(Place{.file = path},
                "the image has " + std::to_string(image.bytes.size()) + " bytes, its header says " +
                    std::to_string(image.header.image_bytes()),
                "fetch or build it again");
  }
  if (protocol::crc32c(std::span<const std::uint8_t>(image.bytes).subspan(ImageHeader::bytes)) !=
      image.header.program_crc) {
    throw Error(Place{.file = path}, "the image is damaged: its CRC is wrong",
                "fetch or build it again");
  }
  return image;
}

std::string version_text(std::uint32_t version) {
  return std::to_string(version >> 16) + "." + std::to_string(version >> 8 & 0xFFu) + "." +
         std::to_string(version & 0xFFu);
}

std::uint32_t version_from_text(const std::string& text) {
  std::array<unsigned, 3> parts{};
  const char* at = text.data();
  const char* const end = at + text.size();
  bool good = true;
  for (std::size_t i = 0; i < parts.size() && good; ++i) {
    const auto [last, error] = std::from_chars(at, end, parts[i]);
    good = error == std::errc() && parts[i] <= (i == 0 ? 0xFFFFu : 0xFFu) &&
           (i == 2 ? last == end : last != end && *last == '.');
    at = good && i < 2 ? last + 1 : last;
  }
  if (!good) throw Error("'" + text + "' is no version", "write for instance 0.2.0");
  return protocol::image_version(parts[0], parts[1], parts[2]);
}

KeySeed read_key(const std::string& path) {
  std::ifstream file(path);
  const char* remedy =
      "a key file has a line \"seed = \" and 64 hexadecimal digits; make one with "
      "umov device key FILE";
  if (!file) throw Error(Place{.file = path}, "can't be read", remedy);
  std::string line;
  for (std::size_t number = 1; std::getline(file, line); ++number) {
    if (line.empty() || line[0] == '#') continue;
    constexpr std::string_view start = "seed = ";
    KeySeed seed{};
    std::size_t size = 0;
    const char* digits_end = nullptr;
    if (!line.starts_with(start) ||
        sodium_hex2bin(seed.data(), seed.size(), line.data() + start.size(),
                       line.size() - start.size(), nullptr, &size, &digits_end) != 0 ||
        size != seed.size() || digits_end != line.data() + line.size()) {
      throw Error(Place{.file = path, .line = number}, "this is no key", remedy);
    }
    return seed;
  }
  throw Error(Place{.file = path}, "no key in this file", remedy);
}

void make_key(const std::string& path) {
  start_sodium();
  KeySeed seed;
  randombytes_buf(seed.data(), seed.size());
  std::array<char, 2 * 32 + 1> hex{};
  sodium_bin2hex(hex.data(), hex.size(), seed.data(), seed.size());
  const std::string text =
      "# A key that signs programs for controllers. Whoever has it can make controllers run "
      "anything\n"
      "# that were built to trust it: keep it to yourself, and keep a copy.\nseed = " +
      std::string(hex.data()) + "\n";
  const int descriptor = ::open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  const bool written = descriptor >= 0 && ::write(descriptor, text.data(), text.size()) ==
                                              static_cast<ssize_t>(text.size());
  const int error = errno;
  if (descriptor >= 0) ::close(descriptor);
  if (!written) {
    throw Error(Place{.file = path}, std::string("can't be written: ") + std::strerror(error),
                error == EEXIST ? "a key is never overwritten: give another name"
                                : "give a file that can be made");
  }
}

std::array<std::uint8_t, 32> public_key(const KeySeed& seed) {
  start_sodium();
  std::array<std::uint8_t, 32> key;
  std::array<std::uint8_t, 64> secret;
  crypto_sign_seed_keypair(key.data(), secret.data(), seed.data());
  return key;
}

void sign_image(FirmwareImage& image, const KeySeed& seed) {
  start_sodium();
  protocol::write_image_header(image.header, image.bytes);
  std::array<std::uint8_t, 32> key;
  std::array<std::uint8_t, 64> secret;
  crypto_sign_seed_keypair(key.data(), secret.data(), seed.data());
  const auto message = signed_part(image);
  crypto_sign_detached(image.header.signature.data(), nullptr, message.data(), message.size(),
                       secret.data());
  protocol::write_image_header(image.header, image.bytes);
}

bool signed_by(const FirmwareImage& image, const std::array<std::uint8_t, 32>& key) {
  start_sodium();
  const auto message = signed_part(image);
  return crypto_sign_verify_detached(image.header.signature.data(), message.data(), message.size(),
                                     key.data()) == 0;
}

std::vector<std::uint8_t> with_dfu_suffix(std::span<const std::uint8_t> image) {
  namespace usb = protocol::usb;
  std::vector<std::uint8_t> file(image.begin(), image.end());
  const auto u16 = [&](std::uint16_t value) {
    file.push_back(static_cast<std::uint8_t>(value));
    file.push_back(static_cast<std::uint8_t>(value >> 8));
  };
  u16(0xFFFF);  // any release of the device
  u16(usb::update_product_id);
  u16(usb::vendor_id);
  u16(0x0100);
  for (const char c : {'U', 'F', 'D'}) file.push_back(static_cast<std::uint8_t>(c));
  file.push_back(suffix_bytes);
  const std::uint32_t crc = suffix_crc(file);
  for (int i = 0; i < 4; ++i) file.push_back(static_cast<std::uint8_t>(crc >> 8 * i));
  return file;
}

}  // namespace umov::instrument
