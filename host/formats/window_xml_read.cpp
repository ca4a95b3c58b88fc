#include <algorithm>
#include <cctype>
#include <cmath>
#include <optional>

#include <pugixml.hpp>

#include "host/errors/error.hpp"
#include "host/formats/decimal.hpp"
#include "host/formats/klems_table.hpp"
#include "host/formats/window_xml.hpp"

namespace umov::formats {
namespace {

constexpr double visible_um = 0.555;  ///< where the eye is most sensitive
constexpr double solar_um = 0.700;    ///< half of the sun's power lies on either side

bool is_gap(char c) {
  return c == ' ' || c == '\t' || c == '\n' || c == '\r' || c == ',';
}

std::string lower(std::string_view text) {
  std::string out(text);
  for (char& c : out) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
  return out;
}

class Reader {
 public:
  Reader(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  WindowElement read() {
    // Line ends stay as they are, so that places in the tree are places in the file.
    const auto parsed = document_.load_buffer(
        text_.data(), text_.size(), pugi::parse_cdata | pugi::parse_escapes, pugi::encoding_utf8);
    if (!parsed)
      fail(parsed.offset, {}, std::string("is not well-formed XML: ") + parsed.description(),
           "the file may be cut off");
    const pugi::xml_node root = document_.child("WindowElement");
    if (!root) fail(0, {}, "has no WindowElement", "give a Radiance or WINDOW 6 XML file");
    require_nothing_after(root);
    const pugi::xml_node optical = child(root, "Optical");
    const pugi::xml_node layer = child(optical, "Layer");
    if (const auto second = layer.next_sibling("Layer"))
      fail(offset(second), "Layer", "there is more than one layer",
           "give a file of a single surface");
    const pugi::xml_node definition = child(layer, "DataDefinition");
    read_structure(child(definition, "IncidentDataStructure"));
    for (const auto basis : definition.children("AngleBasis")) read_basis(basis);

    WindowElement element;
    element.name = text_of(layer.child("Material").child("Name"));
    element.manufacturer = text_of(layer.child("Material").child("Manufacturer"));
    for (const auto data : layer.children("WavelengthData")) {
      const pugi::xml_node wavelength = child(data, "Wavelength");
      for (const auto block : data.children("WavelengthDataBlock"))
        read_block(block, wavelength, element);
    }
    if (element.blocks.empty())
      fail(offset(layer), "WavelengthDataBlock", "there is no reflection matrix",
           "the file must hold a block \"Reflection Front\" or \"Reflection Back\"");
    return element;
  }

 private:
  [[noreturn]] void fail(std::ptrdiff_t at, const std::string& what, const std::string& problem,
                         const std::string& remedy) const {
    const auto end = std::min<std::size_t>(at > 0 ? static_cast<std::size_t>(at) : 0, text_.size());
    const auto lines =
        std::count(text_.begin(), text_.begin() + static_cast<std::ptrdiff_t>(end), '\n');
    throw Error(Place{file_, static_cast<std::size_t>(lines) + 1, what}, problem, remedy);
  }

  /// Only blanks and comments may follow the element.
  void require_nothing_after(const pugi::xml_node& root) const {
    constexpr const char* problem = "the file goes on after WindowElement";
    constexpr const char* remedy = "a file holds one WindowElement and nothing behind it";
    if (const auto more = root.next_sibling()) fail(offset(more), more.name(), problem, remedy);
    constexpr std::string_view closing = "</WindowElement";
    std::size_t at = text_.rfind(closing);
    if (at == std::string_view::npos) return;  // <WindowElement/>: what it lacks is told elsewhere
    at = text_.find('>', at) + 1;
    while (at < text_.size()) {
      if (std::isspace(static_cast<unsigned char>(text_[at]))) {
        ++at;
      } else if (text_.substr(at).starts_with("<!--")) {
        at = text_.find("-->", at) + 3;  // the parser found the comment closed
      } else {
        fail(static_cast<std::ptrdiff_t>(at), {}, problem, remedy);
      }
    }
  }

  static std::ptrdiff_t offset(const pugi::xml_node& node) { return node.offset_debug(); }

  static std::string text_of(const pugi::xml_node& node) {
    return std::string(trimmed(std::string_view(node.text().get()).substr(0, 400)));
  }

  pugi::xml_node child(const pugi::xml_node& parent, const char* name) const {
    const pugi::xml_node node = parent.child(name);
    if (!node)
      fail(offset(parent), name, "is missing", "the file may be cut off or of another kind");
    return node;
  }

  double number(const pugi::xml_node& node) const {
    double value = 0;
    if (const char* problem = read_decimal(text_of(node), value))
      fail(offset(node), node.name(),
           std::string(problem) + ": \"" + text_of(node).substr(0, 40) + "\"",
           "give a plain decimal number");
    return value;
  }

  void read_structure(const pugi::xml_node& node) {
    const std::string structure = lower(text_of(node));
    if (structure == "columns") {
      incident_by_rows_ = false;
    } else if (structure == "rows") {
      incident_by_rows_ = true;
    } else if (structure.starts_with("tensortree")) {
      fail(offset(node), node.name(),
           "is a tensor tree: its cells follow the scatterer, not a fixed set of patches",
           "convert it with Radiance's bsdf2klems first");
    } else {
      fail(offset(node), node.name(), "should be Columns or Rows", "the file is of another kind");
    }
  }

  void read_basis(const pugi::xml_node& node) {
    const std::string name = text_of(child(node, "AngleBasisName"));
    std::vector<KlemsRing> rings;
    for (const auto block : node.children("AngleBasisBlock")) {
      if (rings.size() == KlemsBasis::max_rings)
        fail(offset(block), "AngleBasisBlock", "there are too many rings",
             "a basis has at most 64");
      KlemsRing ring;
      const auto bounds = child(block, "ThetaBounds");
      // Early files let the cap about the normal begin at minus its upper edge.
      ring.lower_deg = rings.empty() ? 0.0 : number(child(bounds, "LowerTheta"));
      ring.upper_deg = number(child(bounds, "UpperTheta"));
      const double patches = number(child(block, "nPhis"));
      if (patches < 1 || patches > KlemsBasis::max_patches || patches != std::floor(patches))
        fail(offset(block), "nPhis", "is no number of patches",
             "give a whole number from 1 to 1024");
      ring.patches = static_cast<int>(patches);
      rings.push_back(ring);
    }
    if (rings.empty()) return;  // named only; the rings are those that the name stands for
    try {
      bases_.push_back(KlemsBasis(name, std::move(rings)));
    } catch (const Error& error) {
      fail(offset(node), "AngleBasis", error.problem(), error.remedy());
    }
  }

  KlemsBasis basis(const pugi::xml_node& block, const char* which) const {
    const auto node = child(block, which);
    const std::string name = text_of(node);
    for (const KlemsBasis& known : bases_)
      if (lower(known.name()) == lower(name)) return known;
    if (auto known = KlemsBasis::by_name(name)) return *known;
    fail(offset(node), which,
         "angle basis \"" + name.substr(0, 60) + "\" is not defined in the file",
         "define it with an AngleBasis, or use LBNL/Klems Full, Half or Quarter");
  }

  void read_block(const pugi::xml_node& block, const pugi::xml_node& wavelength,
                  WindowElement& element) {
    const auto direction_node = child(block, "WavelengthDataDirection");
    const std::string direction = lower(text_of(direction_node));
    if (direction.starts_with("transmission")) {
      ++element.transmission_blocks;
      return;
    }
    if (direction != "reflection front" && direction != "reflection back")
      fail(offset(direction_node), direction_node.name(),
           "should be a reflection or transmission, front or back",
           "name it as WINDOW does, such as \"Reflection Front\"");
    const bool front = direction == "reflection front";
    KlemsMatrix matrix{basis(block, "ColumnAngleBasis"), basis(block, "RowAngleBasis"), {}};
    if (incident_by_rows_ && matrix.incident.size() != matrix.exit.size())
      fail(offset(block), "RowAngleBasis",
           "rows of incident patches with two different bases are ambiguous",
           "write the matrix with incident patches as columns");
    read_values(child(block, "ScatteringData"), matrix);
    const auto dhr = directional_hemispherical(matrix);
    const auto most = std::max_element(dhr.begin(), dhr.end());
    if (*most > largest_reflectance)
      fail(offset(block), "ScatteringData",
           "incident patch " + std::to_string(most - dhr.begin()) + " reflects " +
               std::to_string(std::lround(100 * *most)) + " % of its light",
           "the values must be BRDF in 1/sr, not multiplied by cos theta; none may reflect over "
           "101 %");
    element.blocks.push_back({text_of(wavelength),
                              wavelength.attribute("unit").as_string("Integral"),
                              front ? "Reflection Front" : "Reflection Back", std::move(matrix)});
  }

  void read_values(const pugi::xml_node& node, KlemsMatrix& matrix) const {
    const std::size_t expected = matrix.incident.size() * matrix.exit.size();
    const pugi::xml_node data = node.first_child();
    const char* const start = data.value();
    const auto place = [&](const char* at) { return data.offset_debug() + (at - start); };
    const std::string_view all(start);
    std::vector<double> values;
    std::size_t at = 0;
    while (true) {
      while (at < all.size() && is_gap(all[at])) ++at;
      if (at == all.size()) break;
      std::size_t end = at;
      while (end < all.size() && !is_gap(all[end])) ++end;
      const std::string_view field = all.substr(at, end - at);
      double value = 0;
      if (values.size() == expected)
        fail(place(all.data() + at), node.name(),
             "there are more than the " + std::to_string(expected) + " values",
             "one value a pair of patches");
      if (const char* problem = read_decimal(field, value))
        fail(place(all.data() + at), node.name(),
             std::string(problem) + ": \"" + std::string(field.substr(0, 40)) + "\"",
             "give a plain decimal number");
      if (value < 0)
        fail(place(all.data() + at), node.name(), "a BRDF is negative",
             "set noise below zero to 0");
      values.push_back(value);
      at = end;
    }
    if (values.size() != expected)
      fail(
          place(all.data() + all.size()), node.name(),
          "there are " + std::to_string(values.size()) + " values, not " + std::to_string(expected),
          "one value a pair of patches; the file may be cut off");
    if (incident_by_rows_) {
      matrix.values.resize(expected);
      for (std::size_t i = 0; i < matrix.incident.size(); ++i)
        for (std::size_t o = 0; o < matrix.exit.size(); ++o)
          matrix.at(o, i) = values[i * matrix.exit.size() + o];
    } else {
      matrix.values = std::move(values);
    }
  }

  std::string_view text_;
  std::string file_;
  pugi::xml_document document_;
  bool incident_by_rows_ = false;
  std::vector<KlemsBasis> bases_;
};

/// Band and the wavelength that stands for it; single wavelengths are turned to micrometres.
std::pair<std::string, double> band_of(const WindowBlock& block) {
  double value = 0;
  if (!read_decimal(block.band, value) && value > 0) {
    const double um = lower(block.unit).starts_with("nano") ? 1e-3 * value : value;
    return {decimal_text(um), um};
  }
  return {block.band, lower(block.band) == "solar" ? solar_um : visible_um};
}

}  // namespace

WindowElement parse_window_xml(std::string_view text, const std::string& file) {
  return Reader(text, file).read();
}

bool is_window_xml(std::string_view bytes) {
  return bytes.substr(0, 65536).find("<WindowElement") != std::string_view::npos;
}

TablePtr read_window_table(std::string_view bytes, const std::string& file) {
  WindowElement element = parse_window_xml(bytes, file);
  const auto rank = [](const WindowBlock& block) {
    return (lower(block.band) == "visible" ? 0 : 2) +
           (block.direction == "Reflection Front" ? 0 : 1);
  };
  auto chosen = std::min_element(element.blocks.begin(), element.blocks.end(),
                                 [&](const auto& a, const auto& b) { return rank(a) < rank(b); });
  std::string description = "Klems matrix " + std::to_string(chosen->matrix.exit.size()) + " x " +
                            std::to_string(chosen->matrix.incident.size()) + ", " + chosen->band +
                            ", " + chosen->direction + ", file " + file;
  try {
    const auto [band, wavelength_um] = band_of(*chosen);
    return std::make_shared<KlemsTable>(std::move(chosen->matrix), band, wavelength_um,
                                        std::move(description));
  } catch (const Error& error) {
    throw Error(Place{file}, error.problem(), error.remedy());
  }
}

}  // namespace umov::formats
