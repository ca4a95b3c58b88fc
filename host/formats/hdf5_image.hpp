// HDF5 files as images in memory, with the C library's handles owned.
//
// A file is built in memory and put on disk in one step by the caller, behind a user block of 512
// bytes that carries the SHA-256 of what follows. A reader checks that sum before the HDF5 library
// sees a byte: that library is not made for damaged input.
#pragma once

#include <hdf5.h>

#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace umov::formats {

/// Owns one HDF5 identifier of any kind.
class Hdf5Handle {
 public:
  Hdf5Handle() = default;
  explicit Hdf5Handle(hid_t id) : id_(id) {}
  Hdf5Handle(Hdf5Handle&& other) noexcept : id_(std::exchange(other.id_, -1)) {}
  Hdf5Handle& operator=(Hdf5Handle&& other) noexcept;
  Hdf5Handle(const Hdf5Handle&) = delete;
  Hdf5Handle& operator=(const Hdf5Handle&) = delete;
  ~Hdf5Handle();
  hid_t get() const { return id_; }
  bool valid() const { return id_ >= 0; }

 private:
  hid_t id_ = -1;
};

/// Builds a file. Paths such as "/records/time_s"; groups are made as needed. Every failure of the
/// library throws umov::Error naming the path.
class Hdf5Builder {
 public:
  explicit Hdf5Builder(std::string name);
  void group(const std::string& path);
  void attribute(const std::string& object, const std::string& name, const std::string& text);
  void attribute(const std::string& object, const std::string& name,
                 const std::vector<std::string>& texts);
  /// One number is stored as a scalar.
  void attribute(const std::string& object, const std::string& name,
                 std::span<const double> numbers);
  void column(const std::string& path, std::span<const double> values, const std::string& unit);
  void column(const std::string& path, std::span<const std::int64_t> values,
              const std::string& unit);
  /// Stored in one byte each.
  void small_column(const std::string& path, std::span<const int> values, const std::string& unit);
  void column(const std::string& path, const std::vector<std::string>& texts);
  /// Row-major matrix [rows, columns].
  void matrix(const std::string& path, std::span<const double> values, std::size_t rows,
              std::size_t columns, const std::string& unit);
  /// Row-major array of any number of dimensions.
  void array(const std::string& path, std::span<const double> values,
             std::span<const std::size_t> shape, const std::string& unit);
  /// The whole file: user block and HDF5 image. Ends the building.
  std::string finish();

 private:
  void store(const std::string& path, std::span<const hsize_t> dimensions, hid_t file_type,
             hid_t memory_type, const void* values, const std::string& unit);
  hid_t check(hid_t result, const std::string& path) const;
  std::string name_;
  Hdf5Handle file_;
};

/// Reads a file from memory. Columns longer than 50 million entries are refused.
class Hdf5Reader {
 public:
  /// `bytes` must outlive nothing: they are copied into the library. Throws umov::Error for bytes
  /// that are no HDF5 file or whose user block's checksum differs.
  Hdf5Reader(std::string_view bytes, std::string name);
  bool has(const std::string& path) const;
  bool has_attribute(const std::string& name) const;     ///< of the root
  std::string attribute(const std::string& name) const;  ///< of the root; empty where absent
  std::vector<double> doubles(const std::string& path) const;
  std::vector<std::int64_t> integers(const std::string& path) const;
  std::vector<int> small_integers(const std::string& path) const;
  std::vector<std::string> texts(const std::string& path) const;
  /// Matrix [rows, columns], row by row.
  std::vector<double> matrix(const std::string& path, std::size_t& rows,
                             std::size_t& columns) const;
  /// Array of shape.size() dimensions, row-major; its lengths go to `shape`. An array that claims
  /// more numbers than the file's size can hold even when compressed is refused.
  std::vector<double> array(const std::string& path, std::span<std::size_t> shape) const;
  [[noreturn]] void fail(const std::string& path, const std::string& problem) const;

 private:
  Hdf5Handle open_dataset(const std::string& path, std::size_t rank,
                          std::vector<hsize_t>& dimensions) const;
  template <class T>
  std::vector<T> numbers(const std::string& path, std::size_t rank, hid_t memory_type,
                         H5T_class_t wanted, std::vector<hsize_t>& dimensions) const;
  std::string name_;
  std::size_t file_size_ = 0;
  Hdf5Handle file_;
};

/// True for bytes that start as an HDF5 file does, with or without the user block.
bool looks_like_hdf5(std::string_view bytes);

}  // namespace umov::formats
