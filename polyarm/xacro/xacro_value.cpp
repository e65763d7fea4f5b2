#include "polyarm/xacro/xacro_value.hpp"

#include <charconv>
#include <cmath>

#include "polyarm/base/text.hpp"
#include "polyarm/xacro/xacro_work.hpp"

namespace polyarm::description {

std::string float_text(double value) {
  if (std::isnan(value)) return "nan";
  if (std::isinf(value)) return value > 0 ? "inf" : "-inf";
  char buffer[40];
  const auto end = std::to_chars(buffer, buffer + sizeof buffer, value, std::chars_format::scientific).ptr;
  std::string text(buffer, end);
  const auto e = text.find('e');
  const int exponent = std::stoi(text.substr(e + 1));
  std::string sign = text[0] == '-' ? "-" : "", digits;
  for (const char c : text.substr(0, e))
    if (c >= '0' && c <= '9') digits += c;
  if (exponent < -4 || exponent >= 16) {
    std::string out = sign + digits.substr(0, 1);
    if (digits.size() > 1) out += "." + digits.substr(1);
    return out + (exponent < 0 ? "e-" : "e+") + (std::abs(exponent) < 10 ? "0" : "") +
           std::to_string(std::abs(exponent));
  }
  if (exponent < 0) return sign + "0." + std::string(static_cast<std::size_t>(-exponent - 1), '0') + digits;
  const auto whole = static_cast<std::size_t>(exponent) + 1;
  if (digits.size() <= whole) return sign + digits + std::string(whole - digits.size(), '0') + ".0";
  return sign + digits.substr(0, whole) + "." + digits.substr(whole);
}

std::string repr_of(const XacroValue& value) {
  if (const std::string* text = value.text()) {
    spend(text->size() / 8);
    const char quote =
        text->find('\'') != std::string::npos && text->find('"') == std::string::npos ? '"' : '\'';
    std::string out(1, quote);
    for (const char c : *text) {
      if (c == quote || c == '\\') out += '\\';
      if (c == '\n')
        out += "\\n";
      else
        out += c;
    }
    return out + quote;
  }
  return str_of(value);
}

std::string str_of(const XacroValue& value) {
  if (const std::string* text = value.text()) return spend(text->size() / 64), *text;
  spend(10);
  if (const auto* flag = std::get_if<bool>(&value.data)) return *flag ? "True" : "False";
  if (const auto* whole = std::get_if<std::int64_t>(&value.data)) return std::to_string(*whole);
  if (const auto* number = std::get_if<double>(&value.data)) return float_text(*number);
  std::string out;
  if (const XacroList* list = value.list()) {
    for (const XacroValue& item : *list) out += (out.empty() ? "" : ", ") + repr_of(item);
    if (list->is_tuple) return "(" + out + (list->size() == 1 ? ",)" : ")");
    return "[" + out + "]";
  }
  if (const XacroDict* dict = value.dict()) {
    for (const auto& [key, item] : *dict)
      out += (out.empty() ? "" : ", ") + repr_of(key) + ": " + repr_of(item);
    return "{" + out + "}";
  }
  if (const auto* function = std::get_if<XacroFunction>(&value.data)) return "<" + function->name + ">";
  return "None";
}

XacroValue copy_of(const XacroValue& value) {
  spend(1);
  if (const XacroList* list = value.list()) {
    auto out = std::make_shared<XacroList>(*list);
    for (XacroValue& item : *out) item = copy_of(item);
    return out;
  }
  if (const XacroDict* dict = value.dict()) {
    auto out = std::make_shared<XacroDict>();
    for (const auto& [key, item] : *dict) out->emplace_back(key, copy_of(item));
    return out;
  }
  return value;
}

bool truth_of(const XacroValue& value) {
  if (const std::string* text = value.text()) return !text->empty();
  if (const auto* flag = std::get_if<bool>(&value.data)) return *flag;
  if (const auto* whole = std::get_if<std::int64_t>(&value.data)) return *whole != 0;
  if (const auto* number = std::get_if<double>(&value.data)) return *number != 0;
  if (const XacroList* list = value.list()) return !list->empty();
  if (const XacroDict* dict = value.dict()) return !dict->empty();
  return !std::holds_alternative<std::monostate>(value.data);
}

XacroValue literal_of(const XacroValue& value) {
  const std::string* text = value.text();
  if (!text) return value;
  if (text->size() >= 2 && text->front() == '\'' && text->back() == '\'')
    return text->substr(1, text->size() - 2);
  const std::string word(trim(*text));
  if (word.empty() || word.find('_') != std::string::npos) return value;
  if (word == "true" || word == "True") return true;
  if (word == "false" || word == "False") return false;
  const bool plus = word[0] == '+' && word.size() > 1 && word[1] != '-';
  const char* begin = word.data() + (plus ? 1 : 0);
  const char* end = word.data() + word.size();
  std::int64_t whole = 0;
  const auto read = std::from_chars(begin, end, whole);
  if (read.ptr == end)
    return read.ec == std::errc() ? XacroValue(whole) : value;  // too large for an integer: unchanged
  double number = 0;
  if (const auto real = std::from_chars(begin, end, number); real.ec == std::errc() && real.ptr == end)
    return number;
  return value;
}

}  // namespace polyarm::description
