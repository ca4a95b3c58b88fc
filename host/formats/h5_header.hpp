// What scan.h5 and brdf.h5 have in common: provenance, header keys, checksums.
#pragma once

#include <set>
#include <string>
#include <utility>
#include <vector>

#include "host/formats/hdf5_image.hpp"
#include "host/formats/provenance.hpp"

namespace umov::formats {

using Keys = std::vector<std::pair<std::string, std::string>>;

/// Root attributes and /header. `format` is the file's own format name. Keys that `numbers` names
/// become numeric attributes; the others are text.
void write_h5_header(Hdf5Builder& file, const std::string& format, const Keys& keys,
                     const Provenance& provenance, const std::string& content_sha256,
                     const std::set<std::string>& numbers = {});

/// Checks the format, reads provenance (its checksum verified) and keys.
Provenance read_h5_header(const Hdf5Reader& file, const std::string& format, Keys& keys);

/// Throws umov::Error where the file carries a content checksum that is not `computed`.
void verify_h5_content(const Hdf5Reader& file, const std::string& computed);

/// Keys and values must be text that HDF5 keeps: no NUL. Throws umov::Error.
void check_storable(const Keys& keys, const std::string& name);

}  // namespace umov::formats
