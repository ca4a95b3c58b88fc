#include "host/formats/h5_kind.hpp"

#include "host/formats/atomic_file.hpp"
#include "host/formats/hdf5_image.hpp"

namespace umov::formats {

H5Kind h5_kind(const std::filesystem::path& path) {
  return h5_kind(read_whole_file(path), path.string());
}

H5Kind h5_kind(std::string_view bytes, const std::string& name) {
  const Hdf5Reader file(bytes, name);
  const std::string format = file.attribute("format");
  if (format == "umov scan h5") return H5Kind::scan;
  if (format == "umov brdf h5") return H5Kind::brdf;
  if (format == "umov table h5") return H5Kind::table;
  if (format == "umov sim h5") return H5Kind::sim;
  return H5Kind::other;
}

}  // namespace umov::formats
