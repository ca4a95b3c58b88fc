// Why a case is missed: what withheld rows and the oracle say of it.
#include <gtest/gtest.h>

#include "host/gap/benchmark/misses.hpp"
#include "host/gap/benchmark/score_page.hpp"
#include "tests/unit/benchmark/hand_made.hpp"

namespace umov::gap::benchmark {
namespace {

/// A leaking polariser whose oracle leaves G² = .01 of a thousand records.
Entry leaking(const Answer& first, double g2_after) {
  Entry e = entry(truth("single", {{"polarizer_leakage", 12}}), first);
  e.first.has_gap = true;
  e.first.g2_after = g2_after;
  e.first.records_used = 1000;
  e.oracle = answer("explained", {{"polarizer_leakage", 1.0}});
  e.oracle->has_gap = true;
  e.oracle->g2_after = 0.01;
  return e;
}

std::optional<MissReason> reason(const Entry& e) {
  return miss_reason(e, e.first);
}

const Answer turned = answer("explained", {{"polarizer_rotation", .9}});

TEST(MissReason, what_fits_withheld_rows_as_well_as_the_truth_mimics_it) {
  EXPECT_EQ(reason(leaking(turned, 0.0115)), MissReason::mimicry);
  EXPECT_EQ(reason(leaking(turned, 0.005)), MissReason::mimicry);
}

TEST(MissReason, a_truth_that_fits_them_better_was_not_found) {
  const Entry e = leaking(turned, 0.02);
  EXPECT_EQ(reason(e), MissReason::search);
  EXPECT_NEAR(*withheld_excess(e), 20, 1e-9);
  EXPECT_EQ(misses({e}).front().why, "search 20");
  EXPECT_EQ(reason(leaking(turned, 0.014)), MissReason::faint) << "as noise might have it";
}

TEST(MissReason, what_the_oracle_does_not_name_cannot_be_seen) {
  Entry e = leaking(answer("none_needed"), 0.02);
  e.oracle->causes.clear();
  EXPECT_EQ(reason(e), MissReason::unseen);
}

TEST(MissReason, a_flag_beside_the_right_name_is_a_rest_and_a_second_name_more) {
  EXPECT_EQ(reason(leaking(answer("explained_in_part", {{"polarizer_leakage", .9}}), 0.01)),
            MissReason::rest);
  EXPECT_EQ(reason(leaking(answer("explained", {{"polarizer_leakage", .9}, {"dust", .9}}), 0.01)),
            MissReason::more);
}

TEST(MissReason, what_is_named_in_the_second_place_is_behind) {
  Entry e = leaking(answer("explained", {{"sample_model", .9}, {"polarizer_leakage", .9}},
                           {{"sample_model", "polarizer_leakage"}}),
                    0.01);
  e.truth.one_gaussian_lobe = false;
  EXPECT_EQ(reason(e), MissReason::behind);
}

TEST(MissReason, one_claim_does_not_serve_two_effects) {
  Entry e = leaking(answer("explained", {{"dust", .6}}, {{"dust", "backlash"}}), 0.02);
  e.truth = truth("double", {{"dust", 20}, {"backlash", 12}});
  EXPECT_EQ(reason(e), MissReason::search);
}

TEST(MissReason, nothing_is_said_of_crowds_and_of_answers_that_do_not_say_how_many_records) {
  Entry crowd = leaking(turned, 0.02);
  crowd.truth.kind = "crowded";
  EXPECT_FALSE(reason(crowd));
  Entry silent = leaking(turned, 0.02);
  silent.first.records_used = 0;
  EXPECT_FALSE(reason(silent));
}

TEST(MissReason, cases_without_a_known_effect_have_reasons_of_their_own) {
  Entry none = entry(truth("none", {}), answer("unexplained"));
  EXPECT_EQ(reason(none), MissReason::chance);
  none.truth.one_gaussian_lobe = false;
  EXPECT_EQ(reason(none), MissReason::material);
  const TrueCase ghost = truth("foreign", {{"ghost", 12}});
  EXPECT_EQ(reason(entry(ghost, turned)), MissReason::mimicry);
  EXPECT_EQ(reason(entry(ghost, answer("none_needed"))), MissReason::unseen);
}

TEST(MissReason, without_an_oracle_nothing_is_said) {
  Entry e = leaking(turned, 0.02);
  e.oracle.reset();
  EXPECT_FALSE(reason(e));
  EXPECT_EQ(misses({e}).front().why, "");
}

TEST(MissReason, the_page_counts_reasons_by_measure) {
  const std::string page = score_markdown({leaking(turned, 0.02), leaking(turned, 0.01)}, {});
  EXPECT_NE(page.find("| top1_set | 1 | 0 | 1 | 0 | 0 | 0 | 0 | 0 | 0 |"), std::string::npos)
      << page;
}

}  // namespace
}  // namespace umov::gap::benchmark
