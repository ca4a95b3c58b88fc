#include "host/formats/hdf5_image.hpp"

#include <algorithm>
#include <atomic>
#include <limits>

#include "host/errors/error.hpp"
#include "host/formats/sha256.hpp"

namespace umov::formats {
namespace {

constexpr std::size_t user_block_size = 512;  // the smallest HDF5 permits
constexpr std::string_view user_block_start = "umov hdf5 file, sha256 of all bytes from 512 on: ";
constexpr std::string_view signature = "\x89HDF\r\n\x1a\n";
constexpr hsize_t most_entries = 50'000'000;
constexpr hsize_t chunk_entries = 65536;
constexpr double most_compression = 1100.0;  // deflate cannot exceed 1032 : 1
constexpr unsigned deflate_level = 3;

void silence_library() {
  // Every result is checked and thrown as an error of ours; the library's own traces go nowhere.
  static const herr_t once = H5Eset_auto2(H5E_DEFAULT, nullptr, nullptr);
  (void)once;
}

Hdf5Handle memory_access() {
  Hdf5Handle access(H5Pcreate(H5P_FILE_ACCESS));
  H5Pset_fapl_core(access.get(), 1 << 20, false);
  H5Pset_fclose_degree(access.get(), H5F_CLOSE_STRONG);
  return access;
}

Hdf5Handle text_type() {
  Hdf5Handle type(H5Tcopy(H5T_C_S1));
  H5Tset_size(type.get(), H5T_VARIABLE);
  H5Tset_cset(type.get(), H5T_CSET_UTF8);
  return type;
}

/// The core driver takes two images of one name for the same file.
std::string unique_name(const std::string& name) {
  static std::atomic<unsigned> opened = 0;
  return name + "#" + std::to_string(++opened);
}

std::vector<const char*> pointers(const std::vector<std::string>& texts) {
  std::vector<const char*> result;
  for (const std::string& text : texts) result.push_back(text.c_str());
  return result;
}

/// Reads strings from a dataset or attribute, whichever `read` and `reclaim` stand for.
template <class Read>
bool read_texts(hid_t type, hid_t space, std::size_t count, Read read,
                std::vector<std::string>& texts) {
  texts.clear();
  if (count == 0) return true;
  if (H5Tis_variable_str(type) > 0) {
    std::vector<char*> raw(count, nullptr);
    const Hdf5Handle memory = text_type();
    if (H5Tset_cset(memory.get(), H5Tget_cset(type)) < 0) return false;
    if (read(memory.get(), raw.data()) < 0) return false;
    for (const char* text : raw) texts.emplace_back(text == nullptr ? "" : text);
    return H5Dvlen_reclaim(memory.get(), space, H5P_DEFAULT, raw.data()) >= 0;
  }
  const std::size_t width = H5Tget_size(type);
  if (width == 0 || width > 1 << 20 || width * count > std::size_t{1} << 30) return false;
  std::string raw(width * count, '\0');
  if (read(type, raw.data()) < 0) return false;
  for (std::size_t i = 0; i < count; ++i) {
    const std::string_view field = std::string_view(raw).substr(i * width, width);
    texts.emplace_back(field.substr(0, field.find('\0')));
  }
  return true;
}

}  // namespace

Hdf5Handle& Hdf5Handle::operator=(Hdf5Handle&& other) noexcept {
  std::swap(id_, other.id_);
  return *this;
}

Hdf5Handle::~Hdf5Handle() {
  if (id_ < 0) return;
  // H5Idec_ref on a file only drops the reference; files must be closed as files.
  if (H5Iget_type(id_) == H5I_FILE) {
    H5Fclose(id_);
  } else {
    H5Idec_ref(id_);
  }
}

Hdf5Builder::Hdf5Builder(std::string name) : name_(std::move(name)) {
  silence_library();
  const Hdf5Handle access = memory_access();
  file_ = Hdf5Handle(
      check(H5Fcreate(unique_name(name_).c_str(), H5F_ACC_TRUNC, H5P_DEFAULT, access.get()), "/"));
}

hid_t Hdf5Builder::check(hid_t result, const std::string& path) const {
  if (result < 0)
    throw Error(Place{name_, 0, path}, "HDF5 cannot store this",
                "the memory may be short, or a name may be used twice");
  return result;
}

void Hdf5Builder::group(const std::string& path) {
  const Hdf5Handle made(
      check(H5Gcreate2(file_.get(), path.c_str(), H5P_DEFAULT, H5P_DEFAULT, H5P_DEFAULT), path));
}

void Hdf5Builder::attribute(const std::string& object, const std::string& name,
                            const std::string& text) {
  const Hdf5Handle owner(check(H5Oopen(file_.get(), object.c_str(), H5P_DEFAULT), object));
  const Hdf5Handle space(check(H5Screate(H5S_SCALAR), object));
  const Hdf5Handle type = text_type();
  const Hdf5Handle creation(check(H5Pcreate(H5P_ATTRIBUTE_CREATE), object));
  H5Pset_char_encoding(creation.get(), H5T_CSET_UTF8);
  const Hdf5Handle made(check(
      H5Acreate2(owner.get(), name.c_str(), type.get(), space.get(), creation.get(), H5P_DEFAULT),
      object + "@" + name));
  const char* value = text.c_str();
  check(H5Awrite(made.get(), type.get(), &value), object + "@" + name);
}

void Hdf5Builder::attribute(const std::string& object, const std::string& name,
                            const std::vector<std::string>& texts) {
  const Hdf5Handle owner(check(H5Oopen(file_.get(), object.c_str(), H5P_DEFAULT), object));
  const hsize_t size = texts.size();
  const Hdf5Handle space(check(H5Screate_simple(1, &size, nullptr), object));
  const Hdf5Handle type = text_type();
  const Hdf5Handle made(check(
      H5Acreate2(owner.get(), name.c_str(), type.get(), space.get(), H5P_DEFAULT, H5P_DEFAULT),
      object + "@" + name));
  check(H5Awrite(made.get(), type.get(), pointers(texts).data()), object + "@" + name);
}

void Hdf5Builder::attribute(const std::string& object, const std::string& name,
                            std::span<const double> numbers) {
  const Hdf5Handle owner(check(H5Oopen(file_.get(), object.c_str(), H5P_DEFAULT), object));
  const hsize_t size = numbers.size();
  const Hdf5Handle space(
      check(size == 1 ? H5Screate(H5S_SCALAR) : H5Screate_simple(1, &size, nullptr), object));
  const Hdf5Handle made(check(
      H5Acreate2(owner.get(), name.c_str(), H5T_IEEE_F64LE, space.get(), H5P_DEFAULT, H5P_DEFAULT),
      object + "@" + name));
  check(H5Awrite(made.get(), H5T_NATIVE_DOUBLE, numbers.data()), object + "@" + name);
}

void Hdf5Builder::store(const std::string& path, std::span<const hsize_t> dimensions,
                        hid_t file_type, hid_t memory_type, const void* values,
                        const std::string& unit) {
  const Hdf5Handle space(check(
      H5Screate_simple(static_cast<int>(dimensions.size()), dimensions.data(), nullptr), path));
  const Hdf5Handle creation(check(H5Pcreate(H5P_DATASET_CREATE), path));
  const hsize_t last = dimensions.back();
  if (H5Tget_class(file_type) != H5T_STRING && last >= 4096) {
    std::vector<hsize_t> chunk(dimensions.size(), 1);
    chunk.back() = std::min(last, chunk_entries);
    check(H5Pset_chunk(creation.get(), static_cast<int>(chunk.size()), chunk.data()), path);
    check(H5Pset_shuffle(creation.get()), path);
    check(H5Pset_deflate(creation.get(), deflate_level), path);
  } else if (dimensions.size() > 2 && H5Sget_simple_extent_npoints(space.get()) >= 4096) {
    std::vector<hsize_t> chunk(dimensions.size(), 1);
    hsize_t entries = 1;
    for (std::size_t d = chunk.size(); d-- > 0 && entries < chunk_entries;) {
      chunk[d] = std::min(dimensions[d], std::max<hsize_t>(chunk_entries / entries, 1));
      entries *= chunk[d];
    }
    check(H5Pset_chunk(creation.get(), static_cast<int>(chunk.size()), chunk.data()), path);
    check(H5Pset_shuffle(creation.get()), path);
    check(H5Pset_deflate(creation.get(), deflate_level), path);
  }
  const Hdf5Handle made(check(H5Dcreate2(file_.get(), path.c_str(), file_type, space.get(),
                                         H5P_DEFAULT, creation.get(), H5P_DEFAULT),
                              path));
  const hsize_t total = static_cast<hsize_t>(H5Sget_simple_extent_npoints(space.get()));
  if (total > 0)
    check(H5Dwrite(made.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values), path);
  if (!unit.empty()) attribute(path, "unit", unit);
}

void Hdf5Builder::column(const std::string& path, std::span<const double> values,
                         const std::string& unit) {
  const hsize_t size = values.size();
  store(path, {&size, 1}, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.data(), unit);
}

void Hdf5Builder::column(const std::string& path, std::span<const std::int64_t> values,
                         const std::string& unit) {
  const hsize_t size = values.size();
  store(path, {&size, 1}, H5T_STD_I64LE, H5T_NATIVE_INT64, values.data(), unit);
}

void Hdf5Builder::small_column(const std::string& path, std::span<const int> values,
                               const std::string& unit) {
  const hsize_t size = values.size();
  store(path, {&size, 1}, H5T_STD_I8LE, H5T_NATIVE_INT, values.data(), unit);
}

void Hdf5Builder::column(const std::string& path, const std::vector<std::string>& texts) {
  const hsize_t size = texts.size();
  const Hdf5Handle type = text_type();
  store(path, {&size, 1}, type.get(), type.get(), pointers(texts).data(), {});
}

void Hdf5Builder::matrix(const std::string& path, std::span<const double> values, std::size_t rows,
                         std::size_t columns, const std::string& unit) {
  const hsize_t size[2] = {rows, columns};
  store(path, size, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.data(), unit);
}

void Hdf5Builder::array(const std::string& path, std::span<const double> values,
                        std::span<const std::size_t> shape, const std::string& unit) {
  const std::vector<hsize_t> dimensions(shape.begin(), shape.end());
  store(path, dimensions, H5T_IEEE_F64LE, H5T_NATIVE_DOUBLE, values.data(), unit);
}

std::string Hdf5Builder::finish() {
  check(H5Fflush(file_.get(), H5F_SCOPE_GLOBAL), "/");
  const ssize_t size = H5Fget_file_image(file_.get(), nullptr, 0);
  check(size, "/");
  std::string bytes(user_block_size + static_cast<std::size_t>(size), '\0');
  check(H5Fget_file_image(file_.get(), bytes.data() + user_block_size,
                          static_cast<std::size_t>(size)),
        "/");
  file_ = Hdf5Handle();
  Sha256 hash;
  hash.update(std::string_view(bytes).substr(user_block_size));
  const std::string start = std::string(user_block_start) + hash.hex_digest() + "\n";
  std::copy(start.begin(), start.end(), bytes.begin());
  return bytes;
}

bool looks_like_hdf5(std::string_view bytes) {
  return bytes.starts_with(signature) || bytes.starts_with(user_block_start) ||
         (bytes.size() > user_block_size && bytes.substr(user_block_size).starts_with(signature));
}

Hdf5Reader::Hdf5Reader(std::string_view bytes, std::string name)
    : name_(std::move(name)), file_size_(bytes.size()) {
  silence_library();
  if (!looks_like_hdf5(bytes))
    throw Error(Place{name_}, "is not an HDF5 file", "give a file written by umov");
  if (!bytes.starts_with(signature)) {
    const std::string_view image = bytes.substr(std::min(bytes.size(), user_block_size));
    Sha256 hash;
    hash.update(image);
    const std::string expected = std::string(user_block_start) + hash.hex_digest() + "\n";
    if (!bytes.starts_with(expected))
      throw Error(Place{name_}, "the file is damaged or cut off: its checksum differs",
                  "restore it from a copy, or build it again from its source");
    bytes = image;
  }
  const Hdf5Handle access = memory_access();
  // The library takes a copy; it promises not to write to the buffer.
  if (H5Pset_file_image(access.get(), const_cast<char*>(bytes.data()), bytes.size()) < 0)
    throw Error(Place{name_}, "is too large to be read into memory", "free some memory");
  file_ = Hdf5Handle(H5Fopen(unique_name(name_).c_str(), H5F_ACC_RDONLY, access.get()));
  if (!file_.valid())
    throw Error(Place{name_}, "is not a readable HDF5 file: damaged or cut off",
                "restore it from a copy, or build it again from its source");
}

void Hdf5Reader::fail(const std::string& path, const std::string& problem) const {
  throw Error(Place{name_, 0, path}, problem, "the file was not written by umov, or is damaged");
}

bool Hdf5Reader::has(const std::string& path) const {
  // H5Lexists wants every step of the path to exist.
  for (std::size_t slash = path.find('/', 1); slash != std::string::npos;
       slash = path.find('/', slash + 1))
    if (H5Lexists(file_.get(), path.substr(0, slash).c_str(), H5P_DEFAULT) <= 0) return false;
  return H5Lexists(file_.get(), path.c_str(), H5P_DEFAULT) > 0;
}

bool Hdf5Reader::has_attribute(const std::string& name) const {
  return H5Aexists(file_.get(), name.c_str()) > 0;
}

std::string Hdf5Reader::attribute(const std::string& name) const {
  if (!has_attribute(name)) return {};
  const Hdf5Handle attribute(H5Aopen(file_.get(), name.c_str(), H5P_DEFAULT));
  const Hdf5Handle type(H5Aget_type(attribute.get()));
  const Hdf5Handle space(H5Aget_space(attribute.get()));
  std::vector<std::string> texts;
  if (!attribute.valid() || H5Tget_class(type.get()) != H5T_STRING ||
      H5Sget_simple_extent_npoints(space.get()) != 1 ||
      !read_texts(
          type.get(), space.get(), 1,
          [&](hid_t memory, void* out) { return H5Aread(attribute.get(), memory, out); }, texts))
    fail("/@" + name, "the attribute is not one text");
  return texts.front();
}

Hdf5Handle Hdf5Reader::open_dataset(const std::string& path, std::size_t rank,
                                    std::vector<hsize_t>& dimensions) const {
  if (!has(path)) fail(path, "the dataset is missing");
  Hdf5Handle dataset(H5Dopen2(file_.get(), path.c_str(), H5P_DEFAULT));
  if (!dataset.valid()) fail(path, "is not a dataset");
  const Hdf5Handle space(H5Dget_space(dataset.get()));
  if (H5Sget_simple_extent_ndims(space.get()) != static_cast<int>(rank))
    fail(path, "does not have " + std::to_string(rank) + " dimensions");
  dimensions.assign(rank, 0);
  H5Sget_simple_extent_dims(space.get(), dimensions.data(), nullptr);
  hsize_t total = 1;
  for (const hsize_t size : dimensions) {
    if (size > most_entries || total * size > 20 * most_entries)
      fail(path, "claims " + std::to_string(size) + " entries, more than any scan has");
    total *= size;
  }
  return dataset;
}

template <class T>
std::vector<T> Hdf5Reader::numbers(const std::string& path, std::size_t rank, hid_t memory_type,
                                   H5T_class_t wanted, std::vector<hsize_t>& dimensions) const {
  const Hdf5Handle dataset = open_dataset(path, rank, dimensions);
  const Hdf5Handle type(H5Dget_type(dataset.get()));
  const H5T_class_t found = H5Tget_class(type.get());
  // Another program may store whole numbers where doubles are expected, never the other way round.
  if (found != wanted && !(wanted == H5T_FLOAT && found == H5T_INTEGER))
    fail(path, "is not a dataset of numbers of the right kind");
  std::size_t total = 1;
  for (const hsize_t size : dimensions) total *= static_cast<std::size_t>(size);
  std::vector<T> values(total);
  if (total > 0 &&
      H5Dread(dataset.get(), memory_type, H5S_ALL, H5S_ALL, H5P_DEFAULT, values.data()) < 0)
    fail(path, "cannot be read");
  return values;
}

std::vector<double> Hdf5Reader::doubles(const std::string& path) const {
  std::vector<hsize_t> dimensions;
  return numbers<double>(path, 1, H5T_NATIVE_DOUBLE, H5T_FLOAT, dimensions);
}

std::vector<std::int64_t> Hdf5Reader::integers(const std::string& path) const {
  std::vector<hsize_t> dimensions;
  return numbers<std::int64_t>(path, 1, H5T_NATIVE_INT64, H5T_INTEGER, dimensions);
}

std::vector<int> Hdf5Reader::small_integers(const std::string& path) const {
  std::vector<hsize_t> dimensions;
  return numbers<int>(path, 1, H5T_NATIVE_INT, H5T_INTEGER, dimensions);
}

std::vector<double> Hdf5Reader::matrix(const std::string& path, std::size_t& rows,
                                       std::size_t& columns) const {
  std::vector<hsize_t> dimensions;
  std::vector<double> values = numbers<double>(path, 2, H5T_NATIVE_DOUBLE, H5T_FLOAT, dimensions);
  rows = static_cast<std::size_t>(dimensions[0]);
  columns = static_cast<std::size_t>(dimensions[1]);
  return values;
}

std::vector<double> Hdf5Reader::array(const std::string& path, std::span<std::size_t> shape) const {
  std::vector<hsize_t> dimensions;
  open_dataset(path, shape.size(), dimensions);
  double total = sizeof(double);
  for (const hsize_t size : dimensions) total *= static_cast<double>(size);
  if (total > most_compression * static_cast<double>(file_size_))
    fail(path, "claims more numbers than the file has room for");
  std::vector<double> values =
      numbers<double>(path, shape.size(), H5T_NATIVE_DOUBLE, H5T_FLOAT, dimensions);
  std::transform(dimensions.begin(), dimensions.end(), shape.begin(),
                 [](hsize_t size) { return static_cast<std::size_t>(size); });
  return values;
}

std::vector<std::string> Hdf5Reader::texts(const std::string& path) const {
  std::vector<hsize_t> dimensions;
  const Hdf5Handle dataset = open_dataset(path, 1, dimensions);
  const Hdf5Handle type(H5Dget_type(dataset.get()));
  const Hdf5Handle space(H5Dget_space(dataset.get()));
  std::vector<std::string> texts;
  if (H5Tget_class(type.get()) != H5T_STRING ||
      !read_texts(
          type.get(), space.get(), static_cast<std::size_t>(dimensions[0]),
          [&](hid_t memory, void* out) {
            return H5Dread(dataset.get(), memory, H5S_ALL, H5S_ALL, H5P_DEFAULT, out);
          },
          texts))
    fail(path, "is not a readable dataset of texts");
  return texts;
}

}  // namespace umov::formats
