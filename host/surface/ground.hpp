// The ground that particles rest on: flat, or heights on a square that repeats.
#pragma once

#include <cstddef>
#include <vector>

namespace umov::surface {

class Ground {
 public:
  /// Flat, at `z`.
  explicit Ground(double z = 0.0) : flat_(z) {}
  /// side × side heights over a square of `size`, as trace::Scene::add_height_field() takes them.
  Ground(std::vector<double> heights, std::size_t side, double size);

  bool rough() const { return !heights_.empty(); }
  /// Height of the centre of a sphere of `radius` over (x, y) that has sunk until it touches a
  /// summit of the heights. A facet it may enter, by less than its size times its slope.
  double rest(double x, double y, double radius) const;
  /// Mean height below a disc.
  double level(double x, double y, double radius) const;

 private:
  template <class Act>
  void each_below(double x, double y, double radius, const Act& act) const;

  double flat_ = 0.0;
  std::vector<double> heights_;
  std::size_t side_ = 0;
  double size_ = 0.0;
};

}  // namespace umov::surface
