// The neighbourhood of a fitted explanation as linear algebra: the signature of every effect that
// is not in it, freed of what the fitted parameters would absorb. All that a search, a bootstrap or
// a held-out test needs then costs a few small matrices, whatever the number of observations.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include <Eigen/Core>

#include "host/gap/engine/forward_model.hpp"
#include "host/gap/engine/refit.hpp"

namespace umov::gap {

/// One way an effect can show: a group of its probes.
struct Candidate {
  std::size_t effect = 0;
  std::vector<Eigen::Index> columns;  ///< of the view's matrices
};

/// What a set of candidates does to the residual, to first order.
struct LinearFit {
  double gain = 0;              ///< decrease of χ² at the best coefficients
  double ln_evidence = 0;       ///< against the explanation itself, priors integrated out
  Eigen::VectorXd coefficient;  ///< posterior mean, in units of the probes
};

class LinearView {
 public:
  /// `at` must be a minimum. `with_candidates` false: only what is fitted, for held_out_by_fold().
  /// Without folds nothing can be withheld.
  /// With `near`, a view under the same whitening of an explanation that differs little: the
  /// signatures that it has serve here too.
  LinearView(const ForwardModel& model, const Refit& at, const Whitening& whitening,
             const std::vector<int>& fold, bool with_candidates = true, int threads = 1,
             const LinearView* near = nullptr);

  const std::vector<Candidate>& candidates() const { return candidates_; }
  /// Best coefficients within the signs that are physical.
  LinearFit fit(std::span<const std::size_t> set) const { return fit(set, reduced_right_); }
  /// The same for another residual, of which `pull` holds the products with all signatures.
  LinearFit fit(std::span<const std::size_t> set, const Eigen::VectorXd& pull) const;
  /// Products of the signatures with each other, what is fitted taken out; zero where that has
  /// absorbed one.
  const Eigen::MatrixXd& gram() const { return reduced_; }
  /// R with R·Rᵀ = gram(): R times independent normal numbers are the pulls of noise alone.
  Eigen::MatrixXd root_of_pulls() const;
  /// Does the candidate exist with one sign only?
  bool one_sided(std::size_t candidate) const {
    return members_[static_cast<std::size_t>(candidates_[candidate].columns.front())].one_sided;
  }
  /// Parameter values of a candidate with these coefficients: where a full refit starts.
  std::vector<double> alpha(std::size_t candidate, const Eigen::VectorXd& coefficient) const;
  /// χ² of the withheld rows, fold by fold, when what is fitted is fitted to the others.
  std::vector<double> held_out_by_fold() const;
  /// Median of its sum when the fitted explanation is true: what no model can go below.
  double held_out_floor(int draws, std::uint64_t seed) const;
  /// Largest gain of any single candidate (structural ones apart) in `draws` measurements that hold
  /// nothing but noise; ascending.
  std::vector<double> null_maxima(int draws, std::uint64_t seed) const;
  /// What all candidates but series of many terms together leave: noise, as far as the catalogue
  /// knows.
  struct Left {
    Eigen::VectorXd residual;  ///< whitened
    Eigen::VectorXd kept;      ///< share of each observation's variance that is left in it
    double rank;               ///< degrees of freedom that they and the fitted parameters take
  };
  Left left_by_everything() const;

 private:
  struct Normal {
    Eigen::MatrixXd matrix;
    Eigen::VectorXd right;
    double square = 0;
    Eigen::Index observations = 0;
  };
  struct Member {
    std::size_t effect;
    std::vector<double> probe;
    bool one_sided;
    double prior_precision;  ///< of its coefficient
  };

  Normal normal_of(const Eigen::MatrixXd& columns, const Eigen::VectorXd& residual,
                   const std::vector<Eigen::Index>& rows) const;
  std::vector<Eigen::Index> columns_of(std::span<const std::size_t> set) const;
  std::vector<double> held_out(const std::vector<Eigen::Index>& columns,
                               const Eigen::VectorXd& prior, const std::vector<Normal>& folds,
                               const Normal& all) const;

  const ForwardModel& model_;
  std::vector<Candidate> candidates_;
  std::vector<Member> members_;
  std::vector<Normal> folds_;
  Normal all_;               ///< with the priors of the fitted parameters
  Eigen::MatrixXd reduced_;  ///< signatures' Gram matrix, fitted parameters projected out
  Eigen::VectorXd reduced_right_;
  Eigen::Index fitted_ = 0;
  Eigen::VectorXd residual_, kept_by_fit_;
  Eigen::MatrixXd signatures_;  ///< whitened, as they are
  Eigen::MatrixXd left_;        ///< signatures of unit length, fitted parameters projected out
  double fitted_rank_ = 0;
};

}  // namespace umov::gap
