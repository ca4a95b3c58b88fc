#include "host/chamber/scene_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "host/chamber/scene_parts.hpp"
#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/formats/mesh_file.hpp"
#include "host/formats/photometry.hpp"
#include "host/optics/angles.hpp"
#include "host/optics/frames.hpp"
#include "host/toml/parse.hpp"
#include "host/toml/scene_table.hpp"

namespace umov::chamber {
namespace {

constexpr double longest_mm = 1e5;
constexpr double any_mm = 1e6;

std::string text_of(const std::filesystem::path& path) {
  constexpr std::size_t most = std::size_t{16} << 20;
  return formats::read_whole_file(path, most);
}

class Reader {
 public:
  Reader(const toml::table& table, const std::filesystem::path& file, const Departure& departure)
      : name_(file.string()), root_(table, name_, ""), materials_(file), departure_(departure) {}

  Job read() {
    if (root_.has("bands")) read_bands();
    materials_.read_named(root_);
    // Sources of a chamber make holes in its base, so they come first.
    std::vector<SceneTable> sources = root_.tables("source");
    if (root_.has("chamber")) read_chamber();
    for (SceneTable& source : sources) read_source(source);
    if (chamber_) finish_chamber();
    for (SceneTable& box : root_.tables("box")) read_box(box);
    for (SceneTable& mesh : root_.tables("mesh")) read_mesh_table(mesh);
    Luminaire& l = job_.luminaire;
    if (l.scene.plates.empty() && l.scene.tubes.empty() && l.scene.meshes.empty()) {
      throw Error(Place{name_}, "there is nothing in it",
                  "add a [chamber], [[box]] or [[mesh]], and a [[source]]");
    }
    if (root_.has("camera")) read_camera();
    if (root_.has("region")) read_region();
    if (root_.has("goniophotometer")) read_goniophotometer();
    if (root_.has("glare")) read_glare();
    root_.refuse_unknown();
    if (!job_.camera && !job_.distribution) {
      throw Error(Place{name_}, "nothing is to be measured",
                  "add a [camera] or a [goniophotometer]");
    }
    l.scene.check();
    return std::move(job_);
  }

 private:
  struct Chamber {
    double radius, height;
    trace::MaterialId base;
    std::vector<trace::Plate::Hole> holes;
    bool closed;
    trace::MaterialId lid;
  };

  static Vec3 vector(SceneTable& table, std::string_view key) {
    const std::vector<double> v = table.numbers(key, -any_mm, any_mm);
    if (v.size() != 3) {
      table.fail(key, fmt::format("has {} numbers", v.size()), "give [x, y, z]");
    }
    return {v[0], v[1], v[2]};
  }

  static bool flag(SceneTable& table, std::string_view key, bool preset) {
    if (!table.has(key)) return preset;
    return table.text(key, {"yes", "no"}) == "yes";
  }

  void read_bands() {
    SceneTable table = root_.table("bands");
    std::vector<double> um = table.numbers("wavelength_nm", 1.0, 1e5);
    for (double& w : um) w *= 1e-3;
    table.refuse_unknown();
    try {
      job_.luminaire.bands.emplace(std::move(um));
    } catch (const Error& error) {
      table.fail("wavelength_nm", "gives " + error.problem(), error.remedy());
    }
    materials_.use(*job_.luminaire.bands);
  }

  /// W/nm of a lumen by band; of the same power everywhere where the source does not say.
  std::vector<double> spectrum(SceneTable& table) const {
    constexpr const char* key = "spectrum";
    if (!job_.luminaire.bands) {
      if (table.has(key)) {
        table.fail(key, "is given, but the scene has no bands",
                   "add [bands] with wavelength_nm, or leave it out");
      }
      return {};
    }
    const Bands& bands = *job_.luminaire.bands;
    std::vector<double> power(bands.size(), 1.0);
    constexpr double most = 1e30;
    if (table.has(key)) {
      power = table.is_list(key) ? table.spectrum(key, bands.size(), 0.0, most)
                                 : bands.means(table.spectrum(key, bands.fine_um(), 0.0, most));
    }
    const double lumens = bands.luminous(power);
    if (!(lumens > 0.0)) table.fail(key, "has no light in the bands", "widen [bands]");
    for (double& p : power) p /= lumens;
    return power;
  }

  std::pair<double, double> range(SceneTable& table, std::string_view key) {
    const std::vector<double> v = table.numbers(key, -any_mm, any_mm);
    if (v.size() != 2 || !(v[1] > v[0])) table.fail(key, "is no range", "give [from, to]");
    return {v[0], v[1]};
  }

  void read_chamber() {
    SceneTable table = root_.table("chamber");
    Luminaire& l = job_.luminaire;
    Chamber c{};
    c.radius = 0.5 * table.number("diameter_mm", 1e-3, longest_mm);
    c.height = table.number("height_mm", 1e-3, longest_mm);
    const auto wall = materials_.surface(table, "wall");
    const auto base = table.has("base") ? materials_.surface(table, "base") : wall;
    c.closed = table.has("lid");
    const auto lid = c.closed ? materials_.surface(table, "lid") : wall;
    table.refuse_unknown();
    const trace::MaterialId side = l.add(wall);
    c.base = l.add(base);
    if (c.closed) c.lid = l.add(lid);
    l.scene.tubes.push_back({0.0, 0.0, c.radius, 0.0, c.height, true, side});
    l.opening_z = c.height;
    l.opening_diameter_mm = 2.0 * c.radius;
    chamber_ = c;
  }

  void finish_chamber() {
    Luminaire& l = job_.luminaire;
    l.scene.plates.push_back(
        {0.0, 0.0, 0.0, chamber_->radius, true, chamber_->base, chamber_->holes});
    if (chamber_->closed) {
      l.scene.plates.push_back(
          {0.0, 0.0, chamber_->height, chamber_->radius, false, chamber_->lid});
    }
  }

  std::shared_ptr<const IntensityTable> photometric(SceneTable& table, double& flux) {
    if (!table.has("file")) return nullptr;
    const std::filesystem::path path = table.file("file");
    const formats::Photometry photometry = formats::read_photometry(path);
    if (!table.has("flux_lm")) flux = photometry.zonal_lm(0.0, 90.0);
    return std::make_shared<IntensityTable>(photometry, path.string());
  }

  Vec3 shift() const { return {departure_.shift_x_mm, departure_.shift_y_mm, 0.0}; }

  double excess(std::size_t source) const {
    return source < departure_.excess.size() ? 1.0 + departure_.excess[source] : 1.0;
  }

  std::shared_ptr<const Surface> edge_of(SceneTable& table) {
    const auto edge = table.has("edge") ? materials_.surface(table, "edge") : materials_.black();
    if (departure_.edge_rho == 0.0) return edge;
    constexpr double usual_incidence_deg = 45.0;
    return std::make_shared<const Surface>(
        "edge", Lambertian{edge->reflectance(usual_incidence_deg) + departure_.edge_rho});
  }

  // Lumens of each of `count` sources: one number for all or one for each.
  std::vector<double> fluxes(SceneTable& table, std::size_t count, double from_file) {
    if (!table.has("flux_lm") && from_file > 0.0) return std::vector<double>(count, from_file);
    if (!table.has("flux_lm")) table.fail("flux_lm", "is missing", "give the lumens of a source");
    return table.spectrum("flux_lm", count, 0.0, 1e9);
  }

  void read_source(SceneTable& table) {
    const std::string kind = table.text("kind", {"disk", "rectangle"});
    double file_flux = 0.0;
    const auto intensities = photometric(table, file_flux);
    const auto surface =
        table.has("surface") ? materials_.surface(table, "surface") : materials_.black();
    Luminaire& l = job_.luminaire;
    if (kind == "rectangle") {
      Emitter e{};
      e.centre = vector(table, "centre_mm") + shift();
      e.half_u = 0.5 * vector(table, "edge_u_mm");
      e.half_v = 0.5 * vector(table, "edge_v_mm");
      const Vec3 normal = optics::cross(e.half_u, e.half_v);
      const double area = std::sqrt(optics::dot(normal, normal));
      const double sides =
          std::sqrt(optics::dot(e.half_u, e.half_u) * optics::dot(e.half_v, e.half_v));
      if (!(area > 0.0) || std::abs(optics::dot(e.half_u, e.half_v)) > 1e-6 * sides) {
        table.fail("edge_v_mm", "is not at right angles to edge_u_mm", "give two sides");
      }
      e.normal = normal / area;
      e.flux_lm = excess(l.emitters.size()) * fluxes(table, 1, file_flux)[0];
      e.spectrum = spectrum(table);
      e.table = intensities;
      e.name = "source " + std::to_string(l.emitters.size() + 1);
      table.refuse_unknown();
      l.add_emitter(e, surface);
      return;
    }
    const double radius = 0.5 * table.number("diameter_mm", 1e-6, longest_mm);
    const bool down =
        table.has("facing") && table.text("facing", {"up", "down"}) == std::string("down");
    const auto count = static_cast<std::size_t>(table.number("count", 1.0, 1000.0, 1.0));
    std::vector<Vec3> places;
    double depth = 0.0;
    bool in_base = false;
    if (table.has("centre_mm")) {
      if (count != 1) table.fail("count", "does not go with centre_mm", "use ring_radius_mm");
      places.push_back(vector(table, "centre_mm") + shift());
    } else {
      if (!chamber_) {
        table.fail("ring_radius_mm", "needs a [chamber] with a base", "give centre_mm instead");
      }
      const double ring = table.number("ring_radius_mm", 0.0, longest_mm,
                                       count == 1 ? std::optional<double>(0.0) : std::nullopt);
      const double start = table.number("azimuth_deg", -360.0, 360.0, 0.0);
      depth = table.number("depth_mm", 0.0, longest_mm, 0.0);
      in_base = true;
      job_.rings = job_.rings || ring > 0.0;
      job_.least_depth_mm = std::min(depth, job_.least_depth_mm.value_or(depth));
      depth = std::max(0.0, depth + departure_.depth_mm);
      const double radius_of_ring = ring > 0.0 ? ring + departure_.ring_mm : 0.0;
      for (std::size_t i = 0; i < count; ++i) {
        const double a =
            optics::radians(start + 360.0 * static_cast<double>(i) / static_cast<double>(count));
        const Vec3 on_ring(radius_of_ring * std::cos(a), radius_of_ring * std::sin(a), -depth);
        places.push_back(on_ring + shift());
      }
    }
    const auto edge = edge_of(table);
    const std::vector<double> flux = fluxes(table, count, file_flux);
    const std::vector<double> power = spectrum(table);
    table.refuse_unknown();
    for (std::size_t i = 0; i < places.size(); ++i) {
      const Vec3& at = places[i];
      Emitter e{};
      e.name = "source " + std::to_string(l.emitters.size() + 1);
      e.flux_lm = excess(l.emitters.size()) * flux[i];
      e.centre = at;
      e.normal = Vec3(0.0, 0.0, down ? -1.0 : 1.0);
      e.half_u = Vec3(radius, 0.0, 0.0);
      e.half_v = Vec3(0.0, down ? -radius : radius, 0.0);
      e.disc = true;
      e.table = intensities;
      e.spectrum = power;
      l.add_emitter(e, surface);
      if (!in_base) continue;
      if (std::hypot(at.x, at.y) + radius > chamber_->radius) {
        table.fail("ring_radius_mm", "puts a hole over the edge of the base",
                   fmt::format("it can be {:g} at most", chamber_->radius - radius));
      }
      for (const auto& other : chamber_->holes) {
        if (std::hypot(other.x - at.x, other.y - at.y) < other.radius + radius) {
          table.fail("ring_radius_mm", "lets holes overlap", "use a wider ring or smaller holes");
        }
      }
      chamber_->holes.push_back({at.x, at.y, radius});
      if (depth > 0.0) {
        l.scene.tubes.push_back({at.x, at.y, radius, -depth, 0.0, true, l.add(edge)});
      }
    }
  }

  void read_box(SceneTable& table) {
    const Vec3 from = vector(table, "from_mm");
    const Vec3 to = vector(table, "to_mm");
    if (!(to.x > from.x && to.y > from.y && to.z > from.z)) {
      table.fail("to_mm", "is not above from_mm in x, y and z", "exchange them");
    }
    const bool inward =
        table.has("front") && table.text("front", {"inside", "outside"}) == std::string("inside");
    std::vector<bool> left_out(6, false);
    constexpr std::array names{"-x", "+x", "-y", "+y", "-z", "+z"};
    if (table.has("open")) {
      const std::string side = table.text("open", {"-x", "+x", "-y", "+y", "-z", "+z"});
      for (std::size_t i = 0; i < names.size(); ++i) left_out[i] = side == names[i];
    }
    const auto surface = materials_.surface(table, "surface");
    table.refuse_unknown();
    Luminaire& l = job_.luminaire;
    l.add_box(from, to, inward, l.add(surface), left_out);
  }

  void read_mesh_table(SceneTable& table) {
    const std::filesystem::path path = table.file("file");
    const double unit = table.number("unit_mm", 1e-6, 1e6, 1.0);
    const Vec3 at = table.has("at_mm") ? vector(table, "at_mm") : Vec3(0.0, 0.0, 0.0);
    const bool closed = flag(table, "closed", false);
    const auto surface = materials_.surface(table, "surface");
    table.refuse_unknown();
    formats::MeshFile mesh = formats::read_mesh(path);
    if (closed) {
      if (const std::size_t open = mesh.open_edges(); open > 0) {
        throw Error(Place{path.string()},
                    fmt::format("the mesh should be closed but has {} open edges", open),
                    "close its gaps, turn faces to one side, or write closed = \"no\"");
      }
    }
    Luminaire& l = job_.luminaire;
    const trace::MaterialId material = l.add(surface);
    trace::Triangles triangles;
    for (const auto& v : mesh.vertices) {
      triangles.vertices.push_back({static_cast<float>(at.x + unit * static_cast<double>(v[0])),
                                    static_cast<float>(at.y + unit * static_cast<double>(v[1])),
                                    static_cast<float>(at.z + unit * static_cast<double>(v[2]))});
    }
    triangles.faces.assign(mesh.faces.begin(), mesh.faces.end());
    triangles.materials.assign(mesh.faces.size(), material);
    l.scene.meshes.push_back(std::move(triangles));
  }

  void read_camera() {
    SceneTable table = root_.table("camera");
    Camera c;
    c.centre = table.has("centre_mm") ? vector(table, "centre_mm")
                                      : Vec3(0.0, 0.0, job_.luminaire.opening_z);
    c.view_deg = table.number("view_deg", 0.0, 89.9) + departure_.view_deg;
    c.azimuth_deg = table.number("azimuth_deg", -360.0, 360.0, 270.0);
    c.distance_mm = table.number("distance_mm", 0.0, 1e9, 0.0);
    const std::vector<double> pixels = table.numbers("pixels", 1.0, 20000.0);
    if (pixels.size() != 2) table.fail("pixels", "is no pair", "give [width, height]");
    c.width = static_cast<std::size_t>(pixels[0]);
    c.height = static_cast<std::size_t>(pixels[1]);
    c.pixel_mm = table.number("pixel_mm", 1e-6, longest_mm);
    job_.map.rays_per_pixel =
        static_cast<std::uint64_t>(table.number("rays_per_pixel", 2.0, 1e9, 1000.0));
    if (table.has("estimator")) {
      const std::string e = table.text("estimator", {"unidirectional", "next_event", "mis"});
      job_.map.estimator = e == "mis"          ? Estimator::mis
                           : e == "next_event" ? Estimator::next_event
                                               : Estimator::unidirectional;
    }
    table.refuse_unknown();
    job_.camera = c;
  }

  void read_region() {
    SceneTable table = root_.table("region");
    const auto x = range(table, "x_mm");
    const auto y = range(table, "y_mm");
    table.refuse_unknown();
    job_.region = Region{x.first, x.second, y.first, y.second};
  }

  void read_goniophotometer() {
    SceneTable table = root_.table("goniophotometer");
    DistributionRequest request;
    request.rays = static_cast<std::uint64_t>(table.number("rays", 64.0, 1e12, 2e6));
    request.planes = static_cast<std::size_t>(table.number("planes", 1.0, 3600.0, 24.0));
    request.angles = static_cast<std::size_t>(table.number("angles", 3.0, 1801.0, 37.0));
    table.refuse_unknown();
    job_.distribution = request;
  }

  void read_glare() {
    SceneTable table = root_.table("glare");
    Glare glare;
    glare.background_cd_m2 = table.number("background_cd_m2", 1e-6, 1e6, glare.background_cd_m2);
    // From far away the camera sees what an observer at any distance would.
    const bool near = job_.camera && job_.camera->distance_mm > 0.0;
    if (near) glare.observer_distance_m = 1e-3 * job_.camera->distance_mm;
    const double distance =
        table.number("observer_distance_m", 1e-3, 1e6, glare.observer_distance_m);
    if (near && std::abs(distance / glare.observer_distance_m - 1.0) > 1e-6) {
      table.fail("observer_distance_m",
                 fmt::format("= {:g}, but the camera stands at {:g} mm", distance,
                             job_.camera->distance_mm),
                 "leave it out, or move the camera by its distance_mm");
    }
    glare.observer_distance_m = distance;
    glare.position_index = table.number("position_index", 1.0, 16.0, glare.position_index);
    table.refuse_unknown();
    if (!job_.camera) root_.fail("glare", "needs a [camera]", "add one");
    job_.glare = glare;
  }

  std::string name_;
  SceneTable root_;
  SceneMaterials materials_;
  const Departure& departure_;
  Job job_;
  std::optional<Chamber> chamber_;
};

}  // namespace

Job job_from_toml(std::string_view text, const std::filesystem::path& file,
                  const Departure& departure) {
  const toml::table table =
      parse_toml(text, file.string(), "see host/chamber/README.md for scene files");
  return Reader(table, file, departure).read();
}

Job read_job(const std::filesystem::path& path) {
  return job_from_toml(text_of(path), path);
}

Described described_scene(const std::filesystem::path& path) {
  const std::string text = text_of(path);
  const Job job = job_from_toml(text, path);
  if (!job.camera) {
    throw Error(Place{path.string()}, "no camera looks at the luminaire",
                "add the [camera] that the map was taken with");
  }
  if (!(job.luminaire.flux_lm() > 0.0)) {
    throw Error(Place{path.string()}, "nothing shines", "add a [[source]]");
  }
  const auto view = [text, path](const Departure& departure) {
    Job built = job_from_toml(text, path, departure);
    return View{std::move(built.luminaire), *built.camera};
  };
  return {view, job.rings, job.least_depth_mm};
}

}  // namespace umov::chamber
