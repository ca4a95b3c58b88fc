// Every measure on cases where it is right and where it goes wrong.
#include <cmath>

#include <gtest/gtest.h>

#include "host/gap/benchmark/breakdown.hpp"
#include "host/gap/benchmark/misses.hpp"
#include "host/gap/benchmark/score_page.hpp"
#include "tests/unit/benchmark/hand_made.hpp"

namespace umov::gap::benchmark {
namespace {

TEST(Score, top_1_is_right_up_to_the_set_or_plainly) {
  const TrueCase dusty = truth("single", {{"dust", 12}});
  const std::vector<Entry> entries = {
      entry(dusty, answer("explained", {{"dust", 0.9}})),
      entry(dusty, answer("explained", {{"stray_forward", 0.6}}, {{"dust", "stray_forward"}})),
      entry(dusty, answer("explained", {{"backlash", 0.9}})),
      entry(dusty, answer("none_needed")),
      // Too small for this measure, and out of the plane.
      entry(truth("single", {{"dust", 9}}), answer("none_needed")),
  };
  EXPECT_EQ(measure(entries, "top1_set").n, 4u);
  EXPECT_EQ(measure(entries, "top1_set").hits, 2u);
  EXPECT_EQ(measure(entries, "top1_plain").hits, 1u);
  EXPECT_FALSE(measure(entries, "top1_set").met());

  std::vector<Entry> full = entries;
  full[3].truth.style = "full";
  EXPECT_EQ(measure(full, "top1_set").n, 3u);
}

TEST(Score, the_largest_share_leads) {
  const TrueCase dusty = truth("single", {{"dust", 12}});
  const auto second = entry(dusty, answer("explained", {{"backlash", 0.9}, {"dust", 0.9}}));
  EXPECT_EQ(measure({second}, "top1_set").hits, 0u);
  EXPECT_EQ(measure({second}, "detection").hits, 1u);
}

TEST(Score, prescribed_scans_can_mend_an_answer_and_spoil_it) {
  Entry mended = entry(truth("single", {{"dust", 12}}), answer("none_needed"));
  mended.last = answer("explained", {{"dust", 0.9}});
  Entry spoilt = entry(truth("single", {{"dust", 12}}), answer("explained", {{"dust", 0.9}}));
  spoilt.last = answer("explained", {{"backlash", 0.9}});
  EXPECT_EQ(measure({mended}, "top1_set").hits, 0u);
  EXPECT_EQ(measure({mended}, "top1_followed").hits, 1u);
  EXPECT_EQ(measure({spoilt}, "top1_followed").hits, 0u);
}

TEST(Score, an_effect_is_detected_by_a_name_or_by_a_flag) {
  const TrueCase dusty = truth("single", {{"dust", 8}});
  EXPECT_EQ(measure({entry(dusty, answer("explained", {{"backlash", 0.9}}))}, "detection").hits,
            1u);
  EXPECT_EQ(measure({entry(dusty, answer("unexplained"))}, "detection").hits, 1u);
  EXPECT_EQ(measure({entry(dusty, answer("none_needed"))}, "detection").hits, 0u);
  // A richer reflectance on a material that needs one is no sign of the effect.
  TrueCase rough = dusty;
  rough.one_gaussian_lobe = false;
  const Answer richer = answer("explained", {{"sample_model", 0.9}});
  EXPECT_EQ(measure({entry(rough, richer)}, "detection").hits, 0u);
  EXPECT_EQ(measure({entry(rough, answer("failed"))}, "detection").hits, 0u);
}

TEST(Score, false_alarms_are_names_and_flags_but_not_a_reflectance_that_is_richer) {
  const TrueCase none = truth("none", {});
  TrueCase other = none;
  other.one_gaussian_lobe = false;
  const Answer richer = answer("explained", {{"sample_model", 0.9}});
  const std::vector<Entry> entries = {
      entry(none, answer("none_needed")),
      entry(none, answer("explained", {{"dust", 0.9}})),
      entry(none, answer("unexplained")),
      entry(none, richer),
      entry(other, richer),
  };
  EXPECT_EQ(measure(entries, "false_alarms").hits, 3u);
  EXPECT_EQ(measure(entries, "not_none_needed").hits, 4u);
  EXPECT_EQ(measure(entries, "false_names").hits, 2u);
  EXPECT_EQ(measure(entries, "false_alarms_other").n, 1u);
  EXPECT_EQ(measure(entries, "false_alarms_other").hits, 0u);
  // In one set with the model, an effect is no confident guess.
  const auto both = entry(other, answer("explained", {{"dust", 0.6}}, {{"dust", "sample_model"}}));
  EXPECT_EQ(measure({both}, "false_alarms").hits, 0u);
}

TEST(Score, a_pair_is_exact_when_both_and_nothing_else_are_claimed) {
  const TrueCase pair = truth("double", {{"dust", 20}, {"backlash", 11}});
  const auto hits = [&](const Answer& a) { return *measure({entry(pair, a)}, "exact_pair").hits; };
  EXPECT_EQ(hits(answer("explained", {{"backlash", 0.9}, {"dust", 0.9}})), 1u);
  EXPECT_EQ(hits(answer("explained", {{"dust", 0.9}})), 0u);
  EXPECT_EQ(hits(answer("explained", {{"dust", 0.9}, {"backlash", 0.9}, {"speckle", 0.9}})), 0u);
  EXPECT_EQ(hits(answer("explained", {{"dust", 0.9}, {"detector_zero", 0.6}},
                        {{"backlash", "detector_zero"}})),
            1u);
  // One of them is too small to be asked for.
  const TrueCase faint = truth("double", {{"dust", 20}, {"backlash", 9}});
  EXPECT_EQ(measure({entry(faint, answer("none_needed"))}, "exact_pair").n, 0u);
}

TEST(Score, triples_count_what_is_right_missing_and_too_much) {
  const TrueCase three = truth("triple", {{"dust", 20}, {"backlash", 11}, {"speckle", 8}});
  // Two right, one missing, one wrong: F1 = 4 / (4 + 1 + 1).
  const auto some =
      entry(three, answer("explained", {{"dust", .9}, {"backlash", .9}, {"lockin_phase", .9}}));
  EXPECT_NEAR(measure({some}, "triples_f1").value.value, 4.0 / 6, 1e-12);
  EXPECT_NEAR(measure({entry(three, answer("none_needed"))}, "triples_f1").value.value, 0, 1e-12);
  const auto all =
      entry(three, answer("explained", {{"dust", .9}, {"backlash", .9}, {"speckle", .9}}));
  // Micro: of both cases together 5 right, 1 missing, 1 wrong.
  EXPECT_NEAR(measure({some, all}, "triples_f1").value.value, 10.0 / 12, 1e-12);
  EXPECT_EQ(measure({some, all}, "exact_triple").hits, 1u);
  // Two cases may agree by chance.
  EXPECT_FALSE(measure({some, some}, "triples_f1").surely());
  EXPECT_TRUE(measure(std::vector<Entry>(10, some), "triples_f1").surely());
}

TEST(Score, unknown_effects_are_flagged_unless_something_imitates_them) {
  TrueCase odd = truth("foreign", {{"ghost", 12}});
  EXPECT_EQ(measure({entry(odd, answer("unexplained"))}, "unknown_flagged").hits, 1u);
  EXPECT_EQ(
      measure({entry(odd, answer("explained_in_part", {{"dust", .9}}))}, "unknown_flagged").hits,
      1u);
  const auto taken = entry(odd, answer("explained", {{"dust", 0.9}}));
  EXPECT_EQ(measure({taken}, "unknown_flagged").hits, 0u);
  EXPECT_EQ(measure({taken}, "unknown_named").hits, 1u);
  odd.look_alikes = {"dust"};
  EXPECT_EQ(measure({entry(odd, answer("explained", {{"dust", 0.9}}))}, "unknown_flagged").n, 0u);

  const TrueCase known = truth("single", {{"dust", 12}});
  EXPECT_EQ(measure({entry(known, answer("unexplained"))}, "known_flagged").hits, 1u);
  EXPECT_EQ(measure({entry(known, answer("explained", {{"dust", .9}}))}, "known_flagged").hits, 0u);
  EXPECT_EQ(
      measure({entry(known, answer("explained_in_part", {{"dust", .9}}))}, "known_unexplained")
          .hits,
      0u);
}

TEST(Score, sets_are_judged_where_something_is_named) {
  const TrueCase dusty = truth("single", {{"dust", 12}});
  const std::vector<Entry> entries = {
      entry(dusty, answer("explained", {{"backlash", .6}}, {{"backlash", "dust", "speckle"}})),
      entry(dusty, answer("explained", {{"backlash", .9}})),
      entry(dusty, answer("unexplained")),
  };
  EXPECT_EQ(measure(entries, "set_coverage").n, 2u);
  EXPECT_EQ(measure(entries, "set_coverage").hits, 1u);
  EXPECT_NEAR(measure(entries, "set_size").value.value, 2.0, 1e-12);
  EXPECT_FALSE(measure(entries, "set_size").met());
}

TEST(Score, a_coverage_above_its_band_misses_it_too) {
  Measure m = measure({entry(truth("single", {{"dust", 12}}), answer("explained", {{"dust", .9}}))},
                      "set_coverage");
  EXPECT_DOUBLE_EQ(m.value.value, 1.0);
  EXPECT_FALSE(m.met());
  EXPECT_FALSE(m.surely());
}

TEST(Score, probabilities_that_boast_are_miscalibrated) {
  const TrueCase dusty = truth("single", {{"dust", 12}});
  std::vector<Entry> boasting, honest;
  for (int i = 0; i < 200; ++i) {
    const char* name = i % 10 < 6 ? "dust" : "backlash";
    boasting.push_back(entry(dusty, answer("explained", {{name, 0.99}})));
    honest.push_back(entry(dusty, answer("explained", {{name, 0.6}})));
  }
  EXPECT_NEAR(measure(boasting, "ece").value.value, 0.39, 0.01);
  EXPECT_NEAR(measure(honest, "ece").value.value, 0.0, 1e-12);
  EXPECT_EQ(measure(honest, "ece").n, 200u);
}

TEST(Score, the_gap_is_compared_with_what_the_oracle_closes) {
  const auto with_gap = [](double after, double oracle_after) {
    Entry e = entry(truth("single", {{"dust", 12}}), answer("explained", {{"dust", .9}}));
    e.first.has_gap = true;
    e.first.g2_before = 5;
    e.first.g2_after = after;
    e.oracle = e.first;
    e.oracle->g2_after = oracle_after;
    return e;
  };
  EXPECT_NEAR(measure({with_gap(1, 1)}, "closed_median").value.value, 1.0, 1e-12);
  EXPECT_NEAR(measure({with_gap(3, 1)}, "closed_median").value.value, 0.5, 1e-12);
  EXPECT_NEAR(measure({with_gap(1, 1), with_gap(5, 1)}, "closed_decile").value.value, 0.1, 1e-12);
  // An oracle that closes nothing sets no mark.
  EXPECT_EQ(measure({with_gap(3, 5)}, "closed_median").n, 0u);
  EXPECT_NEAR(measure({with_gap(3, 1)}, "closed_median", Candidate::oracle).value.value, 1, 1e-12);
}

TEST(Score, intervals_are_judged_for_effects_that_are_there) {
  TrueCase dusty = truth("single", {{"dust", 12}});
  const Answer named = answer("explained", {{"dust", .9}, {"backlash", .9}});
  EXPECT_EQ(measure({entry(dusty, named)}, "interval_coverage").n, 1u);
  EXPECT_EQ(measure({entry(dusty, named)}, "interval_coverage").hits, 1u);
  dusty.effects[0].parameters[0].second = 1.2;
  EXPECT_EQ(measure({entry(dusty, named)}, "interval_coverage").hits, 0u);
  dusty.effects[0].parameters.emplace_back("other", 1);
  EXPECT_EQ(measure({entry(dusty, named)}, "interval_coverage_all").n, 1u);
}

TEST(Score, in_a_crowd_the_enlarged_effect_must_lead) {
  TrueCase crowd = truth("crowded", {{"dust", 300}, {"backlash", 40}});
  crowd.effects[0].enlarged = true;
  EXPECT_EQ(
      measure({entry(crowd, answer("explained", {{"dust", .9}, {"backlash", .9}}))}, "crowded")
          .hits,
      1u);
  const auto turned = entry(crowd, answer("explained", {{"backlash", .9}, {"dust", .9}}));
  EXPECT_EQ(measure({turned}, "crowded").hits, 0u);
  Entry alike = turned;
  alike.truth.look_alikes = {"backlash"};
  EXPECT_EQ(measure({alike}, "crowded").hits, 0u);
  EXPECT_EQ(measure({alike}, "crowded_alike").hits, 1u);
}

TEST(Score, the_others_are_judged_by_their_own_answers) {
  Entry e = entry(truth("single", {{"dust", 12}}), answer("explained", {{"dust", .9}}));
  e.largest_residual = answer("explained", {{"backlash", 1}});
  EXPECT_EQ(measure({e}, "top1_set", Candidate::largest_residual).hits, 0u);
  EXPECT_EQ(measure({e}, "top1_set", Candidate::forward_bic).n, 0u);
}

TEST(Score, permuted_labels_take_every_truth_elsewhere) {
  std::vector<Entry> entries;
  for (int i = 0; i < 20; ++i) {
    Entry e = entry(truth("single", {{"effect_" + std::to_string(i), 12}}),
                    answer("explained", {{"effect_" + std::to_string(i), .9}}));
    e.truth.name = "case_" + std::to_string(i);
    entries.push_back(e);
  }
  EXPECT_EQ(measure(entries, "top1_set").hits, 20u);
  EXPECT_EQ(measure(permuted(entries, 5), "top1_set").hits, 0u);
}

TEST(Score, misses_are_listed_with_truth_and_answer) {
  const auto list =
      misses({entry(truth("single", {{"dust", 12}}),
                    answer("explained", {{"backlash", .9}}, {{"backlash", "speckle"}})),
              entry(truth("none", {}), answer("none_needed"))});
  ASSERT_EQ(list.size(), 2u);
  EXPECT_EQ(list[0].measure, "top1_set");
  EXPECT_EQ(list[1].measure, "top1_followed");
  EXPECT_EQ(list[0].truth, "dust 12.0");
  EXPECT_EQ(list[0].answer, "explained: backlash 0.90 or speckle");
}

TEST(Breakdown, effects_plans_and_confusions_are_counted) {
  std::vector<Entry> entries = {
      entry(truth("single", {{"dust", 12}}), answer("explained", {{"dust", .9}})),
      entry(truth("single", {{"dust", 12}}),
            answer("explained", {{"backlash", .6}}, {{"backlash", "dust"}})),
      entry(truth("single", {{"dust", 8}}), answer("none_needed")),
      entry(truth("none", {}), answer("explained", {{"backlash", .9}})),
  };
  const auto effects = by_effect(entries);
  ASSERT_EQ(effects.size(), 2u);
  EXPECT_EQ(effects[0].effect, "backlash");
  EXPECT_EQ(effects[0].right.n, 2u);
  EXPECT_EQ(effects[0].right.hits, 1u);
  EXPECT_EQ(effects[1].plain.hits, 1u);
  EXPECT_EQ(effects[1].up_to_set.hits, 2u);
  EXPECT_EQ(effects[1].up_to_set.n, 3u);
  const auto pairs = confusions(entries);
  ASSERT_EQ(pairs.size(), 2u);
  EXPECT_EQ(pairs[0].named, "");
  EXPECT_EQ(pairs[1].named, "backlash");
  EXPECT_EQ(pairs[1].in_set, 1u);
  EXPECT_EQ(by_style(entries)[0].alarms.hits, 1u);
  EXPECT_EQ(by_material(entries)[0].top1.n, 2u);
}

TEST(Breakdown, an_effect_left_out_is_flagged_mimicked_absorbed_or_not_seen) {
  TrueCase dusty = truth("single", {{"dust", 12}});
  TrueCase rough = dusty;
  rough.one_gaussian_lobe = false;
  const auto rows = left_out({
      entry(dusty, answer("unexplained")),
      entry(dusty, answer("explained_in_part", {{"backlash", .9}})),
      entry(dusty, answer("explained", {{"stray_forward", .9}})),
      entry(rough, answer("explained", {{"sample_model", .9}})),
      entry(dusty, answer("none_needed")),
  });
  ASSERT_EQ(rows.size(), 1u);
  EXPECT_EQ(rows[0].n, 5u);
  EXPECT_EQ(rows[0].flagged, 2u);
  EXPECT_EQ(rows[0].mimicked, 1u);
  EXPECT_EQ(rows[0].mimics, std::vector<std::string>{"stray_forward"});
  EXPECT_EQ(rows[0].absorbed, 1u);
  EXPECT_EQ(rows[0].unseen, 1u);
}

TEST(ScorePage, says_where_floors_and_oracle_failed) {
  Entry lone = entry(truth("none", {}), answer("none_needed"));
  EXPECT_EQ(score_markdown({lone}, {}).find("failed, such as"), std::string::npos);
  lone.rivals_failed = "no memory";
  EXPECT_NE(score_markdown({lone}, {})
                .find("Of 1 cases floors and oracle failed, such as "
                      "case_0001: no memory."),
            std::string::npos);
}

TEST(ScorePage, says_what_was_met_what_was_missed_and_how_sure_that_is) {
  std::vector<Entry> entries;
  for (int i = 0; i < 100; ++i)
    entries.push_back(entry(truth("single", {{"dust", 12}}), answer("explained", {{"dust", .9}})));
  for (int i = 0; i < 10; ++i)
    entries.push_back(entry(truth("none", {}), answer("explained", {{"dust", .9}})));
  const std::string page = score_markdown(entries, {"ab12", 120, "", false, 1});
  EXPECT_NE(page.find("110 of 120 cases answered"), std::string::npos);
  EXPECT_NE(page.find("| **1.000** [0.964, 1.000] (100/100) | ≥ 0.95 | met, surely |"),
            std::string::npos);
  EXPECT_NE(page.find("| ≤ 0.01 | missed by 0.990, surely |"), std::string::npos);
  EXPECT_NE(page.find("| no cases |"), std::string::npos);
  const std::string json = score_json(entries, {"ab12", 120, "", false, 1});
  EXPECT_NE(json.find("\"top1_set\""), std::string::npos);
}

}  // namespace
}  // namespace umov::gap::benchmark
