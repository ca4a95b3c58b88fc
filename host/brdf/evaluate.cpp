#include "host/brdf/evaluate.hpp"

namespace umov::brdf {

template optics::Mueller<double> evaluate<double, double>(const Model&, std::span<const double>,
                                                          double, const Geometry<double>&);
template optics::Mueller<double> evaluate<double, double>(const Model&, std::span<const double>,
                                                          double, const Geometry<double>&,
                                                          const FacetFrame<double>&);
template optics::Mueller<double> mirror_reflectance<double, double>(const Model&,
                                                                    std::span<const double>, double,
                                                                    const double&);

}  // namespace umov::brdf
