#include "polyarm/xacro/xacro_texts.hpp"

#include <algorithm>
#include <cstdlib>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/xacro/xacro_work.hpp"
#include "polyarm/xacro/xacro_yaml.hpp"

namespace polyarm::description {

static_assert(kDeepest == bounds::kXacroNesting && kMostElements == bounds::kXacroElements &&
              kLongestText == bounds::kXacroTextBytes && kMostText == bounds::kXacroBytes);

namespace {

/// A default ends at a blank outside of quotes, `${…}` and `$(…)`.
std::size_t end_of_default(const std::string& text, std::size_t begin) {
  const auto ends = [&](std::size_t at) {
    return at >= text.size() || std::isspace(static_cast<unsigned char>(text[at]));
  };
  for (const auto& [open, close] : {std::pair{"${", '}'}, {"$(", ')'}})
    if (text.compare(begin, 2, open) == 0)
      for (auto at = text.find(close, begin); at != std::string::npos; at = text.find(close, at + 1))
        if (ends(at + 1)) return at + 1;
  std::size_t at = begin;
  while (!ends(at)) {
    const char letter = text[at];
    auto partner = letter == '\'' || letter == '"' ? text.find(letter, at + 1) : at;
    if (partner == std::string::npos) return at;
    // A quote without a partner belongs to the quoted piece before it: ''' is one piece.
    if (partner != at)
      while (!ends(partner + 1) && text[partner + 1] == letter &&
             text.find(letter, partner + 2) == std::string::npos)
        ++partner;
    at = partner + 1;
  }
  return at;
}

}  // namespace

std::optional<std::vector<XacroScope::Parameter>> xacro_parameters(const std::string& text) {
  std::vector<XacroScope::Parameter> out;
  std::size_t at = 0;
  const auto blank = [&](std::size_t i) { return std::isspace(static_cast<unsigned char>(text[i])) != 0; };
  const auto past_blanks = [&](std::size_t i) {
    while (i < text.size() && blank(i)) ++i;
    return i;
  };
  while ((at = past_blanks(at)) < text.size()) {
    XacroScope::Parameter p;
    while (at < text.size() && text[at] == '*') ++p.block, ++at;
    while (at < text.size() && !blank(at) && text[at] != '=' && text[at] != ':') p.name += text[at++];
    std::size_t sign = past_blanks(at);
    if (text.compare(sign, 1, ":") == 0) ++sign;
    if (text.compare(sign, 1, "=") == 0) {
      at = past_blanks(sign + 1);
      p.forwards = text.compare(at, 1, "^") == 0;
      if (p.forwards) at += text.compare(at, 2, "^|") == 0 ? 2 : 1;
      const std::size_t end = end_of_default(text, at);
      if (end > at) p.fallback = text.substr(at, end - at);
      at = end;
    }
    if (p.name.empty() || p.block > 2 || (at < text.size() && !blank(at))) return std::nullopt;
    out.push_back(std::move(p));
  }
  return out;
}

void XacroTexts::fail(const std::string& what, const std::string& advice) const {
  Location where;
  std::string chain;
  for (auto step = steps_.rbegin(); step != steps_.rend(); ++step) {
    if (where.file.empty()) where = {step->file.string(), step->line};
    if (!step->what.empty() && chain.size() < 2000)
      chain += "; " + step->what + " (" + step->file.string() + ":" + std::to_string(step->line) + ")";
  }
  throw Error(Problem{"xacro", where, what + chain, advice});
}

XacroScope& XacroTexts::new_scope(XacroScope* parent) {
  scopes_.push_back(std::make_unique<XacroScope>());
  scopes_.back()->parent = parent;
  return *scopes_.back();
}

XacroValue* XacroTexts::find_property(XacroScope* scope, const std::string& name) {
  const XacroScope* asked = scope;
  for (; scope; scope = scope->parent) {
    spend(3 + name.size() / 64);
    const auto found = scope->properties.find(name);
    if (found == scope->properties.end()) continue;
    XacroScope::Property& property = found->second;
    if (property.raw) {
      if (property.working) throw Error("bad-expression", "the property '" + name + "' is made of itself");
      property.working = true;
      XacroValue value = literal_of(evaluate(*property.value.text(), scope));
      XacroScope::Property& again = scope->properties[name];
      again = {std::move(value), false, false};
      return &again.value;
    }
    return &property.value;
  }
  return asked && asked->otherwise ? find_property(asked->otherwise, name) : nullptr;
}

XacroNames XacroTexts::names_for(XacroScope* scope) {
  XacroNames out;
  out.property = [this, scope](const std::string& name, XacroValue& value) {
    const XacroValue* found = find_property(scope, name);
    if (!found) return false;
    if (found->text()) spend(found->text()->size() / 32);
    return value = *found, true;
  };
  out.function = [this, scope](const std::string& name, const XacroList& arguments, XacroValue& value) {
    return function(name, arguments, value);
  };
  out.member = [this](const XacroScope* space, const std::string& name, XacroValue& value) {
    if (const XacroValue* found = find_property(const_cast<XacroScope*>(space), name))
      return value = *found, true;
    return false;
  };
  return out;
}

XacroValue XacroTexts::evaluate(const std::string& text, XacroScope* scope) {
  if (text.find('$') == std::string::npos) return text;
  if (++evaluations_ > kMostElements) fail("the expansion takes too long");
  spend(10 + text.size() / 4);
  if (++depth_ > kDeepest) {
    depth_ = 0;
    throw Error("bad-expression", "properties lead deeper and deeper into each other");
  }
  XacroValue only;
  std::string out;
  int pieces = 0;
  for (std::size_t at = 0; at < text.size(); ++pieces) {
    const auto dollar = text.find('$', at);
    if (dollar != at) {
      out += text.substr(at, dollar - at);
      at = std::min(dollar, text.size());
      only = out;
      continue;
    }
    std::size_t dollars = at;
    while (dollars < text.size() && text[dollars] == '$') ++dollars;
    const char open = dollars < text.size() ? text[dollars] : '\0';
    if (dollars - at > 1 && (open == '{' || open == '(')) {  // escaped: removes one dollar and keeps the rest
      out += text.substr(at + 1, dollars - at - 1) + open;
      at = dollars + 1;
      only = out;
      continue;
    }
    if (dollars - at == 1 && (open == '{' || open == '(')) {
      const auto close = open == '{' ? text.find('}', dollars) : closing(text, dollars);
      if (close == std::string::npos)
        throw Error("bad-expression", std::string("a '$") + open + "' has no end");
      const std::string inner = text.substr(dollars + 1, close - dollars - 1);
      const std::string resolved = str_of(evaluate(inner, scope));
      only = open == '{' ? evaluate_expression(resolved, names_for(scope)) : substitution(resolved, scope);
      out += str_of(only);
      if (out.size() > kLongestText) throw Error("bad-expression", "the text is too long");
      spend(out.size() / 64);
      at = close + 1;
      continue;
    }
    out += text.substr(at, dollars - at);
    at = dollars;
    only = out;
  }
  --depth_;
  if ((written_ += out.size()) > kMostText) fail("the expansion writes too much text");
  return pieces == 1 ? only : XacroValue(out);
}

std::size_t XacroTexts::closing(const std::string& text, std::size_t open) {
  int depth = 0;
  for (std::size_t at = open; at < text.size(); ++at) {
    depth += text[at] == '(' ? 1 : text[at] == ')' ? -1 : 0;
    if (depth == 0) return at;
  }
  return std::string::npos;
}

std::string XacroTexts::text_of(const std::string& text, XacroScope* scope) {
  return placed(text, [&] { return str_of(evaluate(text, scope)); });
}

XacroValue XacroTexts::value_of_text(const std::string& text, XacroScope* scope) {
  return placed(text, [&] { return literal_of(evaluate(text, scope)); });
}

XacroValue XacroTexts::substitution(const std::string& inner, XacroScope* scope) {
  const std::string all(trim(inner));
  const auto space = all.find_first_of(" \t\n");
  const std::string command = all.substr(0, space);
  const std::string rest(space == std::string::npos ? "" : trim(std::string_view(all).substr(space)));
  XacroValue out;
  if (command == "eval") return str_of(evaluate_expression(rest, eval_names(scope)));
  XacroList words;
  if (command == "optenv") {
    const auto blank = rest.find_first_of(" \t\n");
    words.emplace_back(rest.substr(0, blank));
    words.emplace_back(
        std::string(blank == std::string::npos ? "" : trim(std::string_view(rest).substr(blank))));
  } else if (!rest.empty()) {
    words.emplace_back(rest);
  }
  if (!function(command, words, out))
    throw Error("bad-expression", "'$(" + command + " …)' is not understood");
  return out;
}

XacroNames XacroTexts::eval_names(XacroScope* scope) {
  const auto typed = [](const std::string& text) -> XacroValue {
    const std::string word = lower(text);
    if (word == "true" || word == "false") return word == "true";
    const XacroValue literal = literal_of(text);
    return std::holds_alternative<bool>(literal.data) || literal.text() ? XacroValue(text) : literal;
  };
  XacroNames names = names_for(scope);
  names.property = [this, typed, inner = names.property](const std::string& name, XacroValue& value) {
    if (name == "true" || name == "false") return value = name == "true", true;
    const auto found = arguments_.find(name);
    return found == arguments_.end() ? inner(name, value) : (value = typed(found->second), true);
  };
  names.function = [typed, inner = names.function](const std::string& name, const XacroList& given,
                                                   XacroValue& value) {
    if (!inner(name, given, value)) return false;
    if (name == "arg") value = typed(str_of(value));
    return true;
  };
  return names;
}

bool XacroTexts::function(const std::string& name, const XacroList& a, XacroValue& out) {
  const auto text = [&](std::size_t i) -> std::string {
    if (i >= a.size()) throw Error("bad-expression", "'" + name + "' needs a value");
    return str_of(a[i]);
  };
  if (name == "arg") {
    const auto found = arguments_.find(text(0));
    if (found == arguments_.end())
      throw Error("bad-expression", "the argument '" + text(0) + "' is not declared and not given",
                  "give it as " + text(0) + ":=VALUE");
    out = found->second;
    return true;
  }
  if (name == "find") {
    const fs::path folder = find_package_(text(0));
    if (folder.empty() && keeps_unknown_packages_) return out = "package://" + text(0), true;
    if (folder.empty())
      throw Error("no-package", "the package '" + text(0) + "' is not found",
                  "set POLYARM_PACKAGES to the folders that hold packages; polyarm xacro takes --package " +
                      text(0) + "=FOLDER, too");
    packages_.insert(folder);
    out = folder.string();
    return true;
  }
  if (name == "env" || name == "optenv") {
    const char* value = std::getenv(text(0).c_str());
    if (!value && name == "env") throw Error("bad-expression", "the environment has no '" + text(0) + "'");
    out = std::string(value ? value : a.size() > 1 ? text(1) : "");
    return true;
  }
  if (name == "dirname") return out = fs::absolute(reading_.back()).parent_path().string(), true;
  if (name == "cwd") return out = fs::current_path().string(), true;
  if (name == "anon") return out = text(0) + "_1", true;
  if (name == "abs_filename") return out = resolve(text(0)).string(), true;
  if (name == "load_yaml") return out = load_yaml(text(0)), true;
  if (name == "tokenize") {
    spend(text(0).size() / 2);
    auto list = std::make_shared<XacroList>();
    const std::string by = a.size() > 1 ? text(1) : ",; ", all = text(0);
    const bool skip_empty = a.size() < 3 || truth_of(a[2]);
    for (std::size_t at = 0; at <= all.size();) {
      const std::size_t end = std::min(all.find_first_of(by, at), all.size());
      if (end > at || !skip_empty) list->emplace_back(all.substr(at, end - at));
      at = end + 1;
    }
    out = list;
    return true;
  }
  if (name == "message" || name == "warning" || name == "error" || name == "fatal" ||
      name == "print_location") {
    std::string all;
    for (const XacroValue& value : a) all += (all.empty() ? "" : " ") + str_of(value);
    if (name == "fatal") throw Error("xacro-fatal", all);
    if (name != "message" && name != "print_location")
      warnings_.warning("xacro-" + name, {steps_.back().file.string(), current_line()}, all);
    out = std::string();
    return true;
  }
  return false;
}

fs::path XacroTexts::resolve(const std::string& name) const {
  const fs::path path = name;
  return path.is_absolute() ? path : reading_.back().parent_path() / path;
}

fs::path XacroTexts::file_for(const std::string& name) const {
  const fs::path path = resolve(name);
  std::error_code error;
  if (fs::is_regular_file(path, error)) return path;
  for (const fs::path& package : packages_) {
    const fs::path inside = path.lexically_normal().lexically_relative(package.lexically_normal());
    if (inside.empty() || inside.begin()->string() == "..") continue;
    if (const fs::path found = find_inside(package, inside); !found.empty()) return found;
  }
  return path;
}

XacroValue XacroTexts::load_yaml(const std::string& name) {
  const fs::path path = file_for(name);
  std::error_code error;
  if (!fs::is_regular_file(path, error)) throw Error("no-file", "there is no file " + path.string());
  if (const auto found = yamls_.find(path.string()); found != yamls_.end()) return copy_of(found->second);
  if (report_) report_->files.push_back(path);
  const auto evaluate = [&](const std::string& text) {
    return evaluate_expression(text, names_for(nullptr));
  };
  return copy_of(yamls_[path.string()] = read_yaml(read_file(path), path.string(), evaluate));
}

}  // namespace polyarm::description
