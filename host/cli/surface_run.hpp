// A simulated surface from options to results: angles one after the other, shared by ranks, stopped
// and continued.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/cli/command.hpp"
#include "host/parallel/ranks/ranks.hpp"
#include "host/surface/scene_file.hpp"
#include "host/trace/simulation.hpp"

namespace umov::cli {

struct SurfaceOptions {
  std::string scene;
  std::string output;
  std::vector<double> theta_i_deg;      ///< empty: the scene's, else 0
  std::optional<double> samples;        ///< launches at most an angle
  double relative_error_percent = 0.0;  ///< 0: the scene's
  std::size_t rings = 18;
  std::size_t strip = 180;
  double strip_half_width_deg = 2.0;
  bool resume = false;

  /// Where the state of a stopped run is kept.
  std::string state_file() const { return output + ".state"; }
};

/// Simulates one surface after the other, with progress, alone or as one of several ranks.
class SurfaceRun {
 public:
  SurfaceRun(const SurfaceOptions& options, const Common& common, const Ranks& ranks);

  /// Angles of incidence in degrees: of the options, else of the scene.
  std::vector<double> angles(const surface::Surface& described) const;

  /// What the options and the scene ask of a simulation, but for θi. Valid as long as this.
  trace::Request request(const surface::Surface& described) const;

  /// The results of all angles, or of those until Ctrl-C. With an output file, the state is kept
  /// beside it each minute and at Ctrl-C, and taken up where the options say so.
  std::vector<trace::Result> simulate(const surface::Surface& described);

  /// Was it Ctrl-C that ended simulate()?
  bool interrupted() const { return interrupted_; }
  bool first_rank() const { return ranks_.rank() == 0; }

 private:
  const SurfaceOptions& options_;
  const Common& common_;
  const Ranks& ranks_;
  bool interrupted_ = false;
};

}  // namespace umov::cli
