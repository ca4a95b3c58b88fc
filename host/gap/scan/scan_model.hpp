// A gonioreflectometer scan as a forward model of the diagnosis: X and Y of every record from a
// reflectance model of the library and the instrument's signal chain.
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <vector>

#include "host/brdf/facet.hpp"
#include "host/brdf/model.hpp"
#include "host/calibrate/noise.hpp"
#include "host/formats/scan_table.hpp"
#include "host/gap/engine/forward_model.hpp"
#include "host/gap/scan/effect_list.hpp"
#include "host/gap/scan/knowledge.hpp"
#include "host/gap/scan/record.hpp"

namespace umov::gap::scan {

struct ScanModelOptions {
  std::string model = "microfacet+nef";
  /// More records than this are thinned, evenly along every row; 0: none are.
  std::size_t most_records = 0;
  Knowledge knowledge;  ///< its fit, where there is one, names the model
};

class ScanModel : public ForwardModel {
 public:
  /// Throws umov::Error where the records cannot carry a diagnosis.
  explicit ScanModel(const std::vector<formats::ScanTable>& scans,
                     const ScanModelOptions& options = {});
  ~ScanModel() override;

  const Observations& observations() const override { return observations_; }
  const std::vector<Parameter>& base() const override { return base_; }
  const std::vector<Effect>& effects() const override { return effects_; }
  std::vector<std::vector<double>> further_starts() const override;
  void predict(const Explanation& explanation, Eigen::VectorXd& mean, Eigen::MatrixXd* jacobian,
               const std::vector<bool>& wanted = {}) const override;
  NoiseShape noise(const Eigen::VectorXd& mean) const override;
  std::unique_ptr<ForwardModel> thinned(std::size_t most) const override;

  const ScanRecords& records() const { return records_; }
  /// Sizes of effects that are in order: declared tolerances, then the calibration's uncertainties.
  const std::vector<Tolerance>& limits() const { return limits_; }
  /// Name of the reflectance model.
  std::string reflectance() const { return model_.name(); }
  /// The same model looking at other records, of a measurement that could be made. Their values are
  /// not looked at.
  ScanModel with_records(std::vector<Record> records) const;
  /// How many records count; each gives two observations, X of all first, then Y.
  std::size_t used() const { return used_.size(); }

 private:
  void make_catalogue();
  void make_observations();
  std::vector<Circumstance> circumstances() const;
  /// Signal of a record. `angles`: the same values in the scalar that angles are computed in.
  template <class T, class A>
  void evaluate(const Explanation& explanation, const std::vector<T>& values,
                const std::vector<A>& angles, std::size_t record, T& x, T& y, bool bent) const;

  /// Columns of derivatives that a series of an explanation takes.
  struct SeriesColumns {
    SeriesId id;
    std::size_t first, columns;
  };
  std::vector<SeriesColumns> series_of(const Explanation& explanation) const;
  /// rms slope of the base's lobe.
  double slope_at(const std::vector<double>& values, std::size_t wavelength) const;

  ScanRecords records_;
  std::vector<brdf::FacetFrame<double>> facet_frames_;  ///< of every record as commanded
  std::vector<std::size_t> used_;                       ///< numbers of the records that count
  brdf::Model model_;
  int lobe_ = -1;
  calibrate::NoiseModel noise_;  ///< of the first scan
  Observations observations_;
  std::vector<std::vector<Eigen::Index>> same_place_;  ///< as in NoiseShape
  std::vector<Parameter> base_;
  std::vector<Effect> effects_;
  std::vector<KnownEffect> known_;
  std::vector<Tolerance> limits_;
  bool known_bends_ = false;  ///< some of these move angles
  /// For every wavelength: number of the base parameter behind each model parameter; -1 = held.
  std::vector<std::vector<int>> source_;
  std::vector<double> held_;
  std::vector<bool> squared_;  ///< base parameter is the square of the model's (κ)
};

}  // namespace umov::gap::scan
