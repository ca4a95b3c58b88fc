#include "host/formats/mesh_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <cstring>
#include <map>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/text_lines.hpp"

namespace umov::formats {
namespace {

using Vertex = std::array<float, 3>;

constexpr std::size_t stl_head = 84;
constexpr std::size_t stl_face = 50;

bool has_area(const Vertex& a, const Vertex& b, const Vertex& c) {
  double u[3];
  double v[3];
  for (std::size_t i = 0; i < 3; ++i) {
    u[i] = static_cast<double>(b[i]) - static_cast<double>(a[i]);
    v[i] = static_cast<double>(c[i]) - static_cast<double>(a[i]);
  }
  const double x = u[1] * v[2] - u[2] * v[1];
  const double y = u[2] * v[0] - u[0] * v[2];
  const double z = u[0] * v[1] - u[1] * v[0];
  return x * x + y * y + z * z > 0.0;
}

std::vector<std::string_view> words(std::string_view line) {
  std::vector<std::string_view> found;
  while (true) {
    const auto start = line.find_first_not_of(" \t\r");
    if (start == std::string_view::npos) return found;
    line.remove_prefix(start);
    const auto end = std::min(line.find_first_of(" \t\r"), line.size());
    found.push_back(line.substr(0, end));
    line.remove_prefix(end);
  }
}

[[noreturn]] void refuse(const std::string& file, std::size_t line, const std::string& problem,
                         const std::string& remedy) {
  throw Error(Place{file, line}, problem, remedy);
}

float coordinate(std::string_view word, const std::string& file, std::size_t line) {
  double value = 0.0;
  if (const char* wrong = read_decimal(word, value))
    refuse(file, line, fmt::format("`{}` {}", word, wrong), "give a number");
  if (std::abs(value) > 1e9) refuse(file, line, fmt::format("{:g} is too far", value), "scale it");
  return static_cast<float>(value);
}

Vertex vertex_of(const std::vector<std::string_view>& w, const std::string& file,
                 std::size_t line) {
  if (w.size() < 4) refuse(file, line, "a vertex needs three coordinates", "complete the line");
  return {coordinate(w[1], file, line), coordinate(w[2], file, line), coordinate(w[3], file, line)};
}

void add_face(MeshFile& mesh, std::uint32_t a, std::uint32_t b, std::uint32_t c) {
  if (has_area(mesh.vertices[a], mesh.vertices[b], mesh.vertices[c]))
    mesh.faces.push_back({a, b, c});
}

MeshFile parse_obj(std::string_view text, const std::string& file) {
  MeshFile mesh;
  LineReader lines(text);
  std::string_view line;
  while (lines.next(line)) {
    const auto w = words(line);
    if (w.empty()) continue;
    if (w[0] == "v") mesh.vertices.push_back(vertex_of(w, file, lines.line_number()));
    if (w[0] != "f") continue;
    std::vector<std::uint32_t> corners;
    for (std::size_t i = 1; i < w.size(); ++i) {
      std::int64_t number = 0;
      const auto word = w[i].substr(0, w[i].find('/'));
      if (const char* wrong = read_integer(word, number))
        refuse(file, lines.line_number(), fmt::format("`{}` {}", w[i], wrong),
               "a face lists numbers of vertices");
      const auto count = static_cast<std::int64_t>(mesh.vertices.size());
      const std::int64_t index = number > 0 ? number - 1 : count + number;
      if (number == 0 || index < 0 || index >= count)
        refuse(file, lines.line_number(), fmt::format("a face with vertex {} of {}", number, count),
               "vertices are numbered from 1 and come before their faces");
      corners.push_back(static_cast<std::uint32_t>(index));
    }
    if (corners.size() < 3)
      refuse(file, lines.line_number(), fmt::format("a face with {} corners", corners.size()),
             "it needs three at least");
    for (std::size_t i = 2; i < corners.size(); ++i)
      add_face(mesh, corners[0], corners[i - 1], corners[i]);
  }
  return mesh;
}

MeshFile parse_stl_text(std::string_view text, const std::string& file) {
  MeshFile mesh;
  LineReader lines(text);
  std::string_view line;
  std::size_t first = 0;
  while (lines.next(line)) {
    const auto w = words(line);
    if (w.empty()) continue;
    if (w[0] == "outer") first = mesh.vertices.size();
    if (w[0] == "vertex") mesh.vertices.push_back(vertex_of(w, file, lines.line_number()));
    if (w[0] != "endloop") continue;
    if (mesh.vertices.size() != first + 3)
      refuse(file, lines.line_number(),
             fmt::format("a face with {} corners", mesh.vertices.size() - first),
             "STL has triangles only");
    const auto a = static_cast<std::uint32_t>(first);
    add_face(mesh, a, a + 1, a + 2);
  }
  return mesh;
}

MeshFile parse_stl_binary(std::string_view bytes, const std::string& file, std::uint32_t count) {
  MeshFile mesh;
  for (std::size_t i = 0; i < count; ++i) {
    float numbers[12];
    std::memcpy(numbers, bytes.data() + stl_head + i * stl_face, sizeof numbers);
    const auto first = static_cast<std::uint32_t>(mesh.vertices.size());
    for (std::size_t v = 0; v < 3; ++v) {
      for (std::size_t k = 0; k < 3; ++k) {
        if (!std::isfinite(numbers[3 + 3 * v + k]) || std::abs(numbers[3 + 3 * v + k]) > 1e9F)
          refuse(file, 0, fmt::format("face {} has a coordinate that is no number", i),
                 "write the file again");
      }
      mesh.vertices.push_back({numbers[3 + 3 * v], numbers[4 + 3 * v], numbers[5 + 3 * v]});
    }
    add_face(mesh, first, first + 1, first + 2);
  }
  return mesh;
}

}  // namespace

std::size_t MeshFile::open_edges() const {
  std::map<Vertex, std::size_t> number;
  std::vector<std::size_t> place;
  for (const Vertex& v : vertices) place.push_back(number.emplace(v, number.size()).first->second);
  std::map<std::pair<std::size_t, std::size_t>, int> ways;
  for (const auto& face : faces) {
    for (std::size_t k = 0; k < 3; ++k) ++ways[{place[face[k]], place[face[(k + 1) % 3]]}];
  }
  std::size_t open = 0;
  for (const auto& [edge, times] : ways) {
    const auto back = ways.find({edge.second, edge.first});
    if (times != 1 || back == ways.end() || back->second != 1) ++open;
  }
  return open;
}

MeshFile parse_mesh(std::string_view bytes, const std::string& file) {
  MeshFile mesh;
  std::uint32_t count = 0;
  if (bytes.size() >= stl_head) std::memcpy(&count, bytes.data() + 80, sizeof count);
  if (bytes.size() >= stl_head && bytes.size() == stl_head + stl_face * std::size_t{count}) {
    mesh = parse_stl_binary(bytes, file, count);
  } else if (bytes.starts_with("solid")) {
    mesh = parse_stl_text(bytes, file);
  } else {
    mesh = parse_obj(bytes, file);
  }
  if (mesh.faces.empty())
    refuse(file, 0, "no face was found", "give a Wavefront OBJ or an STL file with triangles");
  return mesh;
}

MeshFile read_mesh(const std::filesystem::path& path) {
  constexpr std::size_t most = std::size_t{256} << 20;
  return parse_mesh(read_whole_file(path, most), path.string());
}

}  // namespace umov::formats
