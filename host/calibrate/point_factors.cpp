#include "host/calibrate/point_factors.hpp"

#include <cmath>
#include <set>
#include <string>

#include <fmt/format.h>
#include <Eigen/Dense>

#include "host/calibrate/declared_causes.hpp"

namespace umov::calibrate {

namespace {

using Factor = formats::BrdfTable::Factor;

class Collector {
 public:
  Collector(const formats::BrdfTable::Points& points, const std::vector<PointOrigin>& origin,
            const Calibration& calibration)
      : points_(points), origin_(origin), calibration_(calibration) {}

  /// d ln f for a shift of the parameters of the point's wavelength.
  double log_shift(std::size_t i, const Eigen::VectorXd& shift) const {
    const PointOrigin& origin = origin_[i];
    return calibrate::log_shift(calibration_.wavelengths[origin.wavelength], points_.theta_r_deg[i],
                                origin.bias_lever, shift);
  }

  template <class Shift>
  void add(std::string name, Shift&& shift_of_point) {
    Factor factor{std::move(name), std::vector<double>(points_.size(), 0.0)};
    double visible = 0;  // chi-square of one standard deviation over all points
    for (std::size_t i = 0; i < points_.size(); ++i) {
      factor.per_point[i] = shift_of_point(i);
      const double u = points_.brdf_u[i];
      visible += u > 0 ? factor.per_point[i] * factor.per_point[i] / (u * u) : 0.0;
    }
    if (visible >= 0.003) factors.push_back(std::move(factor));
  }

  std::vector<Factor> factors;

 private:
  const formats::BrdfTable::Points& points_;
  const std::vector<PointOrigin>& origin_;
  const Calibration& calibration_;
};

/// What a systematic quantity does to a point through the standard's scan.
double shift_through_standard(const Collector& collector, const Systematic& systematic,
                              const PointOrigin& origin, double brdf, std::size_t i) {
  return brdf * collector.log_shift(i, systematic.shift[origin.wavelength]);
}

void add_stray_light(Collector& collector, const formats::BrdfTable::Points& points,
                     const std::vector<PointOrigin>& origin, const Calibration& calibration) {
  const Eigen::MatrixXd shifts = calibration.stray.shifts();
  for (const Systematic& s : calibration.systematics) {
    if (s.kind != Systematic::Kind::stray) continue;
    const Eigen::VectorXd column = shifts.col(static_cast<Eigen::Index>(s.cause));
    collector.add(fmt::format("stray light {}", s.cause + 1), [&](std::size_t i) {
      const double level = calibration.stray.level_shift(
          column, points.wavelength_nm[i], points.theta_r_deg[i], points.phi_r_deg[i]);
      return shift_through_standard(collector, s, origin[i], points.brdf_per_sr[i], i) -
             origin[i].per_volt * origin[i].stray_v * level;
    });
  }
}

void add_declared(Collector& collector, const formats::BrdfTable::Points& points,
                  const std::vector<PointOrigin>& origin, const Calibration& calibration) {
  for (const DeclaredCause& cause : declared_causes(points, origin, calibration))
    collector.add(cause.name, [&](std::size_t i) {
      double shift = cause.own_per_sr.empty() ? 0.0 : cause.own_per_sr[i];
      if (cause.through_standard)
        shift += shift_through_standard(collector, calibration.systematics[*cause.through_standard],
                                        origin[i], points.brdf_per_sr[i], i);
      return shift;
    });
}

}  // namespace

double log_shift(const WavelengthCalibration& entry, double theta_r_deg, double bias_lever,
                 const Eigen::VectorXd& shift) {
  const auto& function = entry.instrument_function;
  const auto count = static_cast<Eigen::Index>(function.degrees.size());
  double sum = -shift(0);
  if (count > 0) sum -= function.basis(theta_r_deg).dot(shift.segment(1, count));
  if (entry.bias_active)
    sum -= bias_lever / (1.0 + entry.detector_bias * bias_lever) * shift(count + 1);
  return sum;
}

std::string statistics_factor_name(const WavelengthCalibration& entry, Eigen::Index column) {
  if (column == 0) return fmt::format("gain {:g} nm", entry.wavelength_nm);
  if (column <= static_cast<Eigen::Index>(entry.instrument_function.degrees.size()))
    return fmt::format("instrument function {:g} nm {}", entry.wavelength_nm, column);
  return fmt::format("detector bias {:g} nm", entry.wavelength_nm);
}

std::vector<Factor> point_factors(const formats::BrdfTable::Points& points,
                                  const std::vector<PointOrigin>& origin,
                                  const Calibration& calibration, const Dark& scan_dark) {
  Collector collector(points, origin, calibration);

  // Statistics of the standard's scan: columns of a Cholesky factor of each covariance.
  for (std::size_t w = 0; w < calibration.wavelengths.size(); ++w) {
    const WavelengthCalibration& entry = calibration.wavelengths[w];
    const Eigen::MatrixXd lower = Eigen::LLT<Eigen::MatrixXd>(entry.covariance).matrixL();
    for (Eigen::Index k = 0; k < lower.cols(); ++k) {
      const Eigen::VectorXd shift = lower.col(k);
      collector.add(statistics_factor_name(entry, k), [&](std::size_t i) {
        return origin[i].wavelength == w ? points.brdf_per_sr[i] * collector.log_shift(i, shift)
                                         : 0.0;
      });
    }
    // A δ that is too small to be told from zero still is not known to be zero.
    if (!entry.bias_active)
      collector.add(fmt::format("detector bias {:g} nm", entry.wavelength_nm), [&](std::size_t i) {
        return origin[i].wavelength == w ? -points.brdf_per_sr[i] * entry.detector_bias_u *
                                               (origin[i].bias_lever - entry.gain_bias_lever)
                                         : 0.0;
      });
    const double open = entry.bias_active ? entry.detector_bias : entry.detector_bias_u;
    collector.add(fmt::format("detector bias of open analyser {:g} nm", entry.wavelength_nm),
                  [&](std::size_t i) {
                    return origin[i].wavelength == w
                               ? -points.brdf_per_sr[i] * open * origin[i].open_bias
                               : 0.0;
                  });
  }

  collector.add("reference standard", [&](std::size_t i) {
    return points.brdf_per_sr[i] *
           calibration.wavelengths[origin[i].wavelength].reference_relative_u;
  });
  collector.add("reference shape", [&](std::size_t i) {
    return points.brdf_per_sr[i] * calibration.shape_u *
           ReferenceStandard::shape(points.theta_r_deg[i]);
  });

  // Dark and ranges act on the standard (through the parameters) and on the point itself.
  std::set<double> gains;
  for (const PointOrigin& o : origin) gains.insert(o.gain);
  const auto through_standard = [&](Systematic::Kind kind, double gain, std::size_t i) {
    for (const Systematic& s : calibration.systematics)
      if (s.kind == kind && s.gain == gain)
        return points.brdf_per_sr[i] * collector.log_shift(i, s.shift[origin[i].wavelength]);
    return 0.0;
  };
  for (const Systematic& s : calibration.systematics) gains.insert(s.gain);
  for (const RangeError& range : calibration.ranges.ranges) gains.insert(range.gain);
  const Eigen::MatrixXd electronics =
      electronics_shifts(calibration.ranges, calibration.nonlinearity);
  // Column `cause` of the electronics' errors at a point: d f/f of its range's error and of κ.
  const auto electronic_shift = [&](Eigen::Index cause, std::size_t i) {
    const Eigen::Index row = calibration.ranges.number(origin[i].gain);
    const double error = row < 0 ? 0.0 : electronics(row, cause);
    const double kappa = electronics(electronics.rows() - 1, cause);
    const double signal = origin[i].signal_v;
    return origin[i].per_volt * signal * (kappa * signal - error);
  };
  for (double gain : gains) {
    collector.add(fmt::format("dark range {:g}", gain), [&](std::size_t i) {
      double shift = through_standard(Systematic::Kind::dark, gain, i);
      if (origin[i].gain == gain && !origin[i].own_dark)
        shift -= origin[i].per_volt * calibration.dark.at(gain).x_u;
      return shift;
    });
    collector.add(fmt::format("scan dark range {:g}", gain), [&](std::size_t i) {
      return origin[i].gain == gain && origin[i].own_dark
                 ? -origin[i].per_volt * scan_dark.at(gain).x_u
                 : 0.0;
    });
    const Eigen::Index column = calibration.ranges.number(gain);
    collector.add(fmt::format("gain range {:g}", gain), [&](std::size_t i) {
      double shift = through_standard(Systematic::Kind::range, gain, i);
      if (column >= 0)
        shift += electronic_shift(column, i);
      else if (origin[i].gain == gain)
        shift -= points.brdf_per_sr[i] * calibration.ranges.at(gain).u;
      return shift;
    });
  }
  collector.add("detector nonlinearity", [&](std::size_t i) {
    return through_standard(Systematic::Kind::nonlinearity, 0, i) +
           electronic_shift(electronics.cols() - 1, i);
  });
  add_stray_light(collector, points, origin, calibration);
  add_declared(collector, points, origin, calibration);
  return collector.factors;
}

}  // namespace umov::calibrate
