#include "host/calibrate/declared_causes.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include <fmt/format.h>

#include "host/optics/angles.hpp"

namespace umov::calibrate {

namespace {

class Causes {
 public:
  Causes(const formats::BrdfTable::Points& points, const std::vector<PointOrigin>& origin,
         const Calibration& calibration)
      : points_(points),
        origin_(origin),
        calibration_(calibration),
        declared_(calibration.declared) {}

  std::vector<DeclaredCause> all() {
    add_detector_arm();
    add_incidence();
    add_source();
    if (declared_.solid_angle_relative_u > 0)
      add("solid angle", [&](std::size_t i) {
        return origin_[i].other_solid_angle
                   ? points_.brdf_per_sr[i] * declared_.solid_angle_relative_u
                   : 0.0;
      });
    if (declared_.aperture_half_angle_deg > 0)
      add("aperture", [&](std::size_t i) { return -origin_[i].aperture_doubt_per_sr; });
    return std::move(causes_);
  }

 private:
  template <class Shift>
  void add(std::string name, const Shift& shift) {
    DeclaredCause cause{std::move(name), std::vector<double>(points_.size(), 0.0)};
    for (std::size_t i = 0; i < points_.size(); ++i) cause.own_per_sr[i] = shift(i);
    causes_.push_back(std::move(cause));
  }

  /// One cause for each value of `key`, in ascending order.
  template <class Key, class Name, class Shift>
  void add_each(const Key& key, const Name& name, const Shift& shift) {
    std::map<std::pair<double, double>, std::vector<std::size_t>> members;
    for (std::size_t i = 0; i < points_.size(); ++i) members[key(i)].push_back(i);
    for (const auto& [value, list] : members) {
      DeclaredCause cause{name(value), std::vector<double>(points_.size(), 0.0)};
      for (std::size_t i : list) cause.own_per_sr[i] = shift(i);
      causes_.push_back(std::move(cause));
    }
  }

  /// In the plane of incidence a lean takes from θr what it adds to θi.
  double along_plane(std::size_t i) const {
    return std::cos(optics::radians(points_.phi_r_deg[i]));
  }

  void add_detector_arm() {
    for (std::size_t k = 0; k < calibration_.systematics.size(); ++k) {
      const Systematic& systematic = calibration_.systematics[k];
      const auto moved = [&](std::size_t i) {
        return origin_[i].by_detector_per_sr_deg *
               detector_shift_deg(systematic, declared_, origin_[i].theta_r_commanded_deg,
                                  origin_[i].direction);
      };
      switch (systematic.kind) {
        case Systematic::Kind::detector_zero:
          add("detector zero", moved);
          break;
        case Systematic::Kind::detector_eccentricity:
          add(fmt::format("detector eccentricity {}", systematic.cause + 1), moved);
          break;
        case Systematic::Kind::detector_play:
          add("detector play", moved);
          break;
        case Systematic::Kind::standard_lean:
          causes_.push_back({"standard lean", {}});
          break;
        default:
          continue;
      }
      causes_.back().through_standard = k;
    }
    if (declared_.position_u_deg > 0)
      add_each(
          [&](std::size_t i) { return std::pair(rounded(origin_[i].theta_r_commanded_deg), 0.0); },
          [](const auto& at) { return fmt::format("detector stop {:g}", at.first); },
          [&](std::size_t i) {
            return origin_[i].by_detector_per_sr_deg * declared_.position_u_deg;
          });
  }

  void add_incidence() {
    if (declared_.theta_i_zero_u_deg > 0)
      add("incidence zero", [&](std::size_t i) {
        return origin_[i].by_incidence_per_sr_deg * declared_.theta_i_zero_u_deg;
      });
    if (declared_.sample_lean_u_deg > 0)
      add("sample lean", [&](std::size_t i) {
        return (origin_[i].by_incidence_per_sr_deg -
                origin_[i].by_detector_per_sr_deg * along_plane(i)) *
               declared_.sample_lean_u_deg;
      });
    if (declared_.position_u_deg > 0)
      add_each(
          [&](std::size_t i) { return std::pair(rounded(origin_[i].theta_i_commanded_deg), 0.0); },
          [](const auto& at) { return fmt::format("incidence stop {:g}", at.first); },
          [&](std::size_t i) {
            return origin_[i].by_incidence_per_sr_deg * declared_.position_u_deg;
          });
  }

  void add_source() {
    const double u = declared_.source_relative_u;
    if (!(u > 0)) return;
    const auto share = [&](std::size_t i) { return points_.brdf_per_sr[i] * u; };
    const auto nm = [&](std::size_t i) {
      return calibration_.wavelengths[origin_[i].wavelength].wavelength_nm;
    };
    add_each([&](std::size_t i) { return std::pair(nm(i), 0.0); },
             [](const auto& at) { return fmt::format("source {:g} nm", at.first); }, share);
    add_each(
        [&](std::size_t i) { return std::pair(nm(i), rounded(origin_[i].theta_i_commanded_deg)); },
        [](const auto& at) { return fmt::format("source {:g} nm {:g}", at.first, at.second); },
        share);
  }

  static double rounded(double angle_deg) { return std::round(angle_deg * 1e3) / 1e3 + 0.0; }

  const formats::BrdfTable::Points& points_;
  const std::vector<PointOrigin>& origin_;
  const Calibration& calibration_;
  const DeclaredDoubts& declared_;
  std::vector<DeclaredCause> causes_;
};

}  // namespace

std::vector<DeclaredCause> declared_causes(const formats::BrdfTable::Points& points,
                                           const std::vector<PointOrigin>& origin,
                                           const Calibration& calibration) {
  const bool any = std::any_of(declared_keys.begin(), declared_keys.end(), [&](const auto& key) {
    return calibration.declared.*key.value > 0;
  });
  if (!any) return {};
  return Causes(points, origin, calibration).all();
}

}  // namespace umov::calibrate
