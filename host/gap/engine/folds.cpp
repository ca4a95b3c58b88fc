#include "host/gap/engine/folds.hpp"

#include <algorithm>
#include <map>
#include <random>

namespace umov::gap {

std::vector<int> fold_of_observations(const std::vector<int>& row, int count, std::uint64_t seed) {
  std::vector<int> rows = row;
  std::sort(rows.begin(), rows.end());
  rows.erase(std::unique(rows.begin(), rows.end()), rows.end());
  // Not std::shuffle: its order is the library's own affair, and results must repeat anywhere.
  std::mt19937_64 random(seed);
  for (std::size_t i = rows.size(); i > 1; --i) std::swap(rows[i - 1], rows[random() % i]);
  std::map<int, int> fold;
  for (std::size_t i = 0; i < rows.size(); ++i)
    fold[rows[i]] = static_cast<int>(i % static_cast<std::size_t>(count));
  std::vector<int> result;
  result.reserve(row.size());
  for (const int r : row) result.push_back(fold[r]);
  return result;
}

}  // namespace umov::gap
