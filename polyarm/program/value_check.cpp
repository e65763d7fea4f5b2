/// Finds errors that would end a run, for values known before: literals, and names that one `let` creates and
/// nothing changes. Other values are left to the run.
#include <cmath>
#include <functional>
#include <map>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/language/compliance.hpp"
#include "polyarm/language/functions.hpp"
#include "polyarm/language/operators.hpp"
#include "polyarm/program/code.hpp"
#include "polyarm/program/percent.hpp"
#include "polyarm/program/scope.hpp"

namespace polyarm::program {

namespace {
using Statements = Statement::Kind;
using data::Number;

class ValueCheck {
 public:
  ValueCheck(const Program& program, Scope& scope) : program_{program}, scope_{scope} {}

  void run() {
    for (const Problem& problem : scope_.problems().list())
      if (problem.severity == Severity::error) announced_.insert({problem.where.file, problem.where.line});
    collect_names();
    block(program_.statements);
  }

 private:
  /// A name that one `let` creates and no line changes has the value of that `let`.
  void collect_names() {
    std::set<std::string> changed;
    std::map<std::string, int> made;
    for_each_statement(program_.statements, [&](const Statement& s) {
      const std::string first = s.name.substr(0, s.name.find('.'));
      if (s.kind == Statements::let && s.expression) {
        ++made[s.name];
        lets_[s.name] = &s;
      } else if (s.kind == Statements::set || s.kind == Statements::set_literal ||
                 s.kind == Statements::for_loop || s.kind == Statements::try_block) {
        changed.insert(first);
      }
      changed.insert(s.second_name);
      for (const Parameter& parameter : s.parameters) changed.insert(parameter.name);
      for (const Clause& clause : s.clauses) changed.insert(clause.target.substr(0, clause.target.find('.')));
    });
    std::erase_if(lets_, [&](const auto& each) {
      return changed.contains(each.first) || made[each.first] > 1 || scope_.names.contains(each.first);
    });
  }

  // Values.

  using Known = std::optional<Value>;

  /// Empty if it is unknown; a failing computation is reported at its place.
  Known fold(const Expression& e) {
    try {
      Known out = folded(e);
      constexpr std::size_t kLargest = 1000;
      if (out && (out->extent().values > kLargest || (out->as_text() && out->as_text()->size() > kLargest)))
        return std::nullopt;
      return out;
    } catch (const OperationError& error) {
      report(e.place, error.code, error.what, error.advice);
      return std::nullopt;
    }
  }

  Known folded(const Expression& e) {
    using Kinds = Expression::Kind;
    switch (e.kind) {
      case Kinds::literal:
        return e.value;
      case Kinds::name:
        return known(e.name);
      case Kinds::binary:
        return binary(e);
      case Kinds::call:
        return call(e);
      case Kinds::each:  // its value depends on the loop
        for (std::size_t i = 1; i < e.parts.size(); ++i) fold(*e.parts[i]);
        return std::nullopt;
      default:
        break;
    }
    std::vector<Value> parts;
    bool all = true;
    for (const ExpressionPtr& part : e.parts)
      if (Known value = fold(*part))
        parts.push_back(std::move(*value));
      else
        all = false;
    if (!all) return std::nullopt;
    if (e.kind == Kinds::unary) return apply(e.op, parts[0]);
    if (e.kind == Kinds::index) return element(parts[0], parts[1]);
    if (e.kind == Kinds::field) return field(parts[0], e.name);
    if (e.kind == Kinds::list) return make_list(data::List(parts.begin(), parts.end()));
    if (e.kind == Kinds::record) return make_record({e.names, parts});
    return std::nullopt;
  }

  /// With dots: "box.size.x".
  Known known(const std::string& name) {
    const auto at = lets_.find(name);
    if (at == lets_.end()) {
      const auto dot = name.rfind('.');
      const Known whole = dot == std::string::npos ? Known{} : known(name.substr(0, dot));
      return whole ? Known(field(*whole, name.substr(dot + 1))) : Known{};
    }
    const auto [value, made] = values_.try_emplace(name);
    if (made) {
      ++quiet_;  // its own line reports its faults
      Known found = fold(*at->second->expression);
      --quiet_;
      values_[name] = std::move(found);
    }
    return values_[name];
  }

  /// The right side of `and` and `or` is ignored if the left side decides.
  Known binary(const Expression& e) {
    const Known left = fold(*e.parts[0]);
    const bool* truth = left ? left->as_boolean() : nullptr;
    const bool logical = e.op == Operator::logical_and || e.op == Operator::logical_or;
    if (logical && truth && *truth == (e.op == Operator::logical_or)) return left;
    if (logical && !truth) {  // it may protect the other side
      ++quiet_;
      fold(*e.parts[1]);
      --quiet_;
      return std::nullopt;
    }
    const Known right = fold(*e.parts[1]);
    const Number* divisor = right ? right->as_number() : nullptr;
    const bool divides = e.op == Operator::divide || e.op == Operator::modulo;
    if (!left && divides && divisor && divisor->value == 0)
      throw OperationError{"zero", std::string("'") + spelling(e.op) + "' by zero", {}};
    if (!left || !right) return std::nullopt;
    return apply(e.op, *left, *right);
  }

  Known call(const Expression& e) {
    std::vector<Known> arguments;
    for (const ExpressionPtr& part : e.parts) arguments.push_back(fold(*part));
    const Function* function = scope_.function(e.name) ? nullptr : find_function(e.name);
    if (!function || function->name == "here" || function->name == "ask") return std::nullopt;
    if (!function->call && function->live != Live::comply) return std::nullopt;
    const std::optional<std::vector<Value>> values = values_of(e, *function, arguments);
    if (!values) return std::nullopt;
    for (std::size_t i = 0; i < values->size(); ++i) require(*function, i, (*values)[i]);
    if (function->call) return function->call(*values, e.names);
    compliance(e, *values);
    return std::nullopt;
  }

  /// The arguments in the order of the parameters; empty if one is unknown.
  std::optional<std::vector<Value>> values_of(const Expression& e, const Function& function,
                                              const std::vector<Known>& arguments) {
    Bound bound;
    try {
      bound = bind_arguments(signature_of(function), e.names);
    } catch (const OperationError&) {  // reported by the type check
      return std::nullopt;
    }
    std::vector<Value> values;
    for (std::size_t i = 0; i < bound.argument_of.size(); ++i) {
      const FunctionParameter& parameter = function.parameters[i];
      const int at = bound.argument_of[i];
      if (at >= 0 && !arguments[static_cast<std::size_t>(at)]) return std::nullopt;
      const Dimension dimension = parameter.wanted == Wanted::length  ? Dimension::length
                                  : parameter.wanted == Wanted::angle ? Dimension::angle
                                                                      : Dimension::none;
      values.push_back(at >= 0 ? *arguments[static_cast<std::size_t>(at)]
                               : Value(Number{*parameter.otherwise, dimension}));
    }
    for (const int at : bound.further) {
      if (!arguments[static_cast<std::size_t>(at)]) return std::nullopt;
      values.push_back(*arguments[static_cast<std::size_t>(at)]);
    }
    return values;
  }

  /// Arguments that no run can use are a mistake of the program, also inside a `try`.
  void compliance(const Expression& e, const std::vector<Value>& values) {
    const int tries = std::exchange(tries_, 0);
    try {
      compliance_of(values);
    } catch (const OperationError& error) {
      report(e.place, error.code, error.what, error.advice);
    }
    tries_ = tries;
  }

  // Statements.

  static bool leaves(const Statement& s) {
    return s.kind == Statements::stop || s.kind == Statements::break_loop ||
           s.kind == Statements::continue_loop || s.kind == Statements::return_value ||
           s.kind == Statements::raise;
  }
  static bool is_separate(const Statement& s) {
    return s.kind == Statements::function || s.kind == Statements::task || s.kind == Statements::on_stop ||
           s.kind == Statements::test;
  }

  void block(const Block& statements) {
    bool left = false;
    for (const Statement& s : statements) {
      if (!left || is_separate(s)) statement(s);
      left = left || leaves(s);
    }
  }

  std::optional<bool> truth_of(const ExpressionPtr& e) {
    const Known value = e ? fold(*e) : Known{};
    return value && value->as_boolean() ? std::optional(*value->as_boolean()) : std::nullopt;
  }

  void statement(const Statement& s) {
    switch (s.kind) {
      case Statements::branch:
        return branches(s);
      case Statements::while_loop:
        if (truth_of(s.expression) != false) block(s.body);
        return;
      case Statements::try_block:
        ++tries_;  // errors in there are caught
        block(s.body);
        --tries_;
        return block(s.handler);
      case Statements::for_loop:
        range(s);
        return block(s.body);
      default:
        break;
    }
    for_each_expression(s, [&](const Expression& e) {
      const Known value = fold(e);
      if (!value) return;
      if (&e == s.expression.get() && (s.kind == Statements::wait_time || s.kind == Statements::wait ||
                                       s.kind == Statements::every || s.kind == Statements::pulse))
        time(e, *value, s.kind == Statements::every);
      const bool timeout = s.kind == Statements::wait || s.kind == Statements::meet ||
                           s.kind == Statements::lock || s.kind == Statements::expect;
      if (&e == s.second.get() && timeout) time(e, *value);
      for (const Clause& clause : s.clauses)
        if (&e == clause.value.get()) quantity(clause, *value);
    });
    block(s.body);
    for (const Clause& clause : s.clauses) block(clause.otherwise);
  }

  void branches(const Statement& s) {
    for (const Branch& branch : s.branches) {
      const std::optional<bool> truth = branch.condition ? truth_of(branch.condition) : true;
      if (truth != false) block(branch.body);
      if (truth == true) return;
    }
  }

  void range(const Statement& s) {
    const Known first = s.expression ? fold(*s.expression) : Known{},
                last = s.second ? fold(*s.second) : Known{};
    const Number *from = first ? first->as_number() : nullptr, *to = last ? last->as_number() : nullptr;
    constexpr double kLargest = 1e15;  // as in the interpreter
    for (const Number* end : {from, to})
      if (s.second && end && std::abs(end->value) > kLargest)
        return report(s.second->place, "bad-type", "this range is too large to count");
    if (!from || !to) return;
    if (from->dimension != to->dimension)
      return report(s.second->place, "bad-type",
                    "a range goes from one number to another of the same unit, here are " +
                        described(*first) + " and " + described(*last));
    const auto whole = [](const Number& n) { return n.value == std::floor(n.value); };
    if (from->dimension != Dimension::none && !(whole(*from) && whole(*to)) && !is_quiet())
      scope_.warning("range-step", s.second->place,
                     std::string("this range counts in steps of 1") + data::unit_text(from->dimension),
                     "count without a unit and multiply, such as for i in 0 .. 5, and i * 10mm");
    const bool written =
        s.expression->kind == Expression::Kind::literal && s.second->kind == Expression::Kind::literal;
    if (written && to->value < from->value && !is_quiet())
      scope_.warning("empty-range", s.second->place,
                     "this range is empty, since " + last->text() + " is below " + first->text() +
                         ": the lines of the loop are never reached",
                     "a range counts upwards; count from the end with another name: let i = N + 1 - k");
  }

  void time(const Expression& e, const Value& value, bool above_zero = false) {
    const Number* number = value.as_number();
    if (number && above_zero && number->value == 0)
      return report(e.place, "bad-value", "this time must be above 0, here is " + value.text());
    if (number && number->value < 0)
      report(e.place, "bad-value", "a time cannot be negative: " + value.text());
  }

  void quantity(const Clause& clause, const Value& value) {
    using Kinds = Clause::Kind;
    const Number* n = value.as_number();
    const bool counts = clause.kind == Kinds::speed || clause.kind == Kinds::accel ||
                        clause.kind == Kinds::payload || clause.kind == Kinds::blend ||
                        clause.kind == Kinds::duration;
    if (!counts || !n) return;
    const std::string word = std::string("'") + spelling(clause.kind) + "'";
    const bool may_be_zero = clause.kind == Kinds::blend || clause.kind == Kinds::payload;
    if (n->value < 0 || (n->value == 0 && !may_be_zero))
      return report(clause.value->place, "bad-type", word + " must be above 0, here is " + value.text());
    const bool share = clause.kind == Kinds::speed || clause.kind == Kinds::accel;
    if (share && n->dimension == Dimension::none && n->value > 1)
      report(clause.value->place, "bad-value",
             word + " as a percentage is at most 100%, here it is " + percent(n->value),
             clause.kind == Kinds::speed ? "with a unit write such as 500mm/s, 30deg/s or 50%"
                                         : "with a unit write such as 2m/s2, 200deg/s2 or 50%");
  }

  bool is_quiet() const { return quiet_ > 0 || tries_ > 0; }

  /// Once for each line; lines with type errors are reported elsewhere.
  void report(Place place, const std::string& code, const std::string& what, const std::string& advice = {}) {
    const Location where = program_.at(place);
    if (is_quiet() || !announced_.insert({where.file, where.line}).second) return;
    scope_.error(code, place, what, advice);
  }

  const Program& program_;
  Scope& scope_;
  std::map<std::string, const Statement*> lets_;
  std::map<std::string, Known> values_;
  std::set<std::pair<std::string, int>> announced_;  ///< lines with an error
  int quiet_ = 0;                               ///< above 0: nothing is reported
  int tries_ = 0;  ///< `try` blocks around: the rehearsal reports what fails there
};

/// Functions that call themselves or each other for any values.
class RecursionCheck {
 public:
  explicit RecursionCheck(Scope& scope) : scope_{scope} {}

  void run() {
    find_ends();
    for (const Statement* function : scope_.functions) sure_calls(function->body, calls_[function->name]);
    for (const Statement* function : scope_.functions) {
      std::set<std::string> seen;
      std::vector<std::string> way;
      if (!comes_back(function->name, function->name, seen, way)) continue;
      const Place place = calls_[function->name].at(way.front());
      std::string through;
      for (std::size_t i = 0; i + 1 < way.size(); ++i) through += (i ? ", '" : " through '") + way[i] + "'";
      scope_.error("endless-recursion", place,
                   "'" + function->name + "' always calls itself" + through + ", and never ends",
                   "return before the call when there is nothing left to do");
    }
  }

 private:
  using Calls = std::map<std::string, Place>;

  static void calls_in(const Expression& e, Calls& out) {
    const bool decides =
        e.kind == Expression::Kind::binary && (e.op == Operator::logical_and || e.op == Operator::logical_or);
    for (const ExpressionPtr& part : e.parts) {
      calls_in(*part, out);
      if (decides) break;
    }
    if (e.kind == Expression::Kind::call) out.try_emplace(e.name, e.place);
  }

  static bool may_leave(const Statement& s) {
    bool out = false;
    for_each_statement(s.body, [&](const Statement& inner) { out = out || leaves(inner); });
    for_each_statement(s.handler, [&](const Statement& inner) { out = out || leaves(inner); });
    for (const Branch& branch : s.branches)
      for_each_statement(branch.body, [&](const Statement& inner) { out = out || leaves(inner); });
    for (const Clause& clause : s.clauses)
      for_each_statement(clause.otherwise, [&](const Statement& inner) { out = out || leaves(inner); });
    return out || leaves(s);
  }
  static bool leaves(const Statement& s) {
    return s.kind == Statement::Kind::stop || s.kind == Statement::Kind::return_value ||
           s.kind == Statement::Kind::raise || s.kind == Statement::Kind::break_loop ||
           s.kind == Statement::Kind::continue_loop || s.kind == Statement::Kind::hold;
  }

  static void for_each_call_in(const Block& block, const std::function<void(const Expression&)>& visit) {
    for_each_statement(block, [&](const Statement& s) {
      for_each_expression(s, [&](const Expression& e) { for_each_call(e, visit); });
    });
  }

  /// Functions that may end the program or raise an error, directly or through calls.
  void find_ends() {
    std::map<std::string, std::vector<std::string>> called_by;
    std::vector<std::string> open;
    for (const Statement* function : scope_.functions) {
      bool ends = false;
      for_each_statement(function->body, [&](const Statement& s) {
        ends = ends || s.kind == Statement::Kind::stop || s.kind == Statement::Kind::raise;
      });
      if (ends && ends_.insert(function->name).second) open.push_back(function->name);
      for_each_call_in(function->body,
                       [&](const Expression& e) { called_by[e.name].push_back(function->name); });
    }
    while (!open.empty()) {
      const std::vector<std::string> callers = called_by[open.back()];
      open.pop_back();
      for (const std::string& caller : callers)
        if (ends_.insert(caller).second) open.push_back(caller);
    }
  }

  bool may_end(const Statement& s) const {
    bool out = false;
    const auto look = [&](const Expression& e) { out = out || ends_.contains(e.name); };
    for_each_expression(s, [&](const Expression& e) { for_each_call(e, look); });
    for_each_call_in(s.body, look);
    for (const Branch& branch : s.branches) for_each_call_in(branch.body, look);
    return out;
  }

  /// The functions that the block certainly calls before it can be left.
  void sure_calls(const Block& block, Calls& out) const {
    for (const Statement& s : block) {
      if (s.kind == Statement::Kind::try_block || s.kind == Statement::Kind::function) return;
      if (s.expression) calls_in(*s.expression, out);
      for (const ExpressionPtr& argument : s.arguments) calls_in(*argument, out);
      if (s.kind == Statement::Kind::branch) {
        if (!s.branches.empty() && s.branches.front().condition) calls_in(*s.branches.front().condition, out);
        in_all(s.branches, out);
      }
      if (may_leave(s) || may_end(s)) return;
    }
  }

  /// The functions that all branches call, if one branch is certainly taken.
  void in_all(const std::vector<Branch>& branches, Calls& out) const {
    if (branches.empty() || branches.back().condition) return;
    Calls common;
    sure_calls(branches.front().body, common);
    for (std::size_t i = 1; i < branches.size(); ++i) {
      Calls here;
      sure_calls(branches[i].body, here);
      std::erase_if(common, [&](const auto& each) { return !here.contains(each.first); });
    }
    out.insert(common.begin(), common.end());
  }

  bool comes_back(const std::string& from, const std::string& to, std::set<std::string>& seen,
                  std::vector<std::string>& way) {
    if (!seen.insert(from).second) return false;
    const auto calls = calls_.find(from);
    if (calls == calls_.end()) return false;
    for (const auto& [name, place] : calls->second) {
      way.push_back(name);
      if (name == to || comes_back(name, to, seen, way)) return true;
      way.pop_back();
    }
    return false;
  }

  Scope& scope_;
  std::map<std::string, Calls> calls_;
  std::set<std::string> ends_;
};
}  // namespace

void check_values(const Program& program, Scope& scope) {
  ValueCheck(program, scope).run();
  RecursionCheck(scope).run();
}

}  // namespace polyarm::program
