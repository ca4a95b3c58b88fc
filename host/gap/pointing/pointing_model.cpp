#include "host/gap/pointing/pointing_model.hpp"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>
#include <fmt/ranges.h>

#include "host/errors/error.hpp"

namespace umov::gap {
namespace {

/// Error on the sky for one arc second of a parameter.
struct SkyError {
  double altitude, azimuth;  ///< azimuth times cos E
};

struct TermParameter {
  const char* name;
  const char* meaning;
  SkyError (*error)(double altitude_rad, double azimuth_rad);
};

struct Term {
  const char* name;
  const char* stage;
  const char* physics;
  std::vector<TermParameter> parameters;
};

/// Some ten times what a well-kept telescope needs: the scale of an effect before any data.
constexpr double usual_size_arcsec = 20;

const std::vector<TermParameter>& offsets() {
  static const std::vector<TermParameter> terms = {
      {"altitude_offset_arcsec", "zero of the altitude encoder",
       [](double, double) {
         return SkyError{1, 0};
       }},
      {"azimuth_offset_arcsec", "zero of the azimuth encoder", [](double e, double) {
         return SkyError{0, std::cos(e)};
       }}};
  return terms;
}

const std::vector<Term>& terms() {
  static const std::vector<Term> all = {
      {"azimuth_axis_tilt",
       "mount",
       "The azimuth axis leans off the vertical: the altitude error goes once round with azimuth, "
       "and the azimuth error grows with the sine of the altitude.",
       {{"north_arcsec", "lean towards the north",
         [](double e, double a) {
           return SkyError{std::cos(a), std::sin(a) * std::sin(e)};
         }},
        {"east_arcsec", "lean towards the east",
         [](double e, double a) {
           return SkyError{std::sin(a), -std::cos(a) * std::sin(e)};
         }}}},
      {"collimation",
       "tube",
       "The optical axis is not square to the altitude axis: a constant error across the sky.",
       {{"angle_arcsec", "departure from a right angle",
         [](double, double) {
           return SkyError{0, 1};
         }}}},
      {"axes_not_perpendicular",
       "mount",
       "Altitude and azimuth axes do not meet at a right angle: an azimuth error with the sine of "
       "the altitude.",
       {{"angle_arcsec", "departure from a right angle",
         [](double e, double) {
           return SkyError{0, std::sin(e)};
         }}}},
      {"tube_flexure",
       "tube",
       "The tube sags under its weight, in proportion to the part of gravity across it: the cosine "
       "of the altitude.",
       {{"sag_arcsec", "sag of a horizontal tube",
         [](double e, double) {
           return SkyError{std::cos(e), 0};
         }}}},
      {"refraction_error",
       "atmosphere",
       "Refraction that was corrected with a wrong pressure or temperature: the cotangent of the "
       "altitude.",
       {{"constant_arcsec", "error of the refraction at 45 deg",
         [](double e, double) {
           return SkyError{std::cos(e) / std::sin(e), 0};
         }}}},
      {"azimuth_encoder_eccentricity",
       "encoder",
       "The azimuth scale does not turn about its own centre: once a turn.",
       {{"sine_arcsec", "part with the sine of the azimuth",
         [](double e, double a) {
           return SkyError{0, std::sin(a) * std::cos(e)};
         }},
        {"cosine_arcsec", "part with its cosine",
         [](double e, double a) {
           return SkyError{0, std::cos(a) * std::cos(e)};
         }}}},
      {"azimuth_bearing",
       "mount",
       "The azimuth bearing is not flat: the axis nods twice a turn.",
       {{"sine_arcsec", "altitude error with the sine of twice the azimuth",
         [](double, double a) {
           return SkyError{std::sin(2 * a), 0};
         }},
        {"cosine_arcsec", "with its cosine",
         [](double, double a) {
           return SkyError{std::cos(2 * a), 0};
         }}}},
  };
  return all;
}

std::vector<std::string> known_names() {
  std::vector<std::string> names;
  for (const Term& term : terms()) names.emplace_back(term.name);
  return names;
}

}  // namespace

std::vector<std::string> PointingModel::names() {
  return known_names();
}

PointingModel::PointingModel(const formats::PointingRun& run,
                             const std::vector<std::string>& base_terms) {
  constexpr std::size_t fewest_stars = 12;
  if (run.size() < fewest_stars)
    throw Error(fmt::format("{} stars are too few for a diagnosis", run.size()),
                fmt::format("measure at least {}, over the whole sky", fewest_stars));
  const std::vector<std::string> names = known_names();
  for (const std::string& name : base_terms)
    if (std::find(names.begin(), names.end(), name) == names.end())
      throw Error(fmt::format("there is no pointing term '{}'", name),
                  fmt::format("terms: {}", fmt::join(names, ", ")));

  const std::size_t stars = run.size();
  constexpr double degree = 3.14159265358979323846 / 180;
  observations_.value.resize(static_cast<Eigen::Index>(2 * stars));
  observations_.channels = {"altitude", "azimuth"};
  observations_.axes = {{"altitude", "deg", {}}, {"azimuth", "deg", {}}, {"star", "1", {}}};
  for (std::size_t half = 0; half < 2; ++half) {
    for (std::size_t i = 0; i < stars; ++i) {
      const double altitude = run.true_altitude_deg[i];
      double turn = std::remainder(run.true_azimuth_deg[i] - run.encoder_azimuth_deg[i], 360.0);
      observations_.value[static_cast<Eigen::Index>(half * stars + i)] =
          3600 *
          (half == 0 ? altitude - run.encoder_altitude_deg[i] : turn * std::cos(altitude * degree));
      observations_.row.push_back(static_cast<int>(i));
      observations_.channel.push_back(static_cast<int>(half));
      observations_.axes[0].value.push_back(altitude);
      observations_.axes[1].value.push_back(std::remainder(run.true_azimuth_deg[i] - 180.0, 360.0) +
                                            180.0);
      observations_.axes[2].value.push_back(static_cast<double>(i));
    }
  }

  const auto column = [&](const TermParameter& parameter) {
    Eigen::VectorXd errors(static_cast<Eigen::Index>(2 * stars));
    for (std::size_t i = 0; i < stars; ++i) {
      const SkyError e =
          parameter.error(run.true_altitude_deg[i] * degree, run.true_azimuth_deg[i] * degree);
      errors[static_cast<Eigen::Index>(i)] = e.altitude;
      errors[static_cast<Eigen::Index>(stars + i)] = e.azimuth;
    }
    return errors;
  };
  const auto add_to_base = [&](const TermParameter& p, const std::string& name) {
    base_.push_back({name, "arcsec", p.meaning});
    base_columns_.conservativeResize(static_cast<Eigen::Index>(2 * stars),
                                     base_columns_.cols() + 1);
    base_columns_.rightCols(1) = column(p);
  };
  for (const TermParameter& p : offsets()) add_to_base(p, p.name);
  for (const Term& term : terms()) {
    if (std::find(base_terms.begin(), base_terms.end(), term.name) != base_terms.end()) {
      for (const TermParameter& p : term.parameters)
        add_to_base(p, fmt::format("{}.{}", term.name, p.name));
      continue;
    }
    Effect effect{term.name, term.stage, term.physics, "P. Wallace, TPOINT", {}};
    effect.probes.resize(1);
    Eigen::MatrixXd columns(static_cast<Eigen::Index>(2 * stars),
                            static_cast<Eigen::Index>(term.parameters.size()));
    for (std::size_t i = 0; i < term.parameters.size(); ++i) {
      Parameter parameter{term.parameters[i].name, "arcsec", term.parameters[i].meaning};
      parameter.prior_u = usual_size_arcsec;
      effect.parameters.push_back(parameter);
      Probe probe(term.parameters.size(), 0.0);
      probe[i] = 1;
      effect.probes[0].push_back(probe);
      columns.col(static_cast<Eigen::Index>(i)) = column(term.parameters[i]);
    }
    effects_.push_back(std::move(effect));
    effect_columns_.push_back(std::move(columns));
  }
}

void PointingModel::predict(const Explanation& explanation, Eigen::VectorXd& mean,
                            Eigen::MatrixXd* jacobian, const std::vector<bool>& /*wanted*/) const {
  mean = base_columns_ *
         Eigen::Map<const Eigen::VectorXd>(explanation.base.data(), base_columns_.cols());
  Eigen::Index parameters = base_columns_.cols();
  for (std::size_t k = 0; k < explanation.effects.size(); ++k) {
    const Eigen::MatrixXd& columns = effect_columns_[explanation.effects[k]];
    mean +=
        columns * Eigen::Map<const Eigen::VectorXd>(explanation.alpha[k].data(), columns.cols());
    parameters += columns.cols();
  }
  if (jacobian == nullptr) return;
  jacobian->resize(mean.size(), parameters);
  jacobian->leftCols(base_columns_.cols()) = base_columns_;
  Eigen::Index next = base_columns_.cols();
  for (const std::size_t effect : explanation.effects) {
    jacobian->middleCols(next, effect_columns_[effect].cols()) = effect_columns_[effect];
    next += effect_columns_[effect].cols();
  }
}

NoiseShape PointingModel::noise(const Eigen::VectorXd& mean) const {
  return {Eigen::VectorXd::Ones(mean.size()), {}, {}};
}

}  // namespace umov::gap
