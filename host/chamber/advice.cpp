#include "host/chamber/advice.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"

namespace umov::chamber {
namespace {

using optics::radians;

constexpr std::size_t most_pixels = 2000;
/// Where a sphere illuminates its sample.
constexpr double sphere_deg = 8.0;

Vec3 direction(double in_plane, double beta) {
  return {std::sin(in_plane) * std::cos(beta), std::sin(beta), std::cos(in_plane) * std::cos(beta)};
}

Vec3 light_from(double theta) {
  return {-std::sin(theta), 0.0, std::cos(theta)};
}

/// What one version of the luminaire gives.
struct Taken {
  std::optional<Map> map;
  std::optional<Distribution> distribution;
  std::optional<double> ugr;
};

/// A poorer description of a surface.
struct Variant {
  std::string knows;
  int readings;
  std::shared_ptr<const Surface> surface;
};

std::vector<Variant> variants(const Surface& full) {
  const double total = std::min(1.0, full.reflectance(sphere_deg));
  std::vector<Variant> all;
  all.push_back(
      {"reflectance alone", 1, std::make_shared<Surface>(full.name(), Lambertian{total})});
  const std::array six{5.0, 25.0, 45.0, 60.0, 70.0, 80.0};
  std::vector<double> specular;
  for (const double theta : six)
    specular.push_back(std::min(total, measured_specular(full, theta)));
  all.push_back({"reflectance and 6 specular readings", 7,
                 std::make_shared<Surface>(
                     full.name(), DiffuseSpecular(total, {six.begin(), six.end()}, specular))});
  const std::vector<std::pair<std::vector<double>, double>> tables{
      {{10.0, 70.0}, 10.0},
      {{5.0, 45.0, 75.0}, 10.0},
      {{5.0, 45.0, 75.0}, 5.0},
      {{six.begin(), six.end()}, 5.0},
      {{six.begin(), six.end()}, 2.5},
      {{5, 15, 25, 35, 45, 52.5, 60, 65, 70, 75, 80, 85}, 2.5}};
  for (const auto& [incidences, step] : tables) {
    const brdf::PlanesTable table = measured_planes(full, incidences, step);
    int readings = 1;
    for (const auto& slice : table.incidences())
      readings += static_cast<int>(slice.in_plane.deg.size() + slice.across.deg.size());
    std::shared_ptr<const Surface> surface;
    try {
      surface = std::make_shared<Surface>(full.name(), PlanesSurface(table, 0, total));
    } catch (const Error&) {
      continue;  // too coarse to hold its light: nobody could use it
    }
    all.push_back({fmt::format("{} incidences, every {:g}° in two planes", incidences.size(), step),
                   readings, std::move(surface)});
  }
  return all;
}

class Adviser {
 public:
  Adviser(const Job& job, const AdviceRequest& request) : job_(job), request_(request) {
    if (!job.camera) return;
    camera_ = *job.camera;
    while (camera_.width * camera_.height > most_pixels) {
      camera_.width = (camera_.width + 1) / 2;
      camera_.height = (camera_.height + 1) / 2;
      camera_.pixel_mm *= 2.0;
    }
  }

  Advice run() {
    std::vector<std::shared_ptr<const Surface>> ablated;
    for (const auto& surface : job_.luminaire.surfaces) {
      if (std::holds_alternative<Lambertian>(surface->kind())) continue;
      if (std::find(ablated.begin(), ablated.end(), surface) != ablated.end()) continue;
      if (surface->bands() > 1) {
        throw Error(Place{surface->name()},
                    "has a spectrum, and what is left out of it would be too",
                    "give it its values at one wavelength: advice is about directions");
      }
      ablated.push_back(surface);
    }
    if (ablated.empty()) {
      throw Error("every surface of the scene is Lambertian: there is nothing to leave out",
                  "give the surface in question the best BRDF there is, say a table");
    }
    jobs_ = 2.0 + 8.0 * static_cast<double>(ablated.size());
    const Taken full = take(job_.luminaire, request_.seed);
    // The same again: what differs is noise.
    const Taken again = take(job_.luminaire, request_.seed + 1);
    const Ablation noise = compare(full, again);
    Advice advice;
    for (const auto& surface : ablated) {
      std::vector<Ablation> own;
      for (const Variant& variant : variants(*surface)) {
        Luminaire changed = job_.luminaire;
        for (auto& one : changed.surfaces) {
          if (one == surface) one = variant.surface;
        }
        Ablation a = compare(full, take(changed, request_.seed + 1));
        a.surface = surface->name();
        a.knows = variant.knows;
        a.readings = variant.readings;
        beyond(a.intensity, noise.intensity);
        beyond(a.luminance, noise.luminance);
        own.push_back(std::move(a));
      }
      say(own, advice.sentences);
      advice.ablations.insert(advice.ablations.end(), own.begin(), own.end());
    }
    return advice;
  }

 private:
  Taken take(const Luminaire& luminaire, std::uint64_t seed) {
    if (request_.progress) request_.progress(done_ / jobs_);
    done_ += 1.0;
    const Tracer tracer(luminaire);
    Taken taken;
    if (job_.camera) {
      MapRequest map;
      map.rays_per_pixel = request_.rays_per_pixel;
      map.seed = seed;
      map.threads = request_.threads;
      map.team = request_.team;
      const Map whole = luminance_map(tracer, camera_, map);
      if (job_.glare) taken.ugr = glare_rating(whole, *job_.glare).ugr_map;
      taken.map = job_.region ? cut(whole, *job_.region) : whole;
    }
    if (job_.distribution) {
      DistributionRequest request = *job_.distribution;
      request.rays = request_.launches;
      request.seed = seed;
      request.threads = request_.threads;
      request.team = request_.team;
      request.progress = {};
      taken.distribution = intensity_distribution(tracer, request);
    }
    return taken;
  }

  static Ablation compare(const Taken& full, const Taken& other) {
    Ablation a;
    if (full.map) {
      const Likeness l = likeness(*full.map, *other.map);
      a.luminance = l.nrmse;
      a.ncc = l.ncc;
    }
    if (full.ugr) a.ugr = std::abs(*full.ugr - *other.ugr);
    if (full.distribution) a.intensity = difference(*full.distribution, *other.distribution).rms;
    return a;
  }

  static void beyond(std::optional<double>& value, const std::optional<double>& noise) {
    if (value) value = std::sqrt(std::max(0.0, *value * *value - *noise * *noise));
  }

  // The least that is enough for each quantity.
  void say(const std::vector<Ablation>& own, std::vector<std::string>& sentences) const {
    const auto speak = [&](const char* quantity, const char* unit, double scale, double tolerance,
                           std::optional<double> Ablation::*value) {
      if (!(own.front().*value)) return;
      const auto within = [&](const Ablation& a) { return *(a.*value) <= tolerance; };
      const auto found = std::find_if(own.begin(), own.end(), within);
      const auto off = [&](const Ablation& a) {
        return fmt::format("{:.2g}{}", scale * *(a.*value), unit);
      };
      const std::string name = "`" + own.front().surface + "`";
      const std::string limit = fmt::format("{:g}{}", scale * tolerance, unit);
      if (found == own.end()) {
        sentences.push_back(
            fmt::format("{}: nothing that was tried holds {}; {} of {} is {} off. Measure closer.",
                        quantity, limit, own.back().knows, name, off(own.back())));
        return;
      }
      std::string sentence = fmt::format(
          "{}: {} of {} is enough, {} reading{}: {} off (tolerance {})", quantity, found->knows,
          name, found->readings, found->readings == 1 ? "" : "s", off(*found), limit);
      if (found != own.begin()) {
        const Ablation& poorer = *(found - 1);
        sentence += fmt::format("; with {} it is {} off", poorer.knows, off(poorer));
      }
      // More readings of the wrong kind can do harm.
      const auto worse = std::find_if_not(found, own.end(), within);
      if (worse != own.end()) {
        sentence += fmt::format("; but {} would be {} off: too coarse a table is worse than none",
                                worse->knows, off(*worse));
      }
      sentences.push_back(sentence + ".");
    };
    const Tolerances& t = request_.tolerances;
    speak("Intensity distribution", " % of the peak", 100.0, t.intensity, &Ablation::intensity);
    speak("Luminance map", " %", 100.0, t.luminance, &Ablation::luminance);
    speak("UGR", "", 1.0, t.ugr, &Ablation::ugr);
  }

  const Job& job_;
  const AdviceRequest& request_;
  Camera camera_;
  double jobs_ = 1.0, done_ = 0.0;
};

}  // namespace

Advice advise(const Job& job, const AdviceRequest& request) {
  return Adviser(job, request).run();
}

brdf::PlanesTable measured_planes(const Surface& surface, const std::vector<double>& theta_i_deg,
                                  double step_deg) {
  std::vector<brdf::PlanesAtIncidence> incidences;
  for (const double incidence : theta_i_deg) {
    brdf::PlanesAtIncidence slice;
    slice.theta_i_deg = incidence;
    slice.in_plane.brdf_per_sr.resize(1);
    slice.across.brdf_per_sr.resize(1);
    const double theta = radians(incidence);
    const int last = static_cast<int>(std::ceil(90.0 / step_deg)) - 1;
    for (int i = -last; i <= last; ++i) {
      const double angle = i * step_deg;
      slice.in_plane.deg.push_back(angle);
      slice.in_plane.brdf_per_sr[0].push_back(
          surface.value(light_from(theta), direction(radians(angle), 0.0)));
      if (i < 0) continue;
      slice.across.deg.push_back(angle);
      slice.across.brdf_per_sr[0].push_back(
          surface.value(light_from(theta), direction(theta, radians(angle))));
    }
    incidences.push_back(std::move(slice));
  }
  return brdf::PlanesTable({0.555}, std::move(incidences), surface.name());
}

double measured_specular(const Surface& surface, double theta_i_deg) {
  if (const auto* two = std::get_if<DiffuseSpecular>(&surface.kind()))
    return two->specular_at(std::cos(radians(theta_i_deg)));
  const double theta = radians(theta_i_deg);
  const double half = radians(2.5);
  const double level = surface.value(light_from(theta), direction(theta, radians(60.0)));
  constexpr int radii = 12;
  constexpr int turns = 24;
  double sum = 0.0;
  for (int i = 0; i < radii; ++i) {
    for (int k = 0; k < turns; ++k) {
      const double away = half * std::sqrt((i + 0.5) / radii);
      const double turn = 2.0 * optics::pi * (k + 0.5) / turns;
      const Vec3 to = direction(theta + away * std::cos(turn), away * std::sin(turn));
      if (to.z > 0.0) sum += std::max(0.0, surface.value(light_from(theta), to) - level) * to.z;
    }
  }
  double specular = sum / (radii * turns) * 2.0 * optics::pi * (1.0 - std::cos(half));
  if (const auto* model = std::get_if<Modelled>(&surface.kind())) {
    const double probability = model->sampler.mirror_probability(theta);
    if (probability > 0.0) {
      const auto mirrored = model->sampler.sample(theta, 0.5, 0.5, 0.0);
      if (mirrored && mirrored->mirror) specular += probability * mirrored->weight[0][0];
    }
  }
  return specular;
}

}  // namespace umov::chamber
