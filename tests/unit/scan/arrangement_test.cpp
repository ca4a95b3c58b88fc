// Set-ups that take a hand: where a program is cut, what is asked for, which scans a plan makes.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>

#include "host/errors/error.hpp"
#include "host/scan/arrangement.hpp"
#include "host/scan/scan_part.hpp"

namespace umov::scan {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

const std::string small =
    "sample = \"red gloss\"\nwavelengths_nm = [532]\ntheta_i_deg = [30]\n"
    "theta_r_deg = [-20, 0, 20]\nstates = [[\"P\", \"P\"]]\n";

Plan plan_with(const std::string& blocks) {
  return parse_plan(small + blocks, "plan.toml");
}

std::string block(const std::string& menu, const std::string& rest = "") {
  return "[[block]]\nmenu = \"" + menu + "\"\n" + rest;
}

std::string message_of(const Plan& plan, const std::optional<std::string>& only) {
  try {
    scan_parts(plan, "scan.h5", only);
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(Stretches, AProgramIsCutOnlyWhereAHandIsNeeded) {
  const auto program = expand(plan_with(block("reverse") + block("flip") + block("iris") +
                                        block("nd", "optical_density = 2\n") + block("oop")));
  const auto cut = stretches(program, {});
  ASSERT_EQ(cut.size(), 4u);
  EXPECT_EQ(cut[0].blocks, "main, reverse");
  EXPECT_TRUE(cut[0].arrangement.plain());
  EXPECT_EQ(cut[1].arrangement.text(), "sample_azimuth_deg=180");
  EXPECT_EQ(cut[2].arrangement.text(), "iris_fraction=0.5");
  EXPECT_EQ(cut[3].blocks, "nd, oop") << "the filter wheel turns by itself";
  EXPECT_TRUE(cut[3].arrangement.plain());
  EXPECT_EQ(cut[0].first, 0u);
  for (std::size_t i = 1; i < cut.size(); ++i) EXPECT_EQ(cut[i].first, cut[i - 1].end);
  EXPECT_EQ(cut.back().end, program.rows.size());
}

TEST(Stretches, TwoBlocksInOneSetUpAreOneStretch) {
  const auto cut =
      stretches(expand(plan_with(block("flip") + block("flip", "dwell_ms = 100\n"))), {});
  ASSERT_EQ(cut.size(), 2u);
  EXPECT_EQ(cut[1].blocks, "flip, flip");
}

TEST(Instructions, SayWhatToDoAndHowToUndoIt) {
  const Arrangement plain, turned{{{"sample_azimuth_deg", "180"}}},
      stopped{{{"iris_fraction", "0.5"}}};
  EXPECT_THAT(instructions({turned, plain, "flip"}),
              ElementsAre("Turn the sample to 180 deg about its normal."));
  EXPECT_THAT(instructions({stopped, turned, "iris"}),
              ElementsAre("Turn the sample back to 0 deg about its normal.",
                          "Set the detector's iris to 0.5 of its usual diameter."));
  EXPECT_THAT(instructions({plain, stopped, ""}),
              ElementsAre("Open the detector's iris to its usual diameter."));
  const auto unknown = instructions({turned, std::nullopt, "flip"});
  ASSERT_EQ(unknown.size(), 2u);
  EXPECT_THAT(unknown[1], HasSubstr("all else is as usual"));
}

TEST(Instructions, ATileAfterAnEmptyStageIsOneExchange) {
  const Arrangement empty{{{"sample_removed", "1"}}}, tile{{{"sample", "white-99"}}};
  EXPECT_THAT(instructions({{}, empty, ""}), ElementsAre("Put the sample back in its place."));
  EXPECT_THAT(instructions({tile, Arrangement{}, "white_tile"}),
              ElementsAre("Put white-99 in the place of the sample."));
}

TEST(ScanParts, AWhiteTileIsAScanOfItsOwnThatTheSampleRefersTo) {
  const auto parts = scan_parts(
      plan_with(block("flip") +
                block("white_tile", "reference_dhr = { 532 = 0.985 }\nreference_dhr_u = 0.003\n")),
      "results/scan.h5");
  ASSERT_EQ(parts.size(), 2u);
  const auto own = header_keys(parts[0].plan), white = header_keys(parts[1].plan);
  const auto value = [](const auto& keys, const std::string& name) {
    for (const auto& [key, text] : keys)
      if (key == name) return text;
    return std::string("-");
  };
  EXPECT_EQ(value(own, "reference"), "scan-white.h5") << "beside the scan, so without a folder";
  EXPECT_EQ(parts[1].output, "results/scan-white.h5");
  EXPECT_EQ(value(white, "role"), "white");
  EXPECT_EQ(value(white, "sample"), "white-99");
  EXPECT_EQ(value(white, "reference_dhr_532"), "0.985");
  EXPECT_EQ(value(white, "reference"), "-");
  EXPECT_EQ(value(own, "reference_dhr_532"), "-");
  EXPECT_EQ(expand(parts[0].plan).blocks.size(), 2u);
  EXPECT_TRUE(parts[0].standing.plain());
  EXPECT_EQ(parts[1].standing.text(), "sample=white-99");
  EXPECT_EQ(stretches(expand(parts[1].plan), parts[1].standing).front().blocks, "white_tile");
}

TEST(ScanParts, OneBlockAloneKeepsItsNameAndCountsFromZero) {
  const auto plan = plan_with(block("flip") + block("iris") + block("white_tile"));
  const auto flip = scan_parts(plan, "flip.h5", "flip");
  ASSERT_EQ(flip.size(), 1u);
  const auto program = expand(flip[0].plan);
  ASSERT_EQ(program.blocks.size(), 1u);
  EXPECT_EQ(program.blocks[0].name, "flip");
  EXPECT_EQ(program.blocks[0].first, 0);
  EXPECT_EQ(program.rows.front().block, 0);
  const auto main = scan_parts(plan, "main.h5", "main");
  ASSERT_EQ(main.size(), 1u);
  EXPECT_EQ(expand(main[0].plan).blocks.size(), 1u);
  EXPECT_FALSE(main[0].plan.reference) << "the tile is not part of this run";
  const auto tile = scan_parts(plan, "tile.h5", "white_tile");
  ASSERT_EQ(tile.size(), 1u);
  EXPECT_EQ(tile[0].output, "tile.h5");
  EXPECT_NE(program_id(flip[0].plan), program_id(main[0].plan));
}

TEST(ScanParts, WhatCanNotBeIsRefusedWithThePlace) {
  EXPECT_THAT(message_of(plan_with(block("flip")), "iris"), HasSubstr("main, flip"));
  EXPECT_THAT(message_of(plan_with(block("white_tile") + block("white_tile")), std::nullopt),
              HasSubstr("plan.toml:8"));
  const auto twice =
      parse_plan("reference = \"old.h5\"\n" + small + block("white_tile"), "plan.toml");
  EXPECT_THAT(message_of(twice, std::nullopt), HasSubstr("`reference`"));
  EXPECT_THROW(plan_with(block("flip", "reference_dhr = { 532 = 0.9 }\n")), Error)
      << "only a tile has a reference";
}

TEST(RequirePlain, NamesTheBlockAndTheWayOut) {
  const auto cut = stretches(expand(plan_with(block("reverse") + block("iris"))), {});
  try {
    require_plain(cut, "plan.toml");
    FAIL() << "an iris was taken for plain";
  } catch (const Error& error) {
    EXPECT_THAT(error.what(), HasSubstr("iris_fraction=0.5"));
    EXPECT_THAT(error.what(), HasSubstr("--block iris --arrange made"));
  }
  EXPECT_NO_THROW(require_plain(stretches(expand(plan_with(block("reverse"))), {}), "plan.toml"));
}

}  // namespace
}  // namespace umov::scan
