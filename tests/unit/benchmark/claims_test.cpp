#include "host/gap/benchmark/claims.hpp"

#include <gtest/gtest.h>

#include "host/errors/error.hpp"
#include "tests/unit/benchmark/hand_made.hpp"

namespace umov::gap::benchmark {
namespace {

TEST(Claims, a_cause_is_claimed_from_one_half_on) {
  EXPECT_EQ(claims_of(answer("explained", {{"dust", 0.5}})).size(), 1u);
  EXPECT_EQ(claims_of(answer("explained", {{"dust", 0.49}})).size(), 0u);
}

TEST(Claims, rivals_of_one_set_are_claimed_together) {
  // Two of a third each, listed or not: one claim, up to the set.
  const auto claims = claims_of(
      answer("explained", {{"dust", 0.4}, {"stray_forward", 0.35}}, {{"dust", "stray_forward"}}));
  ASSERT_EQ(claims.size(), 1u);
  EXPECT_EQ(claims[0].lead, "dust");
  EXPECT_TRUE(claims[0].members.contains("stray_forward"));
  EXPECT_DOUBLE_EQ(claims[0].share, 1.5);

  Answer quiet = answer("explained", {{"dust", 0.4}}, {{"dust", "stray_forward"}});
  EXPECT_EQ(claims_of(quiet).size(), 0u);
  quiet.probabilities["stray_forward"] = 0.4;
  EXPECT_EQ(claims_of(quiet).size(), 1u);
}

TEST(Claims, two_sure_causes_that_share_a_rival_stay_two) {
  const auto claims = claims_of(answer("explained", {{"dust", 0.9}, {"backlash", 0.95}},
                                       {{"dust", "stray_forward"}, {"backlash", "stray_forward"}}));
  EXPECT_EQ(claims.size(), 2u);
  EXPECT_EQ(claims[0].members.size(), 3u);
}

TEST(Claims, a_set_never_claims_more_than_it_lists) {
  Answer a = answer("explained", {{"dust", 0.9}}, {{"dust", "stray_forward"}});
  a.probabilities["stray_forward"] = 0.9;
  EXPECT_EQ(claims_of(a).size(), 1u);
}

TEST(Claims, a_richer_reflectance_comes_last_whatever_its_share) {
  const auto claims = claims_of(answer("explained", {{"sample_model", 1.0}, {"dust", 0.9}}));
  ASSERT_EQ(claims.size(), 2u);
  EXPECT_EQ(claims[0].lead, "dust");
  EXPECT_TRUE(claims[1].is_model());
}

TEST(Claims, each_claim_serves_one_effect_only) {
  const auto one = claims_of(answer("explained", {{"dust", 0.9}}, {{"dust", "stray_forward"}}));
  EXPECT_EQ(matched({"dust", "stray_forward"}, one), 1u);
  // The claim of dust must leave its set's other member to dust's own claim.
  std::vector<Claim> open;
  const auto two = claims_of(answer(
      "explained", {{"dust", 0.9}, {"backlash", 0.9}, {"speckle", 0.9}}, {{"dust", "backlash"}}));
  EXPECT_EQ(matched({"backlash", "dust"}, two, &open), 2u);
  ASSERT_EQ(open.size(), 1u);
  EXPECT_EQ(open[0].lead, "speckle");
}

TEST(Claims, an_answer_is_read_from_the_json_of_any_program) {
  const Answer a = parse_answer(R"({"verdict": "explained_in_part",
    "gap": {"before": {"g2": 4}, "after": {"g2": 1}, "floor": {"g2": 0}},
    "causes": [{"effect": "backlash", "probability": 0.9, "share": 0.7,
                "parameters": {"gap_deg": {"value": 0.03, "lo": 0.02, "hi": 0.04}}}],
    "ambiguity_sets": [["backlash", "detector_zero"]]})",
                                "x");
  EXPECT_TRUE(a.flags_unknown());
  ASSERT_NE(a.cause("backlash"), nullptr);
  EXPECT_DOUBLE_EQ(a.cause("backlash")->parameters.at("gap_deg").hi, 0.04);
  EXPECT_TRUE(a.has_gap);
  EXPECT_DOUBLE_EQ(a.g2_after, 1);
  EXPECT_THROW(parse_answer(R"({"causes": []})", "x"), Error);
  EXPECT_THROW(parse_answer("no", "x"), Error);
}

TEST(Truth, is_read_with_the_principal_parameter_first) {
  const auto cases = parse_truth(R"({"cases": [{"case": "case_0007", "class": "single",
    "effects": [{"effect": "finite_aperture", "in_catalogue": true, "enlarged": false,
                 "parameters": {"z_first": 1, "a_second": 2}, "rho": 8, "rho_given_others": 7}],
    "rho": 8, "look_alikes": [{"effect": "dust", "rho_left": 1}],
    "material": {"family": "ggx", "one_gaussian_lobe": false},
    "rho_beyond_one_gaussian_lobe": 40, "plan": {"style": "pm45"}}]})",
                                 "x");
  ASSERT_EQ(cases.size(), 1u);
  EXPECT_EQ(cases[0].effects[0].parameters[0].first, "z_first");
  EXPECT_EQ(cases[0].look_alikes, std::vector<std::string>{"dust"});
  EXPECT_FALSE(cases[0].one_gaussian_lobe);
  EXPECT_THROW(parse_truth("{}", "x"), Error);
}

}  // namespace
}  // namespace umov::gap::benchmark
