#include <cmath>
#include <cstring>
#include <map>

#include <fmt/format.h>

#include "host/errors/error.hpp"
#include "host/formats/rgl_tensor.hpp"
#include "host/formats/tensor_file.hpp"

namespace umov::formats {
namespace {

/// Fields of a file by name, with checks of type and number of dimensions.
class Fields {
 public:
  Fields(std::string_view bytes, std::string name) : name_(std::move(name)) {
    for (TensorField& field : parse_tensor_file(bytes, name_)) {
      std::string key = field.name;
      fields_.emplace(std::move(key), std::move(field));
    }
  }

  bool has(const std::string& key) const { return fields_.contains(key); }

  const TensorField& get(const std::string& key, TensorType type, std::size_t dimensions) const {
    const auto found = fields_.find(key);
    if (found == fields_.end()) fail(0, "there is no field `" + key + "`");
    const TensorField& field = found->second;
    if (field.type != type)
      fail(field.offset,
           fmt::format("field `{}` does not hold {}", key,
                       type == TensorType::f32 ? "32-bit floating-point numbers" : "bytes"));
    if (field.shape.size() != dimensions)
      fail(field.offset, fmt::format("field `{}` has {} dimensions, not {}", key,
                                     field.shape.size(), dimensions));
    return field;
  }

  std::vector<float> floats(const std::string& key, std::size_t dimensions) const {
    const TensorField& field = get(key, TensorType::f32, dimensions);
    std::vector<float> values(field.count());
    if (!values.empty()) std::memcpy(values.data(), field.bytes.data(), field.bytes.size());
    return values;
  }

  /// Length `dimension` of a field.
  std::size_t length(const std::string& key, std::size_t dimensions, std::size_t dimension) const {
    return get(key, TensorType::f32, dimensions).shape[dimension];
  }

  void require(const std::string& key, std::size_t dimensions, std::size_t dimension,
               std::size_t expected) const {
    const TensorField& field = get(key, TensorType::f32, dimensions);
    if (field.shape[dimension] != expected)
      fail(field.offset, fmt::format("field `{}` has length {} along dimension {}, not {}", key,
                                     field.shape[dimension], dimension + 1, expected));
  }

  std::size_t offset_of(const std::string& key, std::size_t entry) const {
    const auto found = fields_.find(key);
    if (found == fields_.end()) return 0;
    const std::size_t width = found->second.type == TensorType::f32 ? sizeof(float) : 1;
    return found->second.offset + width * entry;
  }

  [[noreturn]] void fail(std::size_t byte, const std::string& problem) const {
    throw Error(Place{name_}, fmt::format("byte {}: {}", byte, problem),
                "give an RGL tensor file with one isotropic BRDF");
  }

 private:
  std::string name_;
  std::map<std::string, TensorField> fields_;
};

}  // namespace

TablePtr read_rgl(std::string_view bytes, const std::string& name) {
  const Fields fields(bytes, name);
  RglData data;
  if (fields.has("description")) {
    data.description = fields.get("description", TensorType::u8, 1).bytes;
    data.description.erase(data.description.find_last_not_of('\0') + 1);
  }
  data.jacobian = false;
  for (const char byte : fields.get("jacobian", TensorType::u8, 1).bytes)
    data.jacobian = data.jacobian || byte != 0;
  data.phi_i = fields.floats("phi_i", 1);
  data.theta_i = fields.floats("theta_i", 1);
  const bool spectral = fields.has("spectra");
  if (spectral) data.wavelengths_nm = fields.floats("wavelengths", 1);
  if (spectral && data.wavelengths_nm.empty()) fields.fail(0, "field `wavelengths` is empty");
  const std::string values = spectral ? "spectra" : "rgb";
  data.resolution = fields.length(values, 5, 3);
  for (const std::string& key : {std::string("vndf"), std::string("luminance"), values}) {
    const std::size_t dimensions = key == values ? 5 : 4;
    fields.require(key, dimensions, 0, data.phi_i.size());
    fields.require(key, dimensions, 1, data.theta_i.size());
    if (key == "vndf") continue;
    fields.require(key, dimensions, dimensions - 2, data.resolution);
    fields.require(key, dimensions, dimensions - 1, data.resolution);
  }
  fields.require(values, 5, 2, data.channels());
  data.ndf_rows = fields.length("ndf", 2, 0);
  data.ndf_columns = fields.length("ndf", 2, 1);
  data.sigma_rows = fields.length("sigma", 2, 0);
  data.sigma_columns = fields.length("sigma", 2, 1);
  data.vndf_rows = fields.length("vndf", 4, 2);
  data.vndf_columns = fields.length("vndf", 4, 3);
  data.ndf = fields.floats("ndf", 2);
  data.sigma = fields.floats("sigma", 2);
  data.vndf = fields.floats("vndf", 4);
  data.luminance = fields.floats("luminance", 4);
  data.spectra = fields.floats(values, 5);
  if (fields.has("valid")) {
    const std::string_view bits = fields.get("valid", TensorType::u8, 1).bytes;
    data.valid.assign(bits.begin(), bits.end());
  }
  check_rgl(data, [&](const char* field, std::size_t entry, const std::string& problem) {
    const std::string key = std::string_view(field) == "spectra" ? values : field;
    fields.fail(fields.offset_of(key, entry),
                fmt::format("field `{}`, entry {}: {}", key, entry, problem));
  });
  return std::make_shared<RglTable>(std::move(data), name);
}

}  // namespace umov::formats
