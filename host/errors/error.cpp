#include "host/errors/error.hpp"

#include <utility>

namespace umov {
namespace {

std::string compose(const Place& place, const std::string& problem, const std::string& remedy) {
  std::string text;
  if (!place.file.empty()) {
    text += place.file;
    if (place.line != 0) text += ":" + std::to_string(place.line);
    if (!place.column.empty()) text += ":" + place.column;
    text += ": ";
  }
  text += problem;
  if (!remedy.empty()) text += " (" + remedy + ")";
  return text;
}

}  // namespace

Error::Error(Place place, std::string problem, std::string remedy)
    : std::runtime_error(compose(place, problem, remedy)),
      place_(std::move(place)),
      problem_(std::move(problem)),
      remedy_(std::move(remedy)) {}

Error::Error(std::string problem, std::string remedy)
    : Error(Place{}, std::move(problem), std::move(remedy)) {}

}  // namespace umov
