// The polarised BRDF of a scene over the whole hemisphere, with standard errors.
//
// Launches are made in blocks of fixed size. Blocks may be traced in any order and by any number of
// threads; they are added in the order of their numbers, so that results agree to the last bit.
// The scatter between blocks gives the standard errors.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
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
  double dhr_relative_error;  ///< the largest of all wavelengths, 1 σ
  const Result& result;       ///< of what has been traced
};

struct Request {
  double theta_i = 0.0;  ///< radians, 0 to below π/2
  std::uint64_t seed = 1;
  std::uint64_t samples = 1'000'000;  ///< launches at most; rounded up to 16 blocks
  std::uint64_t block = 2048;         ///< launches a block
  double dhr_relative_error = 0.0;    ///< stop when every wavelength has it (1 σ); 0: never
  std::uint64_t rays = 0;             ///< stop when so many have been traced; 0: never
  int threads = 0;                    ///< 0: all cores; changes no result
  /// Exits count that have met so many faces at most; 0: all. The ledger counts all.
  std::uint32_t most_meetings = 0;
  bool emissivity = false;  ///< also by whom light is absorbed
  std::function<void(const Progress&)> progress = {};
  std::function<bool()> stop = {};  ///< asked now and then; true ends the run with what there is
  const Team* team = nullptr;       ///< all must make the same request; changes no result
};

class Result {
 public:
  /// Without a sample. `owners`: how many absorbers are told apart; 0 none.
  Result(Hemisphere hemisphere, std::size_t wavelengths, std::size_t owners = 0);

  const Hemisphere& hemisphere() const { return hemisphere_; }
  const Ledger& ledger() const { return ledger_; }
  std::uint64_t samples() const { return samples_; }
  /// 1 σ of the DHR over its value, the largest of all wavelengths.
  double dhr_relative_error() const;

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
/// scene that is not periodic (its edges would be part of the answer). With `begun`, state() of an
/// earlier call that was stopped, it goes on from there, to the same bits as without the stop.
Result simulate(const PathTracer& tracer, const Hemisphere& hemisphere, const Request& request,
                const std::vector<double>& begun = {});

}  // namespace umov::trace
