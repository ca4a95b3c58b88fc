#include "host/surface/scene_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <map>
#include <utility>

#include "host/errors/error.hpp"
#include "host/formats/atomic_file.hpp"
#include "host/optics/angles.hpp"
#include "host/surface/gaussian_heights.hpp"
#include "host/surface/ground.hpp"
#include "host/surface/immersion.hpp"
#include "host/surface/particles.hpp"
#include "host/surface/radiance.hpp"
#include "host/surface/scene_materials.hpp"
#include "host/toml/parse.hpp"
#include "host/toml/scene_table.hpp"

namespace umov::surface {
namespace {

using trace::MaterialId;
using trace::MediumId;

constexpr double hottest_k = 6000.0;
// A period that nobody chose holds about so many particles of the sparsest layer.
constexpr double particles_a_period = 1000.0;
// … or so many correlation lengths.
constexpr double lengths_a_period = 48.0;
constexpr double no_temperature = -1.0;

class Reader {
 public:
  Reader(SceneTable root, Reading reading) : root_(std::move(root)), reading_(reading) {}

  Surface read() {
    SceneTable about = root_.table("surface");
    wavelengths_ = about.numbers("wavelengths_um", 0.1, 100.0);
    for (std::size_t i = 1; i < wavelengths_.size(); ++i) {
      if (wavelengths_[i] <= wavelengths_[i - 1]) {
        about.fail("wavelengths_um", "does not rise", "sort it, each wavelength once");
      }
    }
    Surface surface{trace::Scene(wavelengths_), {}, 0.0, {}, 0, {}, {}};
    if (about.has("theta_i_deg")) {
      surface.theta_i_deg = about.numbers("theta_i_deg", 0.0, 89.999);
    }
    read_period(about, surface.scene);
    about.refuse_unknown();
    if (root_.has("emission"))
      background_k_ = root_.table("emission")
                          .number("temperature_k", 1.0, hottest_k, std::optional<double>(300.0));
    set_temperature(trace::vacuum, true, no_temperature);
    read_substrate(surface);
    read_materials();

    std::vector<SceneTable> spheres = root_.tables("particles");
    std::vector<SceneTable> drops = root_.tables("drops");
    const bool film = surface.film = root_.has("film");
    const bool on_film = film && root_.table("film").text("particles", {"in", "on"}, "in") == "on";
    // Of bodies that overlap, the later medium is seen: drops on a film do not reach into it; drops
    // in a film keep their shape.
    if (film && !on_film) read_film(surface);
    std::vector<Disc> placed;
    const double base = on_film ? film_thickness() : 0.0;
    for (std::size_t i = 0; i < spheres.size(); ++i) {
      read_layer(spheres[i], surface, placed, false, i);
    }
    for (std::size_t i = 0; i < drops.size(); ++i) {
      read_layer(drops[i], surface, placed, true, spheres.size() + i);
    }
    if (reading_.part == Part::contaminant && reading_.layer >= spheres.size() + drops.size()) {
      throw Error("there is no such layer of particles", "choose one that the scene has");
    }
    if (on_film) read_film(surface);
    add_spheres(surface, placed, base);
    if (reading_.like == nullptr) {
      immerse(surface, on_film);
    } else {
      surface.scene.materials = reading_.like->scene.materials;
      surface.scene.media = reading_.like->scene.media;
    }
    read_emission(surface);
    read_stop(surface.stop);
    root_.refuse_unknown();
    for (const auto& [name, table] : materials_) {
      if (!used_.contains(name)) {
        materials_.at(name).fail("model", "belongs to a material that nothing is made of",
                                 "leave the material out, or use it");
      }
    }
    surface.steps += surface.scene.spheres.size();
    for (const trace::Triangles& mesh : surface.scene.meshes) surface.steps += mesh.faces.size();
    surface.scene.check();
    return surface;
  }

 private:
  void read_period(SceneTable& about, trace::Scene& scene) {
    double preset = 1.0;
    for (const char* kind : {"particles", "drops"}) {
      for (SceneTable& table : root_.tables(kind)) {
        const double radius = table.number("radius_um", 1e-3, 1e6);
        const double coverage = table.number("coverage", 1e-6, 1.0);
        preset = std::max(preset, radius * std::sqrt(optics::pi * particles_a_period / coverage));
      }
    }
    if (root_.has("substrate")) {
      SceneTable substrate = root_.table("substrate");
      if (substrate.has("rough")) {
        const double length = substrate.table("rough").number("correlation_um", 1e-3, 1e6);
        preset = std::max(preset, lengths_a_period * length);
      }
    }
    if (root_.has("film")) preset = std::max(preset, 8.0 * film_thickness());
    period_ = about.number("period_um", 1e-3, 1e7, preset);
    scene.size_x = scene.size_y = period_;
  }

  double film_thickness() { return root_.table("film").number("thickness_um", 1e-6, 1e6); }

  // Temperatures are kept by material and by medium until all of both are known.
  void set_temperature(std::uint32_t id, bool medium, double kelvin) {
    auto& list = medium ? media_k_ : materials_k_;
    list.resize(std::max<std::size_t>(list.size(), id + 1), background_k_);
    list[id] = kelvin;
  }
  double read_temperature(SceneTable& table) {
    return table.number("temperature_k", 1.0, hottest_k, background_k_);
  }

  // What the next material was in an earlier reading that this one may take it over from.
  const trace::Material* prepared(const trace::Scene& scene) const {
    return reading_.like != nullptr ? &reading_.like->scene.materials.at(scene.materials.size())
                                    : nullptr;
  }
  MaterialId add(trace::Scene& scene, trace::Material material, double kelvin) {
    const MaterialId id = scene.add(std::move(material));
    set_temperature(id, false, kelvin);
    return id;
  }
  MaterialId add_liquid(trace::Scene& scene, SceneTable& table, std::vector<MediumId>& liquids) {
    const MediumId liquid = scene.add(read_liquid(table, wavelengths_));
    liquids.push_back(liquid);
    const double kelvin = read_temperature(table);
    set_temperature(liquid, true, kelvin);
    return add(scene, trace::Interface{liquid}, kelvin);
  }

  void read_substrate(Surface& surface) {
    SceneTable substrate = root_.table("substrate");
    trace::Scene& scene = surface.scene;
    const bool modelled =
        substrate.text("model") != "fresnel" && substrate.text("model") != "lambertian";
    surface.ground = add(scene, read_material(substrate, wavelengths_, prepared(scene)),
                         read_temperature(substrate));
    if (modelled) modelled_.push_back({surface.ground, substrate, false});
    if (!substrate.has("rough")) {
      scene.add_plane(0.0, surface.ground);
      substrate.refuse_unknown();
      return;
    }
    if (modelled) {
      substrate.fail("rough", "does not go with a model, which is rough by itself",
                     "leave it out, or use model = \"fresnel\" or \"lambertian\"");
    }
    SceneTable rough = substrate.table("rough");
    const double correlation = rough.number("correlation_um", 1e-6 * period_, period_);
    if (rough.has("slope_rms") == rough.has("height_rms_um")) {
      rough.fail("slope_rms", "and height_rms_um: exactly one of them must be given",
                 "the slope is √2 times the height over the correlation length");
    }
    const double slope =
        rough.has("slope_rms")
            ? rough.number("slope_rms", 0.0, 3.0)
            : std::sqrt(2.0) * rough.number("height_rms_um", 0.0, 2.0 * correlation) / correlation;
    const double enough = std::ceil(6.0 * period_ / correlation);
    const auto cells =
        static_cast<std::size_t>(rough.number("cells", 8.0, 4096.0, std::min(enough, 1024.0)));
    rough.refuse_unknown();
    substrate.refuse_unknown();
    try {
      auto heights = gaussian_heights(cells, period_, correlation, slope, reading_.seed);
      scene.add_height_field(cells, cells, heights, surface.ground);
      ground_ = Ground(std::move(heights), cells, period_);
      surface.random = slope > 0.0;
    } catch (const Error& e) {
      substrate.fail("rough", "cannot be made: " + e.problem(), e.remedy());
    }
  }

  void read_materials() {
    if (!root_.has("materials")) return;
    SceneTable all = root_.table("materials");
    for (const auto& [key, value] : all.toml()) {
      const std::string name(key.str());
      all.know(name);
      materials_.emplace(name, all.table(name));
    }
  }

  trace::Material named_material(SceneTable& user, const std::string& name, double& kelvin,
                                 const trace::Material* prepared) {
    if (const auto found = materials_.find(name); found != materials_.end()) {
      used_.insert(name);
      trace::Material material = read_material(found->second, wavelengths_, prepared);
      kelvin = read_temperature(found->second);
      found->second.refuse_unknown();
      return material;
    }
    kelvin = background_k_;
    std::string names;
    for (const std::string& soil_name : known_soils()) {
      if (soil_name == name) {
        try {
          return soil(name, wavelengths_);
        } catch (const Error& e) {
          user.fail("material", "is '" + name + "': " + e.problem(), e.remedy());
        }
      }
      names += soil_name + ", ";
    }
    for (const auto& [known, table] : materials_) names += known + ", ";
    user.fail("material", "is '" + name + "', which is unknown",
              "choose one of: " + names + "or describe it in [materials." + name + "]");
  }

  Laying read_laying(SceneTable& table) {
    static const std::map<std::string, Layout> layouts{{"random", Layout::random},
                                                       {"poisson-disk", Layout::poisson_disk},
                                                       {"cluster", Layout::cluster},
                                                       {"grid", Layout::grid}};
    Laying laying{};
    laying.sizes = {2.0 * table.number("radius_um", 0.5e-6 * period_, period_),
                    table.number("spread", 1.0, 3.0, 1.0)};
    laying.coverage = table.number("coverage", 1e-6, 1.0) * reading_.coverage_scale;
    laying.layout =
        layouts.at(table.text("layout", {"random", "poisson-disk", "cluster", "grid"}, "random"));
    laying.overlap = table.flag("overlap", false);
    if (laying.layout == Layout::cluster) {
      laying.cluster_size = table.number("cluster_size", 1.0, 1e6, laying.cluster_size);
      laying.cluster_radius = table.number("cluster_radius_um", 0.0, period_, 0.0);
    }
    return laying;
  }

  void read_layer(SceneTable& table, Surface& surface, std::vector<Disc>& placed, bool drops,
                  std::size_t number) {
    trace::Scene& scene = surface.scene;
    double contact = 180.0;
    const Laying laying = read_laying(table);
    if (drops) {
      contact = table.number("contact_angle_deg", 1.0, 180.0);
    } else {
      table.text("kind", {"sphere"}, "sphere");
    }
    MaterialId material = 0;
    const bool wanted = reading_.part == Part::whole ||
                        (reading_.part == Part::contaminant && reading_.layer == number);
    if (drops) {
      if (wanted) material = add_liquid(scene, table, laying.overlap ? flooding_ : drops_);
      for (const char* key : {"index", "n", "kappa", "temperature_k"}) table.know(key);
    } else {
      double kelvin = 0.0;
      const std::string name = table.text("material");
      auto described = named_material(table, name, kelvin, wanted ? prepared(scene) : nullptr);
      if (wanted) {
        const bool modelled = std::holds_alternative<trace::Modelled>(described);
        material = add(scene, std::move(described), kelvin);
        if (modelled) modelled_.push_back({material, materials_.at(name), laying.overlap});
      }
    }
    table.refuse_unknown();
    if (!wanted) return;
    if (reading_.part == Part::contaminant) {
      if (!drops) scene.meshes.clear();
      scene.add_plane(drops ? 0.01 * period_ : 0.0, material);
      return;
    }

    const std::size_t before = placed.size();
    try {
      surface.steps += lay(placed, laying, period_, reading_.seed + 1 + surface.layers.size());
    } catch (const Error& e) {
      table.fail("coverage", "cannot be laid: " + e.problem(), e.remedy());
    }
    surface.random = surface.random || laying.layout != Layout::grid || laying.sizes.spread > 1.0;
    surface.layers.push_back({drops ? "drop" : "sphere", placed.size() - before, 0.0, material});
    contact_.push_back(optics::radians(contact));
  }

  // Once all discs are where they stay.
  void add_spheres(Surface& surface, const std::vector<Disc>& placed, double base) {
    std::size_t next = 0;
    for (std::size_t l = 0; l < surface.layers.size(); ++l) {
      Layer& layer = surface.layers[l];
      const auto first = placed.begin() + static_cast<std::ptrdiff_t>(next);
      layer.coverage =
          reading_.like != nullptr
              ? reading_.like->layers[l].coverage
              : covered_share({first, first + static_cast<std::ptrdiff_t>(layer.count)}, period_);
      const double cosine = std::cos(contact_[l]);
      for (const std::size_t end = next + layer.count; next < end; ++next) {
        // The disc is what is seen from above: the whole sphere from 90° on, else the cap's base.
        const Disc& disc = placed[next];
        const bool whole = cosine <= -1.0;
        const double radius = cosine > 0.0 ? disc.radius / std::sin(contact_[l]) : disc.radius;
        double z = base - radius * cosine;
        if (ground_.rough() && base == 0.0) {
          z = whole ? ground_.rest(disc.x, disc.y, radius)
                    : ground_.level(disc.x, disc.y, disc.radius) - radius * cosine;
        }
        trace::Sphere sphere{trace::Vec3(disc.x, disc.y, z), radius, layer.material};
        if (!whole && !ground_.rough()) sphere.base_z = 0.0;
        surface.scene.spheres.push_back(sphere);
      }
    }
    surface.covered = reading_.like != nullptr ? reading_.like->covered
                      : placed.empty()         ? 0.0
                                               : covered_share(placed, period_);
  }

  void read_film(Surface& surface) {
    SceneTable film = root_.table("film");
    film.know("particles");
    const double thickness = film.number("thickness_um", 1e-6, period_);
    const MaterialId skin = add_liquid(surface.scene, film, films_);
    film.refuse_unknown();
    if (reading_.part != Part::contaminant) surface.scene.add_plane(thickness, skin);
  }

  // Models learn of the liquids that may lie on them. The ground is wetted by all; particles by a
  // film that they stand in, and by drops where both may overlap.
  void immerse(Surface& surface, bool on_film) {
    for (Face& face : modelled_) {
      const bool ground = face.material == surface.ground;
      std::vector<MediumId> liquids = ground || !on_film ? films_ : std::vector<MediumId>{};
      if (ground) liquids.insert(liquids.end(), drops_.begin(), drops_.end());
      if (ground || face.may_overlap) {
        liquids.insert(liquids.end(), flooding_.begin(), flooding_.end());
      }
      auto& model = std::get<trace::Modelled>(surface.scene.materials[face.material]);
      for (const MediumId liquid : liquids) {
        try {
          model.immersed.emplace_back(liquid, immersed(model.sampler, surface.scene.media[liquid]));
        } catch (const Error& e) {
          face.table.fail("model", "does not go with the liquid on it: " + e.problem(), e.remedy());
        }
      }
    }
  }

  void read_emission(Surface& surface) {
    if (!root_.has("emission")) return;
    SceneTable table = root_.table("emission");
    table.know("temperature_k");
    Emission emission;
    materials_k_.resize(surface.scene.materials.size(), background_k_);
    media_k_.resize(surface.scene.media.size(), background_k_);
    emission.temperature_k = materials_k_;
    emission.temperature_k.insert(emission.temperature_k.end(), media_k_.begin(), media_k_.end());
    emission.temperature_k[surface.scene.materials.size() + trace::vacuum] = 0.0;
    emission.sky_k = table.number("sky_temperature_k", 0.0, hottest_k, 0.0);
    if (table.has("sun_theta_deg")) {
      emission.sun_theta_deg = table.number("sun_theta_deg", 0.0, 89.999);
      emission.sun_phi_deg = table.number("sun_phi_deg", -360.0, 360.0, 180.0);
      const double share = table.number("sun_transmittance", 0.0, 1.0, 1.0);
      for (const double w : wavelengths_) emission.sun.push_back(share * sun_irradiance(w));
    }
    table.refuse_unknown();
    surface.emission = std::move(emission);
  }

  void read_stop(Stop& stop) {
    if (!root_.has("stop")) return;
    SceneTable table = root_.table("stop");
    stop.dhr_relative_error = table.number("dhr_relative_error", 1e-6, 1.0, 0.0);
    stop.cell_relative_error = table.number("cell_relative_error", 1e-6, 1.0, 0.0);
    if (table.has("cell_deg")) {
      const std::vector<double> direction = table.numbers("cell_deg", -360.0, 360.0);
      if (direction.size() != 2 || direction[0] < 0.0 || direction[0] >= 90.0) {
        table.fail("cell_deg", "is no direction", "write [theta_r, phi_r], theta_r 0 to below 90");
      }
      if (table.has("cell_percentile")) {
        table.fail("cell_percentile", "and cell_deg: at most one of them may be given",
                   "a run stops by one cell or by a share of all");
      }
      stop.cell_deg = {direction[0], direction[1]};
    }
    stop.cell_percentile = table.number("cell_percentile", 1.0, 100.0, stop.cell_percentile);
    for (const char* key : {"cell_deg", "cell_percentile"}) {
      if (table.has(key) && !table.has("cell_relative_error")) {
        table.fail(key, "says of which cells, but not how well", "add cell_relative_error");
      }
    }
    stop.rays = table.number("max_rays", 1.0, 1e15, 0.0);
    table.refuse_unknown();
  }

  // A face with a model, and where it is described.
  struct Face {
    MaterialId material;
    SceneTable table;
    bool may_overlap;
  };

  SceneTable root_;
  Reading reading_;
  std::vector<Face> modelled_;
  std::vector<MediumId> films_, drops_, flooding_;  // the latter: of drops that may overlap
  std::vector<double> wavelengths_;
  double period_ = 0.0;
  double background_k_ = 300.0;
  std::vector<double> materials_k_, media_k_;
  std::map<std::string, SceneTable> materials_;
  std::set<std::string> used_;
  std::vector<double> contact_;  // radians, by layer
  Ground ground_;
};

}  // namespace

Surface surface_from_toml(std::string_view text, const std::string& file, const Reading& reading) {
  const toml::table table = parse_toml(text, file, "see host/surface/README.md for scene files");
  return Reader(SceneTable(table, file, ""), reading).read();
}

Surface read_surface(const std::filesystem::path& path, const Reading& reading) {
  return surface_from_toml(formats::read_whole_file(path), path.string(), reading);
}

}  // namespace umov::surface
