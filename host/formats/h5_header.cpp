#include "host/formats/h5_header.hpp"

#include <array>
#include <ctime>
#include <set>
#include <span>

#include "host/errors/error.hpp"
#include "host/formats/content_hash.hpp"
#include "host/formats/decimal.hpp"

namespace umov::formats {
namespace {

struct ProvenanceField {
  const char* attribute;
  std::string Provenance::*member;
};

constexpr std::array<ProvenanceField, 8> provenance_fields = {{
    {"program", &Provenance::program},
    {"command", &Provenance::command},
    {"created", &Provenance::created},
    {"device", &Provenance::device},
    {"firmware_hash", &Provenance::firmware_hash},
    {"role", &Provenance::role},
    {"settings", &Provenance::settings},
    {"plan", &Provenance::plan},
}};

}  // namespace

std::string utc_now() {
  const std::time_t now = std::time(nullptr);
  std::tm utc{};
  gmtime_r(&now, &utc);
  std::array<char, 32> text;
  const std::size_t size = std::strftime(text.data(), text.size(), "%Y-%m-%dT%H:%M:%SZ", &utc);
  return std::string(text.data(), size);
}

void check_storable(const Keys& keys, const std::string& name) {
  for (const auto& [key, value] : keys)
    if (key.empty() || (key + value).find('\0') != std::string::npos)
      throw Error(Place{name}, "a header key is empty or holds a NUL byte",
                  "keys and values are plain text");
}

void write_h5_header(Hdf5Builder& file, const std::string& format, const Keys& keys,
                     const Provenance& provenance, const std::string& content_sha256,
                     const std::set<std::string>& numbers) {
  Provenance complete = provenance;
  if (complete.created.empty()) complete.created = utc_now();
  for (const auto& [key, value] : keys) {
    if (key == "device" && complete.device.empty()) complete.device = value;
    if (key == "role" && complete.role.empty()) complete.role = value;
  }
  std::set<std::string> taken = {"format", "content_sha256", "provenance_sha256"};
  file.attribute("/", "format", format);
  file.attribute("/", "content_sha256", content_sha256);
  file.attribute("/", "provenance_sha256", provenance_sha256(complete));
  for (const ProvenanceField& field : provenance_fields) {
    taken.insert(field.attribute);
    if (const std::string& value = complete.*field.member; !value.empty())
      file.attribute("/", field.attribute, value);
  }
  // Copies for readers that look at attributes; /header is what counts, it keeps order and doubles.
  std::vector<std::string> names, values;
  for (const auto& [key, value] : keys) {
    double number = 0.0;
    if (taken.insert(key).second) {
      if (numbers.contains(key) && read_decimal(value, number) == nullptr) {
        file.attribute("/", key, std::span<const double>(&number, 1));
      } else {
        file.attribute("/", key, value);
      }
    }
    names.push_back(key);
    values.push_back(value);
  }
  file.group("/header");
  file.column("/header/key", names);
  file.column("/header/value", values);
}

Provenance read_h5_header(const Hdf5Reader& file, const std::string& format, Keys& keys) {
  const std::string found = file.attribute("format");
  if (found != format)
    file.fail("/@format", found.empty() ? "the file does not say what it is"
                                        : "the file is \"" + found + "\", not \"" + format + "\"");
  Provenance provenance;
  for (const ProvenanceField& field : provenance_fields)
    provenance.*field.member = file.attribute(field.attribute);
  if (file.has_attribute("provenance_sha256") &&
      file.attribute("provenance_sha256") != provenance_sha256(provenance))
    file.fail("/@provenance_sha256", "the provenance was changed: its checksum differs");
  keys.clear();
  if (file.has("/header")) {
    const std::vector<std::string> names = file.texts("/header/key");
    const std::vector<std::string> values = file.texts("/header/value");
    if (names.size() != values.size()) file.fail("/header", "keys and values differ in number");
    for (std::size_t i = 0; i < names.size(); ++i) keys.emplace_back(names[i], values[i]);
  }
  return provenance;
}

void verify_h5_content(const Hdf5Reader& file, const std::string& computed) {
  if (file.has_attribute("content_sha256") && file.attribute("content_sha256") != computed)
    file.fail("/@content_sha256", "the data were changed: their checksum differs");
}

}  // namespace umov::formats
