// What a measurement allows one who knows all but the effect.
#include <gtest/gtest.h>

#include "host/gap/benchmark/ceiling.hpp"
#include "tests/unit/gap/bell.hpp"

namespace umov::gap {
namespace {

NamingRates rates_of(double rho, int threads = 1) {
  const Bell model(1);
  const Whitening whitening(model.noise(model.observations().value));
  const Refit base = refit(model, base_explanation(model), whitening);
  return NamingCeiling(model, base, whitening).rates(rho, 200, 5, threads);
}

TEST(NamingCeiling, EffectsThatLookNothingAlikeAreNamedWherePlain) {
  const NamingRates plain = rates_of(10);
  EXPECT_EQ(plain.drawn, 400);
  EXPECT_EQ(plain.named, plain.drawn);
  EXPECT_EQ(plain.in_set, plain.drawn);
  EXPECT_EQ(plain.set_size, plain.drawn);
}

TEST(NamingCeiling, WhatDrownsInNoiseIsAGuess) {
  const NamingRates faint = rates_of(0.1);
  // One of two: half, give or take five standard deviations.
  EXPECT_NEAR(faint.named, 200, 50);
  // Neither is six ahead.
  EXPECT_GT(faint.set_size, 750);
}

TEST(NamingCeiling, DoesNotDependOnThreads) {
  EXPECT_EQ(rates_of(2, 1).named, rates_of(2, 3).named);
}

}  // namespace
}  // namespace umov::gap
