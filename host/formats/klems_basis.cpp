#include "host/formats/klems_basis.hpp"

#include <algorithm>
#include <array>
#include <cctype>
#include <cmath>
#include <numbers>
#include <utility>

#include "host/errors/error.hpp"
#include "host/optics/angles.hpp"

namespace umov::formats {
namespace {

constexpr double edge_tolerance_deg = 1e-4;

struct NamedBasis {
  std::string_view name;
  std::vector<KlemsRing> rings;
};

const std::array<NamedBasis, 3>& named() {
  static const std::array<NamedBasis, 3> bases{{
      {"LBNL/Klems Full",
       {{0, 5, 1},
        {5, 15, 8},
        {15, 25, 16},
        {25, 35, 20},
        {35, 45, 24},
        {45, 55, 24},
        {55, 65, 24},
        {65, 75, 16},
        {75, 90, 12}}},
      {"LBNL/Klems Half",
       {{0, 6.5, 1},
        {6.5, 19.5, 8},
        {19.5, 32.5, 12},
        {32.5, 46.5, 16},
        {46.5, 61.5, 20},
        {61.5, 76.5, 12},
        {76.5, 90, 4}}},
      {"LBNL/Klems Quarter", {{0, 9, 1}, {9, 27, 8}, {27, 46, 12}, {46, 66, 12}, {66, 90, 8}}},
  }};
  return bases;
}

bool same_text(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(), [](char x, char y) {
    return std::tolower(static_cast<unsigned char>(x)) ==
           std::tolower(static_cast<unsigned char>(y));
  });
}

void check(const std::string& name, const std::vector<KlemsRing>& rings) {
  const auto refuse = [&](const std::string& problem) {
    throw Error("angle basis \"" + name + "\": " + problem,
                "rings go from 0 to 90 deg without gaps, each with 1 patch or more");
  };
  if (rings.empty()) refuse("has no rings");
  if (rings.size() > KlemsBasis::max_rings) refuse("has too many rings");
  double edge = 0;
  int patches = 0;
  for (const KlemsRing& ring : rings) {
    if (std::abs(ring.lower_deg - edge) > edge_tolerance_deg)
      refuse("a ring begins at " + std::to_string(ring.lower_deg) +
             " deg where the one before ends at " + std::to_string(edge) + " deg");
    if (!(ring.upper_deg > ring.lower_deg)) refuse("a ring ends before it begins");
    if (ring.patches < 1 || ring.patches > KlemsBasis::max_patches)
      refuse("a ring has no sensible number of patches");
    patches += ring.patches;
    if (patches > KlemsBasis::max_patches) refuse("has too many patches");
    edge = ring.upper_deg;
  }
  if (std::abs(edge - 90) > edge_tolerance_deg) refuse("ends at " + std::to_string(edge) + " deg");
}

}  // namespace

double KlemsPatch::projected_solid_angle() const {
  const double lower = std::sin(theta_lower), upper = std::sin(theta_upper);
  return phi_half_width * (upper * upper - lower * lower);
}

KlemsBasis::KlemsBasis(std::string name, std::vector<KlemsRing> rings)
    : name_(std::move(name)), rings_(std::move(rings)) {
  check(name_, rings_);
  for (std::size_t r = 0; r < rings_.size(); ++r) {
    first_.push_back(patches_.size());
    const double width = 2 * std::numbers::pi / rings_[r].patches;
    for (int p = 0; p < rings_[r].patches; ++p)
      patches_.push_back({optics::radians(rings_[r].lower_deg),
                          optics::radians(rings_[r].upper_deg), width * p, width / 2, r});
  }
}

std::optional<KlemsBasis> KlemsBasis::by_name(std::string_view name) {
  for (const NamedBasis& basis : named())
    if (same_text(basis.name, name)) return KlemsBasis(std::string(basis.name), basis.rings);
  return std::nullopt;
}

std::size_t KlemsBasis::ring_of(double theta) const {
  const double theta_deg = theta * 180 / std::numbers::pi;
  for (std::size_t r = 0; r + 1 < rings_.size(); ++r)
    if (theta_deg < rings_[r].upper_deg) return r;
  return rings_.size() - 1;
}

std::size_t KlemsBasis::patch_of(double theta, double phi) const {
  const std::size_t ring = ring_of(theta);
  const int n = rings_[ring].patches;
  const double turn = phi / (2 * std::numbers::pi);
  const int p = static_cast<int>(std::floor((turn - std::floor(turn)) * n + 0.5)) % n;
  return first_[ring] + static_cast<std::size_t>(p);
}

}  // namespace umov::formats
