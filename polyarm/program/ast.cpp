#include "polyarm/program/ast.hpp"

#include <algorithm>

#include "polyarm/base/text.hpp"

namespace polyarm::program {

const char* spelling(Operator op) {
  static constexpr const char* kSpellings[] = {"or", "and", "not", "==", "!=", "<",   "<=", ">",
                                               ">=", "+",   "-",   "*",  "/",  "mod", "-",  "^"};
  return kSpellings[static_cast<int>(op)];
}

namespace {
void collect_names(const Expression& expression, std::vector<std::string>& out) {
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

std::string Program::source(int line) const {
  if (line < 1 || static_cast<std::size_t>(line) > lines.size()) return {};
  return std::string(trim(lines[static_cast<std::size_t>(line) - 1]));
}

}  // namespace polyarm::program
