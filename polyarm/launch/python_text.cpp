#include "polyarm/launch/python_text.hpp"

#include <algorithm>
#include <cctype>

#include "polyarm/base/text.hpp"

namespace polyarm::ros_files {

namespace python_words {
namespace {

constexpr std::size_t kLongest = 1 << 20, kMostTokens = 100'000;

bool begins_name(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) != 0 || c == '_' || (c & 0x80) != 0;
}
bool in_name(char c) {
  return begins_name(c) || std::isdigit(static_cast<unsigned char>(c)) != 0;
}

class Words {
 public:
  explicit Words(std::string_view text) : text_(text.substr(0, kLongest)) {}

  std::vector<PythonToken> read() {
    while (at_ < text_.size() && out_.size() < kMostTokens) one();
    return std::move(out_);
  }

 private:
  void one() {
    const char c = text_[at_];
    column_ = static_cast<int>(at_ - begin_);
    if (c == '#') {
      at_ = std::min(text_.find('\n', at_), text_.size());
    } else if (c == '\n') {
      ++line_;
      begin_ = ++at_;
      fresh_ = fresh_ || depth_ == 0;
    } else if (c == '\\' && at_ + 1 < text_.size() && text_[at_ + 1] == '\n') {
      ++line_;
      begin_ = at_ += 2;
    } else if (std::isspace(static_cast<unsigned char>(c)) || c == '\\') {
      ++at_;
    } else if (c == '"' || c == '\'') {
      string("");
    } else if (begins_name(c)) {
      name();
    } else if (std::isdigit(static_cast<unsigned char>(c))) {
      number();
    } else {
      sign();
    }
  }

  void add(PythonToken::Kind kind, std::string text, int line, bool formatted = false) {
    out_.push_back({kind, std::move(text), formatted, line, fresh_, column_});
    fresh_ = false;
  }

  void name() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && in_name(text_[at_])) ++at_;
    const std::string word(text_.substr(begin, at_ - begin));
    const bool quote = at_ < text_.size() && (text_[at_] == '"' || text_[at_] == '\'');
    if (quote && word.size() <= 2 && word.find_first_not_of("rRbBfFuU") == std::string::npos)
      return string(lower(word));
    add(PythonToken::Kind::name, word, line_);
  }

  void number() {
    const std::size_t begin = at_;
    while (at_ < text_.size() && (in_name(text_[at_]) || text_[at_] == '.')) ++at_;
    add(PythonToken::Kind::number, std::string(text_.substr(begin, at_ - begin)), line_);
  }

  /// Keeps == and similar together, so that they are not read as assignments.
  void sign() {
    const bool pair = at_ + 1 < text_.size() && text_[at_ + 1] == '=' &&
                      std::string_view("=!<>+-*/%:").find(text_[at_]) != std::string_view::npos;
    const std::size_t size = pair ? 2 : 1;
    if (std::string_view("([{").find(text_[at_]) != std::string_view::npos) ++depth_;
    if (std::string_view(")]}").find(text_[at_]) != std::string_view::npos) depth_ = std::max(0, depth_ - 1);
    add(PythonToken::Kind::sign, std::string(text_.substr(at_, size)), line_);
    at_ += size;
  }

  void string(const std::string& prefix) {
    const char quote = text_[at_];
    const std::string three(3, quote);
    const bool triple = text_.substr(at_, 3) == three;
    const std::string_view end = triple ? std::string_view(three) : std::string_view(three).substr(0, 1);
    const bool raw = prefix.find('r') != std::string::npos;
    const int line = line_;
    std::string out;
    for (at_ += end.size(); at_ < text_.size();) {
      if (text_.substr(at_, end.size()) == end) {
        at_ += end.size();
        return add(PythonToken::Kind::string, std::move(out), line, prefix.find('f') != std::string::npos);
      }
      if (text_[at_] == '\n') {
        if (!triple) return;  // unterminated
        ++line_;
      }
      if (text_[at_] == '\\' && !raw && at_ + 1 < text_.size()) {
        ++at_;
        if (text_[at_] == '\n') ++line_;
        if (text_[at_] != '\n') out += text_[at_] == 'n' ? '\n' : text_[at_] == 't' ? '\t' : text_[at_];
        ++at_;
        continue;
      }
      out += text_[at_++];
    }
  }

  std::string_view text_;
  std::size_t at_ = 0;
  std::size_t begin_ = 0;  ///< begin of the line
  int line_ = 1, column_ = 0, depth_ = 0;
  bool fresh_ = true;
  std::vector<PythonToken> out_;
};

}  // namespace
}  // namespace python_words

std::vector<PythonToken> python_tokens(std::string_view text) {
  return python_words::Words(text).read();
}

}  // namespace polyarm::ros_files
