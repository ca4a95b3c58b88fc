// A simulated surface from options to results: angles one after the other, shared by ranks, stopped
// and continued.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "host/cli/command.hpp"
#include "host/cli/kept_run.hpp"
#include "host/parallel/ranks/ranks.hpp"
#include "host/surface/lays.hpp"
#include "host/trace/simulation.hpp"

namespace umov::cli {

struct SurfaceOptions {
  std::string scene;
  std::string output;
  std::vector<double> theta_i_deg;      ///< empty: the scene's, else 0
  std::optional<double> samples;        ///< launches at most an angle
  double relative_error_percent = 0.0;  ///< of the DHR; 0: the scene's
  double cell_error_percent = 0.0;      ///< 0: the scene's
  std::optional<double> cell_percentile;
  std::vector<double> cell_deg;       ///< θr, φr; empty: the scene's
  std::optional<double> lay_samples;  ///< launches of a lay; 0: one lay
  std::size_t rings = 18;
  std::size_t strip = 180;
  double strip_half_width_deg = 2.0;
  bool resume = false;

  /// Where the state of a stopped run is kept.
  std::string state_file() const { return output + ".state"; }
};

/// Simulates what options and scene ask for, with progress, alone or as one of several ranks.
class SurfaceRun {
 public:
  SurfaceRun(const SurfaceOptions& options, const Common& common, const Ranks& ranks);

  /// Angles of incidence in degrees: of the options, else of the scene.
  std::vector<double> angles(const surface::Surface& described) const;

  /// What the options and the scene ask of a simulation, but for θi. Valid as long as this.
  trace::Request request(const surface::Surface& described) const;
  /// Launches of a lay, 0: one lay; nothing: as surface::launches_a_lay() has it.
  std::optional<std::uint64_t> lay_launches() const;
  trace::Hemisphere hemisphere() const;

  /// The state that is kept beside the output file, and taken up where the options say so. `more`
  /// is what the run depends on beside scene, seed, angles and cells.
  KeptRun kept(const std::vector<double>& theta_i_deg, const std::string& more) const;

  /// A line for the progress of one simulation: launches and errors.
  std::string said(const trace::Progress& p) const;

  /// The results of all angles, or of those until Ctrl-C.
  std::vector<trace::Result> simulate(const surface::Lays& lays);

  /// How many lays a result is of.
  std::uint64_t lays(const surface::Surface& described, const trace::Result& result) const;

  /// Was it Ctrl-C that ended simulate()?
  bool interrupted() const { return interrupted_; }
  bool first_rank() const { return ranks_.rank() == 0; }

 private:
  std::uint64_t launches(const surface::Surface& described) const;

  const SurfaceOptions& options_;
  const Common& common_;
  const Ranks& ranks_;
  bool interrupted_ = false;
};

}  // namespace umov::cli
