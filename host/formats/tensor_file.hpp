// Tensor files, the container of RGL's and Mitsuba's measured BSDFs: named arrays of numbers.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <vector>

namespace umov::formats {

enum class TensorType : std::uint8_t { u8 = 1, i8, u16, i16, u32, i32, u64, i64, f16, f32, f64 };

struct TensorField {
  std::string name;
  TensorType type = TensorType::u8;
  std::vector<std::size_t> shape;  ///< slowest first
  std::string_view bytes;          ///< of the file; as long as shape and type say
  std::size_t offset = 0;          ///< of the bytes in the file
  std::size_t count() const;       ///< numbers in the field
};

bool looks_like_tensor_file(std::string_view bytes);

/// Fields in the file's order, as views into `bytes`. Throws umov::Error with the byte for a file
/// that is cut off, a field outside the file, fields that together are longer than the file, a name
/// that stands twice, and bytes after the last field.
std::vector<TensorField> parse_tensor_file(std::string_view bytes, const std::string& name);

/// Collects fields and lays them out, each aligned to 8 bytes.
class TensorBuilder {
 public:
  void add(std::string name, std::vector<std::size_t> shape, std::span<const float> values);
  void add(std::string name, std::vector<std::size_t> shape, std::span<const std::uint8_t> values);
  void add(std::string name, std::string_view text);
  std::string finish() const;

 private:
  void add_bytes(std::string name, TensorType type, std::vector<std::size_t> shape,
                 const void* data, std::size_t size);
  std::vector<TensorField> fields_;
  std::vector<std::string> storage_;
};

}  // namespace umov::formats
