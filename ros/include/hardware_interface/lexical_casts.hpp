#pragma once
/// Numbers and lists in text, whatever the locale.
#include <clocale>
#include <cstdint>
#include <cstdlib>
#include <limits>
#include <locale>
#include <optional>
#include <sstream>
#include <stdexcept>
#include <string>
#include <type_traits>
#include <vector>

#include "polyarm_ros/standard.hpp"

namespace hardware_interface {

/// The whole text as a number; throws std::invalid_argument.
inline double stod(const std::string& text) {
  if (text.empty()) throw std::invalid_argument("empty string is not a valid real number");
  std::istringstream in(text);
  in.imbue(std::locale::classic());
  double value = 0;
  in >> value;
  if (in && in.eof()) return value;
  char* end = nullptr;  // "nan", "inf" and hexadecimal numbers
  value = std::strtod(text.c_str(), &end);
  if (end == text.c_str() || *end != '\0')
    throw std::invalid_argument("'" + text + "' is not a valid real number");
  return value;
}
inline float stof(const std::string& text) {
  return static_cast<float>(hardware_interface::stod(text));
}

inline bool parse_bool(const std::string& text) {
  if (text == "true" || text == "True" || text == "TRUE" || text == "1") return true;
  if (text == "false" || text == "False" || text == "FALSE" || text == "0") return false;
  throw std::invalid_argument("'" + text + "' is not a boolean; use true or false");
}

namespace internal {
/// The elements of "[a, b, c]" without blanks and quotes; throws std::invalid_argument.
inline std::vector<std::string> elements(const std::string& text) {
  const auto begin = text.find_first_not_of(" \t\r\n"), end = text.find_last_not_of(" \t\r\n");
  if (begin == std::string::npos || text[begin] != '[' || text[end] != ']')
    throw std::invalid_argument("'" + text + "' is not a list; write [a, b]");
  std::vector<std::string> out;
  std::string word;
  const auto take = [&] {
    const auto first = word.find_first_not_of(" \t\r\n'\""), last = word.find_last_not_of(" \t\r\n'\"");
    if (first != std::string::npos) out.push_back(word.substr(first, last - first + 1));
    word.clear();
  };
  for (std::size_t i = begin + 1; i < end; ++i)
    if (text[i] == ',')
      take();
    else if (text[i] == '[' || text[i] == ']')
      throw std::invalid_argument("'" + text + "': lists in lists are not known");
    else
      word += text[i];
  take();
  return out;
}
template <typename T>
T element(const std::string& text) {
  if constexpr (std::is_same_v<T, std::string>)
    return text;
  else if constexpr (std::is_same_v<T, bool>)
    return parse_bool(text);
  else if constexpr (std::is_floating_point_v<T>)
    return static_cast<T>(hardware_interface::stod(text));
  else {
    std::size_t used = 0;
    const long long value = std::stoll(text, &used);
    if (used != text.size()) throw std::invalid_argument("'" + text + "' is not a whole number");
    return static_cast<T>(value);
  }
}
}  // namespace internal

template <typename T>
std::vector<T> parse_array(const std::string& text) {
  std::vector<T> out;
  for (const std::string& word : internal::elements(text)) out.push_back(internal::element<T>(word));
  return out;
}
inline std::vector<std::string> parse_string_array(const std::string& text) {
  return parse_array<std::string>(text);
}
inline std::vector<double> parse_double_array(const std::string& text) {
  return parse_array<double>(text);
}

inline std::string to_lower_case(std::string text) {
  for (char& c : text)
    if (c >= 'A' && c <= 'Z') c = static_cast<char>(c - 'A' + 'a');
  return text;
}

}  // namespace hardware_interface
