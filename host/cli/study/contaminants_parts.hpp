// What the parts of the contaminants study share.
#pragma once

#include <string>
#include <vector>

#include "host/cli/study/study.hpp"
#include "host/surface/scene_file.hpp"
#include "host/trace/simulation.hpp"

namespace umov::study {

/// Launches of a simulation unless said otherwise.
inline constexpr std::uint64_t launches = 1u << 20;
/// Launches after which particles are laid anew.
inline constexpr std::uint64_t launches_a_lay = 1u << 14;

/// Simulates the study's surfaces, one after the other, and tells how far it is.
class SurfaceBench {
 public:
  SurfaceBench(const Options& options, std::size_t simulations)
      : options_(options), simulations_(simulations) {}

  /// `text` is a scene file. Throws Stopped where the options say so.
  trace::Result simulate(const std::string& text, double theta_i_deg, surface::Reading reading,
                         std::uint64_t samples = launches);
  /// Share of light from an angle that meets particles of a scene file first.
  /// `number`: of its random numbers and lays; errors with the same go together.
  trace::Estimate hidden(const std::string& text, double theta_i_deg, std::uint64_t number) const;

  std::uint64_t rays() const { return rays_; }
  double lost() const { return lost_; }  ///< largest share of all simulations

 private:
  const Options& options_;
  std::size_t simulations_, done_ = 0;
  std::uint64_t rays_ = 0;
  double lost_ = 0.0;
};

/// Along the plane of incidence, means over all wavelengths; θr signed, degrees.
struct InPlane {
  std::vector<double> theta_deg;
  std::vector<double> brdf, brdf_u;  ///< 1/sr
  std::vector<double> s1, s1_u;      ///< m10/m00, signed

  std::vector<double> times_cosine() const;
  /// Mean BRDF from `low` to `high` degrees, weighted by the width of the cells.
  trace::Estimate mean(double low, double high) const;
  trace::Estimate mean_s1(double low, double high) const;
};
InPlane in_plane(const trace::Result& result, std::size_t wavelengths);

inline constexpr std::size_t bands = 11;
extern const char* const band_text;  ///< the first lines of every scene

void add_soil(Page& page, SurfaceBench& bench);
void add_water(Page& page, SurfaceBench& bench);
inline constexpr std::size_t soil_simulations = 2 * (1 + 2 * (1 + 5));
inline constexpr std::size_t water_simulations = 2 * (1 + 3 + 5);

}  // namespace umov::study
