#include "polyarm/launch/launch_substitution.hpp"

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <optional>

#include "polyarm/base/text.hpp"

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

/// A value of the expression: text, or a number that may be whole or a truth value.
struct Value {
  enum class Kind { text, boolean, whole, real } kind = Kind::text;
  double number = 0;
  std::string text;
  bool is_number() const { return kind != Kind::text; }
};

Value of_text(std::string text) {
  return {Value::Kind::text, 0, std::move(text)};
}
Value of_truth(bool value) {
  return {Value::Kind::boolean, value ? 1.0 : 0.0, {}};
}
Value of_number(double value, bool whole) {
  if (!std::isfinite(value)) refuse("the result of an expression is not a finite number");
  return {whole ? Value::Kind::whole : Value::Kind::real, value, {}};
}
bool is_whole_text(std::string_view text) {
  return !text.empty() && text.find_first_not_of("+-0123456789") == std::string_view::npos;
}
/// What an arg is to Python: a truth value, a number, or text.
Value guessed(const std::string& text) {
  const std::string plain = lower(text);
  if (plain == "true" || plain == "false") return of_truth(plain == "true");
  if (const auto number = parse_number(text)) return of_number(*number, is_whole_text(text));
  return of_text(text);
}
bool truth(const Value& value) {
  return value.is_number() ? value.number != 0 : !value.text.empty();
}
std::string printed(const Value& value) {
  if (value.kind == Value::Kind::text) return value.text;
  if (value.kind == Value::Kind::boolean) return value.number != 0 ? "True" : "False";
  const std::string text = format_number(value.number);
  const bool plain = text.find_first_of(".e") == std::string::npos;
  return value.kind == Value::Kind::real && plain ? text + ".0" : text;
}

class Expression {
 public:
  Expression(std::string_view text, const Substitution& with) : text_(text), with_(with) {}

  std::string evaluate() {
    const Value value = choice();
    skip_blanks();
    if (at_ != text_.size()) refuse_here("is not understood");
    return printed(value);
  }

 private:
  struct Deeper {
    explicit Deeper(int& depth) : depth_(depth) {
      if (++depth_ > kDeepest) refuse("an expression is nested more than 32 deep");
    }
    ~Deeper() { --depth_; }
    int& depth_;
  };

  [[noreturn]] void refuse_here(const std::string& how) const {
    const std::string rest(text_.substr(at_, 20));
    refuse(rest.empty() ? "the expression '" + std::string(text_) + "' ends too early"
                        : "'" + rest + "' " + how + " in the expression '" + std::string(text_) + "'",
           "numbers, texts, args, comparisons, and, or, not, if-else are understood");
  }

  void skip_blanks() {
    while (at_ < text_.size() && std::string_view(" \t\r\n").find(text_[at_]) != std::string_view::npos)
      ++at_;
  }
  static bool is_letter(char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_'; }
  static bool is_digit(char c) { return c >= '0' && c <= '9'; }

  bool sign(std::string_view wanted) {
    skip_blanks();
    if (text_.substr(at_, wanted.size()) != wanted) return false;
    at_ += wanted.size();
    return true;
  }
  bool word(std::string_view wanted) {
    skip_blanks();
    const std::size_t end = at_ + wanted.size();
    if (text_.substr(at_, wanted.size()) != wanted) return false;
    if (end < text_.size() && (is_letter(text_[end]) || is_digit(text_[end]))) return false;
    at_ = end;
    return true;
  }

  Value choice() {
    const Deeper deeper(depth_);
    Value value = either();
    if (!word("if")) return value;
    const bool chosen = truth(either());
    if (!word("else")) refuse_here("stands where 'else' is expected");
    Value otherwise = choice();
    return chosen ? value : otherwise;
  }
  Value either() {
    Value left = both();
    while (word("or")) {
      Value right = both();
      if (!truth(left)) left = std::move(right);
    }
    return left;
  }
  Value both() {
    Value left = negation();
    while (word("and")) {
      Value right = negation();
      if (truth(left)) left = std::move(right);
    }
    return left;
  }
  Value negation() {
    const Deeper deeper(depth_);
    if (word("not")) return of_truth(!truth(negation()));
    return comparison();
  }

  Value comparison() {
    Value left = sum();
    for (const char* wanted : {"==", "!=", "<=", ">=", "<", ">"})
      if (sign(wanted)) return of_truth(compare(left, wanted, sum()));
    const bool not_in = word("not");
    if (!word("in")) {
      if (not_in) refuse_here("stands where 'in' is expected");
      return left;
    }
    const Value whole = sum();
    if (left.is_number() || whole.is_number()) refuse("'in' compares texts");
    return of_truth((whole.text.find(left.text) != std::string::npos) != not_in);
  }

  static bool compare(const Value& a, std::string_view sign, const Value& b) {
    if (a.is_number() != b.is_number()) {
      if (sign == "==") return false;
      if (sign == "!=") return true;
      refuse("a number and a text are compared by '" + std::string(sign) + "'");
    }
    const int order = a.is_number() ? (a.number > b.number) - (a.number < b.number) : a.text.compare(b.text);
    if (sign == "==") return order == 0;
    if (sign == "!=") return order != 0;
    if (sign == "<=") return order <= 0;
    if (sign == ">=") return order >= 0;
    return sign == "<" ? order < 0 : order > 0;
  }

  Value sum() {
    Value left = product();
    for (;;) {
      if (sign("+")) {
        const Value right = product();
        if (!left.is_number() && !right.is_number())
          left.text = limited(left.text + right.text);
        else
          left = calculate(left, '+', right);
      } else if (sign("-")) {
        left = calculate(left, '-', product());
      } else {
        return left;
      }
    }
  }

  Value product() {
    Value left = signed_value();
    for (;;) {
      if (sign("**"))
        left = calculate(left, '^', signed_value());
      else if (sign("*"))
        left = calculate(left, '*', signed_value());
      else if (sign("//"))
        left = calculate(left, 'd', signed_value());
      else if (sign("/"))
        left = calculate(left, '/', signed_value());
      else if (sign("%"))
        left = calculate(left, '%', signed_value());
      else
        return left;
    }
  }

  static Value calculate(const Value& a, char operation, const Value& b) {
    if (!a.is_number() || !b.is_number())
      refuse("a calculation needs numbers on both sides", "float(…) makes one");
    const bool whole = a.kind != Value::Kind::real && b.kind != Value::Kind::real;
    const double x = a.number, y = b.number;
    if (std::string_view("/%d").find(operation) != std::string_view::npos && y == 0)
      refuse("an expression divides by zero");
    switch (operation) {
      case '+':
        return of_number(x + y, whole);
      case '-':
        return of_number(x - y, whole);
      case '*':
        return of_number(x * y, whole);
      case '^':
        return of_number(std::pow(x, y), whole && y >= 0);
      case 'd':
        return of_number(std::floor(x / y), whole);
      case '%':
        return of_number(x - y * std::floor(x / y), whole);
      default:
        return of_number(x / y, false);
    }
  }

  Value signed_value() {
    const Deeper deeper(depth_);
    if (sign("-")) {
      const Value value = signed_value();
      if (!value.is_number()) refuse("a minus stands before a text");
      return of_number(-value.number, value.kind != Value::Kind::real);
    }
    if (sign("+")) return signed_value();
    return single();
  }

  Value single() {
    skip_blanks();
    if (at_ >= text_.size()) refuse_here("");
    if (sign("(")) {
      Value value = choice();
      if (!sign(")")) refuse_here("stands where ')' is expected");
      return value;
    }
    const char c = text_[at_];
    if (c == '\'' || c == '"') return quoted(c);
    if (is_digit(c) || c == '.') return number();
    if (is_letter(c)) return named();
    refuse_here("is not understood");
  }

  Value quoted(char quote) {
    const std::size_t end = text_.find(quote, at_ + 1);
    if (end == std::string_view::npos) refuse_here("is a text that does not end");
    const std::string inside(text_.substr(at_ + 1, end - at_ - 1));
    at_ = end + 1;
    return of_text(inside);
  }

  Value number() {
    std::size_t end = at_;
    while (end < text_.size() &&
           (is_digit(text_[end]) || text_[end] == '.' || lower(text_.substr(end, 1)) == "e" ||
            ((text_[end] == '-' || text_[end] == '+') && lower(text_.substr(end - 1, 1)) == "e")))
      ++end;
    const std::string_view written = text_.substr(at_, end - at_);
    const auto value = parse_number(written);
    if (!value) refuse_here("is no number");
    at_ = end;
    return of_number(*value, is_whole_text(written));
  }

  Value named() {
    std::size_t end = at_;
    while (end < text_.size() && (is_letter(text_[end]) || is_digit(text_[end]))) ++end;
    const std::string name(text_.substr(at_, end - at_));
    if (name.find("__") != std::string::npos) refuse_here("has two underscores, which is not allowed");
    at_ = end;
    if (sign("(")) return call(name);
    if (name == "True" || name == "true") return of_truth(true);
    if (name == "False" || name == "false") return of_truth(false);
    if (name == "None") return of_text("");
    if (name == "pi" && !with_.args.contains("pi")) return of_number(M_PI, false);
    return guessed(arg_value(name, with_));
  }

  Value call(const std::string& name) {
    std::vector<Value> given;
    while (!sign(")")) {
      if (!given.empty() && !sign(",")) refuse_here("stands where ',' or ')' is expected");
      given.push_back(choice());
    }
    if (given.size() == 1 || name == "optenv" || name == "min" || name == "max") {
      if (const auto text = ros_function(name, given)) return *text;
      if (const auto value = python_function(name, given)) return *value;
    }
    if (given.empty() && name == "dirname") return of_text(with_.folder.string());
    refuse(
        "the function '" + name + "' with " + std::to_string(given.size()) + " values is not known here",
        "known are arg, find, env, optenv, dirname, anon, int, float, str, bool, len, abs, min, max, round");
  }

  std::optional<Value> ros_function(const std::string& name, const std::vector<Value>& given) const {
    if (given.empty()) return std::nullopt;
    const std::string first = printed(given.front());
    if (name == "arg") return guessed(arg_value(first, with_));
    if (name == "find") return of_text(package_folder(first, with_));
    if (name == "env") return of_text(variable(first, {}));
    if (name == "optenv") return of_text(variable(first, given.size() > 1 ? printed(given[1]) : ""));
    if (name == "anon") return of_text(first + "_anonymous");
    return std::nullopt;
  }

  static std::optional<Value> python_function(const std::string& name, const std::vector<Value>& given) {
    if (given.empty()) return std::nullopt;
    const Value& first = given.front();
    if (name == "str") return of_text(printed(first));
    if (name == "bool") return of_truth(truth(first));
    if (name == "len" && !first.is_number()) return of_number(static_cast<double>(first.text.size()), true);
    if (name == "min" || name == "max") return extreme(given, name == "max");
    const Value value = first.is_number() ? first : guessed(first.text);
    if (!value.is_number()) return std::nullopt;
    if (name == "int") return of_number(std::trunc(value.number), true);
    if (name == "float") return of_number(value.number, false);
    if (name == "abs") return of_number(std::fabs(value.number), value.kind != Value::Kind::real);
    if (name == "round") return of_number(std::nearbyint(value.number), true);
    return std::nullopt;
  }

  static Value extreme(const std::vector<Value>& given, bool largest) {
    Value out = given.front();
    for (const Value& value : given)
      if (compare(value, largest ? ">" : "<", out)) out = value;
    return out;
  }

  static std::string limited(std::string text) {
    if (text.size() > kLongest) refuse("an expression gives a text of more than 65536 characters");
    return text;
  }

  std::string_view text_;
  const Substitution& with_;
  std::size_t at_ = 0;
  int depth_ = 0;
};

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
    refuse("'$(eval …)' does not stand alone here", "let it be the whole value of the attribute");
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
  return Expression(expression, with).evaluate();
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
    else if (c == '\\' && quote != '\'' && at + 1 < text.size())
      out.back() += text[++at];
    else
      out.back() += c;
  }
  return out;
}

}  // namespace polyarm::ros_files
