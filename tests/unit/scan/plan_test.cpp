#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <map>
#include <set>

#include "host/errors/error.hpp"
#include "host/scan/plan.hpp"
#include "host/scan/plan_menu.hpp"

namespace umov::scan {
namespace {

using ::testing::ElementsAre;
using ::testing::HasSubstr;

const std::string minimal =
    "wavelengths_nm = [532, 633]\n"
    "theta_i_deg = [10, 30, 45, 60]\n"
    "theta_r_deg = { from = -80, to = 80, step = 4 }\n"
    "states = [[\"P\", \"P\"], [\"P\", \"S\"], [\"S\", \"S\"], [\"P\", \"open\"]]\n";

Program program_of(const std::string& text) {
  return expand(parse_plan(text, "plan.toml"));
}

Error error_of(const std::string& text) {
  try {
    parse_plan(text, "plan.toml");
  } catch (const Error& error) {
    return error;
  }
  ADD_FAILURE() << "accepted:\n" << text;
  return Error("nothing thrown", "");
}

std::vector<double> detector_angles(const Program& program, std::size_t first, std::size_t count) {
  std::vector<double> angles;
  for (std::size_t i = first; i < first + count; ++i) angles.push_back(program.rows[i].theta_r_deg);
  return angles;
}

const formats::Block& block(const Program& program, const std::string& name) {
  for (const auto& b : program.blocks)
    if (b.name == name) return b;
  throw std::runtime_error("no block " + name);
}

TEST(Plan, RunsWavelengthThenIncidenceThenStateThenDetector) {
  const Program program = program_of(
      "wavelengths_nm = [633, 532]\ntheta_i_deg = [30, 60]\ntheta_r_deg = [-10, 0, 10]\n"
      "states = [[\"P\", \"P\"], [\"S\", \"open\"]]\ndwell_ms = 70\n");
  ASSERT_EQ(program.rows.size(), 2u * 2 * 2 * 3);
  EXPECT_THAT(detector_angles(program, 0, 6), ElementsAre(-10, 0, 10, -10, 0, 10));
  EXPECT_EQ(program.rows[0].wavelength_nm, 633);
  EXPECT_EQ(program.rows[0].wavelength_index, 0);
  EXPECT_EQ(program.rows[12].wavelength_nm, 532);
  EXPECT_EQ(program.rows[12].wavelength_index, 1);
  EXPECT_EQ(program.rows[6].theta_i_deg, 60);
  EXPECT_EQ(program.rows[3].polarizer_deg, 90);
  EXPECT_TRUE(formats::is_open(program.rows[3].analyzer_deg));
  EXPECT_EQ(program.rows[5].dwell_ms, 70);
  EXPECT_EQ(program.rows[5].gain, gain_auto);
  EXPECT_TRUE(program.rows[5].shutter_open);
  ASSERT_EQ(program.blocks.size(), 1u);
  EXPECT_EQ(program.blocks[0].name, "main");
  EXPECT_EQ(program.blocks[0].last, 23);
}

TEST(Plan, SerpentineTurnsEverySecondLine) {
  const Program program = program_of(
      "wavelengths_nm = 532\ntheta_i_deg = [30, 60]\ntheta_r_deg = [-10, 0, 10]\n"
      "states = [[0, 0], [0, 90], [90, 90]]\norder = \"serpentine\"\n");
  EXPECT_THAT(detector_angles(program, 0, 12),
              ElementsAre(-10, 0, 10, 10, 0, -10, -10, 0, 10, 10, 0, -10));
}

TEST(Plan, RandomOrderTakesEveryRowOnceAndIsSeeded) {
  const std::string text = minimal + "order = \"random\"\n";
  const Program ordered = program_of(minimal);
  const Program first = program_of(text), again = program_of(text);
  const Program other = program_of(text + "seed = 2\n");
  const auto key = [](const PlanRow& r) {
    return std::tuple(r.wavelength_nm, r.theta_i_deg, r.theta_r_deg, r.polarizer_deg,
                      formats::is_open(r.analyzer_deg) ? -999 : r.analyzer_deg);
  };
  std::multiset<decltype(key(ordered.rows[0]))> a, b;
  bool same = true, moved = false, seeded = false;
  for (std::size_t i = 0; i < ordered.rows.size(); ++i) {
    a.insert(key(ordered.rows[i]));
    b.insert(key(first.rows[i]));
    same = same && key(first.rows[i]) == key(again.rows[i]);
    moved = moved || key(first.rows[i]) != key(ordered.rows[i]);
    seeded = seeded || key(first.rows[i]) != key(other.rows[i]);
    EXPECT_EQ(first.rows[i].theta_i_deg, ordered.rows[i].theta_i_deg)
        << "shuffled within a line set";
  }
  EXPECT_EQ(a, b);
  EXPECT_TRUE(same);
  EXPECT_TRUE(moved);
  EXPECT_TRUE(seeded);
}

TEST(Plan, DensifiesAboutEachMirrorDirection) {
  const Plan plan = parse_plan(
      "wavelengths_nm = 532\ntheta_i_deg = [30, 88]\n"
      "theta_r_deg = { from = -80, to = 80, step = 10, near = { within_deg = 4, step = 1 } }\n",
      "plan.toml");
  const std::vector<double> line = plan.grid.theta_r.line(30, 0);
  EXPECT_EQ(line.size(), 17u + 8);
  for (int theta = 26; theta <= 34; ++theta)
    EXPECT_TRUE(std::binary_search(line.begin(), line.end(), theta)) << theta;
  EXPECT_EQ(plan.grid.theta_r.line(88, 0).back(), 90) << "never beyond the horizon";
  EXPECT_EQ(plan.grid.theta_r.line(30, 90).size(), 9u) << "out of plane: the grid from 0 up";
}

TEST(Plan, MirrorFollowsTheIncidence) {
  const Program program = program_of(
      "wavelengths_nm = 532\ntheta_i_deg = { from = 20, to = 80, step = 20 }\n"
      "theta_r_deg = \"mirror\"\nstates = [[45, \"open\"]]\nrole = \"mirror\"\noptical_density = "
      "4\n");
  ASSERT_EQ(program.rows.size(), 4u);
  for (const PlanRow& row : program.rows) {
    EXPECT_EQ(row.theta_r_deg, row.theta_i_deg);
    EXPECT_EQ(row.optical_density, 4);
  }
}

TEST(Plan, OutOfPlaneRowsHaveNoNegativeDetectorAngle) {
  const Program program = program_of(minimal + "phi_r_deg = [0, 90, 180]\n");
  int out_of_plane = 0;
  for (const PlanRow& row : program.rows) {
    if (row.phi_r_deg != 0) {
      EXPECT_GE(row.theta_r_deg, 0);
      ++out_of_plane;
    }
  }
  EXPECT_EQ(out_of_plane, 2 * 4 * 2 * 21 * 4);
}

TEST(Plan, RangesHaveNoRoundingTails) {
  const Plan plan = parse_plan(
      "wavelengths_nm = 532\ntheta_i_deg = 30\ntheta_r_deg = { from = -1, to = 1, step = 0.1 }\n",
      "p");
  EXPECT_EQ(plan.grid.theta_r.base_deg.size(), 21u);
  EXPECT_EQ(plan.grid.theta_r.base_deg[3], -0.7);
  EXPECT_EQ(plan.grid.theta_r.base_deg[10], 0.0);
  EXPECT_FALSE(std::signbit(plan.grid.theta_r.base_deg[10]));
}

TEST(Plan, EveryMenuEntryAddsItsRows) {
  std::string text = minimal;
  for (const std::string_view menu : menu_names)
    text += "[[block]]\nmenu = \"" + std::string(menu) + "\"\n";
  const Program program = program_of(text);
  ASSERT_EQ(program.blocks.size(), 13u);
  std::int64_t next = 0;
  for (std::size_t b = 0; b < program.blocks.size(); ++b) {
    EXPECT_EQ(program.blocks[b].first, next) << "blocks follow each other without gaps";
    EXPECT_GE(program.blocks[b].last, program.blocks[b].first);
    for (auto i = program.blocks[b].first; i <= program.blocks[b].last; ++i)
      EXPECT_EQ(program.rows[static_cast<std::size_t>(i)].block, static_cast<int>(b));
    next = program.blocks[b].last + 1;
  }
  EXPECT_EQ(next, static_cast<std::int64_t>(program.rows.size()));

  const auto of = [&](const std::string& name) {
    const auto& b = block(program, name);
    return std::vector<PlanRow>(program.rows.begin() + b.first, program.rows.begin() + b.last + 1);
  };
  EXPECT_GT(of("reverse")[0].theta_r_deg, of("reverse")[1].theta_r_deg);
  EXPECT_EQ(block(program, "flip").settings[0],
            (std::pair<std::string, std::string>("sample_azimuth_deg", "180")));
  EXPECT_EQ(block(program, "iris").settings[0].second, "0.5");
  EXPECT_EQ(block(program, "long_pass").settings[0].second, "long_pass");
  EXPECT_EQ(block(program, "no_sample").settings[0].first, "sample_removed");
  EXPECT_TRUE(block(program, "shutter").settings.empty());
  for (const PlanRow& row : of("shutter")) EXPECT_FALSE(row.shutter_open);
  std::set<double> densities, azimuths, axes;
  for (const PlanRow& row : of("nd")) densities.insert(row.optical_density);
  for (const PlanRow& row : of("oop")) azimuths.insert(row.phi_r_deg);
  for (const PlanRow& row : of("pm45")) axes.insert(row.analyzer_deg);
  EXPECT_THAT(densities, ElementsAre(0, 1, 2));
  EXPECT_THAT(azimuths, ElementsAre(30, 90, 150));
  EXPECT_THAT(axes, ElementsAre(-45, 45));
  std::map<std::pair<double, double>, int> repeats;
  for (const PlanRow& row : of("repeat")) ++repeats[{row.wavelength_nm, row.theta_r_deg}];
  EXPECT_EQ(repeats.size(), 4u);
  for (const auto& [point, count] : repeats) EXPECT_EQ(count, 8);
}

TEST(Plan, ABlockTakesItsOwnGridWhereItHasOne) {
  const Program program =
      program_of(minimal +
                 "[[block]]\nmenu = \"nd\"\noptical_density = 3\ntheta_i_deg = 45\n"
                 "theta_r_deg = [40, 45, 50]\nstates = [[\"S\", \"S\"]]\nwavelengths_nm = [633]\n"
                 "dwell_ms = 200\nrepeats = 2\n");
  const auto& b = block(program, "nd");
  EXPECT_EQ(b.last - b.first + 1, 6);
  const PlanRow& row = program.rows[static_cast<std::size_t>(b.first)];
  EXPECT_EQ(row.wavelength_index, 1);
  EXPECT_EQ(row.optical_density, 3);
  EXPECT_EQ(row.dwell_ms, 200);
  EXPECT_EQ(b.settings[0].first, "optical_density");
}

TEST(Plan, WhiteStandardKeysReachTheHeader) {
  const Plan plan = parse_plan(
      minimal +
          "role = \"white\"\nsample = \"white 99\"\nreference_dhr = { 532 = 0.99, 633 = 0.985 }\n"
          "reference_dhr_u = 0.005\nreference_brdf = \"tile.h5\"\n",
      "p");
  std::map<std::string, std::string> keys;
  for (const auto& [key, value] : header_keys(plan)) keys[key] = value;
  EXPECT_EQ(keys["role"], "white");
  EXPECT_EQ(keys["sample"], "white 99");
  EXPECT_EQ(keys["reference_dhr_532"], "0.99");
  EXPECT_EQ(keys["reference_dhr_633"], "0.985");
  EXPECT_EQ(keys["reference_dhr_u"], "0.005");
  EXPECT_EQ(keys["reference_brdf"], "tile.h5");
  EXPECT_EQ(keys["solid_angle_sr"], "0.0001");
}

TEST(Plan, TheProgramIdChangesWithTheMeaningOnly) {
  const std::uint32_t id = program_id(parse_plan(minimal, "a"));
  EXPECT_NE(id, 0u);
  EXPECT_EQ(program_id(parse_plan("# a remark\n" + minimal, "b")), id);
  for (const std::string change :
       {"dwell_ms = 51\n", "gain = 10\n", "settle_ms = 3\n", "sample = \"x\"\n",
        "optical_density = 1\n", "order = \"reverse\"\n", "reference_hz = 900\n"})
    EXPECT_NE(program_id(parse_plan(minimal + change, "c")), id) << change;
}

struct Fault {
  const char* what;
  const char* by;
  std::size_t line;
  const char* column;
  const char* message;
};

class PlanFault : public ::testing::TestWithParam<Fault> {};

TEST_P(PlanFault, IsRefusedWithItsPlace) {
  const Fault& fault = GetParam();
  std::string text = minimal + "dwell_ms = 50\n";
  const std::size_t at = text.find(fault.what);
  ASSERT_NE(at, std::string::npos);
  const Error error = error_of(text.replace(at, std::string(fault.what).size(), fault.by));
  EXPECT_EQ(error.place().file, "plan.toml");
  EXPECT_EQ(error.place().line, fault.line) << error.what();
  EXPECT_EQ(error.place().column, fault.column) << error.what();
  EXPECT_THAT(std::string(error.what()), HasSubstr(fault.message));
}

INSTANTIATE_TEST_SUITE_P(
    Keys, PlanFault,
    ::testing::Values(
        Fault{"dwell_ms", "dwel_ms", 5, "dwel_ms", "did you mean \"dwell_ms\"?"},
        Fault{"theta_i_deg", "theta_i", 2, "theta_i", "did you mean \"theta_i_deg\"?"},
        Fault{"dwell_ms = 50", "zzzzzz = 1", 5, "zzzzzz", "known keys: block"},
        Fault{"step = 4", "steps = 4", 3, "theta_r_deg.step", "missing"},
        Fault{"step = 4", "step = 4, near = { within = 5, step = 1 }", 3, "theta_r_deg.near.within",
              "within_deg"},
        Fault{"dwell_ms = 50", "[[block]]\nmenu = \"flop\"", 6, "block[0].menu",
              "did you mean \"flip\"?"},
        Fault{"dwell_ms = 50", "[[block]]\nmenu = \"flip\"\nirisfraction = 1", 7,
              "block[0].irisfraction", "unknown key"},
        Fault{"dwell_ms = 50", "[[block]]\nangle = 3", 5, "block[0]", "`menu` is missing"},
        Fault{"dwell_ms = 50", "block = 3", 5, "block", "[[block]]"},
        Fault{"theta_i_deg = [10, 30, 45, 60]\n", "", 0, "theta_i_deg", "missing"},
        Fault{"dwell_ms = 50", "dwell_ms = ", 5, "12", "TOML"},
        Fault{"dwell_ms = 50", "seed = [ }", 5, "10", "brackets"},
        Fault{"dwell_ms = 50", "[=]", 5, "2", "table header"},
        Fault{"dwell_ms = 50", "dwell_ms = \xef\xbd\xbd", 5, "12", "ASCII"},
        Fault{"dwell_ms = 50", "dwell\x01ms = 50", 5, "6", "control character"},
        Fault{"dwell_ms = 50", "[[block\nmenu = \"flip\"", 5, "8", "TOML"},
        Fault{"dwell_ms = 50", "dwell_ms = 50\ndwell_ms = 60", 6, "12", "TOML"}));

INSTANTIATE_TEST_SUITE_P(
    Values, PlanFault,
    ::testing::Values(
        Fault{"60]", "91]", 2, "theta_i_deg", "0 to 90 deg"},
        Fault{"[10,", "[-10,", 2, "theta_i_deg", "0 to 90 deg"},
        Fault{"10, 30", "30, 30", 2, "theta_i_deg", "twice"},
        Fault{"[10, 30, 45, 60]", "[]", 2, "theta_i_deg", "empty"},
        Fault{"[10, 30, 45, 60]", "[10, nan]", 2, "theta_i_deg", "outside"},
        Fault{"[10, 30, 45, 60]", "[10, \"x\"]", 2, "theta_i_deg", "not a number"},
        Fault{"to = 80", "to = 95", 3, "theta_r_deg.to", "-90 to 90"},
        Fault{"to = 80", "to = -85", 3, "theta_r_deg.to", "empty"},
        Fault{"step = 4", "step = 0", 3, "theta_r_deg.step", "above 0"},
        Fault{"step = 4", "step = 1e-7", 3, "theta_r_deg.step", "100000"},
        Fault{"[532, 633]", "[]", 1, "wavelengths_nm", "empty"},
        Fault{"[532, 633]", "[0.532]", 1, "wavelengths_nm", "100 to 20000 nm"},
        Fault{"\"P\", \"S\"]", "\"P\", \"R\"]", 4, "states", "no polarisation"},
        Fault{"[\"P\", \"S\"]", "\"PS\"", 4, "states", "pair"},
        Fault{"50\n", "0\n", 5, "dwell_ms", "1 to 60000 ms"},
        Fault{"50\n", "50.5\n", 5, "dwell_ms", "whole number"},
        Fault{"50\n", "\"long\"\n", 5, "dwell_ms", "not a number"},
        Fault{"dwell_ms = 50", "gain = 5", 5, "gain", "1, 10, 100, 1000"},
        Fault{"dwell_ms = 50", "role = \"tile\"", 5, "role", "sample, white, mirror, dark"},
        Fault{"dwell_ms = 50", "order = \"oneway\"", 5, "order", "did you mean \"one-way\"?"},
        Fault{"dwell_ms = 50", "phi_r_deg = [-180]", 5, "phi_r_deg", "above -180"},
        Fault{"dwell_ms = 50", "optical_density = 6", 5, "optical_density", "0 to 5"},
        Fault{"dwell_ms = 50", "reference_dhr = { red = 0.9 }", 5, "reference_dhr",
              "no wavelength"},
        Fault{"dwell_ms = 50", "sample = \"a\\nb\"", 5, "sample", "one line"},
        Fault{"dwell_ms = 50", "[[block]]\nmenu = \"flip\"\nwavelengths_nm = [814]", 7,
              "block[0].wavelengths_nm", "none of the plan's"}));

TEST(Plan, ListsOverManyLinesAndBracketsInTextsAreNoTableHeaders) {
  const Plan plan = parse_plan(
      "sample = \"\\\"[=] é\"  # [=]\nreference = '''x[=]'''\n"
      "wavelengths_nm = [\n 532, # [\n 633 ]\ntheta_i_deg = 30\n"
      "theta_r_deg = {from = 0, to = 5, step = 1}\n"
      "states = [\n [+45, -45],\n[ +0, \"open\" ]\n]\n",
      "p");
  EXPECT_EQ(plan.sample, "\"[=] é");
  EXPECT_EQ(plan.grid.states.size(), 2u);
}

TEST(Plan, PlansOfTooManyRowsAreRefusedBeforeTheyAreMade) {
  const Error error = error_of(
      "wavelengths_nm = [532, 633, 814]\n"
      "theta_i_deg = { from = 0, to = 89, step = 0.1 }\n"
      "theta_r_deg = { from = -80, to = 80, step = 0.1 }\n");
  EXPECT_THAT(error.what(), HasSubstr("5000000 rows"));
  EXPECT_THAT(
      error_of("wavelengths_nm = [532]\ntheta_i_deg = 3\ntheta_r_deg = [-5]\nphi_r_deg = 90\n")
          .what(),
      HasSubstr("no rows"));
}

TEST(Plan, EveryPlanOfTheExampleCampaignCanBeRun) {
  std::map<std::string, int> roles;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(UMOV_SOURCE_DIR) + "/examples/campaign")) {
    if (entry.path().extension() != ".toml" || entry.path().filename() == "campaign.toml") continue;
    const Plan plan = load_plan(entry.path());
    EXPECT_EQ(expand(plan).rows.size(), row_count(plan)) << entry.path();
    EXPECT_EQ(plan.grid.wavelengths_nm, (std::vector<double>{532, 633, 814})) << entry.path();
    ++roles[plan.role];
  }
  EXPECT_EQ(roles["white"], 3);
  EXPECT_EQ(roles["mirror"], 1);
  EXPECT_GE(roles["sample"], 2);
}

TEST(Plan, EveryExampleCanBeRun) {
  std::map<std::string, std::size_t> rows_of;
  for (const auto& entry :
       std::filesystem::directory_iterator(std::string(UMOV_SOURCE_DIR) + "/examples/plans")) {
    if (entry.path().extension() != ".toml") continue;
    const Plan plan = load_plan(entry.path());
    const Program program = expand(plan);
    EXPECT_EQ(program.rows.size(), row_count(plan)) << entry.path();
    for (const PlanRow& row : program.rows) {
      ASSERT_TRUE(row.wavelength_nm == 532 || row.wavelength_nm == 633 || row.wavelength_nm == 814);
      ASSERT_LE(std::abs(row.theta_r_deg), 90);
      ASSERT_EQ(row.optical_density, std::floor(row.optical_density)) << "filters of whole density";
    }
    rows_of[entry.path().filename().string()] = program.rows.size();
  }
  EXPECT_EQ(rows_of.count("quick.toml"), 1u);
  EXPECT_LT(rows_of["quick.toml"], 500u);
  EXPECT_EQ(rows_of.count("red-gloss.toml"), 1u);
  EXPECT_EQ(rows_of.count("white.toml"), 1u);
  EXPECT_EQ(rows_of.count("full-menu.toml"), 1u);
  for (const auto& [name, rows] : rows_of) RecordProperty(name, static_cast<int>(rows));
}

}  // namespace
}  // namespace umov::scan
