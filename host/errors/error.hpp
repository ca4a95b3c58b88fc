// The one error type of the host: what is wrong, where, and what to do about it.
#pragma once

#include <cstddef>
#include <stdexcept>
#include <string>
#include <string_view>

namespace umov {

/// Where an error was found. Empty or zero members are left out of the message.
struct Place {
  std::string file;        ///< file path, device name or message name
  std::size_t line = 0;    ///< 1-based, 0 = unknown
  std::string column = {}; ///< column name or 1-based number
};

/// Thrown by all host code for conditions a user can meet.
/// `what()` reads "file:line:column: problem (remedy)", one line, no trailing newline.
class Error : public std::runtime_error {
 public:
  Error(Place place, std::string problem, std::string remedy);
  Error(std::string problem, std::string remedy);

  const Place& place() const { return place_; }
  const std::string& problem() const { return problem_; }
  const std::string& remedy() const { return remedy_; }

 private:
  Place place_;
  std::string problem_;
  std::string remedy_;
};

}  // namespace umov
