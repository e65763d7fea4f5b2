#include "polyarm/xacro/xacro_yaml.hpp"

#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <charconv>
#include <limits>
#include <map>
#include <numbers>
#include <optional>

#include "polyarm/base/error.hpp"
#include "polyarm/xacro/xacro_functions.hpp"
#include "polyarm/xacro/xacro_work.hpp"

namespace polyarm::description {

namespace {

constexpr int kDeepestYaml = 60;
constexpr std::size_t kMostNodes = 1'000'000;

const std::map<std::string, double>& units() {
  static const std::map<std::string, double> table = {{"!radians", 1},   {"!degrees", std::numbers::pi / 180},
                                                      {"!meters", 1},    {"!millimeters", 1e-3},
                                                      {"!foot", 0.3048}, {"!inches", 0.0254}};
  return table;
}

bool one_of(const std::string& word, std::initializer_list<const char*> words) {
  return std::any_of(words.begin(), words.end(), [&](const char* other) { return word == other; });
}

/// "1_000", "-0x1F", "0b101", "017" (octal); empty if the word is not an integer of YAML 1.1.
std::optional<XacroValue> whole_number(std::string word) {
  std::erase(word, '_');
  const bool minus = word.starts_with('-');
  if (minus || word.starts_with('+')) word.erase(0, 1);
  int base = 10;
  if (word.starts_with("0x") || word.starts_with("0b")) {
    base = word[1] == 'x' ? 16 : 2;
    word.erase(0, 2);
  } else if (word.size() > 1 && word[0] == '0') {
    base = 8;
  }
  std::uint64_t size = 0;
  const char* end = word.data() + word.size();
  const auto read = std::from_chars(word.data(), end, size, base);
  if (read.ec != std::errc() || read.ptr != end || size > std::numeric_limits<std::int64_t>::max())
    return std::nullopt;
  return static_cast<std::int64_t>(size) * (minus ? -1 : 1);
}

/// "1.5", ".5", "1.", "1.0e+5": requires a '.', and a sign in the exponent.
std::optional<XacroValue> real_number(std::string word) {
  if (one_of(word, {".inf", ".Inf", ".INF", "+.inf", "+.Inf", "+.INF"}))
    return std::numeric_limits<double>::infinity();
  if (one_of(word, {"-.inf", "-.Inf", "-.INF"})) return -std::numeric_limits<double>::infinity();
  if (one_of(word, {".nan", ".NaN", ".NAN"})) return std::numeric_limits<double>::quiet_NaN();
  std::erase(word, '_');
  const auto e = word.find_first_of("eE");
  if (word.find('.') == std::string::npos || word.find_first_not_of("+-.0123456789eE") != std::string::npos)
    return std::nullopt;
  if (e != std::string::npos && word.find_first_of("+-", e) != e + 1) return std::nullopt;
  double number = 0;
  const char* begin = word.data() + (word[0] == '+' ? 1 : 0);
  const char* end = word.data() + word.size();
  const auto read = std::from_chars(begin, end, number);
  if (read.ec != std::errc() || read.ptr != end) return std::nullopt;
  return number;
}

XacroValue plain_word(const std::string& word) {
  if (one_of(word, {"", "~", "null", "Null", "NULL"})) return {};
  if (one_of(word, {"true", "True", "TRUE", "yes", "Yes", "YES", "on", "On", "ON"})) return true;
  if (one_of(word, {"false", "False", "FALSE", "no", "No", "NO", "off", "Off", "OFF"})) return false;
  if (const auto number = whole_number(word)) return *number;
  if (const auto number = real_number(word)) return *number;
  return word;
}

class Reader {
 public:
  explicit Reader(const std::function<XacroValue(const std::string&)>& evaluate) : evaluate_(evaluate) {}

  XacroValue value(const YAML::Node& node, int depth = 0) {
    if (depth > kDeepestYaml || ++nodes_ > kMostNodes)
      throw Error("yaml-syntax", "the YAML file is nested too deeply");
    spend(node.IsScalar() ? 10 + node.Scalar().size() / 16 : 10);
    if (node.IsMap()) return map(node, depth);
    if (!node.IsSequence()) return scalar(node);
    auto out = std::make_shared<XacroList>();
    for (const auto& item : node) out->push_back(value(item, depth + 1));
    return out;
  }

 private:
  XacroValue map(const YAML::Node& node, int depth) {
    auto out = std::make_shared<XacroDict>();
    std::map<std::string, std::size_t> places;
    const auto set = [&](const XacroValue& key, XacroValue item) {
      const auto [place, fresh] = places.emplace(repr_of(key), out->size());
      if (fresh)
        out->emplace_back(key, std::move(item));
      else
        (*out)[place->second].second = std::move(item);
    };
    const auto take_over = [&](const YAML::Node& other) {
      const XacroValue taken = value(other, depth + 1);
      if (!taken.dict()) throw Error("yaml-syntax", "'<<' takes over maps only");
      for (const auto& [key, item] : *taken.dict()) set(key, item);
    };
    for (const auto& pair : node) {
      if (!is_merge(pair.first)) continue;
      if (!pair.second.IsSequence()) take_over(pair.second);
      for (std::size_t i = pair.second.IsSequence() ? pair.second.size() : 0; i > 0; --i)
        take_over(pair.second[i - 1]);  // the first map has priority
    }
    for (const auto& pair : node)
      if (!is_merge(pair.first)) set(scalar(pair.first), value(pair.second, depth + 1));
    return out;
  }

  static bool is_merge(const YAML::Node& key) {
    return key.IsScalar() && key.Tag() == "?" && key.Scalar() == "<<";
  }

  XacroValue scalar(const YAML::Node& node) const {
    if (!node.IsScalar()) return {};
    const std::string text = node.Scalar();
    if (const auto unit = units().find(node.Tag()); unit != units().end()) try {
        return number_of(evaluate_(text)) * unit->second;
      } catch (const Error& e) {
        const Problem& problem = e.problems().front();
        throw Error(Problem{problem.code, {"", node.Mark().line + 1}, problem.what, problem.advice});
      }
    if (node.Tag() == "!" || node.Tag() == "tag:yaml.org,2002:str") return text;  // quoted, or tagged as text
    return plain_word(text);
  }

  const std::function<XacroValue(const std::string&)>& evaluate_;
  std::size_t nodes_ = 0;
};

}  // namespace

XacroValue read_yaml(const std::string& text, const std::string& file,
                     const std::function<XacroValue(const std::string&)>& evaluate) {
  try {
    return Reader(evaluate).value(YAML::Load(text));
  } catch (const YAML::Exception& e) {
    throw Error(Problem{"yaml-syntax", {file, e.mark.line + 1}, "not valid YAML: " + e.msg, {}});
  } catch (const Error& e) {
    const Problem& problem = e.problems().front();
    throw Error(Problem{problem.code, {file, problem.where.line}, problem.what, problem.advice});
  }
}

}  // namespace polyarm::description
