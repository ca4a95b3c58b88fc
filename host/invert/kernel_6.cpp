#include "host/invert/kernel_dual.hpp"

namespace umov::invert {

template void dual_pass<6>(const brdf::Model&, std::span<const double>, std::span<const int>,
                           double, const View&, std::span<const Channel>, std::span<double>,
                           double*, std::size_t);

}  // namespace umov::invert
