// Where a file came from: root attributes of scan.h5 and brdf.h5.
#pragma once

#include <string>

namespace umov::formats {

/// Empty members are left out of the file.
struct Provenance {
  std::string program;        ///< name and version, "umov 0.1.0"
  std::string command;        ///< command line
  std::string created;        ///< UTC, ISO 8601; filled in at writing where empty
  std::string device;         ///< device name or id
  std::string firmware_hash;  ///< hash of the running firmware
  std::string role;           ///< sample, white, mirror or dark
  std::string settings;       ///< settings of the controller as text
  std::string plan;           ///< text of the plan (TOML)
};

/// Present time in UTC as "2024-05-01T12:00:00Z".
std::string utc_now();

}  // namespace umov::formats
