// A diagnosis in words, the same on the terminal and on a page.
#pragma once

#include <cstddef>
#include <string>
#include <vector>

#include "host/gap/engine/diagnosis.hpp"

namespace umov::gap {

/// One sentence of verdict, and one on what is left where it varies with a circumstance.
std::string verdict_sentence(const Diagnosis& diagnosis);

/// An effect as people say it: "laser drift".
std::string plain_name(const std::string& effect);

/// Is this an effect of so many parameters that they are coefficients of a series, which say
/// nothing one by one?
bool is_series(std::size_t parameters);

/// What is done for a further scan of the menu: "with the sample turned by 180° about its normal".
/// The identifier itself where it is not on the menu.
std::string menu_in_words(const std::string& menu);

/// What a further scan tells apart, each pair once: "incidence zero from backlash".
std::vector<std::string> separations_in_words(const FurtherScan& scan);

}  // namespace umov::gap
