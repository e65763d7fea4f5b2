#include "drivers/wire/xml.hpp"

#include <charconv>
#include <cmath>

namespace polyarm::wire {

namespace {

bool is_space(char c) {
  return c == ' ' || c == '\t' || c == '\r' || c == '\n';
}
bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
bool is_name(char c) {
  return is_letter(c) || (c >= '0' && c <= '9') || c == '.' || c == '-';
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && is_space(text.front())) text.remove_prefix(1);
  while (!text.empty() && is_space(text.back())) text.remove_suffix(1);
  return text;
}

template <typename Number>
std::optional<Number> number_in(std::string_view text) noexcept {
  text = trimmed(text);
  if (text.size() > 1 && text.front() == '+' && text[1] != '-') text.remove_prefix(1);
  Number value{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return value;
}

}  // namespace

/// Keeps a place in the text. Each step says whether it went well; `result` says why not.
class XmlDocument::Parser {
 public:
  Parser(XmlDocument& document, std::string_view text) : document_(document), text_(text) {}

  Result run() {
    document_.element_count_ = document_.attribute_count_ = document_.size_ = 0;
    result_ = Result::whole;
    skip_spaces();
    if (starts("<?") && !skip_declaration()) return result_;
    skip_spaces();
    if (!open_element()) return result_;
    while (depth_ > 0)
      if (!step()) return result_;
    document_.size_ = at_;
    return Result::whole;
  }

 private:
  bool fail(Result why) {
    result_ = why;
    return false;
  }
  bool ends() const { return at_ >= text_.size(); }
  bool starts(std::string_view what) const { return text_.substr(at_).starts_with(what); }
  void skip_spaces() {
    while (!ends() && is_space(text_[at_])) ++at_;
  }
  bool skip_declaration() {
    const std::size_t end = text_.find("?>", at_);
    if (end == std::string_view::npos) return fail(Result::incomplete);
    at_ = end + 2;
    return true;
  }
  bool take(char wanted) {
    if (ends()) return fail(Result::incomplete);
    if (text_[at_] != wanted) return fail(Result::bad);
    ++at_;
    return true;
  }
  bool take_name(std::string_view& name) {
    if (ends()) return fail(Result::incomplete);
    if (!is_letter(text_[at_])) return fail(Result::bad);
    const std::size_t begin = at_;
    while (!ends() && is_name(text_[at_])) ++at_;
    name = text_.substr(begin, at_ - begin);
    return ends() ? fail(Result::incomplete) : true;
  }
  bool take_attribute(Element& element) {
    Attribute one;
    if (document_.attribute_count_ == kMostAttributes) return fail(Result::bad);
    if (!take_name(one.name)) return false;
    skip_spaces();
    if (!take('=')) return false;
    skip_spaces();
    if (ends()) return fail(Result::incomplete);
    const char quote = text_[at_];
    if (quote != '"' && quote != '\'') return fail(Result::bad);
    const std::size_t end = text_.find(quote, ++at_);
    one.value = text_.substr(at_, end == std::string_view::npos ? end : end - at_);
    if (one.value.find_first_of("<&") != std::string_view::npos) return fail(Result::bad);
    if (end == std::string_view::npos) return fail(Result::incomplete);
    at_ = end + 1;
    document_.attributes_[document_.attribute_count_++] = one;
    ++element.count;
    return true;
  }
  /// At '<' of a begin tag.
  bool open_element() {
    if (!take('<')) return false;
    if (document_.element_count_ == kMostElements || depth_ == kMostDepth) return fail(Result::bad);
    const std::size_t index = document_.element_count_;
    Element& element = document_.elements_[index];
    element = {};
    element.depth = static_cast<int>(depth_);
    element.first = document_.attribute_count_;
    if (!take_name(element.name)) return false;
    ++document_.element_count_;
    for (;;) {
      const bool spaced = !ends() && is_space(text_[at_]);
      skip_spaces();
      if (ends()) return fail(Result::incomplete);
      if (text_[at_] == '/') return ++at_, take('>');
      if (text_[at_] == '>') break;
      if (!spaced) return fail(Result::bad);
      if (!take_attribute(element)) return false;
    }
    ++at_;
    open_[depth_++] = index;
    return true;
  }
  bool close_element() {
    at_ += 2;
    std::string_view name;
    if (!take_name(name)) return false;
    skip_spaces();
    if (!take('>')) return false;
    return name == document_.elements_[open_[--depth_]].name ? true : fail(Result::bad);
  }
  /// Inside an element: text, then a tag.
  bool step() {
    const std::size_t end = text_.find('<', at_);
    const std::string_view text =
        text_.substr(at_, end == std::string_view::npos ? std::string_view::npos : end - at_);
    if (text.find('&') != std::string_view::npos) return fail(Result::bad);
    if (end == std::string_view::npos || end + 1 == text_.size()) return fail(Result::incomplete);
    Element& element = document_.elements_[open_[depth_ - 1]];
    if (const std::string_view words = trimmed(text); !words.empty()) element.text = words;
    at_ = end;
    return text_[at_ + 1] == '/' ? close_element() : open_element();
  }

  XmlDocument& document_;
  std::string_view text_;
  std::size_t at_ = 0, depth_ = 0;
  std::array<std::size_t, kMostDepth> open_{};
  Result result_ = Result::whole;
};

XmlDocument::Result XmlDocument::read(std::string_view text) noexcept {
  const Result result = Parser(*this, text).run();
  if (result != Result::whole) element_count_ = attribute_count_ = size_ = 0;
  return result;
}

const XmlDocument::Element* XmlDocument::find(std::string_view name) const noexcept {
  for (std::size_t i = 1; i < element_count_; ++i)
    if (elements_[i].name == name) return &elements_[i];
  return nullptr;
}

std::optional<std::string_view> XmlDocument::attribute(const Element& element,
                                                       std::string_view name) const noexcept {
  for (std::size_t i = element.first; i < element.first + element.count; ++i)
    if (attributes_[i].name == name) return attributes_[i].value;
  return std::nullopt;
}

std::optional<double> XmlDocument::number(const Element& element, std::string_view name) const noexcept {
  const auto text = attribute(element, name);
  return text ? xml_number(*text) : std::nullopt;
}

std::optional<std::int64_t> XmlDocument::integer(const Element& element,
                                                 std::string_view name) const noexcept {
  const auto text = attribute(element, name);
  return text ? xml_integer(*text) : std::nullopt;
}

std::optional<double> xml_number(std::string_view text) noexcept {
  const auto value = number_in<double>(text);
  return value && std::isfinite(*value) ? value : std::nullopt;
}

std::optional<std::int64_t> xml_integer(std::string_view text) noexcept {
  return number_in<std::int64_t>(text);
}

std::string xml_text(std::string_view text) {
  std::string out(text);
  for (char& c : out)
    if (c == '<' || c == '>' || c == '&' || c == '"' || c == '\'' || static_cast<unsigned char>(c) < ' ')
      c = ' ';
  return out;
}

}  // namespace polyarm::wire
