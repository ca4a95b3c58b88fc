#include "host/cli/scene_digest.hpp"

#include <system_error>
#include <vector>

#include <toml++/toml.h>

#include "host/formats/atomic_file.hpp"
#include "host/formats/sha256.hpp"
#include "host/toml/parse.hpp"

namespace umov::cli {
namespace {

/// Strings of a table and of what is in it.
void gather(const toml::node& node, std::vector<std::string>& strings) {
  if (const auto* text = node.as_string()) strings.push_back(text->get());
  if (const auto* table = node.as_table())
    for (const auto& [key, value] : *table) gather(value, strings);
  if (const auto* array = node.as_array())
    for (const toml::node& value : *array) gather(value, strings);
}

}  // namespace

std::string scene_digest(const std::filesystem::path& scene) {
  const std::string own = formats::sha256_of_file(scene);
  std::vector<std::string> strings;
  gather(parse_toml(formats::read_whole_file(scene), scene.string(), "see the scene's README"),
         strings);
  std::string all = own;
  for (const std::string& name : strings) {
    const std::filesystem::path file = scene.parent_path() / name;
    std::error_code none;
    if (std::filesystem::is_regular_file(file, none)) all += formats::sha256_of_file(file);
  }
  if (all == own) return own;
  formats::Sha256 together;
  together.update(all);
  return together.hex_digest();
}

}  // namespace umov::cli
