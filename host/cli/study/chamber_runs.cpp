#include "host/cli/study/chamber_runs.hpp"

#include <cmath>

#include "host/chamber/synthetic_mcpet.hpp"
#include "host/optics/angles.hpp"
#include "host/trace/random_stream.hpp"

namespace umov::study {

using chamber::MixingChamber;
using chamber::Surface;

std::vector<WallModel> wall_models() {
  const brdf::PlanesTable table = chamber::synthetic_mcpet(chamber::mcpet_theta_i_deg, 2.5);
  return {{"diffuse", "diffuse",
           std::make_shared<const Surface>("diffuse", chamber::Lambertian{chamber::mcpet_total})},
          {"diffuse-specular", "diffuse/specular",
           std::make_shared<const Surface>("diffuse/specular", chamber::mcpet_diffuse_specular())},
          {"tabular", "tabular",
           std::make_shared<const Surface>(
               "tabular", chamber::PlanesSurface(table, 0, chamber::mcpet_total))}};
}

std::shared_ptr<const Surface> plastic_wall(double total) {
  return std::make_shared<const Surface>("plastic",
                                         chamber::PlanesSurface(chamber::dense_mcpet(), 0, total));
}

MixingChamber known_chamber() {
  return {};
}

MixingChamber measured_chamber() {
  MixingChamber m;
  m.ring_radius_mm = 8.1;
  m.depth_mm = 1.08;
  m.shift_x_mm = 0.15;
  m.shift_y_mm = -0.10;
  m.flux_lm = {0.97, 0.945, 0.965, 0.96};
  m.edge_rho = 0.04;
  m.view_deg = 55.4;
  m.wall = plastic_wall(chamber::mcpet_total - 0.001);
  return m;
}

std::vector<std::string> withheld() {
  return {"the BRDF between and beyond the six incidences and the 2.5° steps of the table",
          "ring of holes 8.1 mm instead of 8; sources 1.08 mm below the base instead of 1, and "
          "moved by (0.15, −0.10) mm",
          "sources of 0.97, 0.945, 0.965 and 0.96 lm instead of 0.96",
          "edges of the holes reflect 4 % instead of nothing; the wall .983 instead of .984",
          "observer at 55.4° instead of 55°; noise of the camera of 0.5 %"};
}

void add_camera_noise(chamber::Map& map, std::uint64_t seed) {
  for (std::size_t i = 0; i < map.luminance_cd_m2.size(); ++i) {
    const auto u = trace::uniforms(seed, i, 0x5eed);
    const double normal = std::sqrt(-2.0 * std::log(u[0])) * std::cos(2.0 * optics::pi * u[1]);
    double& value = map.luminance_cd_m2[i];
    map.luminance_se[i] = std::hypot(map.luminance_se[i], camera_noise * value);
    value *= 1.0 + camera_noise * normal;
  }
}

chamber::Region printed_region() {
  return {15.0, 35.0, 15.0, 23.0};
}

chamber::Region centred_region() {
  return {20.0, 40.0, 15.0, 23.0};
}

chamber::Map inside_only(const chamber::Map& map, const chamber::Region& region,
                         const MixingChamber& chamber) {
  const double mid_x = 0.5 * map.pixel_mm * static_cast<double>(map.width);
  const double mid_y = 0.5 * map.pixel_mm * static_cast<double>(map.height);
  const double a = 0.5 * chamber.diameter_mm - map.pixel_mm;
  const double b = a * std::cos(optics::radians(chamber.view_deg));
  chamber::Map part;
  part.height = 1;
  part.pixel_mm = map.pixel_mm;
  part.rays_per_pixel = map.rays_per_pixel;
  for (std::size_t y = 0; y < map.height; ++y) {
    for (std::size_t x = 0; x < map.width; ++x) {
      const double mm_x = map.pixel_mm * (static_cast<double>(x) + 0.5);
      const double mm_y = map.pixel_mm * (static_cast<double>(y) + 0.5);
      if (mm_x < region.x_from_mm || mm_x > region.x_to_mm || mm_y < region.y_from_mm ||
          mm_y > region.y_to_mm ||
          std::pow((mm_x - mid_x) / a, 2) + std::pow((mm_y - mid_y) / b, 2) > 1.0) {
        continue;
      }
      part.luminance_cd_m2.push_back(map.at(x, y));
      part.luminance_se.push_back(map.luminance_se[y * map.width + x]);
      ++part.width;
    }
  }
  return part;
}

}  // namespace umov::study
