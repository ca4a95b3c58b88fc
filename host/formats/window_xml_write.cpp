#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/klems_table.hpp"
#include "host/formats/markup.hpp"
#include "host/formats/visible_band.hpp"
#include "host/formats/window_xml.hpp"

namespace umov::formats {
namespace {

constexpr double accuracy = 1e-3;

/// XML comments end at two hyphens.
std::string without_double_hyphens(std::string_view text) {
  std::string out;
  for (const char c : text) {
    if (c == '-' && out.ends_with('-')) out += ' ';
    out += c;
  }
  return out;
}

void append_basis(std::string& out, const KlemsBasis& basis) {
  out += fmt::format("\t\t\t<AngleBasis>\n\t\t\t\t<AngleBasisName>{}</AngleBasisName>\n",
                     escaped_markup(basis.name()));
  for (const KlemsRing& ring : basis.rings()) {
    const double centre = ring.patches == 1 ? 0.0 : 0.5 * (ring.lower_deg + ring.upper_deg);
    out += fmt::format(
        "\t\t\t\t<AngleBasisBlock>\n\t\t\t\t\t<Theta>{}</Theta>\n\t\t\t\t\t<nPhis>{}</nPhis>\n"
        "\t\t\t\t\t<ThetaBounds>\n\t\t\t\t\t\t<LowerTheta>{}</LowerTheta>\n"
        "\t\t\t\t\t\t<UpperTheta>{}</UpperTheta>\n\t\t\t\t\t</ThetaBounds>\n\t\t\t\t</"
        "AngleBasisBlock>\n",
        decimal_text(centre), ring.patches, decimal_text(ring.lower_deg),
        decimal_text(ring.upper_deg));
  }
  out += "\t\t\t</AngleBasis>\n";
}

void append_block(std::string& out, const WindowBlock& block) {
  out += fmt::format(
      "\t\t\t<WavelengthDataBlock>\n\t\t\t\t<WavelengthDataDirection>{}</WavelengthDataDirection>\n"
      "\t\t\t\t<ColumnAngleBasis>{}</ColumnAngleBasis>\n\t\t\t\t<RowAngleBasis>{}</RowAngleBasis>\n"
      "\t\t\t\t<ScatteringDataType>BRDF</ScatteringDataType>\n\t\t\t\t<ScatteringData>\n",
      escaped_markup(block.direction), escaped_markup(block.matrix.incident.name()),
      escaped_markup(block.matrix.exit.name()));
  for (std::size_t o = 0; o < block.matrix.exit.size(); ++o) {
    for (std::size_t i = 0; i < block.matrix.incident.size(); ++i) {
      if (i > 0) out += ' ';
      append_shortest(out, block.matrix.at(o, i));
    }
    out += '\n';
  }
  out += "\t\t\t\t</ScatteringData>\n\t\t\t</WavelengthDataBlock>\n";
}

bool same_basis(const KlemsBasis& a, const KlemsBasis& b) {
  return a.name() == b.name() &&
         std::equal(a.rings().begin(), a.rings().end(), b.rings().begin(), b.rings().end(),
                    [](const KlemsRing& x, const KlemsRing& y) {
                      return x.lower_deg == y.lower_deg && x.upper_deg == y.upper_deg &&
                             x.patches == y.patches;
                    });
}

void check(const WindowElement& element) {
  if (element.blocks.empty()) throw Error("there is no matrix to write", "give at least one");
  for (const WindowBlock& block : element.blocks) {
    const KlemsMatrix& first = element.blocks.front().matrix;
    if (!same_basis(block.matrix.incident, first.incident) ||
        !same_basis(block.matrix.exit, first.exit))
      throw Error("blocks of one file have different bases", "write them to files of their own");
    if (!same_basis(first.incident, first.exit) && first.incident.name() == first.exit.name())
      throw Error("two bases have one name", "name them differently");
    const auto dhr = directional_hemispherical(block.matrix);
    const auto most = std::max_element(dhr.begin(), dhr.end());
    if (*most > largest_reflectance)
      throw Error(fmt::format("incident patch {} would reflect {:.1f} % of its light",
                              most - dhr.begin(), 100 * *most),
                  "a model that creates light cannot be written; choose one with shadowing (see "
                  "docs/physics.md)");
  }
}

/// Reflectance of each ring of incident patches.
std::string reflectance_by_ring(const KlemsMatrix& matrix) {
  const auto dhr = directional_hemispherical(matrix);
  std::string out;
  for (std::size_t r = 0; r < matrix.incident.rings().size(); ++r) {
    const KlemsRing& ring = matrix.incident.rings()[r];
    double sum = 0;
    for (int p = 0; p < ring.patches; ++p)
      sum += dhr[matrix.incident.first_of(r) + static_cast<std::size_t>(p)];
    out += fmt::format("{}{:g}-{:g} deg {:.5g}", r > 0 ? ", " : "", ring.lower_deg, ring.upper_deg,
                       sum / ring.patches);
  }
  return out;
}

struct Averaged {
  KlemsMatrix matrix;
  std::vector<std::string> notes;
};

Averaged averaged(const brdf::Table& table, const std::vector<double>& wavelengths_um,
                  const TableWriting& writing) {
  const std::vector<double> shares = visible_shares(wavelengths_um);
  std::vector<std::pair<double, double>> bands;
  for (std::size_t n = 0; n < shares.size(); ++n)
    if (shares[n] > 1e-6) bands.emplace_back(wavelengths_um[n], shares[n]);
  KlemsSource source;
  source.brdf = [&](double theta_i, double theta_r, double phi_r) {
    double sum = 0;
    for (const auto& [um, share] : bands)
      sum += share * table.at(um, {theta_i, theta_r, phi_r})[0][0];
    return sum;
  };
  const auto* model = dynamic_cast<const ModelTable*>(&table);
  if (model)
    source.mirror = [&](double theta_i) {
      double sum = 0;
      for (const auto& [um, share] : bands) sum += share * model->mirror(um, theta_i);
      return sum;
    };
  KlemsAverage average =
      klems_average(source, *KlemsBasis::by_name("LBNL/Klems Full"), accuracy, writing.progress);
  // Digits beyond the accuracy would only make the file longer.
  for (double& value : average.matrix.values) {
    std::string text;
    append_general(text, value, 7);
    read_decimal(text, value);
  }
  Averaged out{std::move(average.matrix), {}};
  out.notes.push_back(fmt::format(
      "patch averages by adaptive cubature, largest estimated error {:.2g} of the value "
      "(or of 0.001 per sr where that is more)",
      average.largest_relative_error));
  if (wavelengths_um.size() > 1) {
    std::string list;
    for (std::size_t n = 0; n < shares.size(); ++n)
      list +=
          fmt::format("{}{:g} nm {:.3g}", n > 0 ? ", " : "", 1e3 * wavelengths_um[n], shares[n]);
    out.notes.push_back("Visible is the mean over wavelength weighted with D65 and V(lambda): " +
                        list);
  } else {
    out.notes.push_back(
        fmt::format("Visible stands for {:g} nm alone", 1e3 * wavelengths_um.front()));
  }
  if (model && model->has_mirror())
    out.notes.push_back(
        "light that leaves exactly in the mirror direction is in the mirror patch (diagonal)");
  return out;
}

/// The lines of the header that other formats share, put right for a matrix.
std::vector<std::string> comments(const brdf::Table& table, const TableWriting& writing,
                                  const Averaged& averaged,
                                  const std::vector<double>& wavelengths_um) {
  TableHeader header = table_header(table, writing, wavelengths_um, false);
  header.notes.insert(header.notes.end(), averaged.notes.begin(), averaged.notes.end());
  std::vector<std::string> lines = header.lines();
  for (std::string& line : lines) {
    if (line.starts_with("azimuth:"))
      line =
          "azimuth: patch numbers tell where light travels to, on both sides: a mirror is a "
          "diagonal matrix";
    if (line.starts_with("solid angle:"))
      line =
          "solid angle: values are means over an incident and an exit patch, weighted with cos "
          "theta_i cos theta_r";
  }
  lines.push_back("directional-hemispherical reflectance by incident ring: " +
                  reflectance_by_ring(averaged.matrix));
  return lines;
}

}  // namespace

std::string window_xml_text(const WindowElement& element, std::span<const std::string> lines) {
  check(element);
  std::string out =
      "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n"
      "<WindowElement xmlns=\"http://windows.lbl.gov\" "
      "xmlns:xsi=\"http://www.w3.org/2001/XMLSchema-instance\" "
      "xsi:schemaLocation=\"http://windows.lbl.gov/BSDF-v1.4.xsd\">\n";
  if (!lines.empty()) {
    out += "<!--\n";
    for (const std::string& line : lines) out += "  " + without_double_hyphens(line) + "\n";
    out += "-->\n";
  }
  out += fmt::format(
      "\t<WindowElementType>System</WindowElementType>\n\t<FileType>BSDF</"
      "FileType>\n\t<Optical>\n\t\t<Layer>\n"
      "\t\t\t<Material>\n\t\t\t\t<Name>{}</Name>\n\t\t\t\t<Manufacturer>{}</Manufacturer>\n"
      "\t\t\t\t<DeviceType>Other</DeviceType>\n\t\t\t</Material>\n"
      "\t\t\t<DataDefinition>\n\t\t\t\t<IncidentDataStructure>Columns</IncidentDataStructure>\n",
      escaped_markup(element.name), escaped_markup(element.manufacturer));
  const KlemsMatrix& first = element.blocks.front().matrix;
  append_basis(out, first.incident);
  if (!same_basis(first.incident, first.exit)) append_basis(out, first.exit);
  out += "\t\t\t</DataDefinition>\n";
  for (std::size_t n = 0; n < element.blocks.size();) {
    const std::string& band = element.blocks[n].band;
    const std::string& unit = element.blocks[n].unit;
    out += fmt::format(
        "\t\t<WavelengthData>\n\t\t\t<LayerNumber>System</LayerNumber>\n"
        "\t\t\t<Wavelength unit=\"{}\">{}</Wavelength>\n"
        "\t\t\t<SourceSpectrum>CIE Illuminant D65 1nm.ssp</SourceSpectrum>\n"
        "\t\t\t<DetectorSpectrum>ASTM E308 1931 Y.dsp</DetectorSpectrum>\n",
        escaped_markup(unit), escaped_markup(band));
    for (; n < element.blocks.size() && element.blocks[n].band == band &&
           element.blocks[n].unit == unit;
         ++n)
      append_block(out, element.blocks[n]);
    out += "\t\t</WavelengthData>\n";
  }
  return out + "\t\t</Layer>\n\t</Optical>\n</WindowElement>\n";
}

std::string write_window_table(const brdf::Table& table, const TableWriting& writing) {
  const std::vector<double> wavelengths_um = written_wavelengths(table, writing);
  const auto* klems = dynamic_cast<const KlemsTable*>(&table);
  const Averaged values =
      klems ? Averaged{klems->matrix(), {}} : averaged(table, wavelengths_um, writing);
  WindowElement element;
  element.name = table.description().substr(0, 200);
  element.manufacturer = writing.program;
  const std::string band = klems ? klems->band() : "Visible";
  double wavelength_um = 0;
  const std::string unit = read_decimal(band, wavelength_um) ? "Integral" : "Microns";
  for (const char* direction : {"Reflection Front", "Reflection Back"})
    element.blocks.push_back({band, unit, direction, values.matrix});
  return window_xml_text(element, comments(table, writing, values, wavelengths_um));
}

}  // namespace umov::formats
