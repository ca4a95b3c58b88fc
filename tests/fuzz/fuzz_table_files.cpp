// BRDF tables of other programs: MERL, RGL tensors, Zemax. Whatever the bytes, a reader either
// refuses them with umov::Error or yields a table that evaluates to finite numbers and goes through
// its own format unchanged.
//
// MERL files have one size only, some 35 MB; here its reader is asked for fewer cells.
// fuzz-link: umov_formats
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "host/errors/error.hpp"
#include "host/formats/merl.hpp"
#include "host/formats/rgl_tensor.hpp"
#include "host/formats/tensor_file.hpp"
#include "host/formats/zemax_bsdf.hpp"
#include "tests/fuzz/foreign_bytes.hpp"

namespace {

using namespace umov;
using namespace umov::formats;
using fuzz::require;

constexpr HalfAngleCells cells = {2, 3, 2};

const std::string& merl_original() {
  static const std::string bytes = [] {
    std::vector<double> values(3 * cells.count());
    for (std::size_t i = 0; i < values.size(); ++i)
      values[i] = i % 5 == 4 ? -1.0 : static_cast<double>(i);
    return merl_bytes(HalfAngleTable(cells, values, "original"), {}, cells);
  }();
  return bytes;
}

const std::string& rgl_original() {
  static const std::string bytes = [] {
    RglData d;
    d.description = "a";
    d.phi_i = {0.0f};
    d.theta_i = {0.1f, 1.0f};
    d.wavelengths_nm = {500.0f, 600.0f};
    d.ndf_rows = d.ndf_columns = d.sigma_rows = d.sigma_columns = 2;
    d.ndf = d.sigma = {1, 2, 3, 4};
    d.vndf_rows = 3, d.vndf_columns = 2;
    d.vndf = {0, 1, 2, 3, 4, 5, 6, 0, 0, 0, 1, 1};
    d.resolution = 2;
    d.luminance.assign(8, 1.0f);
    d.spectra = {1, 2, 3, 4, 5, 6, 7, 8, 8, 7, 6, 5, 4, 3, -2, 1};
    d.valid = {255};
    return rgl_bytes(d);
  }();
  return bytes;
}

constexpr std::string_view zemax_original =
    "# wavelength: 633 nm\nSource Measured\nSymmetry PlaneSymmetrical\nSpectralContent Monochrome\n"
    "ScatterType BRDF\nSampleRotation 1\n0\nAngleOfIncidence 2\n5 60\nScatterAzimuth 2\n0 180\n"
    "ScatterRadial 3\n0 20 90.5\nMonochrome\nDataBegin\nTIS .3\n1 2 3\n1e-2 5 6\nTIS 1\n7 8 9\n1 1 "
    "2\nDataEnd\n";

void evaluate(const brdf::Table& table) {
  for (const double theta_i : {0.0, 0.3, 1.5})
    for (const double theta_r : {-1.2, 0.0, 0.5, 1.57})
      for (const double phi : {-3.0, 0.0, 0.2, 2.0})
        for (const double um : {0.1, 0.55, 2.0}) {
          const double value = table.at(um, {theta_i, theta_r, phi})[0][0];
          // Numbers near the limits of their type may overflow in sums; they never turn to NaN
          // or negative.
          require(!std::isnan(value) && value >= 0.0);
        }
}

void read_one(std::size_t format, std::string_view bytes) {
  if (format == 0) {
    const auto table = parse_merl(bytes, "fuzz", cells);
    evaluate(*table);
    require(merl_bytes(*table, {}, cells) == bytes);
  } else if (format == 1) {
    looks_like_tensor_file(bytes);
    const TablePtr table = read_rgl(bytes, "fuzz");
    evaluate(*table);
    const std::string once = write_rgl(*table, {});
    require(write_rgl(*read_rgl(once, "again"), {}) == once);
  } else {
    looks_like_zemax(bytes);
    const TablePtr table = read_zemax(bytes, "fuzz");
    evaluate(*table);
    // Origins differ: comments are left out.
    const auto data_of = [](const std::string& text) { return text.substr(text.find("\nSource")); };
    const std::string once = write_zemax(*table, {});
    require(data_of(write_zemax(*read_zemax(once, "again"), {})) == data_of(once));
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::array<std::string_view, 3> originals{merl_original(), rgl_original(), zemax_original};
  const auto [format, bytes] = fuzz::foreign_bytes(originals, data, size);
  try {
    read_one(format, bytes);
  } catch (const Error&) {
  }
  return 0;
}
