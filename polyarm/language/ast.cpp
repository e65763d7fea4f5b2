#include "polyarm/language/ast.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>

#include "polyarm/base/text.hpp"

namespace polyarm::program {

const char* spelling(Operator op) {
  static constexpr const char* kSpellings[] = {"or", "and", "not", "==", "!=", "<",   "<=", ">",
                                               ">=", "+",   "-",   "*",  "/",  "mod", "-",  "^"};
  return kSpellings[static_cast<int>(op)];
}

bool is_comparison(Operator op) {
  return op >= Operator::equal && op <= Operator::greater_equal;
}

const char* spelling(Clause::Kind kind) {
  static constexpr const char* kSpellings[] = {"robot",  "tool",   "frame", "payload", "near",
                                               "around", "speed",  "accel", "blend",   "duration",
                                               "exact",  "smooth", "touch", "until", "at"};
  return kSpellings[static_cast<int>(kind)];
}

static constexpr const char* kMotions[] = {"moveto", "movej",  "movel", "movec",
                                           "speedj", "speedl", "drive", "turn"};

const char* spelling(Statement::Motion motion) {
  return kMotions[static_cast<int>(motion)];
}

std::optional<Statement::Motion> motion_of(std::string_view word) {
  const auto at = std::find(std::begin(kMotions), std::end(kMotions), word);
  if (at == std::end(kMotions)) return std::nullopt;
  return static_cast<Statement::Motion>(at - std::begin(kMotions));
}

namespace {
/// Four digits of a number suffice to find it in the program.
std::string short_text(const Value& value) {
  const data::Number* number = value.as_number();
  if (!number || number->value == 0) return value.text();
  const double scale = std::pow(10, 3 - std::floor(std::log10(std::abs(number->value))));
  const double rounded = std::round(number->value * scale) / scale;
  return std::isfinite(rounded) ? Value(data::Number{rounded, number->dimension}).text() : value.text();
}
}  // namespace

bool has_value(Clause::Kind kind) {
  return kind != Clause::Kind::exact && kind != Clause::Kind::smooth && kind != Clause::Kind::touch;
}

std::string spelled(const Expression& expression) {
  using Kind = Expression::Kind;
  switch (expression.kind) {
    case Kind::name:
      return expression.name;
    case Kind::call: {
      const std::size_t count = expression.parts.size();
      const std::string first = count ? spelled(*expression.parts.front()) : "";
      return expression.name + "(" + first + (count > 1 ? ", …)" : ")");
    }
    case Kind::index:
      return spelled(*expression.parts[0]) + "[" + spelled(*expression.parts[1]) + "]";
    case Kind::field:
      return spelled(*expression.parts[0]) + "." + expression.name;
    case Kind::literal:
      return short_text(expression.value);
    case Kind::binary:
      return spelled(*expression.parts[0]) + " " + spelling(expression.op) + " " +
             spelled(*expression.parts[1]);
    default:
      return "…";
  }
}

namespace {
void collect_names(const Expression& expression, std::vector<std::string>& out) {
  if (expression.kind == Expression::Kind::each) {  // it does not read its own names
    std::vector<std::string> inside;
    for (const ExpressionPtr& part : expression.parts) collect_names(*part, inside);
    const auto own = [&](const std::string& name) {
      const std::string first = name.substr(0, name.find('.'));
      return first == expression.name || (!expression.names.empty() && first == expression.names.front());
    };
    for (std::string& name : inside)
      if (!own(name) && std::find(out.begin(), out.end(), name) == out.end()) out.push_back(std::move(name));
    return;
  }
  if (expression.kind == Expression::Kind::name &&
      std::find(out.begin(), out.end(), expression.name) == out.end())
    out.push_back(expression.name);
  for (const ExpressionPtr& part : expression.parts) collect_names(*part, out);
}
}  // namespace

std::vector<std::string> names_read(const Expression& expression) {
  std::vector<std::string> out;
  collect_names(expression, out);
  return out;
}

Location Program::at(Place place) const {
  return {file_of(place), place.line, place.column};
}

const std::string& Program::file_of(Place place) const {
  const auto index = static_cast<std::size_t>(place.file);
  return index == 0 || index > included.size() ? file : included[index - 1].file;
}

std::string_view Program::line_of(Place place) const {
  const auto index = static_cast<std::size_t>(place.file);
  const auto& text = index == 0 || index > included.size() ? lines : included[index - 1].lines;
  const auto line = static_cast<std::size_t>(place.line);
  return place.line < 1 || line > text.size() ? std::string_view{} : trim(text[line - 1]);
}

namespace {
void find_loads(const Block& block, std::vector<const Statement*>& out) {
  for (const Statement& s : block) {
    const bool known =
        std::any_of(out.begin(), out.end(), [&](const Statement* other) { return other->name == s.name; });
    if ((s.kind == Statement::Kind::load || s.kind == Statement::Kind::import) && !known) out.push_back(&s);
    find_loads(s.body, out);
    find_loads(s.handler, out);
    for (const Branch& branch : s.branches) find_loads(branch.body, out);
  }
}
}  // namespace

std::vector<const Statement*> loads(const Program& program) {
  std::vector<const Statement*> out;
  find_loads(program.statements, out);
  return out;
}

std::vector<const Statement*> tests(const Program& program) {
  std::vector<const Statement*> out;
  for (const Statement& s : program.statements)
    if (s.kind == Statement::Kind::test) out.push_back(&s);
  return out;
}

}  // namespace polyarm::program
