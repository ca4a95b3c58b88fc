#include "host/toml/parse.hpp"

#include "host/errors/error.hpp"
#include "host/toml/text_check.hpp"

namespace umov {

toml::table parse_toml(std::string_view text, const std::string& file, const std::string& remedy) {
  refuse_unparsable(text, file);
  try {
    return toml::parse(text, std::string_view(file));
  } catch (const toml::parse_error& error) {
    const toml::source_position at = error.source().begin;
    throw Error(Place{file, at.line, std::to_string(at.column)},
                "not valid TOML: " + std::string(error.description()), remedy);
  }
}

}  // namespace umov
