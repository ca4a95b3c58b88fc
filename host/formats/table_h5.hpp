// The toolkit's own table file, format "umov table h5": docs/formats/table_h5.md.
#pragma once

#include <filesystem>
#include <string>
#include <string_view>

#include "host/formats/h5_header.hpp"
#include "host/formats/table_file.hpp"

namespace umov::formats {

bool looks_like_table_h5(std::string_view bytes);

struct TableH5 {
  TablePtr table;
  Keys keys;  ///< what the file says about itself in words
  Provenance provenance;
};

/// Throws umov::Error with the HDF5 path.
TableH5 parse_table_h5(std::string_view bytes, const std::string& name);
TablePtr read_table_h5(std::string_view bytes, const std::string& name);

/// Tables of host/brdf and of the readers of this folder keep their own sampling, so that they come
/// back number by number. Any other table (a model, say) is sampled on dense_grid().
std::string write_table_h5(const brdf::Table& table, const TableWriting& writing);
std::string table_h5_bytes(const brdf::Table& table, const TableWriting& writing,
                           const Provenance& provenance);

/// SHA-256 of the data alone: layout, axes, values.
std::string content_sha256(const brdf::Table& table);

}  // namespace umov::formats
