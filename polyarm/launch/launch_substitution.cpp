#include "polyarm/launch/launch_substitution.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "polyarm/base/text.hpp"
#include "polyarm/xacro/xacro_value.hpp"

namespace polyarm::ros_files {

namespace {
constexpr int kDeepest = 32;
constexpr std::size_t kLongest = 65536;

[[noreturn]] void refuse(std::string what, std::string advice = {}, std::string code = "bad-substitution") {
  throw Error(std::move(code), std::move(what), std::move(advice));
}

std::vector<std::string> names_of(const std::map<std::string, std::string>& args) {
  std::vector<std::string> out;
  for (const auto& [name, value] : args) out.push_back(name);
  return out;
}

std::string arg_value(const std::string& name, const Substitution& with) {
  const auto found = with.args.find(name);
  if (found != with.args.end()) return found->second;
  refuse("no arg '" + name + "' is declared before this line" + did_you_mean(name, names_of(with.args)),
         "write '<arg name=\"" + name + "\" default=\"…\"/>' above it", "unknown-arg");
}

std::string variable(const std::string& name, const std::optional<std::string>& otherwise) {
  if (const char* value = std::getenv(name.c_str())) return value;
  if (otherwise) return *otherwise;
  refuse("the environment variable '" + name + "' is not set",
         "set it, or write $(optenv " + name + " VALUE) in the file", "no-variable");
}

[[noreturn]] void missing_package(const std::string& package) {
  refuse("the ROS package '" + package + "' is not found",
         "add the folder that holds it to the package folders", "no-package");
}

std::string package_folder(const std::string& package, const Substitution& with) {
  if (with.in_command && package == "xacro") return "xacro";
  const std::filesystem::path folder = with.find ? with.find(package) : std::filesystem::path();
  if (!folder.empty()) return folder.string();
  if (with.keep_missing) return "$(find " + package + ")";
  missing_package(package);
}

// --- $(eval …) ---

using description::XacroList;
using description::XacroNames;
using description::XacroValue;

bool is_whole_text(std::string_view text) {
  return !text.empty() && text.find_first_not_of("+-0123456789") == std::string_view::npos;
}

/// The Python value of an arg: a bool, a number, or text.
XacroValue guessed(const std::string& text) {
  const std::string plain = lower(trim(text));
  if (plain == "true" || plain == "false") return plain == "true";
  const auto number = parse_number(text);
  if (!number) return text;
  if (!is_whole_text(trim(text)) || std::fabs(*number) > 9e15) return *number;
  return static_cast<std::int64_t>(*number);
}

/// The functions that roslaunch adds to Python's.
bool launch_function(const std::string& name, const XacroList& given, const Substitution& with,
                     XacroValue& out) {
  if (name == "dirname" && given.empty()) return out = with.folder.string(), true;
  static const std::vector<std::string> kOfOne = {"arg", "find", "env", "anon"};
  const bool of_one = std::find(kOfOne.begin(), kOfOne.end(), name) != kOfOne.end();
  if (of_one ? given.size() != 1 : name != "optenv" || given.empty() || given.size() > 2) return false;
  const std::string first = str_of(given.front());
  if (name == "arg") out = guessed(arg_value(first, with));
  if (name == "find") out = package_folder(first, with);
  if (name == "env") out = variable(first, {});
  if (name == "anon") out = first + "_anonymous";
  if (name == "optenv") out = variable(first, given.size() > 1 ? str_of(given[1]) : "");
  return true;
}

/// An arg by name, as a variable of the expression. Other names may be functions, modules or constants.
bool named_arg(const std::string& name, const Substitution& with, XacroValue& out) {
  const auto found = with.args.find(name);
  if (found != with.args.end()) return out = guessed(found->second), true;
  if (name != "true" && name != "false") return false;
  return out = name == "true", true;
}

std::string evaluated(std::string_view expression, const Substitution& with) {
  if (expression.find("__") != std::string_view::npos)
    refuse("two underscores are in the expression '" + std::string(expression.substr(0, 60)) +
           "', which is not allowed");
  const XacroNames names{
      [&](const std::string& name, XacroValue& out) { return named_arg(name, with, out); },
      [&](const std::string& name, const XacroList& given, XacroValue& out) {
        return launch_function(name, given, with, out);
      },
      [](const description::XacroScope*, const std::string&, XacroValue&) { return false; }};
  const XacroValue value = description::evaluate_expression(expression, names);
  if (const double* number = std::get_if<double>(&value.data); number && !std::isfinite(*number))
    refuse("the result of an expression is not a finite number");
  return std::holds_alternative<std::monostate>(value.data) ? "" : str_of(value);
}

// --- $(…) ---

std::string single(const std::string& inside, const Substitution& with) {
  const std::vector<std::string> words = split_words(inside);
  static const std::vector<std::string> kKnown = {"find", "arg", "env", "optenv", "anon", "dirname", "eval"};
  if (words.empty()) refuse("'$()' holds nothing", "write $(arg NAME) or $(find PACKAGE)");
  const std::string& name = words.front();
  if (name == "var" || name.starts_with("find-pkg") || name == "command" || name == "exec-in-pkg")
    refuse("'$(" + name + " …)' belongs to launch files of ROS 2",
           "start with: polyarm run --description FILE --controllers FILE", "ros2-launch");
  if (name == "dirname" && words.size() == 1) return with.folder.string();
  if (name == "optenv" && words.size() >= 2)
    return variable(words[1], join(std::vector(words.begin() + 2, words.end()), " "));
  if (words.size() == 2) {
    if (name == "find") return package_folder(words[1], with);
    if (name == "arg") return arg_value(words[1], with);
    if (name == "env") return variable(words[1], {});
    if (name == "anon") return words[1] + "_anonymous";
  }
  if (name == "eval")
    refuse("'$(eval …)' is not the whole value here", "let it be the whole value of the attribute");
  refuse(
      "'$(" + inside.substr(0, 60) + ")' is not understood" + did_you_mean(name, kKnown),
      "known are: $(find PACKAGE), $(arg NAME), $(env NAME), $(optenv NAME VALUE), $(anon NAME), $(dirname), "
      "$(eval EXPRESSION)");
}

std::size_t closing(std::string_view text, std::size_t from) {
  int open = 1;
  for (std::size_t at = from; at < text.size(); ++at) {
    if (text[at] == '(') ++open;
    if (text[at] == ')' && --open == 0) return at;
  }
  refuse("'" + std::string(text.substr(from - 2, 30)) + "' has no closing ')'", "close it");
}

std::string replaced(std::string_view text, const Substitution& with, int depth) {
  if (depth > kDeepest) refuse("'$(' is nested more than 32 deep");
  std::string out;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t start = std::min(text.find("$(", at), text.size());
    out += text.substr(at, start - at);
    if (start == text.size()) break;
    const std::size_t end = closing(text, start + 2);
    out += single(replaced(text.substr(start + 2, end - start - 2), with, depth + 1), with);
    if (out.size() > kLongest) refuse("a value grows beyond 65536 characters");
    at = end + 1;
  }
  return out;
}
}  // namespace

std::string evaluate_launch_expression(std::string_view expression, const Substitution& with) {
  try {
    const std::string out = evaluated(expression, with);
    if (out.size() > kLongest) refuse("an expression gives a text of more than 65536 characters");
    return out;
  } catch (const Error& error) {
    const Problem& problem = error.problems().front();
    if (problem.code != "bad-expression") throw;
    constexpr std::string_view kBegin = "the name '", kEnd = "' is not defined";
    if (problem.what.starts_with(kBegin) && problem.what.ends_with(kEnd))
      arg_value(problem.what.substr(kBegin.size(), problem.what.size() - kBegin.size() - kEnd.size()), with);
    refuse("the expression '" + std::string(trim(expression).substr(0, 200)) + "': " + problem.what,
           "expressions are those of Python; write an arg by its name or as arg('NAME')");
  }
}

std::string substitute(std::string_view text, const Substitution& with) {
  const std::string_view plain = trim(text);
  if (plain.starts_with("$(eval ") && plain.ends_with(")"))
    return evaluate_launch_expression(plain.substr(7, plain.size() - 8), with);
  return replaced(text, with, 0);
}

void refuse_missing_package(std::string_view text) {
  const std::size_t at = text.find("$(find ");
  if (at == std::string_view::npos) return;
  const std::string_view rest = text.substr(at + 7);
  missing_package(std::string(trim(rest.substr(0, rest.find(')')))));
}

bool launch_condition(const std::string& text) {
  const std::string value = lower(trim(text));
  if (value == "true" || value == "1") return true;
  if (value == "false" || value == "0") return false;
  refuse("'" + text.substr(0, 60) + "' is neither true nor false", "write true, false, 1 or 0");
}

namespace {
/// Within '…' a backslash is a normal character; within "…" it escapes only a quote and a backslash.
bool is_escape(std::string_view text, std::size_t at, char quote) {
  if (quote == '\'' || at + 1 == text.size()) return false;
  return quote == 0 || text[at + 1] == quote || text[at + 1] == '\\';
}
}  // namespace

std::vector<std::string> shell_words(std::string_view text) {
  std::vector<std::string> out;
  bool open = false;
  char quote = 0;
  for (std::size_t at = 0; at < text.size(); ++at) {
    const char c = text[at];
    const bool blank = quote == 0 && std::string_view(" \t\r\n").find(c) != std::string_view::npos;
    if (blank) {
      open = false;
      continue;
    }
    if (!open) out.emplace_back();
    open = true;
    if (quote == 0 && (c == '\'' || c == '"'))
      quote = c;
    else if (c == quote)
      quote = 0;
    else if (c == '\\' && is_escape(text, at, quote))
      out.back() += text[++at];
    else
      out.back() += c;
  }
  return out;
}

}  // namespace polyarm::ros_files
