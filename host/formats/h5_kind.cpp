#include "host/formats/h5_kind.hpp"

#include "host/formats/atomic_file.hpp"
#include "host/formats/hdf5_image.hpp"

namespace umov::formats {

H5Kind h5_kind(const std::filesystem::path& path) {
  const Hdf5Reader file(read_whole_file(path), path.string());
  const std::string format = file.attribute("format");
  if (format == "umov scan h5") return H5Kind::scan;
  if (format == "umov brdf h5") return H5Kind::brdf;
  return H5Kind::other;
}

}  // namespace umov::formats
