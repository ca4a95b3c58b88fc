// Meshes of modelling programs.
#include <gtest/gtest.h>

#include <cstring>

#include "host/formats/mesh_file.hpp"
#include "tests/unit/failure.hpp"

namespace umov::formats {
namespace {

const std::string tetrahedron =
    "# four faces\nv 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\n"
    "f 1 3 2\nf 1 2 4\nf 1/1/1 4/2/1 3/3/1\nf -3 -2 -1\n";

std::string binary_stl(const MeshFile& mesh) {
  std::string out(80, ' ');
  const auto count = static_cast<std::uint32_t>(mesh.faces.size());
  out.append(reinterpret_cast<const char*>(&count), 4);
  for (const auto& face : mesh.faces) {
    out.append(12, '\0');
    for (const std::uint32_t v : face)
      out.append(reinterpret_cast<const char*>(mesh.vertices[v].data()), 12);
    out.append(2, '\0');
  }
  return out;
}

TEST(MeshFile, AClosedBodyHasNoOpenEdgeInAnyFormat) {
  const MeshFile obj = parse_mesh(tetrahedron, "t.obj");
  EXPECT_EQ(obj.faces.size(), 4U);
  EXPECT_EQ(obj.open_edges(), 0U);
  const MeshFile stl = parse_mesh(binary_stl(obj), "t.stl");
  EXPECT_EQ(stl.faces.size(), 4U);
  EXPECT_EQ(stl.open_edges(), 0U);
}

TEST(MeshFile, AMissingOrTurnedFaceOpensEdges) {
  MeshFile mesh = parse_mesh(tetrahedron, "t.obj");
  std::swap(mesh.faces[0][0], mesh.faces[0][1]);
  EXPECT_GT(mesh.open_edges(), 0U);
  mesh.faces.erase(mesh.faces.begin());
  EXPECT_EQ(mesh.open_edges(), 3U);
}

TEST(MeshFile, TextStlAndPolygons) {
  const MeshFile stl = parse_mesh(
      "solid a\n facet normal 0 0 1\n  outer loop\n   vertex 0 0 0\n   vertex 1 0 0\n"
      "   vertex 0 1 0\n  endloop\n endfacet\nendsolid a\n",
      "a.stl");
  EXPECT_EQ(stl.faces.size(), 1U);
  EXPECT_EQ(parse_mesh("v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n", "q.obj").faces.size(),
            2U);
}

TEST(MeshFile, DamageIsRefusedWithItsLine) {
  EXPECT_EQ(failure_of([] { parse_mesh("v 0 0 0\nf 1 2 3\n", "b.obj"); }),
            "b.obj:2: a face with vertex 2 of 1 (vertices are numbered from 1 and come before "
            "their faces)");
  EXPECT_NE(failure_of([] { parse_mesh("v 0 0\n", "b.obj"); }).find("b.obj:1"), std::string::npos);
  EXPECT_NE(failure_of([] { parse_mesh("hello", "b.obj"); }).find("no face"), std::string::npos);
}

}  // namespace
}  // namespace umov::formats
