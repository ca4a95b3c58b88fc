#include "host/cli/study/page.hpp"

#include <algorithm>
#include <string_view>

#include <fmt/format.h>

#include "host/formats/atomic_file.hpp"
#include "host/formats/markup.hpp"
#include "host/report/assets.hpp"

namespace umov::study {
namespace {

constexpr std::string_view style = R"css(
body { font: 16px/1.5 "DejaVu Sans", Arial, sans-serif; color: #1c222b; background: #fff;
       max-width: 960px; margin: 2rem auto; padding: 0 1rem; }
h1 { font-size: 1.7rem; } h2 { font-size: 1.25rem; margin-top: 2.2rem; }
table { border-collapse: collapse; margin: 1rem 0; font-size: .93rem; display: block; overflow-x: auto; }
th, td { border: 1px solid #e3e7ec; padding: .3rem .6rem; text-align: left; }
th { background: #f4f6f8; } code { background: #f4f6f8; padding: 0 .2em; }
figure { margin: 1.5rem 0; } figcaption { color: #5a6472; font-size: .93rem; }
)css";

constexpr std::string_view script = R"js(
const axis = {gridcolor: "#e3e7ec", zerolinecolor: "#aab3bf", linecolor: "#aab3bf", showline: true,
              mirror: true, ticks: "outside", automargin: true, exponentformat: "power"};
for (const figure of JSON.parse(document.getElementById("figures").textContent).figures) {
  const layout = {paper_bgcolor: "#fff", plot_bgcolor: "#fff", height: 480,
                  font: {size: 14, color: "#1c222b"}, ...figure.layout};
  delete layout.width;
  for (const key of Object.keys(layout))
    if (/^[xy]axis\d*$/.test(key)) layout[key] = {...axis, ...layout[key]};
  Plotly.newPlot(figure.name, figure.data, layout, {responsive: true, displaylogo: false});
}
document.documentElement.dataset.ready = "yes";
)js";

/// `code` and **bold** as HTML.
std::string marked_up(const std::string& text) {
  std::string out;
  bool code = false, bold = false;
  const std::string safe = formats::escaped_markup(text);
  for (std::size_t i = 0; i < safe.size(); ++i) {
    if (safe[i] == '`') {
      out += code ? "</code>" : "<code>";
      code = !code;
    } else if (!code && safe.compare(i, 2, "**") == 0) {
      out += bold ? "</b>" : "<b>";
      bold = !bold;
      ++i;
    } else {
      out += safe[i];
    }
  }
  return out;
}

/// Broken at 110 columns, as pages of the documentation are; further lines begin with `indent`.
std::string wrapped(const std::string& text, const std::string& indent = "") {
  constexpr std::size_t width = 110;
  std::string out, line;
  std::size_t at = 0;
  while (at < text.size()) {
    const std::size_t end = std::min(text.find(' ', at), text.size());
    const std::string word = text.substr(at, end - at);
    if (!line.empty() && line.size() + 1 + word.size() > width) {
      out += line + "\n";
      line = indent + word;
    } else {
      line += (line.empty() ? "" : " ") + word;
    }
    at = end + 1;
  }
  return out + line;
}

std::string cells(const std::vector<std::string>& row) {
  std::string out = "|";
  for (const auto& cell : row) out += " " + cell + " |";
  return out + "\n";
}

std::string html_row(const std::vector<std::string>& row, const char* tag) {
  std::string out = "<tr>";
  for (const auto& cell : row) out += fmt::format("<{0}>{1}</{0}>", tag, marked_up(cell));
  return out + "</tr>\n";
}

/// JSON that may stand inside a script element.
std::string embeddable(const Json& json) {
  std::string out;
  for (const char c : json.dump()) out += c == '<' ? std::string("\\u003c") : std::string(1, c);
  return out;
}

}  // namespace

Page::Page(std::string name, std::string title) : Page(name, std::move(title), name + "-") {}

Page::Page(std::string name, std::string title, std::string picture_prefix)
    : name_(std::move(name)),
      title_(std::move(title)),
      picture_prefix_(std::move(picture_prefix)) {}

void Page::heading(std::string text) {
  blocks_.push_back({Block::Kind::heading, std::move(text)});
}

void Page::paragraph(std::string text) {
  blocks_.push_back({Block::Kind::paragraph, std::move(text)});
}

void Page::list(std::vector<std::string> items) {
  Block block{Block::Kind::list, {}};
  block.header = std::move(items);
  blocks_.push_back(std::move(block));
}

void Page::table(std::vector<std::string> header, std::vector<std::vector<std::string>> rows) {
  Block block{Block::Kind::table, {}};
  block.header = std::move(header);
  block.rows = std::move(rows);
  blocks_.push_back(std::move(block));
}

void Page::figure(std::string name, std::string caption, Json data, Json layout) {
  Block block{Block::Kind::figure, std::move(caption)};
  block.name = std::move(name);
  block.data = std::move(data);
  block.layout = std::move(layout);
  blocks_.push_back(std::move(block));
}

void Page::targets(std::vector<Target> list) {
  std::vector<std::vector<std::string>> rows;
  auto& numbers = numbers_["targets"];
  for (auto& target : list) {
    rows.push_back({target.what, target.required, target.found, target.met ? "yes" : "**no**"});
    numbers.push_back({{"what", target.what},
                       {"required", target.required},
                       {"found", target.found},
                       {"met", target.met}});
  }
  table({"what", "required", "found", "met"}, std::move(rows));
}

std::string Page::markdown() const {
  std::string out = "# " + title_ + "\n";
  for (const Block& block : blocks_) {
    out += "\n";
    switch (block.kind) {
      case Block::Kind::heading:
        out += "## " + block.text + "\n";
        break;
      case Block::Kind::paragraph:
        out += wrapped(block.text) + "\n";
        break;
      case Block::Kind::list:
        for (const auto& item : block.header) out += wrapped("- " + item, "  ") + "\n";
        break;
      case Block::Kind::table:
        out += cells(block.header) + cells(std::vector<std::string>(block.header.size(), "---"));
        for (const auto& row : block.rows) out += cells(row);
        break;
      case Block::Kind::figure:
        out += fmt::format("![{0}]({1}{0}.svg)\n\n", block.name, picture_prefix_) +
               wrapped(block.text) + "\n";
        break;
    }
  }
  return out;
}

Json Page::figures() const {
  Json list = Json::array();
  for (const Block& block : blocks_)
    if (block.kind == Block::Kind::figure)
      list.push_back({{"name", block.name}, {"data", block.data}, {"layout", block.layout}});
  return {{"figures", list}};
}

std::string Page::html() const {
  const auto parts = report::assets();
  std::string body = "<h1>" + formats::escaped_markup(title_) + "</h1>\n";
  for (const Block& block : blocks_) {
    switch (block.kind) {
      case Block::Kind::heading:
        body += "<h2>" + marked_up(block.text) + "</h2>\n";
        break;
      case Block::Kind::paragraph:
        body += "<p>" + marked_up(block.text) + "</p>\n";
        break;
      case Block::Kind::list:
        body += "<ul>";
        for (const auto& item : block.header) body += "<li>" + marked_up(item) + "</li>";
        body += "</ul>\n";
        break;
      case Block::Kind::table:
        body += "<table>" + html_row(block.header, "th");
        for (const auto& row : block.rows) body += html_row(row, "td");
        body += "</table>\n";
        break;
      case Block::Kind::figure:
        body += fmt::format("<figure><div id=\"{}\"></div><figcaption>{}</figcaption></figure>\n",
                            block.name, marked_up(block.text));
        break;
    }
  }
  return fmt::format(
      "<!doctype html>\n<html lang=\"en\"><head><meta charset=\"utf-8\">"
      "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\"><title>{}</title>"
      "<link rel=\"icon\" href=\"data:,\"><style>{}</style></head>\n<body>\n{}"
      "<script type=\"application/json\" id=\"figures\">{}</script>\n<!--\n{}\n-->\n"
      "<script>{}</script>\n<script>{}</script>\n</body></html>\n",
      formats::escaped_markup(title_), style, body, embeddable(figures()), parts.plotly_licence,
      parts.plotly, script);
}

void Page::write(const std::filesystem::path& folder) const {
  formats::replace_file(folder / (name_ + ".md"), markdown());
  formats::replace_file(folder / "figures.json", figures().dump() + "\n");
  formats::replace_file(folder / "numbers.json", numbers_.dump(1) + "\n");
  formats::replace_file(folder / "index.html", html());
}

}  // namespace umov::study
