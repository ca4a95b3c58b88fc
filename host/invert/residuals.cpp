#include "host/invert/residuals.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace umov::invert {

double huber_root(double r, double k, double& slope) {
  slope = 1;
  if (k <= 0 || std::abs(r) <= k) return r;
  const double root = std::sqrt(2 * k * std::abs(r) - k * k);
  slope = k / root;
  return std::copysign(root, r);
}

SpectrumResiduals residuals(const Layout& layout, const Observations& data, std::size_t wavelength,
                            std::span<const double> x, std::span<const double> c,
                            const Weighting& weighting, bool derivatives) {
  const Spectrum& spectrum = data.spectra[wavelength];
  const std::vector<double> values = layout.values(wavelength, x);
  const std::vector<int>& active = layout.active(wavelength);
  const auto points = static_cast<Eigen::Index>(spectrum.points.size());
  SpectrumResiduals out;
  out.r.resize(points);
  if (derivatives) {
    out.by_x.resize(points, static_cast<Eigen::Index>(active.size()));
    out.by_c.setZero(points, static_cast<Eigen::Index>(c.size()));
  }
  std::vector<double> slopes;
  for (const int parameter : active) {
    const std::size_t free = *layout.slot(wavelength, static_cast<std::size_t>(parameter));
    slopes.push_back(layout.free()[free].coordinate.slope(x[free]));
  }
  std::vector<double> f, df;
  for (const Site& site : spectrum.sites) {
    f.assign(site.count, 0.0);
    df.assign(derivatives ? site.count * active.size() : 0, 0.0);
    evaluate_channels(layout.model(), values, active, layout.wavelength_um(wavelength), site.view,
                      std::span(spectrum.channels).subspan(site.first, site.count), f, df);
    for (std::size_t i = 0; i < site.count; ++i) {
      const std::size_t index = site.first + i;
      const Observation& point = spectrum.points[index];
      double factor = 1, offset = 0;
      for (std::size_t k = 0; k < c.size(); ++k) {
        const CommonError& common = spectrum.common[k];
        if (common.per_point.empty()) continue;
        (common.relative ? factor : offset) += c[k] * common.per_point[index];
      }
      const double unit = weighting.relative ? point.brdf_per_sr : point.sigma * weighting.scale;
      const auto row = static_cast<Eigen::Index>(index);
      double slope = 1;
      out.r[row] = huber_root((f[i] * factor + offset - point.brdf_per_sr) / unit,
                              weighting.huber_sigma, slope);
      if (!derivatives) continue;
      const double weight = slope / unit;
      for (std::size_t a = 0; a < active.size(); ++a) {
        out.by_x(row, static_cast<Eigen::Index>(a)) =
            weight * factor * df[i * active.size() + a] * slopes[a];
      }
      for (std::size_t k = 0; k < c.size(); ++k) {
        const CommonError& common = spectrum.common[k];
        if (common.per_point.empty()) continue;
        out.by_c(row, static_cast<Eigen::Index>(k)) =
            weight * common.per_point[index] * (common.relative ? f[i] : 1.0);
      }
    }
  }
  return out;
}

Linearisation linearise(const Layout& layout, const Observations& data, std::span<const double> x,
                        std::span<const double> c, const Weighting& weighting) {
  Linearisation out;
  const auto points = static_cast<Eigen::Index>(data.size());
  out.r.resize(points);
  out.by_x.setZero(points, static_cast<Eigen::Index>(layout.size()));
  out.by_c.setZero(points, static_cast<Eigen::Index>(c.size()));
  Eigen::Index first = 0;
  for (std::size_t w = 0; w < data.spectra.size(); ++w) {
    const SpectrumResiduals part = residuals(layout, data, w, x, c, weighting, true);
    const Eigen::Index count = part.r.size();
    out.r.segment(first, count) = part.r;
    const auto& active = layout.active(w);
    for (std::size_t a = 0; a < active.size(); ++a) {
      const std::size_t free = *layout.slot(w, static_cast<std::size_t>(active[a]));
      out.by_x.col(static_cast<Eigen::Index>(free)).segment(first, count) =
          part.by_x.col(static_cast<Eigen::Index>(a));
    }
    if (out.by_c.cols() > 0) out.by_c.middleRows(first, count) = part.by_c;
    first += count;
  }
  return out;
}

double residual_scale(const Eigen::VectorXd& r, double k, std::size_t free_parameters) {
  const auto n = static_cast<double>(r.size());
  const double dof = std::max(1.0, n - static_cast<double>(free_parameters));
  double s = std::sqrt(r.squaredNorm() / dof);
  if (k <= 0 || s == 0) return s;
  // Each step solves the equation with the clipped set held; it falls monotonically to the root.
  for (int step = 0; step < 200; ++step) {
    double inside = 0, clipped = 0;
    for (const double value : r) {
      if (std::abs(value) <= k * s) {
        inside += value * value;
      } else {
        clipped += 1;
      }
    }
    const double left = dof - clipped * k * k;
    const double next = left > 0 ? std::sqrt(inside / left) : s;
    if (!(next < s * (1 - 1e-9))) break;
    s = next;
  }
  return s;
}

}  // namespace umov::invert
