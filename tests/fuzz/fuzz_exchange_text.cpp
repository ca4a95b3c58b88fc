// BRDF text of other programs: Window XML, CSV tables, SCATMECH parameters, ASTM and Cornell
// points. Whatever the bytes, a reader either refuses them with umov::Error or yields something
// that goes through text of its own format unchanged.
// fuzz-link: umov_formats
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <string_view>

#include "host/errors/error.hpp"
#include "host/formats/astm.hpp"
#include "host/formats/cornell_brdf.hpp"
#include "host/formats/klems_table.hpp"
#include "host/formats/scatmech_text.hpp"
#include "host/formats/table_csv.hpp"
#include "host/formats/window_xml.hpp"
#include "tests/fuzz/foreign_bytes.hpp"

namespace {

using namespace umov;
using namespace umov::formats;
using fuzz::require;

constexpr std::string_view window =
    "<WindowElement><Optical><Layer><Material><Name>a</Name></Material><DataDefinition>"
    "<IncidentDataStructure>Columns</IncidentDataStructure><AngleBasis><AngleBasisName>b</"
    "AngleBasisName>"
    "<AngleBasisBlock><nPhis>1</nPhis><ThetaBounds><LowerTheta>0</LowerTheta><UpperTheta>30</"
    "UpperTheta>"
    "</ThetaBounds></AngleBasisBlock><AngleBasisBlock><nPhis>2</nPhis><ThetaBounds><LowerTheta>30</"
    "LowerTheta>"
    "<UpperTheta>90</UpperTheta></ThetaBounds></AngleBasisBlock></AngleBasis></"
    "DataDefinition><WavelengthData>"
    "<Wavelength unit=\"Integral\">Visible</Wavelength><WavelengthDataBlock>"
    "<WavelengthDataDirection>Reflection "
    "Front</WavelengthDataDirection><ColumnAngleBasis>b</ColumnAngleBasis>"
    "<RowAngleBasis>b</RowAngleBasis><ScatteringData>\n.1 .1 .1\n.1, .2 .1\n.1 .1 "
    ".2\n</ScatteringData>"
    "</WavelengthDataBlock></WavelengthData></Layer></Optical></WindowElement>";
constexpr std::string_view grid =
    "# "
    "x\ntheta_i_deg,theta_r_deg,phi_r_deg,wavelength_nm,m00\n0,0,0,550,0.1\n0,30,0,550,0.2\n45,0,0,"
    "550,0.3\n"
    "45,30,0,550,4e-1\n";
constexpr std::string_view planes =
    "plane,theta_i_deg,angle_deg,wavelength_nm,m00\nin,30,-80,550,0.1\nin,30,30,550,0.5\nacross,30,"
    "0,550,0.5\n"
    "across,30,40,550,0.1\n";
constexpr std::string_view scatmech =
    "Two_Source_BRDF_Model\nlambda = 0.6\ntype = 0\nsubstrate = (1.5,0)\nfactor1 = 0.9\n"
    "source1 = Shadowed_Facet_BRDF_Model\nsource1.lambda = 0.6\nsource1.substrate = (1.5,0)\n"
    "source1.sdf = Gaussian_Slope_Distribution_Function\nsource1.sdf.s = 0.2\nsource1.stack = "
    "No_StackModel\n"
    "source1.shadow = Torrance_Sparrow_Shadow_Function\nfactor2 = 1\nsource2 = "
    "Lambertian_BRDF_Model\n"
    "source2.lambda = 0.6\nsource2.substrate = (1.5,0)\nsource2.reflectance = Table_Reflectance\n"
    "source2.reflectance.table = 0.4\ncorrelation = 0 (double: Correlation)\n";
constexpr std::string_view astm =
    "ASTM E2387\nSAMPLE red\nNOTE Odd key: x\nWAVELENGTH 632.8 nm\nANGLE_UNITS DEGREES\nNUM_POINTS "
    "2\n"
    "VARS "
    "theta_i,phi_i,theta_s,phi_s,pol_i,BRDF,BRDF_u\n30,180,40,0,S,0.1,0.01\n30,180,40,90,U,0.2,0."
    "01\n"
    "THETA_I 5\nNUM_POINTS 1\nVARS theta_s,CCBRDF,450nm,u_450nm\n-60,.1,.2,.01\n";
constexpr std::string_view cornell =
    "# a\n# num wls\n2\n450\n650\n0.698132 0 0.698132 3.141593 .5 .4\n1.2 0 0.349066 -1.570796 .05 "
    "0\n";
constexpr std::array<std::string_view, 6> originals{window, grid, planes, scatmech, astm, cornell};

std::string data_of(const std::string& text, std::string_view start) {
  return text.substr(text.find(start));
}

/// Reads, writes, reads and writes again: the two texts must agree from `start` on.
void round_trip(TablePtr (*read)(std::string_view, const std::string&),
                std::string (*write)(const brdf::Table&, const TableWriting&),
                std::string_view text, std::string_view start) {
  const TablePtr table = read(text, "fuzz");
  const auto m = table->at(0.55, {0.3, 0.5, 0.2});
  require(std::isfinite(m[0][0]) && m[0][0] >= 0);
  const std::string once = write(*table, {});
  require(data_of(write(*read(once, "again"), {}), start) == data_of(once, start));
}

void read_one(std::size_t format, std::string_view text) {
  switch (format) {
    case 0:
      is_window_xml(text);
      round_trip(read_window_table, write_window_table, text, "<DataDefinition>");
      break;
    case 1:
      is_grid_csv(text);
      round_trip(read_grid_csv, write_grid_csv, text, "\ntheta_i_deg");
      break;
    case 2:
      is_planes_csv(text);
      round_trip(read_planes_csv, write_planes_csv, text, "\nplane,");
      break;
    case 3: {
      is_scatmech(text);
      const ScatmechModel read = parse_scatmech(text, "fuzz");
      std::string once;
      try {
        once = scatmech_text(read.model, read.values, read.wavelength_um, {});
      } catch (const Error&) {
        break;  // nested sums of more than four terms are read, not written
      }
      require(parse_scatmech(once, "again").model.name() == read.model.name());
      break;
    }
    case 4: {
      is_astm(text);
      const BrdfTable read = read_astm(text, "fuzz");
      const BrdfTable again = read_astm(write_astm(read, {}), "again");
      require(again.points.brdf_per_sr == read.points.brdf_per_sr);
      require(again.points.theta_r_deg == read.points.theta_r_deg);
      require(again.points.used == read.points.used);
      break;
    }
    default: {
      is_cornell_brdf(text);
      const BrdfTable read = read_cornell_brdf(text, "fuzz");
      for (const double u : read.points.brdf_u) require(std::isfinite(u) && u >= 0);
    }
  }
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto [format, text] = fuzz::foreign_bytes(originals, data, size);
  try {
    read_one(format, text);
  } catch (const Error&) {
  }
  return 0;
}
