// The sum over powers of the height phase variance in He and Torrance's directional-diffuse term
// (P10).
#pragma once

namespace umov::brdf {

/// h(g, u) = Σ_{m≥1} g^m e^(-g)/(m!·m) · exp(-u/m) and its partial derivatives.
struct HeightSeries {
  double value, by_g, by_u;
};

/// g > 0, u >= 0. Relative error below 1e-11 where the value is above 1e-300; the cost (some 30
/// terms, 100 below g = 45) does not grow with g. For large g it tends to exp(-u/g)/g with relative
/// deviation about 1/g: the facet limit.
HeightSeries height_series(double g, double u);

}  // namespace umov::brdf
