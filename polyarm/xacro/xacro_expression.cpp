/// xacro expressions: a subset of Python that cannot run code.
#include <algorithm>
#include <charconv>
#include <cmath>
#include <functional>
#include <map>
#include <numbers>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/xacro/xacro_functions.hpp"
#include "polyarm/xacro/xacro_parts.hpp"
#include "polyarm/xacro/xacro_value.hpp"
#include "polyarm/xacro/xacro_work.hpp"

namespace polyarm::description {

namespace {

constexpr int kDeepestExpression = 200;
constexpr std::size_t kMostSteps = 2'000'000;

struct Token {
  enum Kind { end, name, number, text, sign } kind = end;
  std::string word;
  XacroValue value;
};

bool starts_name(char c) {
  return std::isalpha(static_cast<unsigned char>(c)) || c == '_' || static_cast<unsigned char>(c) > 127;
}

class Lexer {
 public:
  explicit Lexer(std::string_view text) : text_(text) {}

  std::vector<Token> all() {
    std::vector<Token> out;
    for (;;) {
      while (at_ < text_.size() && std::isspace(static_cast<unsigned char>(text_[at_]))) ++at_;
      if (at_ >= text_.size()) break;
      out.push_back(next());
    }
    out.push_back({});
    return out;
  }

 private:
  char peek(std::size_t ahead = 0) const { return at_ + ahead < text_.size() ? text_[at_ + ahead] : '\0'; }

  Token next() {
    const char c = peek();
    if (std::isdigit(static_cast<unsigned char>(c)) ||
        (c == '.' && std::isdigit(static_cast<unsigned char>(peek(1)))))
      return number();
    if (c == '\'' || c == '"') return quoted();
    if (starts_name(c)) {
      std::string word;
      while (starts_name(peek()) || std::isdigit(static_cast<unsigned char>(peek()))) word += text_[at_++];
      return {Token::name, word, {}};
    }
    for (const char* sign : {"**", "//", "<=", ">=", "==", "!=", "<<", ">>"})
      if (text_.substr(at_, 2) == sign) return at_ += 2, Token{Token::sign, sign, {}};
    if (std::string_view("+-*/%<>()[]{},:.=&|^~").find(c) == std::string_view::npos)
      refuse(std::string("'") + c + "' has no meaning here");
    ++at_;
    return {Token::sign, std::string(1, c), {}};
  }

  Token number() {
    const char* begin = text_.data() + at_;
    const char* end = text_.data() + text_.size();
    if (peek() == '0' && (peek(1) == 'x' || peek(1) == 'X')) {
      std::int64_t hex = 0;
      const auto read = std::from_chars(begin + 2, end, hex, 16);
      if (read.ec != std::errc()) refuse("a hexadecimal number has no digits");
      at_ = static_cast<std::size_t>(read.ptr - text_.data());
      return {Token::number, "", hex};
    }
    double real = 0;
    const auto read = std::from_chars(begin, end, real);
    const std::string_view digits(begin, static_cast<std::size_t>(read.ptr - begin));
    at_ += digits.size();
    if (read.ec == std::errc::result_out_of_range)
      return {Token::number, "", std::numeric_limits<double>::infinity()};
    if (digits.find_first_of(".eE") != std::string_view::npos) return {Token::number, "", real};
    std::int64_t whole = 0;
    if (std::from_chars(begin, begin + digits.size(), whole).ec != std::errc())
      return {Token::number, "", real};
    return {Token::number, "", whole};
  }

  Token quoted() {
    const char quote = text_[at_++];
    std::string out;
    while (peek() != quote) {
      if (at_ >= text_.size()) refuse("a quote has no partner");
      char c = text_[at_++];
      if (c == '\\' && at_ < text_.size()) {
        c = text_[at_++];
        if (c == 'n' || c == 't')
          c = c == 'n' ? '\n' : '\t';
        else if (c != '\\' && c != '\'' && c != '"')
          out += '\\';  // no escape sequence: the backslash stays
      }
      out += c;
    }
    ++at_;
    return {Token::text, "", out};
  }

  std::string_view text_;
  std::size_t at_ = 0;
};

/// Evaluates while it parses; a branch that is not taken is parsed with `live_` off.
class Evaluator {
 public:
  Evaluator(std::vector<Token> tokens, const XacroNames& names) : tokens_(std::move(tokens)), names_(names) {}

  XacroValue all() {
    XacroValue out = conditional();
    if (is(",")) {  // a tuple
      auto items = std::make_shared<XacroList>(XacroList{out});
      items->is_tuple = true;
      while (take(",") && here().kind != Token::end) items->push_back(conditional());
      out = items;
    }
    if (here().kind != Token::end) refuse("'" + shown() + "' was not expected");
    if (depth_of(out) > kDeepestExpression) refuse("its lists lie too deep within each other");
    return out;
  }

 private:
  struct Deeper {
    explicit Deeper(Evaluator& e) : e_(e) {
      if (++e_.depth_ > kDeepestExpression) refuse("it is nested too deeply");
      if (++e_.steps_ > kMostSteps) refuse("it takes too long");
      spend(8);
    }
    ~Deeper() { --e_.depth_; }
    Evaluator& e_;
  };

  const Token& here() const { return tokens_[at_]; }
  std::string shown() const {
    if (here().kind == Token::end) return "the end";
    return here().kind == Token::number || here().kind == Token::text ? str_of(here().value) : here().word;
  }
  bool is(const char* sign) const { return here().kind == Token::sign && here().word == sign; }
  bool word(const char* name) const { return here().kind == Token::name && here().word == name; }
  bool take(const char* sign) { return is(sign) && ++at_; }
  bool take_word(const char* name) { return word(name) && ++at_; }
  void expect(const char* sign) {
    if (!take(sign)) refuse(std::string("'") + sign + "' was expected before '" + shown() + "'");
  }
  template <typename Read>
  XacroValue unused(Read read) {
    const bool was = std::exchange(live_, false);
    XacroValue out = read();
    live_ = was;
    return out;
  }

  XacroValue conditional() {
    const Deeper deeper(*this);
    const std::size_t begin = at_;
    unused([&] { return disjunction(); });
    if (!word("if")) {
      if (!live_) return {};
      at_ = begin;
      return disjunction();
    }
    const std::size_t condition_at = at_;
    ++at_;
    const bool yes = truth_of(disjunction()) && live_;
    if (!take_word("else")) refuse("'else' was expected before '" + shown() + "'");
    const std::size_t otherwise = at_;
    if (!live_) return conditional();
    if (!yes) return conditional();
    at_ = begin;
    XacroValue out = disjunction();
    (void)condition_at;
    at_ = otherwise;
    unused([&] { return conditional(); });
    return out;
  }

  XacroValue disjunction() {
    XacroValue out = conjunction();
    while (take_word("or")) {
      if (live_ && truth_of(out))
        unused([&] { return conjunction(); });
      else
        out = conjunction();
    }
    return out;
  }

  XacroValue conjunction() {
    XacroValue out = negation();
    while (take_word("and")) {
      if (live_ && !truth_of(out))
        unused([&] { return negation(); });
      else
        out = negation();
    }
    return out;
  }

  XacroValue negation() {
    const Deeper deeper(*this);
    if (take_word("not")) return !truth_of(negation());
    return comparison();
  }

  XacroValue comparison() {
    XacroValue left = bits();
    bool out = true, any = false;
    for (;;) {
      std::string sign;
      for (const char* s : {"<", ">", "<=", ">=", "==", "!="})
        if (is(s)) sign = s;
      if (sign.empty() && word("in")) sign = "in";
      if (sign.empty() && word("is")) sign = "is";
      if (sign.empty() && word("not") && tokens_[at_ + 1].kind == Token::name &&
          tokens_[at_ + 1].word == "in")
        sign = "not in", ++at_;
      if (sign.empty()) return any ? XacroValue(out) : left;
      ++at_;
      if (sign == "is" && take_word("not")) sign = "is not";
      XacroValue right = bits();
      if (live_) out = out && compare(left, sign, right);
      any = true;
      left = std::move(right);
    }
  }

  /// | has the lowest precedence, then ^, &, and the shifts.
  XacroValue bits(std::size_t level = 0) {
    static const char* const signs[][2] = {{"|", "|"}, {"^", "^"}, {"&", "&"}, {"<<", ">>"}};
    if (level == std::size(signs)) return sum();
    XacroValue out = bits(level + 1);
    while (is(signs[level][0]) || is(signs[level][1])) {
      const std::string sign = tokens_[at_++].word;
      const XacroValue right = bits(level + 1);
      if (live_) out = arithmetic(out, sign, right);
    }
    return out;
  }

  XacroValue sum() {
    XacroValue out = product();
    while (is("+") || is("-")) {
      const std::string sign = tokens_[at_++].word;
      const XacroValue right = product();
      if (live_) out = arithmetic(out, sign, right);
    }
    return out;
  }

  XacroValue product() {
    XacroValue out = factor();
    while (is("*") || is("/") || is("//") || is("%")) {
      const std::string sign = tokens_[at_++].word;
      const XacroValue right = factor();
      if (live_) out = arithmetic(out, sign, right);
    }
    return out;
  }

  XacroValue factor() {
    const Deeper deeper(*this);
    if (take("-")) {
      const XacroValue out = factor();
      return live_ ? arithmetic(std::int64_t{0}, "neg", out) : out;
    }
    if (take("~")) {
      const XacroValue out = factor();
      return live_ ? arithmetic(std::int64_t{0}, "~", out) : out;
    }
    if (take("+")) return factor();
    return power();
  }

  XacroValue power() {
    XacroValue out = postfix();
    if (!take("**")) return out;
    const XacroValue right = factor();
    return live_ ? arithmetic(out, "**", right) : out;
  }

  XacroValue postfix() {
    std::string name;
    XacroValue out = atom(name);
    for (;;) {
      if (is("(")) {
        out = call(name, out);
        name.clear();
      } else if (take("[")) {
        out = index(out);
        name.clear();
      } else if (take(".")) {
        if (here().kind != Token::name) refuse("a name was expected after '.'");
        const std::string member = tokens_[at_++].word;
        if (is("(")) {
          out = method(name, out, member);
          name.clear();
        } else {
          out = attribute(name, out, member);
          name = name.empty() ? "" : name + "." + member;
        }
      } else {
        if (!name.empty() && live_ && unresolved_ == name) refuse("the name '" + name + "' is not defined");
        return out;
      }
    }
  }

  /// A bare name may be a function or a module: `name` holds it until it is resolved.
  XacroValue atom(std::string& name) {
    const Deeper deeper(*this);
    const Token token = here();
    if (token.kind == Token::number || token.kind == Token::text) {
      ++at_;
      std::string joined = token.kind == Token::text ? *token.value.text() : "";
      if (token.kind == Token::number) return token.value;
      while (here().kind == Token::text) joined += *tokens_[at_++].value.text();
      return joined;
    }
    if (token.kind == Token::name) {
      ++at_;
      name = token.word;
      return find_name(name);
    }
    if (take("(")) {
      if (take(")")) {
        auto none = std::make_shared<XacroList>();
        none->is_tuple = true;
        return none;
      }
      XacroValue out = element_or_comprehension();
      if (is(",")) {
        auto items = std::make_shared<XacroList>(XacroList{out});
        items->is_tuple = true;
        while (take(",") && !is(")")) items->push_back(conditional());
        out = items;
      }
      expect(")");
      return out;
    }
    if (take("[")) return list();
    if (take("{")) return dict();
    refuse("a value was expected before '" + shown() + "'");
  }

  XacroValue find_name(const std::string& name) {
    for (auto local = locals_.rbegin(); local != locals_.rend(); ++local)
      if (local->first == name) return local->second;
    XacroValue out;
    if (!live_) return out;
    if (name == "True" || name == "False") return name == "True";
    if (name == "None") return out;
    if (names_.property(name, out)) return out;
    if (constant(name, out)) return out;
    if (is_builtin(name)) return XacroFunction{name};
    unresolved_ = name;
    return out;
  }

  XacroValue list() {
    auto out = std::make_shared<XacroList>();
    if (take("]")) return out;
    const std::size_t begin = at_;
    unused([&] { return conditional(); });
    if (word("for")) {
      clauses(begin, [&](XacroValue item, XacroValue) { out->push_back(std::move(item)); });
      expect("]");
      return out;
    }
    at_ = begin;
    do {
      if (is("]")) break;
      out->push_back(conditional());
    } while (take(","));
    expect("]");
    return out;
  }

  /// A value, or `value for name in …`, which makes a list.
  XacroValue element_or_comprehension() {
    const std::size_t begin = at_;
    unused([&] { return conditional(); });
    if (!word("for")) {
      at_ = begin;
      return conditional();
    }
    auto out = std::make_shared<XacroList>();
    clauses(begin, [&](XacroValue item, XacroValue) { out->push_back(std::move(item)); });
    return out;
  }

  using Emit = std::function<void(XacroValue item, XacroValue value)>;

  /// Any number of `for names in source` and `if condition`; then evaluates the expression at `element`.
  void clauses(std::size_t element, const Emit& emit) {
    const Deeper deeper(*this);
    if (take_word("for")) {
      const std::vector<std::string> variables = loop_names();
      if (!take_word("in")) refuse("'in' was expected before '" + shown() + "'");
      const XacroValue source = disjunction();
      const std::size_t after = at_;
      for (const XacroValue& item : live_ ? items_of(source) : XacroList{}) {
        const std::size_t locals = locals_.size();
        bind(variables, item);
        at_ = after;
        clauses(element, emit);
        locals_.resize(locals);
      }
      at_ = after;
      skip_clauses(element, emit);
    } else if (take_word("if")) {
      if (truth_of(disjunction()) || !live_)
        clauses(element, emit);
      else
        skip_clauses(element, emit);
    } else if (live_) {
      const std::size_t end = std::exchange(at_, element);
      XacroValue item = conditional();
      if ((made_ += 1 + size_of(item)) > kMostSteps) refuse("it makes too much");
      emit(std::move(item), take(":") ? conditional() : XacroValue());
      at_ = end;
    }
  }

  void skip_clauses(std::size_t element, const Emit& emit) {
    unused([&] {
      clauses(element, emit);
      return XacroValue();
    });
  }

  std::vector<std::string> loop_names() {
    std::vector<std::string> out;
    const bool enclosed = take("(");
    do {
      if (here().kind != Token::name) refuse("a name was expected after 'for'");
      out.push_back(tokens_[at_++].word);
    } while (take(","));
    if (enclosed) expect(")");
    return out;
  }

  void bind(const std::vector<std::string>& variables, const XacroValue& item) {
    if (variables.size() == 1) {
      locals_.emplace_back(variables.front(), item);
      return;
    }
    const XacroList parts = items_of(item);
    if (parts.size() != variables.size()) refuse("there are not as many values as names");
    for (std::size_t k = 0; k < parts.size(); ++k) locals_.emplace_back(variables[k], parts[k]);
  }

  XacroValue dict() {
    auto out = std::make_shared<XacroDict>();
    const std::size_t begin = at_;
    const auto pair = [&] {
      XacroValue key = conditional();
      expect(":");
      XacroValue value = conditional();
      if (live_) set_key(*out, key, std::move(value));
      return XacroValue();
    };
    if (!is("}")) unused(pair);
    if (word("for")) {
      clauses(begin, [&](const XacroValue& key, XacroValue value) { set_key(*out, key, std::move(value)); });
    } else {
      at_ = begin;
      while (!is("}")) {
        pair();
        if (!take(",")) break;
      }
    }
    expect("}");
    return out;
  }

  XacroList arguments(XacroDict* named = nullptr) {
    XacroList out;
    expect("(");
    while (!is(")")) {
      const bool keyword =
          here().kind == Token::name && tokens_[at_ + 1].kind == Token::sign && tokens_[at_ + 1].word == "=";
      if (keyword) {
        const std::string key = here().word;
        at_ += 2;
        XacroValue value = conditional();
        if (!named) refuse("'" + key + "=' is not understood here");
        named->emplace_back(key, std::move(value));
      } else {
        out.push_back(element_or_comprehension());
      }
      if (!take(",")) break;
    }
    expect(")");
    return out;
  }

  XacroValue call(const std::string& name, const XacroValue&) {
    XacroDict named;
    const XacroList values = arguments(&named);
    if (!live_) return {};
    if (name.empty()) refuse("this cannot be called");
    XacroValue out;
    const auto dot = name.find('.');
    const std::string bare = dot == std::string::npos ? name : name.substr(dot + 1);  // in a module
    unresolved_.clear();
    XacroList all = values;
    if (bare == "tokenize")
      for (const char* key : {"sep", "skip_empty"})
        for (const auto& [own, value] : named)
          if (*own.text() == key) all.push_back(value);
    const bool takes_names = bare == "dict" || bare == "tokenize" || name.starts_with("xacro.");
    if (!named.empty() && !takes_names) refuse("'" + *named[0].first.text() + "=' is not understood here");
    if (!names_.function(bare, all, out) && !call_builtin(bare, all, out))
      refuse("there is no function '" + name + "'" + did_you_mean(bare, builtin_names()));
    if (bare == "dict")
      for (const auto& [key, value] : named)
        set_key(*std::get<std::shared_ptr<XacroDict>>(out.data), key, value);
    return out;
  }

  XacroValue method(const std::string& name, const XacroValue& on, const std::string& member) {
    if (name == "xacro" || name == "math" || name == "python") {  // modules
      unresolved_.clear();
      return call(name + "." + member, {});
    }
    XacroDict named;
    const XacroList values = arguments(&named);
    if (!live_) return {};
    check_defined(name);
    return call_method(on, member, values, named);
  }

  XacroValue attribute(const std::string& name, const XacroValue& on, const std::string& member) {
    XacroValue out;
    if (!live_) return out;
    if (unresolved_ == name && (name == "math" || name == "xacro" || name == "python")) {
      unresolved_.clear();
      if (constant(member, out)) return out;
      if (is_builtin(member)) return XacroFunction{member};
      unresolved_ = name + "." + member;
      return out;
    }
    check_defined(name);
    if (const auto* space = std::get_if<const XacroScope*>(&on.data)) {
      if (names_.member(*space, member, out)) return out;
      refuse("the name space has no property '" + member + "'");
    }
    if (const XacroDict* dict = on.dict()) {
      for (const auto& [key, value] : *dict)
        if (key.text() && *key.text() == member) return value;
      refuse("there is no key '" + member + "'");
    }
    refuse("'" + member + "' is not available for " + repr_of(on));
  }

  void check_defined(const std::string& name) {
    if (!name.empty() && unresolved_ == name) refuse("the name '" + name + "' is not defined");
  }

  XacroValue index(const XacroValue& on) {
    XacroValue begin, end, step;
    bool slice = false;
    if (!is(":")) begin = conditional();
    if (take(":")) {
      slice = true;
      if (!is("]") && !is(":")) end = conditional();
      if (take(":") && !is("]")) step = conditional();
    }
    expect("]");
    if (!live_) return {};
    return slice ? slice_of(on, begin, end, step) : item_of(on, begin);
  }

  std::vector<Token> tokens_;
  const XacroNames& names_;
  std::size_t at_ = 0, steps_ = 0, made_ = 0;
  int depth_ = 0;
  bool live_ = true;
  std::string unresolved_;  // an unknown name that may still be a function
  std::vector<std::pair<std::string, XacroValue>> locals_;
};

}  // namespace

XacroValue evaluate_expression(std::string_view text, const XacroNames& names) {
  if (text.size() > 20'000) refuse("it is too long");
  const XacroWork work;
  spend(5 * text.size());
  return Evaluator(Lexer(text).all(), names).all();
}

}  // namespace polyarm::description
