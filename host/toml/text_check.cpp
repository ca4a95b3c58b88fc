#include "host/toml/text_check.hpp"

#include <cstddef>

#include "host/errors/error.hpp"

namespace umov {
namespace {

bool starts_key(char c) {
  return (c >= 'A' && c <= 'Z') || (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '_' ||
         c == '-' || c == '"' || c == '\'';
}

/// Whether a quotation mark may open a text right behind `c`, or `c` come right behind a closed
/// one.
bool may_border_string(char c) {
  return std::string_view(" \t\r\n=,.[]{}").find(c) != std::string_view::npos;
}

/// Walks over statements, knowing just enough of strings, comments and brackets to tell where the
/// next statement starts.
class Walker {
 public:
  Walker(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  void run() {
    check_characters();
    while (at_ < text_.size()) {
      skip_blanks();
      if (at_ < text_.size() && text_[at_] == '[') check_header();
      skip_statement();
    }
  }

 private:
  [[noreturn]] void fail(std::size_t at, const char* problem) const {
    std::size_t line = 1, column = 1;
    for (std::size_t i = 0; i < at && i < text_.size(); ++i) {
      ++column;
      if (text_[i] == '\n') {
        ++line;
        column = 1;
      }
    }
    throw Error(Place{file_, line, std::to_string(column)},
                std::string("not valid TOML: ") + problem, "compare with the files in examples/");
  }

  void check_characters() const {
    for (std::size_t i = 0; i < text_.size(); ++i) {
      const auto c = static_cast<unsigned char>(text_[i]);
      if ((c < 32 && c != '\t' && c != '\n' && c != '\r') || c == 127)
        fail(i, "a control character");
    }
  }

  void skip_blanks() {
    while (at_ < text_.size() && (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\r'))
      ++at_;
  }

  void check_header() const {
    std::size_t next = at_ + 1;
    if (next < text_.size() && text_[next] == '[') ++next;
    while (next < text_.size() && (text_[next] == ' ' || text_[next] == '\t')) ++next;
    if (next >= text_.size() || !starts_key(text_[next]))
      fail(next, "a table header that does not start with a name");
  }

  /// To the start of the line after the end of the statement.
  void skip_statement() {
    std::string closers;  // of the brackets that are open
    const bool header = at_ < text_.size() && text_[at_] == '[';
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (c == '"' || c == '\'') {
        if (at_ > 0 && !may_border_string(text_[at_ - 1]))
          fail(at_, "a quotation mark in the middle of a word");
        skip_string(c);
        if (at_ < text_.size() && !may_border_string(text_[at_]) && text_[at_] != '#')
          fail(at_, "something between the end of a text and the next blank or sign");
        continue;
      }
      if (static_cast<unsigned char>(c) >= 0x80)
        fail(at_, "a letter outside ASCII that is not between quotation marks");
      ++at_;
      if (c == '#') {
        while (at_ < text_.size() && text_[at_] != '\n') ++at_;
      } else if (!header && (c == '[' || c == '{')) {
        closers += c == '[' ? ']' : '}';
      } else if (!header && (c == ']' || c == '}')) {
        if (closers.empty() || closers.back() != c) fail(at_ - 1, "brackets that do not match");
        closers.pop_back();
      } else if (c == '\n' && closers.empty()) {
        return;
      }
    }
  }

  /// To the first character behind the string that starts here.
  void skip_string(char quote) {
    const std::size_t start = at_;
    const std::string fence(3, quote);
    const bool many_lines = text_.substr(at_).starts_with(fence);
    at_ += many_lines ? 3 : 1;
    while (at_ < text_.size()) {
      const char c = text_[at_];
      if (quote == '"' && c == '\\') {
        skip_escape();
      } else if (many_lines && text_.substr(at_).starts_with(fence)) {
        at_ += 3;
        // One or two quotation marks at the very end belong to the text.
        for (int extra = 0; extra < 2 && at_ < text_.size() && text_[at_] == quote; ++extra) ++at_;
        return;
      } else if (!many_lines && c == quote) {
        ++at_;
        return;
      } else if (!many_lines && c == '\n') {
        break;
      } else {
        ++at_;
      }
    }
    fail(start, "a text without its closing quotation mark");
  }

  /// Behind the escape that starts here; behind all blanks where it continues the line.
  void skip_escape() {
    const auto blank = [&] {
      return at_ < text_.size() &&
             (text_[at_] == ' ' || text_[at_] == '\t' || text_[at_] == '\r' || text_[at_] == '\n');
    };
    ++at_;
    if (!blank()) {
      if (at_ < text_.size()) ++at_;
      return;
    }
    while (blank()) ++at_;
    if (at_ < text_.size() && static_cast<unsigned char>(text_[at_]) >= 0x80)
      fail(at_, "a letter outside ASCII first on a continued line");
  }

  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0;
};

}  // namespace

void refuse_unparsable(std::string_view text, const std::string& file) {
  if (text.starts_with("\xef\xbb\xbf")) text.remove_prefix(3);
  Walker(text, file).run();
}

}  // namespace umov
