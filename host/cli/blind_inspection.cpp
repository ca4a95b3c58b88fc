// umov blind effects, umov blind check: what can be withheld, and whether a truth is the sealed
// one.
#include <memory>
#include <string>

#include <fmt/format.h>
#include <CLI/CLI.hpp>
#include <nlohmann/json.hpp>

#include "hil/blind/case_set.hpp"
#include "host/cli/blind.hpp"
#include "host/errors/error.hpp"

namespace umov::cli {
namespace {

void list_effects(const Common& common) {
  nlohmann::json all = nlohmann::json::array();
  for (const blind::EffectKind& kind : blind::effect_kinds()) {
    blind::Random random(1);
    const blind::EffectContext context;
    nlohmann::json names = nlohmann::json::array();
    for (const auto& [name, value] :
         blind::draw_effect(kind, random, context, kind.smallest).parameters) {
      names.push_back(name);
    }
    if (!common.json) {
      fmt::print("{:<27}{:<9}{:<20}{:>8.2g} to {:<6.2g} {}\n", kind.name,
                 kind.in_catalogue ? "" : "foreign", kind.principal, kind.smallest, kind.largest,
                 kind.about);
      continue;
    }
    all.push_back({{"effect", kind.name},
                   {"in_catalogue", kind.in_catalogue},
                   {"parameters", names},
                   {"smallest", kind.smallest},
                   {"largest", kind.largest},
                   {"both_signs", kind.both_signs},
                   {"about", kind.about}});
  }
  if (common.json) fmt::print("{}\n", all.dump());
}

struct CheckOptions {
  std::string folder, truth;
};

void check(const CheckOptions& options, const Common& common) {
  if (!blind::seal_fits(options.folder, options.truth)) {
    throw Error({options.truth}, "is not the truth that " + options.folder + " was sealed with",
                "name the folder that was made with it; a truth that was changed is void");
  }
  const blind::Seal seal = blind::read_seal(options.folder);
  if (common.json) {
    fmt::print("{}\n", nlohmann::json{{"sha256", seal.sha256}, {"cases", seal.cases}}.dump());
  } else {
    fmt::print("the seal fits: {} cases, sha256 {}\n", seal.cases, seal.sha256);
  }
}

}  // namespace

void add_blind_inspection(CLI::App& blind, const Common& common) {
  auto* effects = blind.add_subcommand("effects", "What effects can be in a case, and how large");
  effects->callback([&common] { list_effects(common); });

  auto options = std::make_shared<CheckOptions>();
  auto* command = blind.add_subcommand("check", "Is this the truth that a set was sealed with?");
  command->add_option("folder", options->folder, "folder of the cases")->required();
  command->add_option("--truth", options->truth, "folder of the sealed truth")->required();
  command->callback([options, &common] { check(*options, common); });
}

}  // namespace umov::cli
