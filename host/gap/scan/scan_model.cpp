#include "host/gap/scan/scan_model.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <string_view>

#include <fmt/format.h>

#include "host/calibrate/calibration.hpp"
#include "host/calibrate/reduce.hpp"
#include "host/errors/error.hpp"
#include "host/formats/fit_file.hpp"
#include "host/gap/scan/chain.hpp"
#include "host/gap/scan/substance.hpp"
#include "host/invert/invert.hpp"
#include "host/optics/angles.hpp"

namespace umov::gap::scan {
namespace {

/// Smallest κ²: the derivative of κ itself is infinite at zero.
constexpr double least_kappa2 = 1e-10;

double median(std::vector<double> values) {
  if (values.empty()) return 0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Groups of records of the same spot in the same light, whenever they were taken: the speckle that
/// a detector sees is the same in them. Groups of one are left out.
std::vector<std::vector<Eigen::Index>> repeated_places(const std::vector<Record>& records,
                                                       const std::vector<std::size_t>& used) {
  std::map<std::array<long long, 8>, std::vector<Eigen::Index>> members;
  for (std::size_t i = 0; i < used.size(); ++i) {
    const Record& r = records[used[i]];
    if (!r.shutter_open || r.sample_removed) continue;  // no light from the sample
    members[place_of(r)].push_back(static_cast<Eigen::Index>(i));
  }
  std::vector<std::vector<Eigen::Index>> groups;
  for (auto& [place, list] : members)
    if (list.size() > 1) groups.push_back(std::move(list));
  return groups;
}

/// A few dozen repeats fix the relative noise to a fifth, the scatter within thousands of records
/// to a hundredth: where the two agree, the latter counts.
void keep_the_surer_relative_noise(calibrate::NoiseModel& noise) {
  constexpr double agree = 2.5;  // standard errors
  for (calibrate::NoiseModel::Entry& entry : noise.entries) {
    if (std::isnan(entry.repeat_relative2)) continue;
    const double within =
        std::max(entry.x.relative2, entry.monitor_relative * entry.monitor_relative);
    const double error = std::sqrt(2 / static_cast<double>(entry.repeat_dof));
    if (std::abs(entry.repeat_relative2 - within) < agree * error * within)
      entry.repeat_relative2 = std::numeric_limits<double>::quiet_NaN();
  }
}

/// The base model fitted to the reduced scan: where the diagnosis starts.
formats::FitResult starting_fit(const std::vector<formats::ScanTable>& scans,
                                const std::string& model, const Knowledge& knowledge) {
  if (knowledge.fit) return fit_at(*knowledge.fit, calibrate::wavelengths_of(scans.front()));
  const calibrate::Calibration calibration =
      knowledge.calibration ? *knowledge.calibration
                            : calibrate::calibration_from_header(scans.front());
  calibrate::ReduceOptions reduce_options;
  reduce_options.dolp = reduce_options.dhr = false;
  const calibrate::Reduction reduction =
      calibrate::reduce(scans.front(), calibration, reduce_options);
  invert::Options options;
  options.model = model;
  options.starts = 6;
  options.held_out = options.dhr = false;
  options.floor_relative = 0.01;
  return invert::invert(reduction.table, options);
}

}  // namespace

ScanModel::~ScanModel() = default;

ScanModel::ScanModel(const std::vector<formats::ScanTable>& scans, const ScanModelOptions& options)
    : records_(prepare_records(scans, options.knowledge.calibration.get())),
      model_(brdf::Model::by_name(options.knowledge.fit ? options.knowledge.fit->model
                                                        : options.model)) {
  require_substance(records_);
  thin(records_, options.most_records);
  noise_ = calibrate::fit_noise(scans.front());
  keep_the_surer_relative_noise(noise_);
  for (const brdf::Component& part : model_.components())
    if (lobe_ < 0 && part.kind == brdf::Kind::microfacet) lobe_ = static_cast<int>(part.first);

  const formats::FitResult fit = starting_fit(scans, options.model, options.knowledge);
  const std::size_t wavelengths = records_.wavelengths_nm.size();
  for (std::size_t w = 0; w < wavelengths; ++w) {
    Parameter p{fmt::format("log_gain_{:g}", records_.wavelengths_nm[w]),
                "1",
                "logarithm of the gain constant over its stated value",
                0.0,
                -0.5,
                0.5,
                records_.gain_constant_relative_u[w]};
    base_.push_back(std::move(p));
    squared_.push_back(false);
  }
  source_.assign(wavelengths, std::vector<int>(model_.parameters().size(), -1));
  for (std::size_t i = 0; i < model_.parameters().size(); ++i) {
    const brdf::Parameter& declared = model_.parameters()[i];
    const formats::FitParameter* fitted = fit.find(declared.name);
    const auto value_at = [&](std::size_t w) {
      return fitted == nullptr ? declared.initial : fitted->at(w).value;
    };
    held_.push_back(value_at(0));
    // A lobe's weight is held in fits of one paint's BRDF; here what it says is not beyond doubt.
    const bool weight = declared.name == "bias" || declared.name.ends_with(".bias");
    // What a given fit left free is free here too.
    const bool free_in_fit = options.knowledge.fit && fitted != nullptr && !fitted->fixed;
    if (declared.held && !weight && !free_in_fit) continue;
    const bool squared = declared.name.ends_with("kappa");
    const auto add = [&](const std::string& name, double value) {
      Parameter p{name, declared.unit, declared.meaning, value, declared.min, declared.max};
      if (squared) {
        p.name += "_squared";
        p.lo = least_kappa2;
        p.hi = declared.max * declared.max;
        // κ² of 1e-10 cannot be told from none, and has no way back: begin where it shows.
        p.absent = std::max(value * value, options.knowledge.hold_fit ? least_kappa2 : 1e-4);
      }
      base_.push_back(std::move(p));
      squared_.push_back(squared);
      return static_cast<int>(base_.size()) - 1;
    };
    // Refractive indices disperse; what is one number in a fit of smooth paint is not here, where
    // a lobe is seen to a thousandth.
    if ((declared.spectral && !weight) || declared.name.ends_with(".n") || declared.name == "n") {
      for (std::size_t w = 0; w < wavelengths; ++w)
        source_[w][i] =
            add(fmt::format("{}_{:g}", declared.name, records_.wavelengths_nm[w]), value_at(w));
    } else {
      const int shared = add(declared.name, value_at(0));
      for (std::size_t w = 0; w < wavelengths; ++w) source_[w][i] = shared;
    }
  }

  if (options.knowledge.hold_fit)
    for (std::size_t i = wavelengths; i < base_.size(); ++i)
      base_[i].lo = base_[i].hi = base_[i].absent;

  make_catalogue();
  limits_ = options.knowledge.tolerances;
  if (options.knowledge.calibration)
    known_ = know_effects(*options.knowledge.calibration, records_, effects_, limits_);
  apply_tolerances(options.knowledge.tolerances, effects_);
  known_bends_ = std::any_of(known_.begin(), known_.end(), [](const KnownEffect& k) {
    return changes_geometry(static_cast<EffectId>(k.effect));
  });
  make_observations();
}

ScanModel ScanModel::with_records(std::vector<Record> records) const {
  ScanModel other = *this;
  other.records_.records = std::move(records);
  other.make_observations();
  return other;
}

std::unique_ptr<ForwardModel> ScanModel::thinned(std::size_t most) const {
  const std::size_t step = (2 * used_.size() + most - 1) / most;
  if (step < 2) return nullptr;
  // One of so many, at a place that moves along: no channel or angle is left out for good.
  std::vector<Record> some;
  for (std::size_t k = 0; k < used_.size(); ++k)
    if (k % step == (k / step) % step) some.push_back(records_.records[used_[k]]);
  return std::make_unique<ScanModel>(with_records(std::move(some)));
}

void ScanModel::make_catalogue() {
  Scale scale;
  scale.wavelengths_nm = records_.wavelengths_nm;
  std::vector<double> adc;
  double largest = 0, duration = 0;
  for (const Record& r : records_.records) {
    if (r.saturated) continue;
    adc.push_back(std::abs(r.x_v) * r.gain);
    largest = std::max(largest, std::abs(r.x_v));
    duration = std::max(duration, r.time_s);
    scale.out_of_plane = scale.out_of_plane || std::abs(std::sin(r.phi_r)) > 0.02;
  }
  constexpr std::size_t fewest_records = 200;
  if (adc.size() < fewest_records)
    throw Error(
        fmt::format("{} usable records are too few for a diagnosis", adc.size()),
        fmt::format("measure at least {}, over several angles of incidence", fewest_records));
  scale.largest_signal_v = largest;
  scale.typical_adc_v = median(adc);
  scale.duration_s = std::max(duration, 1.0);
  if (lobe_ >= 0) {
    const int slope = source_[0][static_cast<std::size_t>(lobe_) + 2];
    if (slope >= 0) scale.slope_rms = base_[static_cast<std::size_t>(slope)].absent;
  }
  effects_ = catalogue(scale);
}

std::vector<Circumstance> ScanModel::circumstances() const {
  const auto of = [this](const char* name, const char* unit, bool of_object, const auto& value) {
    Circumstance c{{name, unit, {}},
                   of_object,
                   std::string_view(name).starts_with("theta_") ? "geometry" : ""};
    for (int part = 0; part < 2; ++part)
      for (const std::size_t i : used_) c.axis.value.push_back(value(records_.records[i]));
    return c;
  };
  // A free way is a setting of its own.
  constexpr double open_deg = 999;
  std::vector<Circumstance> all{
      of("time", "1", false, [](const Record& r) { return r.time; }),
      of("direction", "1", false, [](const Record& r) { return double(r.direction); }),
      of("polarizer_deg", "deg", false,
         [](const Record& r) {
           return r.polarizer_open ? open_deg : optics::degrees(r.polarizer);
         }),
      of("analyzer_deg", "deg", false,
         [](const Record& r) { return r.analyzer_open ? open_deg : optics::degrees(r.analyzer); }),
      of("gain", "1", false, [](const Record& r) { return r.gain; }),
      of("wavelength_nm", "nm", true,
         [this](const Record& r) { return records_.wavelengths_nm[r.wavelength]; }),
      of("theta_i_deg", "deg", true, [](const Record& r) { return optics::degrees(r.theta_i); }),
      of("theta_r_deg", "deg", true, [](const Record& r) { return optics::degrees(r.theta_r); }),
  };
  for (Circumstance& c : all)
    if (c.axis.name == "polarizer_deg" || c.axis.name == "analyzer_deg")
      c.names = {{open_deg, "open"}};
  return all;
}

void ScanModel::make_observations() {
  used_.clear();
  facet_frames_.clear();
  for (std::size_t i = 0; i < records_.records.size(); ++i) {
    const Record& r = records_.records[i];
    if (!r.saturated) used_.push_back(i);
    facet_frames_.push_back(
        brdf::facet_frame(brdf::Geometry<double>{r.theta_i, r.theta_r, r.phi_r}));
  }
  observations_ = {};
  same_place_ = repeated_places(records_.records, used_);
  const auto n = static_cast<Eigen::Index>(used_.size());
  observations_.value.resize(2 * n);
  observations_.axes = {{"theta_i_deg", "deg", {}},  {"theta_r_deg", "deg", {}},
                        {"theta_h_deg", "deg", {}},  {"theta_d_deg", "deg", {}},
                        {"wavelength_nm", "nm", {}}, {"log_signal", "1", {}},
                        {"time", "1", {}},           {"direction", "1", {}}};
  for (int part = 0; part < 2; ++part) {
    for (Eigen::Index i = 0; i < n; ++i) {
      const Record& r = records_.records[used_[static_cast<std::size_t>(i)]];
      observations_.value[part * n + i] = part == 0 ? r.x_v : r.y_v;
      observations_.row.push_back(r.row);
      const brdf::FacetFrame<double>& f = facet_frames_[used_[static_cast<std::size_t>(i)]];
      const std::array<double, 8> coordinates = {optics::degrees(r.theta_i),
                                                 optics::degrees(r.theta_r),
                                                 optics::degrees(std::acos(std::min(1.0, f.cos_h))),
                                                 optics::degrees(std::acos(std::min(1.0, f.cos_d))),
                                                 records_.wavelengths_nm[r.wavelength],
                                                 std::log10(std::max(std::abs(r.x_v), 1e-9)),
                                                 r.time,
                                                 static_cast<double>(r.direction)};
      for (std::size_t a = 0; a < coordinates.size(); ++a)
        observations_.axes[a].value.push_back(coordinates[a]);
      const std::string channel = fmt::format(
          "{}/{}{}", r.polarizer_open ? "U" : fmt::format("{:g}", optics::degrees(r.polarizer)),
          r.analyzer_open ? "U" : fmt::format("{:g}", optics::degrees(r.analyzer)),
          part == 0 ? "" : " Y");
      const auto known =
          std::find(observations_.channels.begin(), observations_.channels.end(), channel);
      observations_.channel.push_back(static_cast<int>(known - observations_.channels.begin()));
      if (known == observations_.channels.end()) observations_.channels.push_back(channel);
    }
  }
  observations_.circumstances = circumstances();
}

std::vector<std::vector<double>> ScanModel::further_starts() const {
  // A broad weak lobe and a narrow strong one may each hold a fit of the other.
  std::vector<std::vector<double>> starts;
  if (lobe_ < 0) return starts;
  const auto slope = source_[0][static_cast<std::size_t>(lobe_) + 2];
  if (slope < 0 ||
      base_[static_cast<std::size_t>(slope)].lo >= base_[static_cast<std::size_t>(slope)].hi)
    return starts;
  for (const double rms : {0.06, 0.2, 0.45}) {
    std::vector<double> start;
    for (const Parameter& p : base_) start.push_back(p.absent);
    start[static_cast<std::size_t>(slope)] = rms;
    for (std::size_t w = 0; w < source_.size(); ++w) {
      const auto set = [&](std::size_t offset, double value) {
        const int at = source_[w][static_cast<std::size_t>(lobe_) + offset];
        if (at >= 0) start[static_cast<std::size_t>(at)] = value;
      };
      set(0, 1.5);
      set(1, 1e-3);
    }
    starts.push_back(std::move(start));
  }
  return starts;
}

NoiseShape ScanModel::noise(const Eigen::VectorXd& mean) const {
  const auto n = static_cast<Eigen::Index>(used_.size());
  NoiseShape shape{Eigen::VectorXd(2 * n), Eigen::VectorXd::Zero(2 * n), {}, same_place_, 0};
  Eigen::VectorXd& sigma = shape.sigma;
  for (Eigen::Index i = 0; i < n; ++i) {
    const Record& r = records_.records[used_[static_cast<std::size_t>(i)]];
    const calibrate::NoiseModel& law = noise_;
    const double nm = records_.wavelengths_nm[r.wavelength];
    sigma[i] = std::sqrt(law.variance_normalised(nm, r.gain, mean[i]));
    sigma[n + i] = std::sqrt(law.variance_y(nm, r.gain, mean[i]));
    // The source's noise that the monitor misses: in phase with the light.
    shape.relative[i] = mean[i];
    shape.order.push_back(i);
  }
  // How well the scatter within records and between repeats fixes the law; its form is no better
  // known than to a few per cent.
  constexpr double form_of_the_law = 0.05;
  Eigen::Index clearest = 0;
  shape.relative.head(n).cwiseAbs().cwiseQuotient(sigma.head(n)).maxCoeff(&clearest);
  const Record& r = records_.records[used_[static_cast<std::size_t>(clearest)]];
  const double dof =
      noise_.dof_normalised(records_.wavelengths_nm[r.wavelength], r.gain, mean[clearest]);
  const double ratio = sigma[clearest] / mean[clearest];
  shape.doubt = ratio * ratio * std::max(form_of_the_law, std::sqrt(2 / dof));
  return shape;
}

}  // namespace umov::gap::scan
