// The polarised BRDF of a scene over the whole hemisphere, with standard errors.
//
// Launches are made in blocks of fixed size. Blocks may be traced in any order and by any number of
// threads; they are added in the order of their numbers, so that results agree to the last bit.
// The scatter between blocks gives the standard errors.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <vector>

#include "host/parallel/team.hpp"
#include "host/trace/hemisphere.hpp"
#include "host/trace/path_tracer.hpp"

namespace umov::trace {

/// Mean and its standard error, element by element.
struct MuellerEstimate {
  optics::Mueller<double> mean, error;
};

struct Estimate {
  double mean, error;
};

class Result;

/// Of a run, so far.
struct Progress {
  std::uint64_t samples;
  double dhr_relative_error;   ///< the largest of all wavelengths, 1 σ
  double cell_relative_error;  ///< Result::cell_relative_error(); 0 where none was asked for
  double done;                 ///< share of the launches, rays or errors asked for, 0 to 1
  const Result& result;        ///< of what has been traced
};

/// How well the cells of the hemisphere (not those of the strip) are to be known.
struct CellGoal {
  double relative_error = 0.0;      ///< 1 σ of m00 over its value; 0: no goal
  double percentile = 50.0;         ///< of all cells, above 0 and up to 100; 50: the median
  std::optional<std::size_t> cell;  ///< this one alone, instead of a percentile
};

struct Request {
  double theta_i = 0.0;  ///< radians, 0 to below π/2
  std::uint64_t seed = 1;
  std::uint64_t samples = 1'000'000;  ///< launches at most; rounded up to 16 blocks
  /// Launches a block; 0: block_of().
  std::uint64_t block = 0;
  /// Stop when every wavelength has this (1 σ) and the cells have theirs; 0: not by the DHR.
  double dhr_relative_error = 0.0;
  CellGoal cells = {};
  std::uint64_t rays = 0;  ///< stop when so many have been traced; 0: never
  int threads = 0;         ///< 0: all cores; changes no result
  /// Exits count that have met so many faces at most; 0: all. The ledger counts all.
  std::uint32_t most_meetings = 0;
  bool emissivity = false;  ///< also by whom light is absorbed
  std::function<void(const Progress&)> progress = {};
  std::function<bool()> stop = {};  ///< asked now and then; true ends the run with what there is
  const Team* team = nullptr;       ///< all must make the same request; changes no result
};

/// Launches a block where nobody chose. In a run that does not stop by its errors, as many as the
/// scene has faces, so that paths one after the other meet the same ones, but few enough for 128
/// blocks; never fewer than 2048.
std::uint64_t block_of(const Request& request, const Scene& scene);

/// Does one of the ranks want the run to stop? All must ask.
bool stop_asked(const Request& request);

class Result {
 public:
  /// Without a sample. `owners`: how many absorbers are told apart; 0 none.
  Result(Hemisphere hemisphere, std::size_t wavelengths, std::size_t owners = 0);

  const Hemisphere& hemisphere() const { return hemisphere_; }
  const Ledger& ledger() const { return ledger_; }
  std::uint64_t samples() const { return samples_; }
  std::uint64_t blocks() const { return blocks_; }
  /// 1 σ of the DHR over its value, the largest of all wavelengths.
  double dhr_relative_error() const;
  /// 1 σ of m00 over its value, of the cell or at the percentile of all cells that `goal` says; the
  /// largest of all wavelengths. Infinite for cells that no light was seen in.
  double cell_relative_error(const CellGoal& goal) const;

  /// Mean BRDF of a cell, weighted by cos θr [1/sr]; basis of each direction's own {s, p}.
  MuellerEstimate brdf(std::size_t cell, std::size_t wavelength) const;
  /// ∫ BRDF cos θr dΩ; element 00 is the DHR.
  MuellerEstimate hemispherical(std::size_t wavelength) const;
  /// Hemispherical m10 over m00. The error takes their correlation into account.
  Estimate hemispherical_dop(std::size_t wavelength) const;
  /// Share of light from θi that `owner` (Absorbed::owner) keeps, for launched I, Q, U, V. After
  /// Kirchhoff also its polarised emissivity towards θi (U with the opposite sign). Needs
  /// Request::emissivity.
  std::array<Estimate, 4> absorptance(std::size_t owner, std::size_t wavelength) const;
  /// Covers Request::emissivity?
  bool knows_absorptance() const { return owners_ > 0; }

  /// All of it as numbers, to be kept in a file and continued.
  std::vector<double> state() const;
  /// Takes state() of a run of the same request over. Throws umov::Error if the number of numbers
  /// does not fit.
  void restore(const std::vector<double>& state);

 private:
  friend class Run;
  struct Sums {
    optics::Mueller<double> sum, squares;
  };
  MuellerEstimate estimate(const Sums& sums, double scale) const;
  template <class Visitor>
  void each_number(Visitor visit);

  Hemisphere hemisphere_;
  Ledger ledger_;
  std::vector<Sums> cells_;            // by cell, then wavelength
  std::vector<Sums> hemisphere_sums_;  // by wavelength
  std::vector<double> dop_products_;   // Σ m10·m00 over blocks, by wavelength
  std::size_t owners_;
  std::vector<std::array<double, 8>> absorbed_;  // by owner, wavelength: Σ x, Σ x² of blocks
  std::uint64_t samples_ = 0;
  std::uint64_t blocks_ = 0;
  double block_ = 0.0;
};

/// Throws umov::Error for a request that makes no sense: θi not from 0 to below 90°, no samples, a
/// goal for cells that there are not, a scene that is not periodic (its edges would be part of the
/// answer). With `begun`, state() of an earlier call that was stopped, it goes on from there, to
/// the same bits as without the stop.
Result simulate(const PathTracer& tracer, const Hemisphere& hemisphere, const Request& request,
                const std::vector<double>& begun = {});

/// The scene of a block, by its number; called from several threads at once. All of a run must have
/// the same wavelengths, materials and media.
using TracerOfBlock = std::function<std::shared_ptr<const PathTracer>(std::uint64_t)>;

/// The same where each block has a scene of its own, such as particles that lie otherwise: the
/// scatter between blocks, and with it every standard error, is then that of scenes and rays.
Result simulate(const TracerOfBlock& tracers, const Hemisphere& hemisphere, const Request& request,
                const std::vector<double>& begun = {});

}  // namespace umov::trace
