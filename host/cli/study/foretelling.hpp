// How well values in directions that were not fitted are foretold: scores, where the misses lie,
// and what in-plane points foretell without any model.
#pragma once

#include <array>
#include <cstddef>
#include <string_view>
#include <vector>

#include "host/formats/brdf_table.hpp"

namespace umov::study {

/// A direction as interpolations and tables of misses see it, degrees.
struct Direction {
  double theta_i_deg = 0, theta_r_deg = 0, phi_r_deg = 0;
  double half_deg = 0;        ///< θh, polar angle of the half vector
  double difference_deg = 0;  ///< θd, angle between the half vector and either beam
  double off_mirror_deg = 0;  ///< between the direction and the mirror direction
  bool in_plane = false;      ///< within .5 deg
};
/// `theta_r_deg` signed in plane.
Direction direction_at(double theta_i_deg, double theta_r_deg, double phi_r_deg);

/// Where a direction lies; the first that applies.
enum class Region {
  lobe,     ///< θh < 10 deg: the surface's mirror lobe
  grazing,  ///< θi or |θr| >= 70 deg
  retro,    ///< θd < 15 deg: detector near the source
  other,
};
inline constexpr std::array region_names = {"lobe, θh < 10°", "grazing, θi or θr ≥ 70°",
                                            "retro, θd < 15°", "elsewhere"};
Region region_of(const Direction& direction);

/// Sizes of relative errors: median and 90th percentile; `offset` is the median with sign, foretold
/// − measured.
struct Score {
  std::size_t points = 0;
  double median = 0, p90 = 0;
  double offset = 0;
};
/// |foretold/measured − 1| over `at` (indices into both); not finite foretellings count as 1.
Score score(const std::vector<double>& foretold, const std::vector<double>& measured,
            const std::vector<std::size_t>& at);
/// What perfect foretelling of noisy values would score: normal noise of `relative_u` at each
/// point.
Score noise_score(const std::vector<double>& relative_u, const std::vector<std::size_t>& at);

/// Points in the (θh, θd) plane with values to be interpolated among them.
class HalfAnglePlane {
 public:
  void add(const Direction& direction, double value);
  bool empty() const { return points_.empty(); }
  /// A plane through the eight nearest points, weighted by 1/(distance² + (1 deg)²), held within
  /// the values of those eight.
  double at(const Direction& direction) const;

 private:
  struct Point {
    double half_deg, difference_deg, value;
  };
  std::vector<Point> points_;
};

/// In-plane curves of each incidence over the angle to the mirror direction, both sides of it
/// together; straight lines between points, and between incidences.
class MirrorAngleCurves {
 public:
  void add(const Direction& direction, double value);
  /// At an incidence that was measured or between two of them; the nearest beyond.
  double at(const Direction& direction) const;

 private:
  struct Curve {
    double theta_i_deg;
    std::vector<std::array<double, 2>> points;  ///< angle and value, ascending
  };
  static double on(const Curve& curve, double off_mirror_deg);
  std::vector<Curve> curves_;  ///< ascending incidence
};

}  // namespace umov::study
