#pragma once
/// The plainest way to run a program: straight down its tree, with C++'s own stack. Of the language it knows
/// what calculates: names, expressions, branches, loops, functions, errors.
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/language/ast.hpp"
#include "polyarm/language/functions.hpp"
#include "polyarm/language/operators.hpp"
#include "polyarm/language/text_functions.hpp"

namespace polyarm::program {

class TreeEvaluator {
 public:
  struct Failure {
    std::string what;
    int line = 0;
  };
  std::vector<std::pair<int, std::string>> logs;  ///< line, text
  std::optional<Failure> failure;
  bool too_long = false;  ///< it was given up after many statements

  explicit TreeEvaluator(const Program& program) : program_{program} {}

  void run() {
    for (const Statement& s : program_.statements)
      if (s.kind == Statement::Kind::function) functions_[s.name] = &s;
    frames_.emplace_back();
    try {
      block(program_.statements, false);
    } catch (const Failure& why) {
      failure = why;
    } catch (const TooLong&) {
      too_long = true;
    }
  }

 private:
  struct TooLong {};
  using Maybe = std::optional<Value>;
  enum class Way { on, break_loop, continue_loop, give };
  struct Variable {
    std::string name;
    Maybe value;
  };

  [[noreturn]] static void fail(const std::string& what, Place place) { throw Failure{what, place.line}; }

  static Value sure(Maybe value, Place place) {
    if (!value) fail("a value was expected, but this function returns none", place);
    return std::move(*value);
  }

  template <typename Work>
  static auto at(Place place, Work work) {
    try {
      return work();
    } catch (const OperationError& error) {
      fail(error.what, place);
    }
  }

  Variable* find(const std::string& name) {
    auto& names = frames_.back();
    for (auto v = names.rbegin(); v != names.rend(); ++v)
      if (v->name == name) return &*v;
    for (Variable& v : frames_.front())
      if (v.name == name) return &v;
    return nullptr;
  }

  /// A variable and the fields behind its name.
  Variable* find(const std::string& name, std::vector<std::string>& fields) {
    std::string rest = name;
    const auto dot = rest.find('.');
    if (dot != std::string::npos) {
      std::size_t from = dot + 1;
      while (from <= rest.size()) {
        const auto next = std::min(rest.find('.', from), rest.size());
        fields.push_back(rest.substr(from, next - from));
        from = next + 1;
      }
    }
    return find(rest.substr(0, dot));
  }

  // Expressions.

  Maybe maybe(const Expression& e) {
    using Kind = Expression::Kind;
    if (e.kind == Kind::call && functions_.contains(e.name)) return call(*functions_.at(e.name), e);
    if (e.kind == Kind::name && e.name.find('.') == std::string::npos) {
      const Variable* variable = find(e.name);
      if (!variable) fail("this name has no value yet", e.place);
      return variable->value;
    }
    return calculated(e);
  }

  Value value(const Expression& e) { return sure(maybe(e), e.place); }

  Value calculated(const Expression& e) {
    using Kind = Expression::Kind;
    switch (e.kind) {
      case Kind::literal:
        return e.value;
      case Kind::name: {
        std::vector<std::string> fields;
        const Variable* variable = find(e.name, fields);
        if (!variable) fail("this name has no value yet", e.place);
        Value out = sure(variable->value, e.place);
        for (const std::string& name : fields) out = at(e.place, [&] { return field(out, name); });
        return out;
      }
      case Kind::unary: {
        const Value of = value(*e.parts[0]);
        return at(e.place, [&] { return apply(e.op, of); });
      }
      case Kind::binary:
        return binary(e);
      case Kind::index:
        return element_of(e);
      case Kind::field: {
        const Value of = value(*e.parts[0]);
        return at(e.place, [&] { return field(of, e.name); });
      }
      case Kind::call:
        return builtin(e);
      default:
        return several(e);
    }
  }

  Value binary(const Expression& e) {
    const Maybe left = maybe(*e.parts[0]);
    const bool logic = e.op == Operator::logical_and || e.op == Operator::logical_or;
    const bool* truth = left ? left->as_boolean() : nullptr;
    if (logic && truth && *truth == (e.op == Operator::logical_or)) return *left;
    const Maybe right = maybe(*e.parts[1]);
    const Value b = sure(right, e.place), a = sure(left, e.place);
    return at(e.place, [&] { return apply(e.op, a, b); });
  }

  Value element_of(const Expression& e) {
    if (e.parts[0]->kind == Expression::Kind::name && e.parts[0]->name.find('.') == std::string::npos) {
      const Value place = sure(maybe(*e.parts[1]), e.place);
      const Variable* list = find(e.parts[0]->name);
      const Value of = list && list->value ? *list->value : Value(false);
      return at(e.place, [&] { return element(of, place); });
    }
    const Maybe list = maybe(*e.parts[0]), place = maybe(*e.parts[1]);
    const Value b = sure(place, e.place), a = sure(list, e.place);
    return at(e.place, [&] { return element(a, b); });
  }

  Value several(const Expression& e) {
    data::List parts;
    for (const ExpressionPtr& part : e.parts) {
      const Maybe each = maybe(*part);
      parts.push_back(sure(each, e.place));
    }
    if (e.kind == Expression::Kind::list) return at(e.place, [&] { return make_list(std::move(parts)); });
    if (e.kind == Expression::Kind::record)
      return at(e.place, [&] { return make_record({e.names, std::move(parts)}); });
    std::string text;
    for (const Value& part : parts) text += shown_text(part);
    return text;
  }

  Value builtin(const Expression& e) {
    const Function& function = *find_function(e.name);
    data::List arguments;
    for (const ExpressionPtr& part : e.parts) arguments.push_back(sure(maybe(*part), e.place));
    return at(e.place, [&] {
      for (std::size_t i = 0; i < arguments.size(); ++i) require(function, i, arguments[i]);
      return function.call(arguments, e.names);
    });
  }

  Maybe call(const Statement& function, const Expression& e) {
    std::vector<Variable> names;
    for (std::size_t i = 0; i < function.parameters.size(); ++i)
      names.push_back({function.parameters[i].name, i < e.parts.size() ? maybe(*e.parts[i]) : Maybe{}});
    frames_.push_back(std::move(names));
    for (std::size_t i = 0; i < function.parameters.size(); ++i)
      if (!frames_.back()[i].value && function.parameters[i].value) {
        Maybe otherwise = maybe(*function.parameters[i].value);
        frames_.back()[i].value = std::move(otherwise);
      }
    given_.reset();
    const std::size_t depth = frames_.size();
    try {
      block(function.body, true);
    } catch (const Failure&) {
      frames_.resize(depth - 1);
      throw;
    }
    frames_.pop_back();
    Maybe out = std::move(given_);
    given_.reset();
    return out;
  }

  // Statements.

  Way block(const Block& statements, bool inner) {
    const std::size_t outer = frames_.back().size();
    Way way = Way::on;
    constexpr int kMostStatements = 1000;
    for (const Statement& s : statements) {
      if (++statements_ > kMostStatements) throw TooLong{};
      way = statement(s);
      if (way != Way::on) break;
    }
    if (inner) frames_.back().resize(outer);
    return way;
  }

  Way statement(const Statement& s) {
    using Kind = Statement::Kind;
    switch (s.kind) {
      case Kind::let: {
        Maybe made = maybe(*s.expression);
        if (frames_.size() == 1 && depth_ == 0) made = sure(std::move(made), s.name_place);
        frames_.back().push_back({s.name, std::move(made)});
        return Way::on;
      }
      case Kind::set:
        set(s);
        return Way::on;
      case Kind::log: {
        std::vector<Maybe> parts;
        for (const ExpressionPtr& part : s.arguments) parts.push_back(maybe(*part));
        std::string text;
        for (const Maybe& part : parts)
          text += (text.empty() && &part == &parts.front() ? "" : " ") + shown_text(sure(part, s.place));
        constexpr std::size_t kLongest = 20000;
        logged_ += text.size();
        if (logged_ > kLongest) throw TooLong{};
        logs.emplace_back(s.place.line, text);
        return Way::on;
      }
      case Kind::call:
        maybe(*s.expression);
        return Way::on;
      case Kind::return_value:
        given_ = s.expression ? maybe(*s.expression) : Maybe{};
        return Way::give;
      case Kind::break_loop:
        return Way::break_loop;
      case Kind::continue_loop:
        return Way::continue_loop;
      case Kind::function:
        return Way::on;
      default:
        ++depth_;
        const Leave left{depth_};
        return structure(s);
    }
  }

  struct Leave {
    int& depth;
    ~Leave() { --depth; }
  };

  Way structure(const Statement& s) {
    switch (s.kind) {
      case Statement::Kind::branch:
        for (const Branch& branch : s.branches)
          if (!branch.condition || condition(*branch.condition, "if")) return block(branch.body, true);
        return Way::on;
      case Statement::Kind::while_loop:
        while (condition(*s.expression, "while")) {
          const Way way = block(s.body, true);
          if (way == Way::give) return way;
          if (way == Way::break_loop) break;
        }
        return Way::on;
      case Statement::Kind::for_loop:
        return for_loop(s);
      default:
        return try_block(s);
    }
  }

  bool condition(const Expression& e, const std::string& of) {
    const Value truth = value(e);
    if (!truth.as_boolean())
      fail("the condition of '" + of + "' is " + data::name(truth.kind()) + " (" +
               truth.text().substr(0, 60) + "), True or False was expected",
           e.place);
    return *truth.as_boolean();
  }

  void set(const Statement& s) {
    std::vector<std::string> fields;
    Variable* variable = find(s.name, fields);
    const bool whole = fields.empty() && s.path.empty();
    if (!variable) fail(whole ? "no value" : "this name has no value yet", s.name_place);
    if (whole) {
      Value next = sure(maybe(*s.expression), s.name_place);
      variable = find(s.name);
      if (!variable->value) fail("'" + s.name + "' has no value yet", s.name_place);
      if (!same_type(*variable->value, next))
        fail("'" + s.name + "' is " + described(*variable->value) + " (" +
                 variable->value->text().substr(0, 60) + ") and cannot become " + described(next) + " (" +
                 next.text().substr(0, 60) + ")",
             s.name_place);
      variable->value = std::move(next);
      return;
    }
    Value root = variable->value.value_or(Value(false));
    std::vector<PathStep> path;
    for (const std::string& name : fields) path.push_back({name, {}});
    for (const PathPart& part : s.path)
      path.push_back({part.field, part.index ? Maybe(maybe(*part.index).value_or(Value(false))) : Maybe{}});
    Value next = sure(maybe(*s.expression), s.name_place);
    at(s.name_place, [&] { replace(root, path, std::move(next)); });
    find(s.name.substr(0, s.name.find('.')))->value = std::move(root);
  }

  Way for_loop(const Statement& s) {
    const Maybe first = maybe(*s.expression), last = s.second ? maybe(*s.second) : Maybe{};
    data::List values;
    if (s.second) {
      const Value to = sure(last, s.place), from = sure(first, s.place);
      const data::Number *a = from.as_number(), *b = to.as_number();
      if (!a || !b || a->dimension != b->dimension)
        fail("a range goes from one number to another of the same unit", s.second->place);
      for (double x = a->value; x <= b->value; x += 1) values.push_back(data::Number{x, a->dimension});
    } else {
      const Value list = sure(first, s.place);
      if (!list.as_list()) fail("a list, or a range such as 1 .. 5, was expected", s.expression->place);
      values = *list.as_list();
    }
    const std::size_t outer = frames_.back().size();
    Way way = Way::on;
    for (std::size_t i = 0; i < values.size() && way != Way::break_loop && way != Way::give; ++i) {
      frames_.back().resize(outer);
      if (!s.second_name.empty())
        frames_.back().push_back({s.second_name, Value(static_cast<double>(i + 1))});
      frames_.back().push_back({s.name, values[i]});
      way = block(s.body, true);
    }
    frames_.back().resize(outer);
    return way == Way::give ? way : Way::on;
  }

  Way try_block(const Statement& s) {
    const std::size_t frames = frames_.size(), outer = frames_.back().size();
    const int depth = depth_;
    try {
      return block(s.body, true);
    } catch (const Failure& why) {
      frames_.resize(frames);
      frames_.back().resize(outer);
      depth_ = depth;
      frames_.back().push_back(
          {s.name, Value(data::Record{{"text", "line"}, {Value(why.what), Value(why.line)}})});
    }
    const Way way = block(s.handler, true);
    frames_.back().resize(outer);
    return way;
  }

  const Program& program_;
  std::map<std::string, const Statement*> functions_;
  std::vector<std::vector<Variable>> frames_;  ///< of the program and of each call
  Maybe given_;
  int depth_ = 0, statements_ = 0;
  std::size_t logged_ = 0;
};

}  // namespace polyarm::program
