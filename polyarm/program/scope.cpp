#include "polyarm/program/scope.hpp"

#include <algorithm>
#include <iterator>
#include <string_view>
#include <utility>

#include "polyarm/base/text.hpp"
#include "polyarm/base/unit_advice.hpp"
#include "polyarm/language/foreign_words.hpp"
#include "polyarm/language/libraries.hpp"
#include "polyarm/language/text_functions.hpp"
#include "polyarm/language/words.hpp"
#include "polyarm/program/code.hpp"

namespace polyarm::program {

using data::Kind;

namespace {
bool is_place(Kind kind) {
  return kind == Kind::joints || kind == Kind::pose;
}

bool can_order(const Type& type) {
  return !type.kind || *type.kind == Kind::number || *type.kind == Kind::text;
}

/// The Wanted that corresponds to a type; empty if the type may fit.
bool surely_not(Wanted wanted, const Type& type) {
  if (!type.kind || wanted == Wanted::any) return false;
  const auto number = [&](std::optional<Dimension> dimension) {
    return *type.kind != Kind::number || (dimension && type.dimension && *type.dimension != *dimension);
  };
  switch (wanted) {
    case Wanted::number:
      return number({});
    case Wanted::length:
      return number(Dimension::length);
    case Wanted::angle:
      return number(Dimension::angle);
    case Wanted::joint:
      return number(Dimension::angle) && number(Dimension::length);
    case Wanted::scalar:
      return number(Dimension::none);
    case Wanted::text:
      return *type.kind != Kind::text;
    case Wanted::list:
      return *type.kind != Kind::list;
    case Wanted::list_or_text:
      return *type.kind != Kind::list && *type.kind != Kind::text;
    case Wanted::pose:
      return *type.kind != Kind::pose;
    case Wanted::joints:
      return *type.kind != Kind::joints;
    default:
      return !is_place(*type.kind);
  }
}
}  // namespace

std::optional<double> bare_number(const Expression& e) {
  if (e.kind == Expression::Kind::unary && e.op == Operator::negate) {
    const auto of = bare_number(*e.parts[0]);
    return of ? std::optional(-*of) : std::nullopt;
  }
  const data::Number* number = e.kind == Expression::Kind::literal ? e.value.as_number() : nullptr;
  return number && number->dimension == Dimension::none ? std::optional(number->value) : std::nullopt;
}

Type number_of(std::optional<Dimension> dimension) {
  return {Kind::number, dimension};
}

std::string described(const Type& type) {
  if (type.kind == Kind::number && type.dimension)
    return *type.dimension == Dimension::none ? "a number without unit" : name(*type.dimension);
  return type.kind ? data::name(*type.kind) : "something";
}

bool surely_other(const Type& a, const Type& b) {
  if (!a.kind || !b.kind) return false;
  if (is_place(*a.kind) && is_place(*b.kind)) return false;
  return *a.kind != *b.kind || (a.dimension && b.dimension && *a.dimension != *b.dimension);
}

bool is_place(const Type& type) {
  return !type.kind || is_place(*type.kind);
}

Scope::Scope(const Program& program, const KnownNames& known, Problems& problems)
    : names{known.names}, program_{program}, problems_{problems}, defined_{known.defined}, elsewhere_{known.elsewhere} {
  for_each_statement(program.statements, [&](const Statement& s) {
    if (s.kind == Statement::Kind::set_literal && !s.name.empty() && !known.names.contains(s.name))
      made.insert(s.name);
  });
  for (const Statement& s : program.statements)
    if (s.kind == Statement::Kind::function && !s.name.empty())
      functions.push_back(&s), function_at_.try_emplace(s.name, &s);
}

std::vector<std::string> Scope::all_names() const {
  std::vector<std::string> out;
  for (const auto& name : names) out.push_back(name.first);
  for (const Variable& variable : variables) out.push_back(variable.name);
  return out;
}

const Type* Scope::local(const std::string& name) const {
  const auto at = places_.find(name);
  return at == places_.end() || at->second.empty() ? nullptr : &variables[at->second.back()].type;
}

void Scope::forget(std::size_t keep) {
  for (std::size_t i = variables.size(); i > keep; --i) places_[variables[i - 1].name].pop_back();
  variables.resize(keep);
}

/// The nearest existing name; not for a file with too many faults, because it compares with every name.
std::string Scope::suggested(const std::string& name) const {
  constexpr std::size_t kMost = 500;
  if (problems_.list().size() >= kMost) return {};
  std::vector<std::string> all = all_names();
  all.insert(all.end(), {"true", "false"});
  return did_you_mean(name, all);
}

std::string Scope::variable_in(const std::string& name) const {
  if (local(name)) return name;
  const std::string first = name.substr(0, name.find('.'));
  return local(first) ? first : std::string{};
}

const Statement* Scope::function(const std::string& name) const {
  const auto at = function_at_.find(name);
  return at == function_at_.end() ? nullptr : at->second;
}

namespace {
/// "in line 3 of Points.data"; a location without a line names the file alone.
std::string in_line_of(const Location& at, bool other_file) {
  const std::string file = at.file.substr(at.file.rfind('/') + 1);
  if (at.line <= 0) return "in " + file;
  return "in line " + std::to_string(at.line) + (other_file ? " of " + file : std::string{});
}
}  // namespace

std::string Scope::in_line(Place place, Place seen_from) const {
  return in_line_of(program_.at(place), place.file != seen_from.file);
}

std::string Scope::where_made(const std::string& name, Place seen_from) const {
  if (const auto at = places_.find(name); at != places_.end() && !at->second.empty())
    return ", " + in_line(variables[at->second.back()].place, seen_from);
  const auto defined = defined_.find(name);
  return defined == defined_.end() ? std::string{} : ", " + in_line_of(defined->second, true);
}

/// True for a name that may be the same as one of another file. The author of an included file does not know
/// the names of the programs that include it: those in a library, and the parameters and other names in
/// functions, are its own.
bool Scope::is_own_name(const std::string& name, Place place) const {
  if (place.file == 0) return false;
  const std::string& file = program_.included[static_cast<std::size_t>(place.file) - 1].file;
  if (file.starts_with(kLibraryPrefix)) return true;
  if (!in_function) return false;
  const auto at = places_.find(name);
  return at == places_.end() || at->second.empty() || variables[at->second.back()].place.file != place.file;
}

void Scope::declare(const std::string& name, Place place, Type type) {
  if (name.empty()) return;
  if (!is_own_name(name, place) && (local(name) || names.contains(name)))
    error("shadowing", place, "there is a '" + name + "' already" + where_made(name, place),
          local(name)
              ? "choose another name, or change it with `set`"
              : "it belongs to the data, the tags or the named states of the robot; choose another name");
  used.emplace(name, place);
  places_[name].push_back(variables.size());
  variables.push_back({name, type, place});
}

Type Scope::type_of_field(const Type& of, const std::string& field, Place place) {
  if (!of.kind || *of.kind == Kind::record) return kUnknown;
  if (is_place(*of.kind) && field == "name") return {Kind::text, {}};
  if (*of.kind == Kind::joints) return number_of({});  // of a joint that slides it is a length
  if (*of.kind == Kind::pose) {
    for (const char* axis : {"x", "y", "z"})
      if (field == axis) return number_of(Dimension::length);
    for (const char* axis : {"rx", "ry", "rz"})
      if (field == axis) return number_of(Dimension::angle);
  }
  error("bad-type", place, described(of) + " has no '" + field + "'",
        *of.kind == Kind::pose ? "a pose has x y z rx ry rz" : "");
  return kUnknown;
}

Type Scope::type_of_name(const std::string& name, Place place) {
  used.emplace(name, place);
  if (const Type* found = local(name)) return *found;
  if (const std::string variable = variable_in(name); !variable.empty()) {
    Type type = *local(variable);
    static const std::vector<std::string> kOfErrors = {"kind", "text", "line", "robot"};
    const std::vector<std::string> parts =
        split_fields(std::string_view(name).substr(variable.size() + 1), '.');
    if (errors.contains(variable) && std::find(kOfErrors.begin(), kOfErrors.end(), parts.front()) == kOfErrors.end())
      error("unknown-name", place,
            "there is no '" + parts.front() + "' in this record" + did_you_mean(parts.front(), kOfErrors),
            "it has " + join(kOfErrors, ", "));
    for (const std::string& part : parts)
      type = type_of_field(type, part, place);
    return type;
  }
  for (std::size_t end = name.size(); end != std::string::npos && end > 0; end = name.rfind('.', end - 1)) {
    const auto at = names.find(name.substr(0, end));
    if (at == names.end()) continue;
    return end == name.size() ? at->second : type_of_field(at->second, name.substr(end + 1), place);
  }
  if (made.contains(name) || program_.lacks_included) return kUnknown;
  if (find_function(name)) {
    error("unknown-name", place, "'" + name + "' is a function", "write `" + name + "()`");
    return kUnknown;
  }
  const auto elsewhere = elsewhere_.find(name);
  error("unknown-name", place, "there is nothing called '" + name + "'" + suggested(name),
        elsewhere != elsewhere_.end() ? "it is in " + elsewhere->second.first + ": write `load " + elsewhere->second.second + "` above"
                                      : "names are data, points, tags and variables of `let`");
  return kUnknown;
}

Type Scope::infer(const Expression& e) {
  using Kinds = Expression::Kind;
  switch (e.kind) {
    case Kinds::literal:
      return type_of(e.value);
    case Kinds::name:
      return type_of_name(e.name, e.place);
    case Kinds::unary:
      return infer_unary(e);
    case Kinds::binary:
      return infer_binary(e);
    case Kinds::call:
      return infer_call(e);
    case Kinds::each:
      return infer_each(e);
    default:
      break;
  }
  const std::vector<Type> parts = infer_all(e);
  if (e.kind == Kinds::list) return {Kind::list, {}};
  if (e.kind == Kinds::record) return {Kind::record, {}};
  if (e.kind == Kinds::field) return type_of_field(parts[0], e.name, e.place);
  if (e.kind == Kinds::joined) return {Kind::text, {}};
  if (parts[0].kind && *parts[0].kind != Kind::list)
    error("bad-type", e.place, "only a list has elements, here is " + described(parts[0]));
  return kUnknown;
}

std::vector<Type> Scope::infer_all(const Expression& e) {
  std::vector<Type> out;
  for (const ExpressionPtr& part : e.parts) out.push_back(infer(*part));
  return out;
}

Type Scope::infer_each(const Expression& e) {
  const Type first = infer(*e.parts[1]);
  const bool range = e.parts.size() > 2;
  const Type last = range ? infer(*e.parts[2]) : kUnknown;
  if (range && (surely_other(first, last) || surely_other(first, number_of({}))))
    error("bad-type", e.parts[2]->place,
          "a range goes from one number to another of the same unit, here are " + described(first) + " and " +
              described(last),
          "write such as 1 .. 5");
  if (!range && first.kind && *first.kind != Kind::list)
    error("bad-type", e.parts[1]->place,
          "a list, or a range such as 1 .. 5, was expected, here is " + described(first));
  const std::size_t outer = variables.size();
  if (!e.names.empty()) declare(e.names.front(), e.place, number_of(Dimension::none));
  declare(e.name, e.place, range ? first : kUnknown);
  infer(*e.parts[0]);
  forget(outer);
  return {Kind::list, {}};
}

/// The fields of a literal text of format(), and the types of their values.
void Scope::check_format(const Expression& e, const std::vector<Type>& arguments) {
  const Expression& text = *e.parts.front();
  if (text.kind != Expression::Kind::literal || !text.value.as_text()) return;
  const std::vector<FormatField> fields = format_fields(*text.value.as_text());
  if (fields.size() + 1 != e.parts.size())
    return error("bad-format", text.place,
                 wrong_values(fields.size(), e.parts.size() - 1),
                 "every value has a field {}");
  for (std::size_t i = 0; i < fields.size(); ++i) {
    const Type& type = arguments[i + 1];
    const Unit* unit = fields[i].unit.empty() ? nullptr : find_unit(fields[i].unit);
    const Type wanted = number_of(unit ? std::optional(unit->dimension) : std::nullopt);
    if (fields[i].of_number() && surely_other(type, wanted))
      error("bad-format", e.parts[i + 1]->place,
            "this field of format() shows " + described(wanted) + ", here is " + described(type));
  }
}

/// p with NAME = value
Type Scope::infer_with(const Expression& e, const std::vector<Type>& arguments) {
  const Type& of = arguments.front();
  if (of.kind && !is_place(*of.kind) && *of.kind != Kind::record)
    error("bad-type", e.parts.front()->place, "'with' copies a pose, a joint state or a record, here is " + described(of),
          "write such as P with z = 10mm");
  for (std::size_t i = 1; i < e.parts.size(); ++i) {
    if (e.names[i].empty()) {
      error("bad-call", e.parts[i]->place, "'with' needs the name of each new value", "write such as P with z = 10mm");
      continue;
    }
    const Type field = of.kind == Kind::pose ? type_of_field(of, e.names[i], e.parts[i]->place) : kUnknown;
    const bool zero = bare_number(*e.parts[i]) == 0.0;
    if (surely_other(field, arguments[i]) && !zero)
      error("bad-type", e.parts[i]->place,
            "'" + e.names[i] + "' is " + described(field) + ", here is " + described(arguments[i]),
            field.dimension ? unit_advice(*field.dimension, bare_number(*e.parts[i])) : std::string{});
  }
  return of;
}

Type Scope::infer_unary(const Expression& e) {
  const Type of = infer(*e.parts[0]);
  const Kind wanted = e.op == Operator::logical_not ? Kind::boolean : Kind::number;
  if (of.kind && *of.kind != wanted)
    error("bad-type", e.place,
          std::string("'") + spelling(e.op) + "' needs " + data::name(wanted) + ", here is " + described(of));
  return wanted == Kind::boolean ? kBoolean : number_of(of.dimension);
}

namespace {
/// The intended form of an operation with the wrong operands.
std::string advice_for(const Expression& e, const Type& a, const Type& b) {
  if (a.kind == Kind::number && b.kind == Kind::number && a.dimension && b.dimension) {
    if (e.op == Operator::multiply || e.op == Operator::divide)
      return "the result would have a unit that programs do not know; divide by a unit first, such as d / "
             "1mm";
    if (*a.dimension == Dimension::none) return unit_advice(*b.dimension, bare_number(*e.parts[0]));
    if (*b.dimension == Dimension::none) return unit_advice(*a.dimension, bare_number(*e.parts[1]));
    return "give both the same kind of unit";
  }
  if (e.op != Operator::add && e.op != Operator::subtract) return "";
  if (a.kind == Kind::pose && b.kind == Kind::pose)
    return "write A * B for B in the frame A, or offset(A, x = 20mm) to shift it";
  if (a.kind == Kind::pose) return "shift a pose with offset(P, x = 20mm, rz = 5deg)";
  return a.kind == Kind::joints ? "change one joint with joints(NAME = …), or move with `speedj`" : "";
}
}  // namespace

void Scope::refuse_pair(const Expression& e, const Type& a, const Type& b) {
  const auto is_name_of_cell = [this](const Expression& part) {
    return part.kind == Expression::Kind::name && names.contains(part.name) && !local(part.name);
  };
  const auto boolean_for_number = [&](const Type& one, const Expression& part, const Type& other) {
    return one.kind == Kind::boolean && other.kind == Kind::number && is_name_of_cell(part);
  };
  const bool joins = e.op == Operator::add && (a.kind == Kind::text || b.kind == Kind::text);
  if (joins)
    return error("bad-type", e.place, "'+' cannot take " + described(a) + " and " + described(b),
                 "a value stands in a text in braces, \"count {n}\"; or write text(…)");
  const bool tag = boolean_for_number(a, *e.parts[0], b) || boolean_for_number(b, *e.parts[1], a);
  error("bad-type", e.place,
        std::string("'") + spelling(e.op) + "' cannot take " + described(a) + " and " + described(b),
        tag ? "a tag is a bool unless signals.yaml says `type: number`" : advice_for(e, a, b));
}

Type Scope::infer_binary(const Expression& e) {
  const Type a = infer(*e.parts[0]), b = infer(*e.parts[1]);
  if (e.op == Operator::logical_and || e.op == Operator::logical_or) {
    if (surely_other(a, kBoolean) || surely_other(b, kBoolean)) refuse_pair(e, a, b);
    return kBoolean;
  }
  if (is_comparison(e.op)) {
    const bool ordered = e.op >= Operator::less && e.op <= Operator::greater_equal;
    if (surely_other(a, b) || (ordered && (!can_order(a) || !can_order(b)))) refuse_pair(e, a, b);
    return kBoolean;
  }
  return infer_arithmetic(e, a, b);
}

Type Scope::infer_arithmetic(const Expression& e, const Type& a, const Type& b) {
  if (!a.kind || !b.kind) return kUnknown;
  if (e.op == Operator::multiply && *a.kind == Kind::pose && *b.kind == Kind::pose) return a;
  const bool joins =
      e.op == Operator::add && *a.kind == *b.kind && (*a.kind == Kind::text || *a.kind == Kind::list);
  if (joins) return a;
  if (*a.kind != Kind::number || *b.kind != Kind::number) {
    refuse_pair(e, a, b);
    return kUnknown;
  }
  if (!a.dimension || !b.dimension) return number_of({});
  return number_of(dimension_of(e, a, b));
}

std::optional<Dimension> Scope::dimension_of(const Expression& e, const Type& a, const Type& b) {
  std::optional<Dimension> out;
  if (e.op == Operator::multiply) {
    out = product(*a.dimension, *b.dimension);
  } else if (e.op == Operator::divide) {
    out = quotient(*a.dimension, *b.dimension);
  } else if (*a.dimension == *b.dimension) {
    out = a.dimension;
  }
  if (!out) refuse_pair(e, a, b);
  return out;
}

Type Scope::infer_call(const Expression& e) {
  const std::vector<Type> arguments = infer_all(e);
  const Statement* own = function(e.name);
  const Function* builtin = own ? nullptr : find_function(e.name);
  if (!own && !builtin) {
    if (program_.lacks_included) return kUnknown;
    if (const ForeignWord* foreign = foreign_word(e.name)) {
      error("unknown-function", e.place, "there is no function '" + e.name + "'", foreign->instead);
      return kUnknown;
    }
    if (const Word* const word = statement_named(e.name)) {
      error("unknown-function", e.place, "'" + e.name + "' is a statement, not a function",
            "write `" + std::string(word->form) + "`");
      return kUnknown;
    }
    std::vector<std::string> all;
    for (const Statement* each : functions) all.push_back(each->name);
    const bool has_tests = !tests(program_).empty();
    for (const std::string& name : function_names())
      if (has_tests || !find_function(name)->in_tests) all.push_back(name);
    error("unknown-function", e.place, "there is no function '" + e.name + "'" + did_you_mean(e.name, all),
          "functions are " + join(all, ", "));
    return kUnknown;
  }
  try {
    if (builtin) return infer_builtin(e, *builtin, arguments);
    bind_arguments(signature_of(*own), e.names);
  } catch (const OperationError& problem) {
    error(problem.code, e.place, problem.what, problem.advice);
  }
  return kUnknown;
}

Type Scope::infer_builtin(const Expression& e, const Function& function, const std::vector<Type>& arguments) {
  const Bound bound = bind_arguments(signature_of(function), e.names);
  const auto look = [&](std::size_t parameter, int argument) {
    if (argument < 0) return;
    const auto& wanted = function.parameters[parameter];
    const Type& type = arguments[static_cast<std::size_t>(argument)];
    if (!surely_not(wanted.wanted, type)) return;
    const Expression& given = *e.parts[static_cast<std::size_t>(argument)];
    const data::Number* literal = given.kind == Expression::Kind::literal ? given.value.as_number() : nullptr;
    const auto dimension = type.kind == Kind::number ? program::dimension_of(wanted.wanted) : std::nullopt;
    if (literal && literal->value == 0 && dimension && *dimension != Dimension::none) return;
    error("bad-type", e.parts[static_cast<std::size_t>(argument)]->place,
          "'" + std::string(wanted.name) + "' of " + std::string(function.name) + "() is " +
              name(wanted.wanted) + ", here is " + described(type),
          dimension ? unit_advice(*dimension, bare_number(given)) : std::string{});
  };
  for (std::size_t i = 0; i < bound.argument_of.size(); ++i) look(i, bound.argument_of[i]);
  for (const int argument : bound.further) look(function.parameters.size() - 1, argument);
  const Type first = arguments.empty() ? kUnknown : arguments.front();
  if (function.name == "interpolate" || function.name == "slice") return first;
  if (function.name == "with") return infer_with(e, arguments);
  if (function.name == "format") check_format(e, arguments);
  if (function.live == Live::random && arguments.empty()) return number_of(Dimension::none);
  if (function.live == Live::random && (arguments.size() != 2 || surely_other(arguments[0], arguments[1])))
    error("bad-call", e.place, "random() takes no values, or two of one unit", "write such as random(1mm, 5mm)");
  if (function.name == "ask") return arguments.size() > 1 ? arguments[1] : Type{Kind::text, {}};
  if (function.in_tests && tests(program_).empty())
    error("no-test", e.place, std::string(function.name) + "() exists in tests only",
          "tests have files of their own: test \"…\", its lines, end");
  if (function.gives == Kind::number)
    return number_of(function.dimension ? function.dimension : first.dimension);
  return {function.gives, {}};
}

void Scope::warn_of_case() {
  std::map<std::string, std::set<std::string>> same;
  for (const auto& name : names) same[lower(name.first)].insert(name.first);
  for (const auto& [name, place] : used) {
    const auto& spellings = same[lower(name)];
    if (spellings.size() < 2 || *spellings.begin() == name) continue;
    warning("case", place, "'" + name + "' and '" + *spellings.begin() + "' differ only in case",
            "they are two names");
  }
}

}  // namespace polyarm::program
