// The polarised BRDF of a scene over the whole hemisphere, with standard errors.
//
// Launches are made in blocks of fixed size. Blocks may be traced in any order and by any number of
// threads; they are added in the order of their numbers, so that results agree to the last bit.
// The scatter between blocks gives the standard errors.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

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

/// Of a run, so far.
struct Progress {
  std::uint64_t samples;
  double dhr_relative_error;  ///< the largest of all wavelengths, 1 σ
};

struct Request {
  double theta_i = 0.0;  ///< radians, 0 to below π/2
  std::uint64_t seed = 1;
  std::uint64_t samples = 1'000'000;  ///< launches at most; rounded up to 16 blocks
  std::uint64_t block = 2048;         ///< launches a block
  double dhr_relative_error = 0.0;    ///< stop when every wavelength has it (1 σ); 0: never
  int threads = 0;                    ///< 0: all cores; changes no result
  std::function<void(const Progress&)> progress = {};
};

class Result {
 public:
  Result(Hemisphere hemisphere, std::size_t wavelengths);

  const Hemisphere& hemisphere() const { return hemisphere_; }
  const Ledger& ledger() const { return ledger_; }
  std::uint64_t samples() const { return samples_; }

  /// Mean BRDF of a cell, weighted by cos θr [1/sr]; basis of each direction's own {s, p}.
  MuellerEstimate brdf(std::size_t cell, std::size_t wavelength) const;
  /// ∫ BRDF cos θr dΩ; element 00 is the DHR.
  MuellerEstimate hemispherical(std::size_t wavelength) const;
  /// Hemispherical m10 over m00. The error takes their correlation into account.
  Estimate hemispherical_dop(std::size_t wavelength) const;

 private:
  friend Result simulate(const PathTracer&, const Hemisphere&, const Request&);
  struct Sums {
    optics::Mueller<double> sum, squares;
  };
  MuellerEstimate estimate(const Sums& sums, double scale) const;

  Hemisphere hemisphere_;
  Ledger ledger_;
  std::vector<Sums> cells_;            // by cell, then wavelength
  std::vector<Sums> hemisphere_sums_;  // by wavelength
  std::vector<double> dop_products_;   // Σ m10·m00 over blocks, by wavelength
  std::uint64_t samples_ = 0;
  std::uint64_t blocks_ = 0;
  double block_ = 0.0;
};

/// Throws umov::Error for a request that makes no sense: θi not from 0 to below 90°, no samples, a
/// scene that is not periodic (its edges would be part of the answer).
Result simulate(const PathTracer& tracer, const Hemisphere& hemisphere, const Request& request);

}  // namespace umov::trace
