// Cases and sets of them: composition, sizes, sealing, and that nothing gives the truth away.
#include <gtest/gtest.h>

#include <unistd.h>
#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>
#include <set>
#include <sstream>

#include "hil/blind/case_draw.hpp"
#include "hil/blind/case_set.hpp"
#include "host/errors/error.hpp"
#include "host/formats/scan_csv.hpp"

namespace umov::blind {
namespace {

namespace fs = std::filesystem;

/// A folder of its own that goes with the test.
class Scratch {
 public:
  explicit Scratch(const std::string& name)
      : path_(fs::temp_directory_path() / ("umov-blind-" + name + "-" + std::to_string(getpid()))) {
    fs::remove_all(path_);
    fs::create_directories(path_);
  }
  ~Scratch() { fs::remove_all(path_); }
  fs::path operator/(const char* name) const { return path_ / name; }

 private:
  fs::path path_;
};

std::string text_of(const fs::path& path) {
  std::ifstream file(path, std::ios::binary);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

/// Small scans, so that tests are quick.
CaseOptions quick() {
  CaseOptions options;
  options.only_style = Style::one_way;
  return options;
}

TEST(Composition, IsAsPromisedForEveryHundred) {
  for (const std::size_t count : {100u, 400u}) {
    std::map<CaseClass, int> found;
    for (const CaseClass c : case_classes(count, 3)) ++found[c];
    for (int i = 0; i < class_count; ++i) {
      EXPECT_EQ(found[static_cast<CaseClass>(i)],
                cases_in_a_hundred[static_cast<std::size_t>(i)] * static_cast<int>(count) / 100);
    }
  }
  EXPECT_EQ(case_classes(37, 3).size(), 37u);
  EXPECT_EQ(case_classes(1, 3).size(), 1u);
}

TEST(Composition, IsShuffledByTheSeed) {
  EXPECT_EQ(case_classes(100, 3), case_classes(100, 3));
  EXPECT_NE(case_classes(100, 3), case_classes(100, 4));
  const auto classes = case_classes(100, 3);
  EXPECT_FALSE(std::is_sorted(classes.begin(), classes.end()));
}

TEST(Case, HasAnEffectOfTheSizeThatWasAskedFor) {
  CaseOptions options = quick();
  options.rho_from = options.rho_to = 10.0;
  for (const char* name : {"backlash", "dust", "lockin_phase", "finite_aperture", "water_film"}) {
    options.only_effect = name;
    const CaseTruth truth = make_case(11, 1, CaseClass::single, options);
    ASSERT_EQ(truth.effects.size(), 1u);
    EXPECT_EQ(truth.effects[0].name, name);
    EXPECT_NEAR(truth.effects[0].rho, 10.0, 0.25);
    EXPECT_NEAR(truth.rho, truth.effects[0].rho, 1e-9);
    const EffectKind& kind = effect_kind(name);
    EXPECT_GE(std::abs(truth.effects[0].size()), 0.999 * kind.smallest);
    EXPECT_LE(std::abs(truth.effects[0].size()), 1.001 * kind.largest);
  }
}

TEST(Case, SizesAreUniformInTheLogarithm) {
  // Kolmogorov and Smirnov's distance of ρ from the promised law, over single cases.
  CaseOptions options = quick();
  options.only_effect = "detector_polarization_bias";
  std::vector<double> place;
  constexpr int cases = 16;
  for (int i = 1; i <= cases; ++i) {
    const CaseTruth truth = make_case(5, static_cast<std::size_t>(i), CaseClass::single, options);
    place.push_back(std::log(truth.rho / 3.0) / std::log(50.0 / 3.0));
  }
  std::sort(place.begin(), place.end());
  double distance = 0.0;
  for (int i = 0; i < cases; ++i) {
    distance = std::max(distance, std::abs(place[static_cast<std::size_t>(i)] - (i + 0.5) / cases));
  }
  EXPECT_LT(distance, 1.95 / std::sqrt(cases));  // one in a thousand
}

TEST(Case, HasAsManyEffectsAsItsClassSays) {
  EXPECT_TRUE(make_case(2, 1, CaseClass::none, quick()).effects.empty());
  const CaseTruth two = make_case(2, 2, CaseClass::two, quick());
  ASSERT_EQ(two.effects.size(), 2u);
  EXPECT_NE(two.effects[0].name, two.effects[1].name);
  EXPECT_GE(two.effects[0].rho, two.effects[1].rho);
  EXPECT_LE(two.effects[0].rho_given_others, 1.001 * two.effects[0].rho);
  EXPECT_EQ(make_case(2, 3, CaseClass::triple, quick()).effects.size(), 3u);
  const CaseTruth foreign = make_case(2, 4, CaseClass::foreign, quick());
  ASSERT_EQ(foreign.effects.size(), 1u);
  EXPECT_FALSE(foreign.effects[0].in_catalogue);
}

TEST(Case, CrowdedHasOneEffectThatLeadsAllSmallOnes) {
  const CaseTruth crowd = make_case(2, 5, CaseClass::crowded, quick());
  EXPECT_GT(crowd.effects.size(), 25u);
  EXPECT_TRUE(crowd.effects[0].enlarged);
  EXPECT_EQ(std::count_if(crowd.effects.begin(), crowd.effects.end(),
                          [](const Effect& e) { return e.enlarged; }),
            1);
  EXPECT_GT(crowd.effects[0].rho, 1.4 * crowd.effects[1].rho);
}

TEST(Case, ConfoundedHasALookAlikeInItsOwnScan) {
  CaseOptions options = quick();
  options.only_effect = "detector_zero";
  const CaseTruth truth = make_case(2, 6, CaseClass::confounded, options);
  ASSERT_FALSE(truth.look_alikes.empty());
  EXPECT_LT(truth.look_alikes[0].rho_left, 3.0);
  const bool backlash = std::any_of(truth.look_alikes.begin(), truth.look_alikes.end(),
                                    [](const LookAlike& l) { return l.effect == "backlash"; });
  EXPECT_TRUE(backlash);
}

TEST(Case, PlanMaterialAndInstrumentDoNotDependOnItsClass) {
  const CaseTruth a = make_case(9, 3, CaseClass::none);
  const CaseTruth b = make_case(9, 3, CaseClass::single);
  EXPECT_EQ(a.material.toml(), b.material.toml());
  EXPECT_EQ(a.records, b.records);
  EXPECT_EQ(a.stated_gain_v, b.stated_gain_v);
  EXPECT_EQ(a.relative_noise, b.relative_noise);
  const auto scan_a = own_scan(a);
  const auto scan_b = own_scan(b);
  EXPECT_EQ(scan_a.keys, scan_b.keys);
  EXPECT_EQ(scan_a.time_s, scan_b.time_s);
}

TEST(Case, FurtherScansGoOnInTimeAndComeBackTheSame) {
  const CaseTruth truth = make_case(4, 1, CaseClass::single, quick());
  const auto own = own_scan(truth);
  const auto flip = further_scan(truth, {menu_block(truth.plan, "flip")});
  EXPECT_GT(flip.time_s.front(), own.time_s.back());
  EXPECT_EQ(formats::scan_csv_text(flip),
            formats::scan_csv_text(further_scan(truth, {menu_block(truth.plan, "flip")})));
  EXPECT_EQ(flip.blocks[0].name, "flip");
  const auto tile = further_scan(truth, {menu_block(truth.plan, "white_tile")});
  EXPECT_EQ(tile.key("role"), "white");
  EXPECT_THROW(
      further_scan(truth, {menu_block(truth.plan, "white_tile"), menu_block(truth.plan, "flip")}),
      Error);
}

TEST(TruthFile, GivesTheSameScansWhenReadBack) {
  TruthFile truth;
  truth.seed = 6;
  truth.cases.push_back(make_case(6, 1, CaseClass::triple, quick()));
  truth.cases.push_back(make_case(6, 2, CaseClass::foreign, quick()));
  const std::string text = truth_text(truth);
  const TruthFile again = parse_truth(text, "truth.json");
  EXPECT_EQ(truth_text(again), text);
  for (const CaseTruth& one : truth.cases) {
    EXPECT_EQ(formats::scan_csv_text(own_scan(again.find(one.name))),
              formats::scan_csv_text(own_scan(one)));
  }
  EXPECT_THROW(again.find("case_0007"), Error);
  EXPECT_THROW(parse_truth("{}", "x"), Error);
  EXPECT_THROW(parse_truth("no json", "x"), Error);
}

TEST(CaseSet, IsTheSameForAnyNumberOfThreadsAndFitsItsSeal) {
  const Scratch scratch("threads");
  MakeOptions options;
  options.cases = 3;
  options.seed = 21;
  options.draws = quick();
  options.threads = 1;
  ASSERT_TRUE(make_case_set(scratch / "a", scratch / "ta", options));
  options.threads = 3;
  ASSERT_TRUE(make_case_set(scratch / "b", scratch / "tb", options));
  for (const char* file :
       {"README.md", "SEAL", "case_0001/scan.csv", "case_0002/scan.csv", "case_0003/scan.csv"}) {
    EXPECT_EQ(text_of((scratch / "a") / file), text_of((scratch / "b") / file)) << file;
    EXPECT_FALSE(text_of((scratch / "a") / file).empty()) << file;
  }
  EXPECT_TRUE(seal_fits(scratch / "a", scratch / "tb"));
  EXPECT_EQ(read_seal(scratch / "a").cases, 3u);
  std::ofstream(scratch / "tb" / truth_name, std::ios::app) << " ";
  EXPECT_FALSE(seal_fits(scratch / "a", scratch / "tb"));
}

TEST(CaseSet, HoldsNoWordOfTheTruth) {
  const Scratch scratch("words");
  MakeOptions options;
  options.cases = 5;
  options.seed = 2;
  options.draws = quick();
  ASSERT_TRUE(make_case_set(scratch / "cases", scratch / "truth", options));
  std::set<std::string> words = {"single",  "triple", "foreign", "confounded",
                                 "crowded", "rho",    "seed"};
  for (const EffectKind& kind : effect_kinds()) words.insert(kind.name);
  for (const std::string& family : material_families()) words.insert(family);
  int files = 0;
  for (const auto& entry : fs::recursive_directory_iterator(scratch / "cases")) {
    if (!entry.is_regular_file()) continue;
    ++files;
    const std::string text = text_of(entry.path());
    const std::string heading =
        entry.path().extension() == ".csv" ? text.substr(0, text.find("index,time_s")) : text;
    for (const std::string& word : words) {
      EXPECT_EQ(heading.find(word), std::string::npos) << entry.path() << " says " << word;
    }
  }
  EXPECT_EQ(files, 5 + 2);
  // Every heading has the same keys, whatever the case.
  std::set<std::string> keys;
  for (int i = 1; i <= 5; ++i) {
    const auto table =
        formats::read_scan_csv((scratch / "cases") / ("case_000" + std::to_string(i)) / "scan.csv");
    std::string names;
    for (const auto& [key, value] : table.keys) names += key + " ";
    keys.insert(names);
  }
  EXPECT_EQ(keys.size(), 1u);
}

TEST(CaseSet, DoesNotOverwriteNorSealBesideTheScans) {
  const Scratch scratch("places");
  MakeOptions options;
  options.cases = 1;
  options.draws = quick();
  options.draws.only_class = CaseClass::none;
  EXPECT_THROW(make_case_set(scratch / "cases", scratch / "cases" / "truth", options), Error);
  ASSERT_TRUE(make_case_set(scratch / "cases", scratch / "truth", options));
  EXPECT_THROW(make_case_set(scratch / "cases", scratch / "other", options), Error);
  EXPECT_THROW(make_case_set(scratch / "more", scratch / "truth", options), Error);
  options.keep_going = [] { return false; };
  EXPECT_FALSE(make_case_set(scratch / "stopped", scratch / "t2", options));
  EXPECT_THROW(read_seal(scratch / "stopped"), Error);
}

}  // namespace
}  // namespace umov::blind
