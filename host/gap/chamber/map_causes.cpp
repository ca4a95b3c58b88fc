#include "host/gap/chamber/map_causes.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <memory>
#include <string>
#include <utility>

#include <fmt/format.h>

#include "host/chamber/synthetic_mcpet.hpp"
#include "host/optics/frames.hpp"

namespace umov::gap {
namespace {

using chamber::Departure;
using chamber::Described;
using chamber::Luminaire;
using chamber::Surface;
using chamber::View;

/// Widths of lobes that are tried: half an octave apart, so that two of them stand for one between
/// without a rest that a source elsewhere would explain.
constexpr std::array lobe_widths{0.06, 0.085, 0.12, 0.17, 0.24};
/// Usual errors of a luminaire that fills a window of this size, [M]'s.
constexpr double usual_size_mm = 60.0;
/// Of the flux of sources of one kind about its mean.
constexpr double usual_excess = 0.05;
/// Beyond this many sources single ones are not told apart.
constexpr std::size_t most_single_sources = 8;

/// A surface of the luminaire that sends light back: the faces it covers.
struct Coat {
  std::string name;
  double total;  ///< its reflectance at 45°
  std::vector<std::size_t> materials;
};

std::vector<Coat> coats_of(const Luminaire& luminaire) {
  std::vector<Coat> coats;
  std::vector<const Surface*> known;
  for (std::size_t m = 0; m < luminaire.surfaces.size(); ++m) {
    const Surface* surface = luminaire.surfaces[m].get();
    if (surface->black() || luminaire.emitter_of[m] >= 0) continue;
    const auto place = std::find(known.begin(), known.end(), surface);
    if (place == known.end()) {
      known.push_back(surface);
      coats.push_back({surface->name(), surface->reflectance(45.0), {m}});
    } else {
      coats[static_cast<std::size_t>(place - known.begin())].materials.push_back(m);
    }
  }
  return coats;
}

std::shared_ptr<const Surface> matt(double rho) {
  return std::make_shared<const Surface>("matt", chamber::Lambertian{rho});
}

Parameter sized(std::string name, const char* unit, const char* meaning, double usual) {
  Parameter p{std::move(name), unit, meaning};
  p.prior_u = usual;
  return p;
}

Effect effect(const char* name, const char* stage, const char* physics) {
  Effect e{name, stage, physics, "Opt. Eng. 52, 095101", {}};
  e.linear = true;
  return e;
}

/// The luminaire with another surface in place of a coat.
View coated(const Described& luminaire, const Coat& coat,
            const std::shared_ptr<const Surface>& surface) {
  View v = luminaire.view({});
  for (const std::size_t m : coat.materials) v.luminaire.surfaces[m] = surface;
  return v;
}

class Catalogue {
 public:
  Catalogue(const Described& luminaire, double size_mm)
      : luminaire_(luminaire), scale_(size_mm / usual_size_mm) {
    const View plain = luminaire.view({});
    camera_ = plain.camera;
    emitters_ = plain.luminaire.emitters;
    coats_ = coats_of(plain.luminaire);
  }

  MapCauses list() {
    for (const Coat& coat : coats_) of_coat(coat);
    position();
    depth();
    exitance();
    edges();
    observer();
    return std::move(out_);
  }

 private:
  /// What `change` makes of no departure at all.
  std::function<View(double)> departed(std::function<void(Departure&, double)> change) const {
    return [&described = luminaire_, change = std::move(change)](double amount) {
      Departure d;
      change(d, amount);
      return described.view(d);
    };
  }

  /// An effect of one coat, of one parameter that is zero or more.
  void add_of_coat(const Coat& coat, Effect e, const std::string& family, Parameter p, double step,
                   std::function<std::shared_ptr<const Surface>(double)> surface) {
    e.of_object = true;
    e.family = coats_.size() > 1
                   ? fmt::format("{}{}{}", coat.name, family.empty() ? "" : ", ", family)
                   : family;
    const auto view = [&described = luminaire_, coat, surface = std::move(surface)](double amount) {
      return coated(described, coat, surface(amount));
    };
    out_.causes.push_back({std::move(e), {{std::move(p), step, view}}, out_.origins.size() - 1});
  }

  void of_coat(const Coat& coat) {
    out_.origins.push_back(
        [&described = luminaire_, coat] { return coated(described, coat, matt(coat.total)); });
    for (const double alpha : lobe_widths) {
      Parameter p = sized("strength", "1", "over that of a smooth plastic of n = 1.6", 0.5);
      p.lo = 0.0;
      // The table's lobe sits on a white body and is scaled with it to the coat's reflectance.
      const double whole = coat.total / chamber::mcpet_total;
      add_of_coat(coat,
                  effect("near_specular_lobe", "wall",
                         "the wall scatters about the mirror direction, more so towards grazing: "
                         "blurred highlights and a brighter wall around them"),
                  fmt::format("alpha {:g}", alpha), p, whole, [alpha, total = coat.total](double) {
                    return std::make_shared<const Surface>(
                        "glossy",
                        chamber::PlanesSurface(chamber::synthetic_plastic(
                                                   alpha, chamber::mcpet_theta_i_deg, 2.5, total),
                                               0, total));
                  });
    }
    Parameter share = sized("share", "1", "mirrored part of the light", 0.01);
    share.lo = 0.0;
    add_of_coat(coat,
                effect("mirror_reflection", "wall",
                       "a share of the light is mirrored: images of the sources with sharp edges"),
                "", share, std::min(0.02, coat.total), [total = coat.total](double amount) {
                  return std::make_shared<const Surface>(
                      "mirror", chamber::DiffuseSpecular{total, {0.0}, {amount}});
                });
    add_of_coat(
        coat, effect("wall_absorption", "wall", "the wall absorbs more than the simulation's"), "",
        sized("absorbed", "1", "more of each reflection", 0.005), std::min(0.01, 0.5 * coat.total),
        [total = coat.total](double amount) { return matt(total - amount); });
  }

  void add(Effect e, std::vector<MapChange> changes) {
    if (!changes.empty()) out_.causes.push_back({std::move(e), std::move(changes)});
  }

  void position() {
    const double usual = 0.2 * scale_;
    const double step = 0.4 * scale_;
    std::vector<MapChange> changes{
        {sized("shift_x_mm", "mm", "of all, along x", usual), step,
         departed([](Departure& d, double amount) { d.shift_x_mm = amount; })},
        {sized("shift_y_mm", "mm", "of all, along y", usual), step,
         departed([](Departure& d, double amount) { d.shift_y_mm = amount; })}};
    if (luminaire_.rings) {
      changes.push_back({sized("ring_mm", "mm", "radius of their ring", usual), step,
                         departed([](Departure& d, double amount) { d.ring_mm = amount; })});
    }
    add(effect("source_position", "sources", "sources, and holes above them, stand elsewhere"),
        std::move(changes));
  }

  void depth() {
    if (!luminaire_.least_depth_mm) return;
    Parameter p = sized("depth_mm", "mm", "deeper", 0.1 * scale_);
    p.lo = -*luminaire_.least_depth_mm;
    add(effect("source_depth", "sources", "the sources lie deeper below the base"),
        {{p, 0.1 * scale_, departed([](Departure& d, double amount) { d.depth_mm = amount; })}});
  }

  void exitance() {
    Effect e = effect("source_exitance", "sources",
                      "the sources shine unequally; all together as much as stated");
    if (emitters_.size() > most_single_sources) return add(std::move(e), exitance_across());
    std::vector<MapChange> changes = exitance_of_each();
    if (changes.empty()) return;
    out_.origins.push_back(
        [&described = luminaire_, alone = alone(0)] { return described.view(alone); });
    out_.causes.push_back({std::move(e), std::move(changes), out_.origins.size() - 1});
  }

  /// One source with the flux of the first, and no other.
  Departure alone(std::size_t source) const {
    Departure d;
    d.excess.assign(emitters_.size(), -1.0);
    d.excess[source] += emitters_[0].flux_lm / emitters_[source].flux_lm;
    return d;
  }

  std::vector<MapChange> exitance_of_each() const {
    std::vector<MapChange> changes;
    for (std::size_t k = 1; k < emitters_.size(); ++k) {
      const double flux = emitters_[k].flux_lm;
      if (!(flux > 0.0) || !(emitters_[0].flux_lm > 0.0)) continue;
      // Light of one source in the place of as much of another's: as if all of the first were.
      changes.push_back(
          {sized(fmt::format("source_{}", k + 1), "1",
                 "of its flux, more than stated; source 1 has as much less", usual_excess),
           emitters_[0].flux_lm / flux,
           [&described = luminaire_, alone = alone(k)](double) { return described.view(alone); }});
    }
    return changes;
  }

  std::vector<MapChange> exitance_across() const {
    std::vector<MapChange> changes;
    for (const bool upwards : {false, true}) {
      const chamber::Vec3 axis = upwards ? camera_.up() : camera_.right();
      std::vector<double> place;
      double mean = 0.0, flux = 0.0, most = 0.0;
      for (const chamber::Emitter& e : emitters_) {
        place.push_back(optics::dot(axis, e.centre));
        mean += e.flux_lm * place.back();
        flux += e.flux_lm;
      }
      for (double& p : place) {
        p -= mean / flux;
        most = std::max(most, std::abs(p));
      }
      if (!(most > 0.0)) continue;
      for (double& p : place) p /= most;
      changes.push_back({sized(upwards ? "top_bottom" : "right_left", "1",
                               "flux of the outermost source in the map, more than stated, the "
                               "others in proportion to their place",
                               usual_excess),
                         1.0, departed([place](Departure& d, double amount) {
                           for (const double p : place) d.excess.push_back(amount * p);
                         })});
    }
    return changes;
  }

  void edges() {
    if (luminaire_.least_depth_mm.value_or(0.0) <= 0.0) return;
    Parameter p = sized("rho", "1", "reflectance of the edges, more than described", 0.05);
    p.lo = 0.0;
    add(effect("hole_edge_reflection", "holes", "the edges of the holes are not quite black"),
        {{p, 0.2, departed([](Departure& d, double amount) { d.edge_rho = amount; })}});
  }

  void observer() {
    add(effect("observer_angle", "camera", "the camera looks from another angle"),
        {{sized("view_deg", "deg", "further from the axis", 0.3), 0.5,
          departed([](Departure& d, double amount) { d.view_deg = amount; })}});
  }

  const Described& luminaire_;
  double scale_;
  chamber::Camera camera_;
  std::vector<chamber::Emitter> emitters_;
  std::vector<Coat> coats_;
  MapCauses out_;
};

}  // namespace

MapCauses map_causes(const Described& luminaire, double size_mm) {
  return Catalogue(luminaire, size_mm).list();
}

double size_of(const chamber::Camera& camera) {
  return camera.pixel_mm * static_cast<double>(std::max(camera.width, camera.height));
}

std::vector<Effect> map_effects(const Described& luminaire) {
  std::vector<Effect> effects;
  for (MapCause& cause : map_causes(luminaire, size_of(luminaire.view({}).camera)).causes) {
    effects.push_back(std::move(cause.effect));
    for (MapChange& change : cause.changes)
      effects.back().parameters.push_back(std::move(change.parameter));
  }
  return effects;
}

}  // namespace umov::gap
