#include "polyarm/description/xacro.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <cstdlib>
#include <memory>
#include <optional>
#include <set>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/description/xacro_value.hpp"
#include "polyarm/description/xacro_yaml.hpp"

namespace polyarm::description {

namespace fs = std::filesystem;
using tinyxml2::XMLDocument;
using tinyxml2::XMLElement;
using tinyxml2::XMLNode;

/// What names mean at a place: of a file, of a macro that is being expanded, or of an include with a name
/// space.
struct XacroScope {
  struct Property {
    XacroValue value;
    bool raw = false;      // a text that is evaluated when it is first asked for
    bool working = false;  // it is being evaluated
  };
  struct Parameter {
    std::string name;
    int block = 0;  // stars
    bool forwards = false;
    std::optional<std::string> fallback;
  };
  struct Macro {
    std::vector<Parameter> parameters;
    const XMLElement* body = nullptr;
    fs::path file;
  };
  XacroScope* parent = nullptr;
  XacroScope* otherwise = nullptr;  // where properties are looked for that neither this nor its parents have
  bool is_space = false;
  std::map<std::string, Property> properties;
  std::map<std::string, std::shared_ptr<XMLDocument>> blocks;  // "*name": whole, "**name": its contents
  std::map<std::string, Macro> macros;
};

namespace {

using Parameter = XacroScope::Parameter;
using Macro = XacroScope::Macro;

constexpr int kDeepest = 150;
constexpr std::size_t kMostElements = 2'000'000;
constexpr std::size_t kLongestText = 5'000'000;  // bytes
constexpr std::size_t kMostText = 100'000'000;   // of all evaluated texts together

bool is_true(const XacroValue& value, const std::string& written) {
  if (!value.text()) return truth_of(value);
  const std::string text(trim(*value.text()));
  if (text == "true" || text == "True") return true;
  if (text == "false" || text == "False") return false;
  if (const XacroValue literal = literal_of(text); literal.is_number()) return truth_of(literal);
  throw Error("bad-condition", "'" + written + "' is neither true nor false (it is '" + text + "')");
}

class Expander {
 public:
  Expander(const XacroOptions& options, Problems& warnings, XacroReport* report)
      : options_(options), warnings_(warnings), report_(report) {
    for (const auto& [name, value] : options.arguments) arguments_[name] = value;
  }

  std::string expand(std::string_view text, const fs::path& file) {
    find_package_ = packages_near(file, options_.packages);
    reading_ = {file};
    const XMLElement* root = load(text, file);
    Frame frame{file, &new_scope(nullptr)};
    XMLElement* out = output_.NewElement(root->Name());
    output_.InsertEndChild(out);
    const Inside inside(*this, Step{file, root->GetLineNum(), ""});
    attributes(*root, *out, frame);
    if (const char* space = root->Attribute("xacro:targetNamespace")) out->SetAttribute("xmlns", space);
    children(*root, *out, frame);
    if (report_) report_->arguments = {arguments_.begin(), arguments_.end()};
    tinyxml2::XMLPrinter printer;
    output_.Print(&printer);
    return "<?xml version=\"1.0\" ?>\n" + std::string(printer.CStr());
  }

 private:
  struct Frame {
    fs::path file;
    XacroScope* scope = nullptr;
  };
  struct Step {
    fs::path file;
    int line = 0;
    std::string what;  // "in the macro 'arm'", "included from here"; empty: just there
  };
  /// Where we are, for what goes wrong below.
  struct Inside {
    Inside(Expander& e, Step step) : e_(e) {
      if (e_.steps_.size() > 2 * kDeepest)
        e_.fail("macros or includes lead deeper and deeper into themselves");
      e_.steps_.push_back(std::move(step));
    }
    ~Inside() { e_.steps_.pop_back(); }
    Expander& e_;
  };

  // --- what goes wrong ---

  [[noreturn]] void fail(const std::string& what, const std::string& advice = {}) const {
    Location where;
    std::string chain;
    for (auto step = steps_.rbegin(); step != steps_.rend(); ++step) {
      if (where.file.empty()) where = {step->file.string(), step->line};
      if (!step->what.empty() && chain.size() < 2000)
        chain += "; " + step->what + " (" + step->file.string() + ":" + std::to_string(step->line) + ")";
    }
    throw Error(Problem{"xacro", where, what + chain, advice});
  }

  /// Runs what may throw without a place, and gives it this one.
  template <typename Work>
  auto placed(const std::string& written, Work work) const {
    try {
      return work();
    } catch (const Error& e) {
      const Problem& problem = e.problems().front();
      if (!problem.where.file.empty()) throw;
      fail(problem.what + " in '" + written + "'", problem.advice);
    }
  }

  // --- documents and scopes, which live as long as the expander ---

  const XMLElement* load(std::string_view text, const fs::path& file) {
    documents_.push_back(std::make_unique<XMLDocument>());
    XMLDocument& document = *documents_.back();
    if (report_) report_->files.push_back(file);
    if (document.Parse(text.data(), text.size()) != tinyxml2::XML_SUCCESS)
      throw Error(Problem{"xml-syntax",
                          {file.string(), document.ErrorLineNum()},
                          "not valid XML: " + std::string(document.ErrorName()),
                          "check that every element is closed and every quote has its partner"});
    if (!document.RootElement())
      throw Error(Problem{"xml-syntax", {file.string(), 1}, "there is no element in the file"});
    return document.RootElement();
  }

  XacroScope& new_scope(XacroScope* parent) {
    scopes_.push_back(std::make_unique<XacroScope>());
    scopes_.back()->parent = parent;
    return *scopes_.back();
  }

  // --- texts ---

  XacroValue* find_property(XacroScope* scope, const std::string& name) {
    const XacroScope* asked = scope;
    for (; scope; scope = scope->parent) {
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

  XacroNames names_for(XacroScope* scope) {
    XacroNames out;
    out.property = [this, scope](const std::string& name, XacroValue& value) {
      if (const XacroValue* found = find_property(scope, name)) return value = *found, true;
      return false;
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

  /// Everything in `${…}` and `$(…)` of a text. A text that is one `${…}` keeps the type of its value.
  XacroValue evaluate(const std::string& text, XacroScope* scope) {
    if (text.find('$') == std::string::npos) return text;
    if (++evaluations_ > kMostElements) fail("the expansion takes too long");
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
      if (dollars - at > 1 && (open == '{' || open == '(')) {  // escaped: one dollar less, and as it is
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

  /// The ')' that belongs to the '(' at `open`.
  static std::size_t closing(const std::string& text, std::size_t open) {
    int depth = 0;
    for (std::size_t at = open; at < text.size(); ++at) {
      depth += text[at] == '(' ? 1 : text[at] == ')' ? -1 : 0;
      if (depth == 0) return at;
    }
    return std::string::npos;
  }

  std::string text_of(const std::string& text, XacroScope* scope) {
    return placed(text, [&] { return str_of(evaluate(text, scope)); });
  }

  /// What a property or a parameter becomes that is given this text.
  XacroValue value_of_text(const std::string& text, XacroScope* scope) {
    return placed(text, [&] { return literal_of(evaluate(text, scope)); });
  }

  /// `$(arg x)`, `$(find p)`, `$(env V)`, `$(eval …)` and their like.
  XacroValue substitution(const std::string& inner, XacroScope* scope) {
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

  /// In $(eval …) arguments come first, and a number in one is a number.
  XacroNames eval_names(XacroScope* scope) {
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

  /// The functions of xacro itself, which `$(name …)` and `xacro.name(…)` both mean.
  bool function(const std::string& name, const XacroList& a, XacroValue& out) {
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
      if (folder.empty())
        throw Error("no-package", "the package '" + text(0) + "' is not found",
                    "say where it is with --package " + text(0) + "=FOLDER, or set POLYARM_PACKAGES");
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

  int current_line() const { return steps_.back().line; }

  /// Relative names begin beside the file that was included last, wherever the macro was written that says
  /// them.
  fs::path resolve(const std::string& name) const {
    const fs::path path = name;
    return path.is_absolute() ? path : reading_.back().parent_path() / path;
  }

  /// The file to read for a name. A package may keep it deeper in its sources than it installs it.
  fs::path file_for(const std::string& name) const {
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

  // --- YAML ---

  XacroValue load_yaml(const std::string& name) {
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

  // --- elements ---

  void attributes(const XMLElement& in, XMLElement& out, Frame& frame) {
    for (const tinyxml2::XMLAttribute* a = in.FirstAttribute(); a; a = a->Next()) {
      const std::string name = a->Name();
      if (name == "xmlns:xacro" || name.starts_with("xacro:")) continue;
      out.SetAttribute(name.c_str(), text_of(a->Value(), frame.scope).c_str());
    }
  }

  void children(const XMLNode& in, XMLNode& out, Frame& frame) {
    bool reads_comments = false;  // as a comment before them asked for
    for (const XMLNode* child = in.FirstChild(); child; child = child->NextSibling()) {
      if (const XMLElement* e = child->ToElement()) {
        element(*e, out, frame);
        reads_comments = false;
      } else if (const tinyxml2::XMLText* text = child->ToText()) {
        const std::string value = text->CData() ? text->Value() : text_of(text->Value(), frame.scope);
        tinyxml2::XMLText* made = output_.NewText(value.c_str());
        made->SetCData(text->CData());
        out.InsertEndChild(made);
        if (!trim(value).empty()) reads_comments = false;
      } else if (const tinyxml2::XMLComment* note = child->ToComment()) {
        comment(*note, out, frame, reads_comments);
      }
    }
  }

  /// Comments are kept, but for those right above an element of xacro: they are about it.
  void comment(const tinyxml2::XMLComment& note, XMLNode& out, Frame& frame, bool& reads_comments) {
    const std::string written = note.Value();
    if (written.find("xacro:eval-comments") != std::string::npos) {
      reads_comments = written.find("xacro:eval-comments:off") == std::string::npos;
      return;
    }
    const std::string value = reads_comments ? text_of(written, frame.scope) : written;
    if (is_about_xacro(note) || value.find("--") != std::string::npos) return;
    out.InsertEndChild(output_.NewComment(value.c_str()));
  }

  /// No empty line is between them, and nothing but other comments.
  static bool is_about_xacro(const tinyxml2::XMLComment& note) {
    const XMLNode* above = &note;
    for (const XMLNode* next = note.NextSibling(); next; above = next, next = next->NextSibling()) {
      const std::string_view written = above->Value();
      const auto lines = std::count(written.begin(), written.end(), '\n');
      if (next->GetLineNum() - above->GetLineNum() - lines > 1) return false;
      if (next->ToComment()) continue;
      const std::string_view tag = next->ToElement() ? next->Value() : "";
      return tag.starts_with("xacro:") && tag != "xacro:insert_block" && tag != "xacro:element" &&
             tag != "xacro:attribute";
    }
    return false;
  }

  /// What the name spaces of XML are called that a file or macro uses is said where its elements go.
  void take_namespaces(const XMLElement& from, XMLNode& out) {
    XMLElement* into = out.ToElement();
    for (const tinyxml2::XMLAttribute* a = from.FirstAttribute(); into && a; a = a->Next())
      if (const std::string_view name = a->Name();
          name.starts_with("xmlns:") && name != "xmlns:xacro" && !into->Attribute(a->Name()))
        into->SetAttribute(a->Name(), a->Value());
  }

  void element(const XMLElement& e, XMLNode& out, Frame& frame) {
    if (++elements_ > kMostElements) fail("the expansion has too many elements");
    const Inside inside(*this, Step{frame.file, e.GetLineNum(), ""});
    const std::string tag = e.Name();
    if (!tag.starts_with("xacro:")) {
      XMLElement* made = output_.NewElement(e.Name());
      out.InsertEndChild(made);
      attributes(e, *made, frame);
      children(e, *made, frame);
      return;
    }
    const std::string name = tag.substr(6);
    if (name == "property") return property(e, frame);
    if (name == "macro") return define(e, frame);
    if (name == "include") return include(e, out, frame);
    if (name == "arg") return argument(e, frame);
    if (name == "if" || name == "unless") return condition(e, out, frame, name == "if");
    if (name == "insert_block") return insert_block(e, out, frame);
    if (name == "element") return made_element(e, out, frame);
    if (name == "attribute") return made_attribute(e, out, frame);
    if (name == "call") {
      const std::string called = text_of(required(e, "macro"), frame.scope);
      return call(e, called, out, frame, "macro");
    }
    call(e, name, out, frame, nullptr);
  }

  std::string required(const XMLElement& e, const char* name) {
    const char* value = e.Attribute(name);
    if (!value) fail(std::string("<") + e.Name() + "> has no attribute '" + name + "'");
    return value;
  }

  std::shared_ptr<XMLDocument> contents_of(const XMLElement& e, Frame& frame) {
    auto holder = std::make_shared<XMLDocument>();
    XMLElement* made = output_.NewElement("holder");  // made in the output document, copied out of it
    children(e, *made, frame);
    holder->InsertEndChild(made->DeepClone(holder.get()));
    output_.DeleteNode(made);
    return holder;
  }

  void property(const XMLElement& e, Frame& frame) {
    const std::string name = text_of(required(e, "name"), frame.scope);
    if (!is_identifier(name)) fail("'" + name + "' is no name for a property");
    const char* value = e.Attribute("value");
    const char* fallback = e.Attribute("default");
    if (flag(e, "remove", false, frame)) {
      if (value || fallback) fail("'" + name + "' is removed and given a value at once");
      for (XacroScope* scope = frame.scope; scope; scope = scope->parent) scope->properties.erase(name);
      return;
    }
    if (!value && fallback) {
      if (has_property(frame.scope, name)) return;
      value = fallback;
    }
    bool lazy = flag(e, "lazy_eval", true, frame);
    XacroScope& target = target_of(e, name, frame, lazy);
    if (!value) {  // a block, evaluated where it is inserted
      auto holder = std::make_shared<XMLDocument>();
      holder->InsertEndChild(e.DeepClone(holder.get()));
      target.blocks["**" + name] = holder;
      return;
    }
    const XacroValue given = lazy ? literal_of(std::string(value)) : value_of_text(value, frame.scope);
    target.properties[name] = {given, lazy && given.text(), false};
  }

  /// The scope that a property goes to. What leaves its own is evaluated at once.
  XacroScope& target_of(const XMLElement& e, const std::string& name, Frame& frame, bool& lazy) {
    const std::string where = e.Attribute("scope") ? e.Attribute("scope") : "";
    XacroScope* target = frame.scope;
    if (where == "global") {
      while (target->parent) target = target->parent;
    } else if (where == "parent") {
      if (target->parent) target = target->parent;
      if (!frame.scope->is_space)
        while (target->is_space) target = target->parent;  // to who called the macro
    } else {
      if (!where.empty() && where != "local")
        warnings_.warning("xacro-scope", {frame.file.string(), e.GetLineNum()},
                          "the scope of '" + name + "' is '" + where + "', not parent or global");
      return *target;
    }
    lazy = false;
    return *target;
  }

  bool flag(const XMLElement& e, const char* name, bool otherwise, Frame& frame) {
    const char* written = e.Attribute(name);
    return written ? placed(written, [&] { return is_true(evaluate(written, frame.scope), written); })
                   : otherwise;
  }

  static bool is_identifier(const std::string& name) {
    const auto letter = [](unsigned char c) { return std::isalnum(c) || c == '_' || c > 127; };
    return !name.empty() && !std::isdigit(static_cast<unsigned char>(name[0])) && !name.starts_with("__") &&
           std::all_of(name.begin(), name.end(), letter);
  }

  static bool has_property(const XacroScope* scope, const std::string& name) {
    for (; scope; scope = scope->parent)
      if (scope->properties.contains(name)) return true;
    return false;
  }

  void argument(const XMLElement& e, Frame& frame) {
    const std::string name = text_of(required(e, "name"), frame.scope);
    if (arguments_.contains(name)) return;
    if (const char* fallback = e.Attribute("default")) arguments_[name] = text_of(fallback, frame.scope);
  }

  void condition(const XMLElement& e, XMLNode& out, Frame& frame, bool wanted) {
    required(e, "value");
    if (flag(e, "value", false, frame) == wanted) children(e, out, frame);
  }

  void made_element(const XMLElement& e, XMLNode& out, Frame& frame) {
    const std::string name = text_of(required(e, "xacro:name"), frame.scope);
    if (name.empty()) fail("<xacro:element> has an empty name");
    XMLElement* made = output_.NewElement(name.c_str());
    out.InsertEndChild(made);
    attributes(e, *made, frame);
    made->DeleteAttribute("xacro:name");
    children(e, *made, frame);
  }

  void made_attribute(const XMLElement& e, XMLNode& out, Frame& frame) {
    const std::string name = text_of(required(e, "name"), frame.scope);
    const std::string value = text_of(required(e, "value"), frame.scope);
    XMLElement* parent = out.ToElement();
    if (name.empty() || !parent) fail("<xacro:attribute> has no element to belong to, or no name");
    parent->SetAttribute(name.c_str(), value.c_str());
  }

  void insert_block(const XMLElement& e, XMLNode& out, Frame& frame) {
    const std::string name = text_of(required(e, "name"), frame.scope);
    for (const char* stars : {"**", "*"})
      for (XacroScope* scope = frame.scope; scope; scope = scope->parent) {
        const auto found = scope->blocks.find(stars + name);
        if (found == scope->blocks.end()) continue;
        const std::shared_ptr<XMLDocument> block = found->second;
        const XMLElement* holder = block->RootElement();
        if (++elements_ > kMostElements) fail("the expansion has too many elements");
        const Inside inside(*this, Step{frame.file, e.GetLineNum(), "in the block '" + name + "'"});
        children(*holder, out, frame);
        return;
      }
    fail("there is no block '" + name + "'");
  }

  // --- macros ---

  /// "a b:=2 c:=^|3 *origin": names, and what each is when it is not given.
  std::vector<Parameter> parameters_of(const std::string& text) const {
    std::vector<Parameter> out;
    std::size_t at = 0;
    const auto blank = [&](std::size_t i) { return std::isspace(static_cast<unsigned char>(text[i])) != 0; };
    const auto past_blanks = [&](std::size_t i) {
      while (i < text.size() && blank(i)) ++i;
      return i;
    };
    while ((at = past_blanks(at)) < text.size()) {
      Parameter p;
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
      if (p.name.empty() || p.block > 2 || (at < text.size() && !blank(at)))
        fail("the parameters '" + text + "' of the macro are not understood");
      out.push_back(std::move(p));
    }
    return out;
  }

  /// A default ends at a blank that is neither within quotes nor within the `${…}` or `$(…)` that it is.
  static std::size_t end_of_default(const std::string& text, std::size_t begin) {
    const auto ends = [&](std::size_t at) {
      return at >= text.size() || std::isspace(static_cast<unsigned char>(text[at]));
    };
    for (const auto& [open, close] : {std::pair{"${", '}'}, {"$(", ')'}})
      if (text.compare(begin, 2, open) == 0)
        for (auto at = text.find(close, begin); at != std::string::npos; at = text.find(close, at + 1))
          if (ends(at + 1)) return at + 1;
    std::size_t at = begin;
    while (!ends(at)) {
      const bool quote = text[at] == '\'' || text[at] == '"';
      const auto partner = quote ? text.find(text[at], at + 1) : at;
      if (partner == std::string::npos) return at;
      at = partner + 1;
    }
    return at;
  }

  void define(const XMLElement& e, Frame& frame) {
    std::string name = required(e, "name");
    if (name.starts_with("xacro:")) name = name.substr(6);
    if (name.find('.') != std::string::npos) fail("a macro's name may hold no '.': '" + name + "'");
    Macro macro{parameters_of(e.Attribute("params") ? e.Attribute("params") : ""), &e, frame.file};
    frame.scope->macros[name] = std::move(macro);
  }

  /// The name space of that name that is seen from `scope`.
  static XacroScope* find_space(XacroScope* scope, const std::string& name) {
    for (; scope; scope = scope->parent)
      if (const auto found = scope->properties.find(name); found != scope->properties.end())
        if (const auto* space = std::get_if<const XacroScope*>(&found->second.value.data))
          return const_cast<XacroScope*>(*space);
    return nullptr;
  }

  /// "name" or "space.name"; `scope` becomes the one that the macro is expanded in.
  static const Macro* find_macro(std::string_view name, XacroScope*& scope) {
    for (auto dot = name.find('.'); dot != std::string_view::npos; dot = name.find('.')) {
      scope = find_space(scope, std::string(name.substr(0, dot)));
      if (!scope) return nullptr;
      name.remove_prefix(dot + 1);
    }
    for (const XacroScope* at = scope; at; at = at->parent)
      if (const auto found = at->macros.find(std::string(name)); found != at->macros.end())
        return &found->second;
    return nullptr;
  }

  [[noreturn]] void unknown_macro(const std::string& name, const Frame& frame) const {
    std::vector<std::string> known;
    for (const XacroScope* at = frame.scope; at; at = at->parent)
      for (const auto& [macro, body] : at->macros) known.push_back(macro);
    fail("there is no macro '" + name + "'" + did_you_mean(name, known));
  }

  void call(const XMLElement& e, const std::string& name, XMLNode& out, Frame& frame,
            const char* own_attribute) {
    XacroScope* home = frame.scope;
    const Macro* found = find_macro(name, home);
    if (!found) unknown_macro(name, frame);
    if (steps_.size() > kDeepest) fail("the macro '" + name + "' leads deeper and deeper into itself");
    const Macro macro = *found;
    Frame outer{frame.file, home};  // what is given is read where the macro lives, if it is a name space
    if (home != frame.scope) {
      outer.scope = &new_scope(home);
      outer.scope->otherwise = frame.scope;
    }
    XacroScope& scope = new_scope(home);
    std::set<std::string> given;
    for (const tinyxml2::XMLAttribute* a = e.FirstAttribute(); a; a = a->Next()) {
      const std::string key = a->Name();
      if (own_attribute && key == own_attribute) continue;
      const bool known = std::any_of(macro.parameters.begin(), macro.parameters.end(),
                                     [&](const Parameter& p) { return p.block == 0 && p.name == key; });
      if (!known) {
        std::vector<std::string> names;
        for (const Parameter& p : macro.parameters) names.push_back(p.name);
        fail("the macro '" + name + "' has no parameter '" + key + "'" + did_you_mean(key, names));
      }
      scope.properties[key] = {value_of_text(a->Value(), outer.scope), false, false};
      given.insert(key);
    }
    blocks(e, name, macro, scope, outer);
    defaults(name, macro, scope, given, outer);
    Frame inner{macro.file, &scope};
    const Inside inside(*this, Step{frame.file, e.GetLineNum(), "in the macro '" + name + "'"});
    take_namespaces(*macro.body, out);
    children(*macro.body, out, inner);
  }

  /// The elements within a call, in the order of the parameters that take them.
  void blocks(const XMLElement& e, const std::string& name, const Macro& macro, XacroScope& scope,
              Frame& frame) {
    const std::shared_ptr<XMLDocument> all = contents_of(e, frame);
    const XMLElement* next = all->RootElement()->FirstChildElement();
    for (const Parameter& p : macro.parameters) {
      if (p.block == 0) continue;
      if (!next) fail("the macro '" + name + "' was given no element for its block '" + p.name + "'");
      auto holder = std::make_shared<XMLDocument>();
      if (p.block == 2) {
        holder->InsertEndChild(next->DeepClone(holder.get()));
      } else {
        XMLElement* outer = holder->NewElement("holder");
        holder->InsertEndChild(outer);
        outer->InsertEndChild(next->DeepClone(holder.get()));
      }
      scope.blocks[std::string(static_cast<std::size_t>(p.block), '*') + p.name] = holder;
      next = next->NextSiblingElement();
    }
    if (next)
      fail("the macro '" + name + "' has no parameter for the element <" + std::string(next->Name()) + ">");
  }

  /// Defaults are read where the macro is called, not within it.
  void defaults(const std::string& name, const Macro& macro, XacroScope& scope,
                const std::set<std::string>& given, Frame& frame) {
    std::vector<std::string> missing;
    for (const Parameter& p : macro.parameters) {
      if (p.block > 0 || given.contains(p.name)) continue;
      const XacroValue* outer =
          p.forwards ? placed(p.name, [&] { return find_property(frame.scope, p.name); }) : nullptr;
      if (outer)
        scope.properties[p.name] = {literal_of(*outer), false, false};
      else if (p.fallback)
        scope.properties[p.name] = {value_of_text(*p.fallback, frame.scope), false, false};
      else
        missing.push_back(p.name);
    }
    if (!missing.empty()) fail("the macro '" + name + "' needs a value for " + join(missing, ", "));
  }

  // --- includes ---

  void include(const XMLElement& e, XMLNode& out, Frame& frame) {
    const std::string written = required(e, "filename");
    const std::string name = text_of(written, frame.scope);
    const bool optional = flag(e, "optional", false, frame);
    std::vector<fs::path> files;
    const bool many = name.find_first_of("*?[") != std::string::npos;
    const fs::path path = many ? resolve(name) : file_for(name);
    std::error_code error;
    if (many) {
      files = files_matching(path);
      if (files.empty() && !optional)
        warnings_.warning("no-file", {frame.file.string(), e.GetLineNum()}, "no file matches '" + name + "'");
    } else if (fs::is_regular_file(path, error)) {
      files.push_back(path);
    } else if (!optional) {
      fail("there is no file '" + path.string() + "' to include");
    }
    XacroScope* scope = frame.scope;
    if (e.Attribute("ns")) {
      scope = &new_scope(frame.scope);
      scope->is_space = true;
      const XacroScope* space = scope;
      frame.scope->properties[text_of(e.Attribute("ns"), frame.scope)] = {space, false, false};
    }
    for (const fs::path& file : files) {
      if (++included_ > 5000 || steps_.size() > kDeepest) fail("files include each other without end");
      const Inside inside(*this, Step{frame.file, e.GetLineNum(), "included from here"});
      const XMLElement* root = load(read_file(file), file);
      Frame inner{file, scope};
      const Inside there(*this, Step{file, root->GetLineNum(), ""});
      take_namespaces(*root, out);
      reading_.push_back(file);
      children(*root, out, inner);
      reading_.pop_back();
    }
  }

  const XacroOptions& options_;
  Problems& warnings_;
  XacroReport* report_;
  PackageSearch find_package_;
  XMLDocument output_;
  std::vector<std::unique_ptr<XMLDocument>> documents_;
  std::vector<std::unique_ptr<XacroScope>> scopes_;
  std::map<std::string, std::string> arguments_;
  std::map<std::string, XacroValue> yamls_;
  std::vector<Step> steps_;
  std::vector<fs::path> reading_;  // the file and the includes that lead to where we are
  std::set<fs::path> packages_;    // that $(find) found
  std::size_t included_ = 0;
  std::size_t elements_ = 0, evaluations_ = 0, written_ = 0;
  int depth_ = 0;
};

}  // namespace

std::string expand_xacro_text(std::string_view text, const fs::path& file, const XacroOptions& options,
                              Problems& warnings, XacroReport* report) {
  return Expander(options, warnings, report).expand(text, file);
}

std::string expand_xacro(const fs::path& file, const XacroOptions& options, Problems& warnings,
                         XacroReport* report) {
  return expand_xacro_text(read_file(file), file, options, warnings, report);
}

bool uses_xacro(std::string_view text) {
  return text.find("<xacro:") != std::string_view::npos || text.find("xmlns:xacro") != std::string_view::npos;
}

}  // namespace polyarm::description
