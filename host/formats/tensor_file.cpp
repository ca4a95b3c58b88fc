#include "host/formats/tensor_file.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include <fmt/format.h>

#include "host/errors/error.hpp"

namespace umov::formats {
namespace {

static_assert(std::endian::native == std::endian::little, "tensor files are little-endian");

constexpr std::string_view magic("tensor_file\0", 12);
constexpr std::size_t most_dimensions = 16;
constexpr std::size_t alignment = 8;

std::size_t size_of(TensorType type) {
  switch (type) {
    case TensorType::u8:
    case TensorType::i8:
      return 1;
    case TensorType::u16:
    case TensorType::i16:
    case TensorType::f16:
      return 2;
    case TensorType::u32:
    case TensorType::i32:
    case TensorType::f32:
      return 4;
    case TensorType::u64:
    case TensorType::i64:
    case TensorType::f64:
      return 8;
  }
  return 0;
}

/// Takes little-endian numbers off a file.
class Bytes {
 public:
  Bytes(std::string_view bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

  std::string_view take(std::size_t size, const char* what) {
    if (size > bytes_.size() - at_)
      fail(at_, fmt::format("the file ends at byte {} within {}", bytes_.size(), what));
    at_ += size;
    return bytes_.substr(at_ - size, size);
  }
  template <class T>
  T number(const char* what) {
    T value;
    std::memcpy(&value, take(sizeof value, what).data(), sizeof value);
    return value;
  }
  std::size_t at() const { return at_; }
  [[noreturn]] void fail(std::size_t byte, const std::string& problem) const {
    throw Error(Place{name_}, fmt::format("byte {}: {}", byte, problem),
                "give a whole tensor file, version 1.0");
  }

 private:
  std::string_view bytes_;
  std::string name_;
  std::size_t at_ = 0;
};

template <class T>
void append(std::string& out, T value) {
  out.append(reinterpret_cast<const char*>(&value), sizeof value);
}

}  // namespace

std::size_t TensorField::count() const {
  return bytes.size() / size_of(type);
}

bool looks_like_tensor_file(std::string_view bytes) {
  return bytes.starts_with(magic);
}

std::vector<TensorField> parse_tensor_file(std::string_view bytes, const std::string& name) {
  Bytes file(bytes, name);
  if (!looks_like_tensor_file(bytes)) file.fail(0, "does not start with 'tensor_file'");
  file.take(magic.size(), "the signature");
  const auto major = file.number<std::uint8_t>("the version");
  const auto minor = file.number<std::uint8_t>("the version");
  if (major != 1 || minor != 0)
    file.fail(magic.size(), fmt::format("version {}.{} is not 1.0", major, minor));
  const auto count = file.number<std::uint32_t>("the number of fields");
  std::vector<TensorField> fields;
  std::size_t total = 0;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::size_t start = file.at();
    TensorField field;
    field.name = file.take(file.number<std::uint16_t>("a name's length"), "a field's name");
    const auto dimensions = file.number<std::uint16_t>("a number of dimensions");
    const auto type = file.number<std::uint8_t>("a field's type");
    const auto offset = file.number<std::uint64_t>("a field's offset");
    if (type < 1 || type > static_cast<std::uint8_t>(TensorType::f64))
      file.fail(start, fmt::format("field {} has the unknown type {}", i + 1, type));
    if (dimensions > most_dimensions)
      file.fail(start, fmt::format("field {} claims {} dimensions", i + 1, dimensions));
    field.type = static_cast<TensorType>(type);
    std::size_t size = size_of(field.type);
    for (std::uint16_t d = 0; d < dimensions; ++d) {
      const auto length = file.number<std::uint64_t>("a field's shape");
      // size stays at most the file's size, so that the product cannot wrap round.
      if (length != 0 && size > bytes.size() / length)
        file.fail(start,
                  fmt::format("field {} claims more numbers than the file has room for", i + 1));
      size *= static_cast<std::size_t>(length);
      field.shape.push_back(static_cast<std::size_t>(length));
    }
    if (offset > bytes.size() || size > bytes.size() - offset)
      file.fail(start, fmt::format("field {} of {} bytes at byte {} reaches beyond the end", i + 1,
                                   size, offset));
    field.offset = static_cast<std::size_t>(offset);
    field.bytes = bytes.substr(field.offset, size);
    total += size;
    if (total > bytes.size()) file.fail(start, "the fields are together longer than the file");
    if (std::any_of(fields.begin(), fields.end(),
                    [&](const TensorField& other) { return other.name == field.name; }))
      file.fail(start, fmt::format("field {} has the name of another", i + 1));
    fields.push_back(std::move(field));
    if (fields.size() > 256) file.fail(start, "more than 256 fields");
  }
  std::size_t end = file.at();
  for (const TensorField& field : fields) end = std::max(end, field.offset + field.bytes.size());
  // Some writers fill up to the alignment behind the last field too.
  const std::string_view rest = bytes.substr(end);
  if (rest.size() >= alignment || rest.find_first_not_of('\0') != std::string_view::npos)
    file.fail(end, fmt::format("{} bytes follow the last field", rest.size()));
  return fields;
}

void TensorBuilder::add_bytes(std::string name, TensorType type, std::vector<std::size_t> shape,
                              const void* data, std::size_t size) {
  fields_.push_back({std::move(name), type, std::move(shape), {}, 0});
  storage_.emplace_back(static_cast<const char*>(data), size);
}

void TensorBuilder::add(std::string name, std::vector<std::size_t> shape,
                        std::span<const float> values) {
  add_bytes(std::move(name), TensorType::f32, std::move(shape), values.data(), values.size_bytes());
}

void TensorBuilder::add(std::string name, std::vector<std::size_t> shape,
                        std::span<const std::uint8_t> values) {
  add_bytes(std::move(name), TensorType::u8, std::move(shape), values.data(), values.size());
}

void TensorBuilder::add(std::string name, std::string_view text) {
  add_bytes(std::move(name), TensorType::u8, {text.size()}, text.data(), text.size());
}

std::string TensorBuilder::finish() const {
  std::size_t end = magic.size() + 2 + sizeof(std::uint32_t);
  for (const TensorField& field : fields_)
    end += 2 + field.name.size() + 2 + 1 + 8 + 8 * field.shape.size();
  std::vector<std::size_t> offsets;
  for (const std::string& data : storage_) {
    end = (end + alignment - 1) / alignment * alignment;
    offsets.push_back(end);
    end += data.size();
  }
  std::string out(magic);
  out += '\1';
  out += '\0';
  append(out, static_cast<std::uint32_t>(fields_.size()));
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    const TensorField& field = fields_[i];
    append(out, static_cast<std::uint16_t>(field.name.size()));
    out += field.name;
    append(out, static_cast<std::uint16_t>(field.shape.size()));
    append(out, static_cast<std::uint8_t>(field.type));
    append(out, static_cast<std::uint64_t>(offsets[i]));
    for (const std::size_t length : field.shape) append(out, static_cast<std::uint64_t>(length));
  }
  for (std::size_t i = 0; i < fields_.size(); ++i) {
    out.resize(offsets[i], '\0');
    out += storage_[i];
  }
  return out;
}

}  // namespace umov::formats
