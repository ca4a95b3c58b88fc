#include "host/scan/scan_part.hpp"

#include <algorithm>
#include <utility>

#include "host/errors/error.hpp"

namespace umov::scan {
namespace {

constexpr const char* white_tile = "white_tile";

std::filesystem::path beside(const std::filesystem::path& output) {
  return output.parent_path() / (output.stem().string() + "-white" + output.extension().string());
}

/// The tile's scan: the block's grid as a plan of its own.
ScanPart tile_part(const Plan& plan, const MenuBlock& block, std::filesystem::path output) {
  ScanPart part{plan, std::move(output), {{{"sample", block.tile.sample}}}};
  part.plan.blocks.clear();
  part.plan.main = true;
  part.plan.grid = block.grid;
  part.plan.role = "white";
  part.plan.sample = block.tile.sample;
  part.plan.reference.reset();
  part.plan.reference_dhr = block.tile.reference_dhr;
  part.plan.reference_dhr_u = block.tile.reference_dhr_u;
  part.plan.reference_brdf = block.tile.reference_brdf;
  return part;
}

std::string block_list(const Plan& plan) {
  std::string names = "main";
  for (const MenuBlock& block : plan.blocks)
    if (names.find(block.menu) == std::string::npos) names += ", " + block.menu;
  return names;
}

}  // namespace

std::vector<ScanPart> scan_parts(const Plan& plan, const std::filesystem::path& output,
                                 const std::optional<std::string>& only) {
  ScanPart own{plan, output, {}};
  own.plan.blocks.clear();
  own.plan.main = !only || *only == "main";
  const MenuBlock* tile = nullptr;
  for (const MenuBlock& block : plan.blocks) {
    if (only && *only != block.menu) continue;
    if (block.menu != white_tile) {
      own.plan.blocks.push_back(block);
      continue;
    }
    if (tile != nullptr)
      throw Error(Place{plan.name, block.line}, "a second block white_tile",
                  "one scan refers to one white tile: put all its angles into one block");
    tile = &block;
  }
  const bool any = own.plan.main || !own.plan.blocks.empty();
  if (!any && tile == nullptr)
    throw Error(Place{plan.name}, "the plan has no block `" + only.value_or("") + "`",
                "it has: " + block_list(plan));
  if (!any) return {tile_part(plan, *tile, output)};
  if (tile == nullptr) return {std::move(own)};
  if (plan.reference)
    throw Error(Place{plan.name, tile->line}, "a block white_tile beside the key `reference`",
                "keep one of them: both name the white scan that this sample refers to");
  ScanPart white = tile_part(plan, *tile, beside(output));
  own.plan.reference = white.output.filename().string();
  std::vector<ScanPart> parts;
  parts.push_back(std::move(own));
  parts.push_back(std::move(white));
  return parts;
}

}  // namespace umov::scan
