// Numbers with no more digits than the uncertainty supports.
#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "host/formats/scan_table.hpp"
#include "host/report/numbers.hpp"

namespace umov::report {
namespace {

TEST(Numbers, the_uncertainty_has_two_digits_and_fixes_the_place_of_the_value) {
  EXPECT_EQ(with_uncertainty(0.48931, 0.00123), "0.4893 ± 0.0012");
  EXPECT_EQ(with_uncertainty(-0.48931, 0.00123), "−0.4893 ± 0.0012");
  EXPECT_EQ(with_uncertainty(1234.5, 30), "1234 ± 30");
  EXPECT_EQ(with_uncertainty(34.02, 7.96), "34.0 ± 8.0");
  EXPECT_EQ(with_uncertainty(0.001, 0.02), "0.001 ± 0.020");
}

TEST(Numbers, an_uncertainty_that_rounds_up_to_the_next_decade_keeps_two_digits) {
  EXPECT_EQ(with_uncertainty(1.23456, 0.00996), "1.235 ± 0.010");
  EXPECT_EQ(with_uncertainty(1.23456, 0.0999), "1.23 ± 0.10");
}

TEST(Numbers, very_small_and_very_large_values_are_scientific) {
  EXPECT_EQ(with_uncertainty(1.234e-7, 5.6e-9), "(1.234 ± 0.056)×10⁻⁷");
  EXPECT_EQ(with_uncertainty(-2.5e8, 1e6), "(−2.500 ± 0.010)×10⁸");
}

TEST(Numbers, plain_numbers_write_powers_as_people_do) {
  EXPECT_EQ(plain(656300.0, 3), "6.56×10⁵");
  EXPECT_EQ(plain(-1.2e-13), "−1.2×10⁻¹³");
  EXPECT_EQ(plain(0.99), "0.99");
  EXPECT_EQ(plain(-INFINITY), "−∞");
}

TEST(Numbers, without_a_usable_uncertainty_the_value_stands_alone) {
  EXPECT_EQ(with_uncertainty(0.489312, 0), "0.4893");
  EXPECT_EQ(with_uncertainty(0.489312, NAN), "0.4893");
  EXPECT_EQ(with_uncertainty(NAN, 0.1), "–");
}

TEST(Numbers, a_value_that_rounds_to_zero_has_no_sign) {
  EXPECT_EQ(with_uncertainty(-0.00001, 0.01), "0.000 ± 0.010");
}

TEST(Numbers, counts_have_thousands_separators) {
  EXPECT_EQ(count(0), "0");
  EXPECT_EQ(count(999), "999");
  EXPECT_EQ(count(1000), "1,000");
  EXPECT_EQ(count(12345678), "12,345,678");
}

TEST(Numbers, axes_have_the_letters_of_the_paper) {
  EXPECT_EQ(axis_name(0), "P");
  EXPECT_EQ(axis_name(90), "S");
  EXPECT_EQ(axis_name(45), "45°");
  EXPECT_EQ(axis_name(-45), "−45°");
  EXPECT_EQ(axis_name(formats::open_axis), "U");
}

}  // namespace
}  // namespace umov::report
