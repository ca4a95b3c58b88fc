// Gauss–Legendre nodes, computed once per order.
#pragma once

#include <vector>

namespace umov::plant {

struct QuadratureRule {
  std::vector<double> node;    ///< on (0, 1), ascending
  std::vector<double> weight;  ///< sum 1
};

/// `order` nodes on (0, 1), exact for polynomials of degree 2·order - 1.
const QuadratureRule& gauss_legendre(int order);

}  // namespace umov::plant
