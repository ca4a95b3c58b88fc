// Signatures of the catalogue's effects, and what is said of them.
#include <cmath>
#include <filesystem>
#include <string>

#include <gtest/gtest.h>

#include "host/cli/study/effect_look_alikes.hpp"
#include "host/cli/study/effect_signatures.hpp"
#include "host/cli/study/page.hpp"
#include "host/formats/scan_csv.hpp"

namespace umov::study {
namespace {

using gap::scan::ScanModel;

const ScanModel& model() {
  static const ScanModel shared({formats::read_scan_csv(std::filesystem::path(UMOV_TEST_DATA) /
                                                        "foreign_scans" / "scan_07_part.csv")});
  return shared;
}

TEST(Effects, every_effect_of_the_catalogue_says_what_it_looks_like) {
  for (const gap::Effect& effect : model().effects()) {
    const LookAlikes* known = look_alikes_of(effect.name);
    ASSERT_NE(known, nullptr) << effect.name;
    EXPECT_FALSE(known->others.empty()) << effect.name;
  }
  EXPECT_EQ(look_alikes_of("gremlins"), nullptr);
}

TEST(Effects, a_refit_of_the_base_leaves_what_it_cannot_follow) {
  const gap::Whitening whitening(model().noise(model().observations().value));
  const gap::Refit at = gap::refit(model(), gap::base_explanation(model()), whitening);
  const auto all = effect_signatures(model(), at, whitening, 1);
  ASSERT_EQ(all.size(), model().effects().size());
  const Eigen::MatrixXd base = at.jacobian(Eigen::all, at.free);
  for (const EffectSignature& s : all) {
    EXPECT_GT(s.alone.norm(), 0) << full_name(*s.effect);
    // The priors of the gains hold back a little of what the base could follow.
    EXPECT_LE(s.size, s.alone.norm() * (1 + 1e-9)) << full_name(*s.effect);
    for (Eigen::Index i = 0; i < base.cols(); ++i) {
      if (at.prior_precision[at.free[static_cast<std::size_t>(i)]] > 0) continue;
      EXPECT_LT(std::abs(base.col(i).dot(s.left)), 1e-5 * base.col(i).norm() * s.alone.norm())
          << full_name(*s.effect) << " and base parameter " << i;
    }
    for (const auto& other : s.alike) EXPECT_LE(other.cosine, 1 + 1e-9);
  }
}

TEST(Effects, pictures_of_a_page_may_have_names_of_their_own) {
  Page page("effects", "Effects", "");
  page.figure("backlash", "Play.", Json::array(), Json::object());
  EXPECT_NE(page.markdown().find("![backlash](backlash.svg)"), std::string::npos);
  Page usual("study", "A study");
  usual.figure("curve", "A curve.", Json::array(), Json::object());
  EXPECT_NE(usual.markdown().find("![curve](study-curve.svg)"), std::string::npos);
}

}  // namespace
}  // namespace umov::study
