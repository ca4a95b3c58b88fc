#include "host/gap/engine/shares.hpp"

#include <algorithm>
#include <map>
#include <numeric>

#include "host/parallel/for_each_index.hpp"

namespace umov::gap {
namespace {

using Order = std::vector<std::size_t>;

constexpr std::size_t most_in_all_orders = 5;

std::vector<Order> orders(std::size_t parts) {
  Order order(parts);
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::vector<Order> all;
  if (parts <= most_in_all_orders) {
    do {
      all.push_back(order);
    } while (std::next_permutation(order.begin(), order.end()));
    return all;
  }
  for (std::size_t turn = 0; turn < parts; ++turn) {
    std::rotate(order.begin(), order.begin() + 1, order.end());
    all.push_back(order);
    all.emplace_back(order.rbegin(), order.rend());
  }
  return all;
}

}  // namespace

std::vector<double> shapley_values(std::size_t parts, const std::function<double(Subset)>& value_of,
                                   int threads) {
  const std::vector<Order> all = orders(parts);
  std::map<Subset, double> value;
  for (const Order& order : all) {
    Subset subset = 0;
    value[subset] = 0;
    for (const std::size_t part : order) value[subset |= Subset{1} << part] = 0;
  }
  std::vector<std::pair<const Subset, double>*> entries;
  for (auto& entry : value) entries.push_back(&entry);
  for_each_index(entries.size(), threads,
                 [&](std::size_t i) { entries[i]->second = value_of(entries[i]->first); });
  std::vector<double> share(parts, 0.0);
  for (const Order& order : all) {
    Subset subset = 0;
    for (const std::size_t part : order) {
      const double before = value.at(subset);
      subset |= Subset{1} << part;
      share[part] += (value.at(subset) - before) / static_cast<double>(all.size());
    }
  }
  return share;
}

}  // namespace umov::gap
