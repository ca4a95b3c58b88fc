// Spectra from columns of files.
#include <gtest/gtest.h>

#include <unistd.h>
#include <filesystem>
#include <fstream>
#include <string>

#include "host/toml/spectrum.hpp"
#include "tests/unit/failure.hpp"

namespace umov {
namespace {

class SpectrumFile : public ::testing::Test {
 protected:
  void TearDown() override { std::filesystem::remove(path_); }
  void write(const std::string& text) const { std::ofstream(path_, std::ios::binary) << text; }
  const std::filesystem::path path_ =
      std::filesystem::temp_directory_path() / ("umov_spectrum_" + std::to_string(::getpid()));
};

TEST_F(SpectrumFile, AColumnIsReadOverMicrometres) {
  write("# soil\nwavelength_nm,wet,dry\n500,.1,.2\n700,.3,.6\n");
  const Spectrum dry = read_spectrum(path_, "dry");
  EXPECT_DOUBLE_EQ(dry.at(0.55, "soil"), 0.3);
  EXPECT_NE(failure_of([&] { static_cast<void>(dry.at(0.8, "soil")); }).find("0.5 and 0.7"),
            std::string::npos);
  EXPECT_NE(failure_of([&] { read_spectrum(path_, "damp"); }).find(":2: has no column `damp`"),
            std::string::npos);
}

TEST_F(SpectrumFile, WhatIsTooLargeForASpectrumIsNotReadToItsEnd) {
  const std::string head = "wavelength_nm,dry\n500,.1\n";
  const std::string line = "# nothing but a note\n";
  std::string text = head;
  while (text.size() + line.size() <= (std::size_t{8} << 20)) text += line;
  write(text);
  EXPECT_EQ(read_spectrum(path_, "dry").value.size(), 1U);
  write(text + line);
  EXPECT_NE(failure_of([&] { read_spectrum(path_, "dry"); }).find("larger than 8 MiB"),
            std::string::npos);
  EXPECT_NE(failure_of([] { read_spectrum("/dev/zero", "dry"); }).find("larger than 8 MiB"),
            std::string::npos);
}

}  // namespace
}  // namespace umov
