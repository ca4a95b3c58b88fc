#include "host/calibrate/standard_file.hpp"

#include <fmt/format.h>

#include "host/calibrate/reference_file.hpp"
#include "host/errors/error.hpp"
#include "host/formats/scan_h5.hpp"
#include "host/formats/sha256.hpp"

namespace umov::calibrate {

StandardScan make_standard(formats::ScanTable scan, const std::filesystem::path& path,
                           const std::optional<std::filesystem::path>& reference_table) {
  if (const auto role = scan.key("role"); role && *role != "white")
    throw Error(Place{path.string()}, fmt::format("the scan's role is `{}`, not `white`", *role),
                "give a scan of a white standard");
  std::optional<std::filesystem::path> table = reference_table;
  if (!table)
    if (const auto named = scan.key("reference_brdf")) {
      const std::filesystem::path file = *named;
      table =
          file.is_absolute() || std::filesystem::exists(file) ? file : path.parent_path() / file;
    }
  StandardScan standard{scan,
                        table ? ReferenceStandard::from_table(read_reference_table(*table), scan)
                              : ReferenceStandard::from_keys(scan),
                        scan.key("sample").value_or(path.stem().string()),
                        formats::sha256_of_file(path)};
  return standard;
}

StandardScan read_standard(const std::filesystem::path& path,
                           const std::optional<std::filesystem::path>& reference_table) {
  return make_standard(formats::read_scan(path).table, path, reference_table);
}

}  // namespace umov::calibrate
