// What luminaires are described with: IES LM-63 and EULUMDAT distributions, Wavefront OBJ and STL
// meshes. Whatever the bytes, a reader either refuses them with umov::Error or yields numbers that
// can be used, and a distribution that goes through text of either format.
// fuzz-link: umov_formats
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

#include "host/errors/error.hpp"
#include "host/formats/mesh_file.hpp"
#include "host/formats/photometry.hpp"
#include "tests/fuzz/foreign_bytes.hpp"

namespace {

using namespace umov;
using namespace umov::formats;
using fuzz::require;
using namespace std::string_view_literals;

constexpr std::string_view ies =
    "IESNA:LM-63-2002\r\n[TEST] a\r\n[MANUFAC] b\r\n[LUMINAIRE] c\r\nTILT=NONE\r\n"
    "1 1000 1 3 3 1 2 -.1 .2 0\r\n1 1 10\r\n0 45 90\r\n0 45 90\r\n5 4 1\r\n5 3 1\r\n5 2 1\r\n";
constexpr std::string_view eulumdat =
    "maker\n3\n4\n4\n90\n3\n45\nreport\nname\nnumber\nfile\ndate\n100\n100\n50\n90\n90\n0\n0\n0\n0"
    "\n"
    "100\n80\n1\n0\n1\n1\nlamp\n1000\nwarm\n80\n10\n0\n0\n0\n0\n0\n0\n0\n0\n0\n0\n0\n90\n180\n270\n"
    "0\n45\n90\n300\n200\n10\n300\n150\n5\n";
constexpr std::string_view obj =
    "# a\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nvn 0 0 1\nf 1 3 2\nf 1/1 2/2 4/4\nf -4//1 -1//1 "
    "-2//1\nf 2 3 4\n";
constexpr std::string_view stl =
    "solid a\nfacet normal 0 0 1\nouter loop\nvertex 0 0 0\nvertex 1 0 0\nvertex 0 1 "
    "0\nendloop\nendfacet\nendsolid a\n";
constexpr std::string_view binary_stl =
    "12345678901234567890123456789012345678901234567890123456789012345678901234567890\1\0\0\0"
    "\0\0\0\0\0\0\0\0\0\0\x80\x3f\0\0\0\0\0\0\0\0\0\0\0\0\0\0\x80\x3f\0\0\0\0\0\0\0\0\0\0\0\0\0\0"
    "\x80\x3f\0\0\0\0\0\0"sv;
constexpr std::array<std::string_view, 5> originals{ies, eulumdat, obj, stl, binary_stl};

/// Written, read and written again: the same text, once candela have seven digits and what is
/// derived from them (a light output ratio) follows. A reader's limits on the number of angles are
/// narrower than what mirrored planes can come to, and EULUMDAT needs two angles.
void round_trip(const Photometry& p, std::string (*write)(const Photometry&),
                Photometry (*read)(std::string_view, const std::string&)) {
  if (p.c_deg.size() > 700 || p.gamma_deg.size() > 700 || p.gamma_deg.size() < 2) return;
  const std::string twice = write(read(write(p), "again"));
  require(write(read(twice, "a third time")) == twice);
}

void use(const Photometry& p) {
  require(p.candela.size() == p.c_deg.size() * p.gamma_deg.size());
  for (const double cd : p.candela) require(std::isfinite(cd) && cd >= 0.0);
  require(std::isfinite(p.intensity(77.0, 33.0)) && p.intensity(359.9, 180.0) >= 0.0);
  require(std::isfinite(p.zonal_lm()) && p.zonal_lm() >= 0.0);
  for (const double mm : {p.length_mm, p.width_mm, p.height_mm}) require(std::isfinite(mm));
  require(std::isfinite(p.lamp_lm) && p.lamp_lm >= 0.0 && std::isfinite(p.watts));
  round_trip(p, ies_text, parse_ies);
  round_trip(p, eulumdat_text, parse_eulumdat);
}

void use(const MeshFile& mesh) {
  require(!mesh.faces.empty());
  for (const auto& vertex : mesh.vertices)
    for (const float v : vertex) require(std::isfinite(v));
  for (const auto& face : mesh.faces)
    for (const std::uint32_t corner : face) require(corner < mesh.vertices.size());
  require(mesh.open_edges() <= 3 * mesh.faces.size());
}

/// Nothing where the bytes are refused; what is read must then stand everything.
template <class Read>
void try_with(Read read, const std::string& bytes) {
  std::optional<decltype(read(bytes, "fuzz"))> found;
  try {
    found = read(bytes, "fuzz");
  } catch (const Error&) {
    return;
  }
  use(*found);
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto [format, bytes] = fuzz::foreign_bytes(originals, data, size);
  switch (format) {
    case 0:
      try_with(parse_ies, bytes);
      break;
    case 1:
      try_with(parse_eulumdat, bytes);
      break;
    default:
      try_with(parse_mesh, bytes);
  }
  return 0;
}
