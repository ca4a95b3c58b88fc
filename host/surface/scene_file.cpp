#include "host/surface/scene_file.hpp"

#include <fmt/format.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <utility>

#include "host/brdf/model.hpp"
#include "host/errors/error.hpp"
#include "host/optics/refractive_index.hpp"
#include "host/surface/gaussian_heights.hpp"
#include "host/surface/particles.hpp"
#include "host/toml/scene_table.hpp"
#include "host/toml/parse.hpp"

namespace umov::surface {
namespace {

using trace::MaterialId;

class Reader {
 public:
  Reader(SceneTable root, std::uint64_t seed) : root_(std::move(root)), seed_(seed) {}

  Surface read() {
    std::vector<double> wavelengths = root_.numbers("wavelengths_nm", 100.0, 1e5);
    for (double& w : wavelengths) w *= 1e-3;
    count_ = wavelengths.size();
    Surface surface{trace::Scene(std::move(wavelengths)), {}};
    period_ = root_.number("period_um", 1e-3, 1e7);
    surface.scene.size_x = surface.scene.size_y = period_;
    read_ground(surface.scene);
    std::vector<Disc> placed;
    for (SceneTable& particles : root_.tables("particles")) {
      read_particles(particles, surface, placed);
    }
    if (root_.has("film")) read_film(surface);
    root_.refuse_unknown();
    surface.scene.check();
    return surface;
  }

 private:
  // Index tables of the program by name, or numbers.
  trace::Medium read_index(SceneTable& table, const trace::Scene& scene) {
    trace::Medium medium;
    if (!table.has("index")) {
      medium.n = table.spectrum("n", count_, 1e-3, 1e3);
      medium.kappa = table.has("kappa") ? table.spectrum("kappa", count_, 0.0, 1e9)
                                        : std::vector<double>(count_, 0.0);
      return medium;
    }
    const auto index = optics::IndexTable::embedded(table.text("index"));
    for (const double w : scene.wavelengths_um) {
      medium.n.push_back(index.n(w));
      medium.kappa.push_back(index.kappa(w));
    }
    return medium;
  }

  trace::Medium read_liquid(SceneTable& table, const trace::Scene& scene) {
    trace::Medium medium = read_index(table, scene);
    for (const double n : medium.n) {
      if (n < 1.0) {
        table.fail(table.has("n") ? "n" : "index", fmt::format("gives n = {}", n),
                   "a liquid has an index of at least 1");
      }
    }
    return medium;
  }

  trace::Material read_model(SceneTable& ground, const trace::Scene& scene) {
    const brdf::Model model = brdf::Model::by_name(ground.text("model"));
    std::vector<std::vector<double>> spectra;
    for (const brdf::Parameter& p : model.parameters()) {
      spectra.emplace_back(count_, p.initial);
    }
    if (ground.has("set")) {
      SceneTable set = ground.table("set");
      for (std::size_t i = 0; i < spectra.size(); ++i) {
        const brdf::Parameter& p = model.parameters()[i];
        set.know(p.name);
        if (set.has(p.name)) spectra[i] = set.spectrum(p.name, count_, p.min, p.max);
      }
      set.refuse_unknown();
    }
    std::vector<brdf::SpectralValues> values;
    for (std::size_t w = 0; w < count_; ++w) {
      values.push_back({{}, scene.wavelengths_um[w]});
      for (const auto& spectrum : spectra) values.back().values.push_back(spectrum[w]);
    }
    return trace::Modelled{brdf::Sampler(model, std::move(values))};
  }

  void read_ground(trace::Scene& scene) {
    SceneTable ground = root_.table("ground");
    const std::string kind = ground.text("kind", {"lambertian", "conductor", "model"});
    MaterialId material = 0;
    if (kind == "lambertian") {
      material = scene.add(trace::Lambertian{ground.spectrum("albedo", count_, 0.0, 1.0)});
    } else if (kind == "conductor") {
      const trace::Medium metal = read_index(ground, scene);
      material = scene.add(trace::Conductor{metal.n, metal.kappa});
    } else {
      material = scene.add(read_model(ground, scene));
    }
    rough_ = ground.has("rough");
    if (rough_) {
      if (kind == "model") {
        ground.fail("rough", "does not go with a model, which is rough by itself", "leave it out");
      }
      SceneTable rough = ground.table("rough");
      const double slope = rough.number("slope_rms", 0.0, 3.0);
      const double correlation = rough.number("correlation_um", 1e-6 * period_, period_);
      const auto cells = static_cast<std::size_t>(rough.number("cells", 8.0, 4096.0, 512.0));
      rough.refuse_unknown();
      scene.add_height_field(cells, cells,
                             gaussian_heights(cells, period_, correlation, slope, seed_), material);
    } else {
      scene.add_plane(0.0, material);
    }
    ground.refuse_unknown();
  }

  void read_particles(SceneTable& table, Surface& surface, std::vector<Disc>& placed) {
    if (rough_) {
      table.fail("kind", "lies on rough ground", "particles need flat ground: leave out rough");
    }
    trace::Scene& scene = surface.scene;
    const std::string kind = table.text("kind", {"soil", "drop"});
    MaterialId material = 0;
    double contact = 180.0;
    if (kind == "soil") {
      material = scene.add(trace::Lambertian{table.spectrum("albedo", count_, 0.0, 1.0)});
    } else {
      contact = table.number("contact_angle_deg", 1.0, 180.0);
      const trace::MediumId liquid = scene.add(read_liquid(table, scene));
      material = scene.add(trace::Interface{trace::vacuum, liquid});
    }
    const Sizes sizes{table.number("diameter_um", 1e-6 * period_, period_),
                      table.number("spread", 1.0, 3.0, 1.0)};
    const double coverage = table.number("coverage", 0.0, 1.0);
    table.refuse_unknown();

    const std::size_t before = placed.size();
    scatter(placed, sizes, coverage, period_, seed_ + 1 + surface.layers.size());
    Layer layer{kind, placed.size() - before, 0.0};
    // The disc is what is seen from above: the whole sphere from 90° on, else the cap's base.
    const double angle = optics::radians(contact);
    for (std::size_t i = before; i < placed.size(); ++i) {
      const Disc& disc = placed[i];
      const double radius = contact < 90.0 ? disc.radius / std::sin(angle) : disc.radius;
      layer.coverage += optics::pi * disc.radius * disc.radius / (period_ * period_);
      trace::Sphere sphere{trace::Vec3(disc.x, disc.y, -radius * std::cos(angle)), radius,
                           material};
      if (contact < 180.0) sphere.base_z = 0.0;
      scene.spheres.push_back(sphere);
    }
    surface.layers.push_back(layer);
  }

  void read_film(Surface& surface) {
    SceneTable film = root_.table("film");
    trace::Scene& scene = surface.scene;
    const double thickness = film.number("thickness_um", 1e-6 * period_, period_);
    const trace::MediumId liquid = scene.add(read_liquid(film, scene));
    film.refuse_unknown();
    if (!scene.spheres.empty() || rough_) {
      root_.fail("film", "lies over particles or rough ground", "a film needs bare flat ground");
    }
    scene.add_plane(thickness, scene.add(trace::Interface{trace::vacuum, liquid}));
  }

  SceneTable root_;
  std::uint64_t seed_;
  std::size_t count_ = 0;
  double period_ = 0.0;
  bool rough_ = false;
};

}  // namespace

Surface surface_from_toml(std::string_view text, const std::string& file, std::uint64_t seed) {
  const toml::table table = parse_toml(text, file, "see host/surface/README.md for scene files");
  return Reader(SceneTable(table, file, ""), seed).read();
}

Surface read_surface(const std::filesystem::path& path, std::uint64_t seed) {
  std::ifstream stream(path, std::ios::binary);
  if (!stream) throw Error(Place{path.string()}, "cannot be read", "check its name");
  const std::string text((std::istreambuf_iterator<char>(stream)),
                         std::istreambuf_iterator<char>());
  return surface_from_toml(text, path.string(), seed);
}

}  // namespace umov::surface
