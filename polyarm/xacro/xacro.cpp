#include "polyarm/xacro/xacro.hpp"

#include <tinyxml2.h>

#include <algorithm>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <optional>
#include <set>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/xml_bounds.hpp"
#include "polyarm/xacro/xacro_texts.hpp"
#include "polyarm/xacro/xacro_work.hpp"

namespace polyarm::description {

using tinyxml2::XMLDocument;
using tinyxml2::XMLElement;
using tinyxml2::XMLNode;

namespace {

using Parameter = XacroScope::Parameter;
using Macro = XacroScope::Macro;

bool is_true(const XacroValue& value, const std::string& written) {
  if (!value.text()) return truth_of(value);
  const std::string text(trim(*value.text()));
  if (text == "true" || text == "True") return true;
  if (text == "false" || text == "False") return false;
  if (const XacroValue literal = literal_of(text); literal.is_number()) return truth_of(literal);
  throw Error("bad-condition", "'" + written + "' is neither true nor false (it is '" + text + "')");
}

class Expander : private XacroTexts {
 public:
  using XacroTexts::XacroTexts;

  std::string expand(std::string_view text, const fs::path& file) {
    const XacroWork work;
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
  /// Calls spend(), and adds the present place to its error.
  void pay(std::size_t units) {
    try {
      spend(units);
    } catch (const Error& e) {
      fail(e.problems().front().what, e.problems().front().advice);
    }
  }

  /// The cost of copying an element.
  static std::size_t size_of_xml(const XMLNode& node) {
    std::size_t out = 20 + std::strlen(node.Value() ? node.Value() : "") / 16;
    if (const XMLElement* e = node.ToElement())
      for (const tinyxml2::XMLAttribute* a = e->FirstAttribute(); a; a = a->Next()) out += 10 + std::strlen(a->Value()) / 16;
    for (const XMLNode* child = node.FirstChild(); child; child = child->NextSibling()) out += size_of_xml(*child);
    return out;
  }
  XMLNode* copy_of_xml(const XMLNode& from, XMLDocument& into) {
    pay(size_of_xml(from));
    return from.DeepClone(&into);
  }

  // --- documents and scopes, which live as long as the expander ---

  const XMLElement* load(std::string_view text, const fs::path& file) {
    documents_.push_back(std::make_unique<XMLDocument>());
    XMLDocument& document = *documents_.back();
    if (report_) report_->files.push_back(file);
    pay(text.size() / 2);
    check_xml_bounds(text, file.string());
    const std::string plain = without_instructions(text);
    if (document.Parse(plain.data(), plain.size()) != tinyxml2::XML_SUCCESS)
      throw Error(Problem{"xml-syntax",
                          {file.string(), document.ErrorLineNum()},
                          "not valid XML: " + std::string(document.ErrorName()),
                          "check that every element is closed and every quote has its partner"});
    if (!document.RootElement())
      throw Error(Problem{"xml-syntax", {file.string(), 1}, "there is no element in the file"});
    return document.RootElement();
  }

  // --- elements ---

  void attributes(const XMLElement& in, XMLElement& out, Frame& frame) {
    for (const tinyxml2::XMLAttribute* a = in.FirstAttribute(); a; a = a->Next()) {
      const std::string name = a->Name();
      if (name == "xmlns:xacro" || name.starts_with("xacro:")) continue;
      out.SetAttribute(name.c_str(), is_mesh(in, name) ? mesh_of(a->Value(), frame).c_str()
                                                       : text_of(a->Value(), frame.scope).c_str());
    }
  }

  static bool is_mesh(const XMLElement& element, const std::string& attribute) {
    return attribute == "filename" && std::string_view(element.Name()) == "mesh";
  }
  /// A mesh may be in a package that is not here, like one of package://: the robot is read without it.
  std::string mesh_of(const char* written, Frame& frame) {
    keeps_unknown_packages_ = true;
    std::string out;
    try {
      out = text_of(written, frame.scope);
    } catch (...) {
      keeps_unknown_packages_ = false;
      throw;
    }
    keeps_unknown_packages_ = false;
    const auto at = out.find("file://package://");
    return at == 0 ? out.substr(std::strlen("file://")) : out;
  }

  void children(const XMLNode& in, XMLNode& out, Frame& frame) {
    bool reads_comments = false;  // a comment before the elements can switch this on
    for (const XMLNode* child = in.FirstChild(); child; child = child->NextSibling()) {
      if (const XMLElement* e = child->ToElement()) {
        element(*e, out, frame);
        reads_comments = false;
      } else if (const tinyxml2::XMLText* text = child->ToText()) {
        const std::string value = text->CData() ? text->Value() : text_of(text->Value(), frame.scope);
        pay(10 + value.size() / 8);
        tinyxml2::XMLText* made = output_.NewText(value.c_str());
        made->SetCData(text->CData());
        out.InsertEndChild(made);
        if (!trim(value).empty()) reads_comments = false;
      } else if (const tinyxml2::XMLComment* note = child->ToComment()) {
        comment(*note, out, frame, reads_comments);
      }
    }
  }

  /// Copies comments, except those directly above an xacro element, which describe the macro code.
  void comment(const tinyxml2::XMLComment& note, XMLNode& out, Frame& frame, bool& reads_comments) {
    const std::string written = note.Value();
    if (written.find("xacro:eval-comments") != std::string::npos) {
      reads_comments = written.find("xacro:eval-comments:off") == std::string::npos;
      return;
    }
    const std::string value = reads_comments ? text_of(written, frame.scope) : written;
    pay(10 + value.size() / 8);
    if (is_about_xacro(note) || value.find("--") != std::string::npos) return;
    out.InsertEndChild(output_.NewComment(value.c_str()));
  }

  /// True if the comment is directly above an xacro element, with only other comments and no empty line
  /// between.
  bool is_about_xacro(const tinyxml2::XMLComment& note) {
    const XMLNode* above = &note;
    for (const XMLNode* next = note.NextSibling(); next; above = next, next = next->NextSibling()) {
      const std::string_view written = above->Value();
      pay(2 + written.size() / 32);
      const auto lines = std::count(written.begin(), written.end(), '\n');
      if (next->GetLineNum() - above->GetLineNum() - lines > 1) return false;
      if (next->ToComment()) continue;
      const std::string_view tag = next->ToElement() ? next->Value() : "";
      return tag.starts_with("xacro:") && tag != "xacro:insert_block" && tag != "xacro:element" &&
             tag != "xacro:attribute";
    }
    return false;
  }

  /// Copies the XML name space declarations of a file or macro to where its elements go.
  void take_namespaces(const XMLElement& from, XMLNode& out) {
    XMLElement* into = out.ToElement();
    for (const tinyxml2::XMLAttribute* a = from.FirstAttribute(); into && a; a = a->Next())
      if (const std::string_view name = a->Name();
          name.starts_with("xmlns:") && name != "xmlns:xacro" && !into->Attribute(a->Name()))
        into->SetAttribute(a->Name(), a->Value());
  }

  /// True for an element of xacro without its prefix, as files from before ROS Noetic have. What is inside
  /// <gazebo> or <ros2_control> belongs to others.
  bool is_unprefixed(const XMLElement& e, const Frame& frame) {
    const std::string tag = e.Name();
    const auto has = [&](const char* name) {
      const char* value = e.Attribute(name);
      return value && *value;
    };
    const bool word = ((tag == "property" && has("name") && (has("value") || has("default"))) ||
                       (tag == "macro" && has("name")) || (tag == "insert_block" && has("name")) ||
                       ((tag == "if" || tag == "unless") && has("value")) ||
                       (tag == "include" && has("filename") && !e.FirstChildElement()));
    XacroScope* home = frame.scope;
    const Macro* const called = word ? nullptr : find_macro(tag, home);
    if (!word && !(called && std::string_view(called->body->Name()) == "macro")) return false;
    for (const XMLNode* above = e.Parent(); above; above = above->Parent())
      if (const std::string_view name = above->Value() ? above->Value() : "";
          name == "gazebo" || name == "ros2_control")
        return false;
    if (unprefixed_.insert(tag).second)
      warnings_.warning("xacro-prefix", {frame.file.string(), e.GetLineNum()},
                        "<" + tag + "> has no prefix; it is read as <xacro:" + tag + ">",
                        "write <xacro:" + tag + ">, which every release of xacro understands");
    return true;
  }

  void element(const XMLElement& e, XMLNode& out, Frame& frame) {
    if (++elements_ > kMostElements) fail("the expansion has too many elements");
    const Inside inside(*this, Step{frame.file, e.GetLineNum(), ""});
    pay(40);
    const std::string tag = e.Name();
    if (!tag.starts_with("xacro:") && !is_unprefixed(e, frame)) {
      XMLElement* made = output_.NewElement(e.Name());
      out.InsertEndChild(made);
      attributes(e, *made, frame);
      children(e, *made, frame);
      return;
    }
    const std::string name = tag.starts_with("xacro:") ? tag.substr(6) : tag;
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
    XMLElement* made = output_.NewElement("holder");  // created in the output document, then copied
    children(e, *made, frame);
    holder->InsertEndChild(copy_of_xml(*made, *holder));
    output_.DeleteNode(made);
    return holder;
  }

  void property(const XMLElement& e, Frame& frame) {
    const std::string name = text_of(required(e, "name"), frame.scope);
    if (!is_identifier(name)) fail("'" + name + "' is not a name for a property");
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
      holder->InsertEndChild(copy_of_xml(e, *holder));
      target.blocks["**" + name] = holder;
      return;
    }
    const XacroValue given = lazy ? literal_of(std::string(value)) : value_of_text(value, frame.scope);
    target.properties[name] = {given, lazy && given.text(), false};
  }

  /// The scope of a property. A property for another scope is evaluated immediately.
  XacroScope& target_of(const XMLElement& e, const std::string& name, Frame& frame, bool& lazy) {
    const std::string where = e.Attribute("scope") ? e.Attribute("scope") : "";
    XacroScope* target = frame.scope;
    if (where == "global") {
      while (target->parent) target = target->parent;
    } else if (where == "parent") {
      if (target->parent) target = target->parent;
      if (!frame.scope->is_space)
        while (target->is_space) target = target->parent;  // the caller of the macro
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

  void define(const XMLElement& e, Frame& frame) {
    std::string name = required(e, "name");
    if (name.starts_with("xacro:")) name = name.substr(6);
    if (name.find('.') != std::string::npos) fail("a macro's name may hold no '.': '" + name + "'");
    const std::string written = e.Attribute("params") ? e.Attribute("params") : "";
    auto parameters = xacro_parameters(written);
    if (!parameters) fail("the parameters '" + written + "' of the macro are not understood");
    if (report_ && reading_.size() == 1 && report_->macros.size() < 20) report_->macros.push_back(name);
    Macro macro{std::move(*parameters), &e, frame.file};
    frame.scope->macros[name] = std::move(macro);
  }

  /// The name space visible from `scope` under that name.
  static XacroScope* find_space(XacroScope* scope, const std::string& name) {
    for (; scope; scope = scope->parent)
      if (const auto found = scope->properties.find(name); found != scope->properties.end())
        if (const auto* space = std::get_if<const XacroScope*>(&found->second.value.data))
          return const_cast<XacroScope*>(*space);
    return nullptr;
  }

  /// "name" or "space.name"; sets `scope` to the one in which the macro is expanded.
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
    pay(20 + 20 * found->parameters.size());  // the parameters are copied, and each may be searched for
    const Macro macro = *found;
    Frame outer{frame.file, home};  // arguments are evaluated in the macro's name space, if it has one
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

  /// The child elements of a call, in the order of the block parameters.
  void blocks(const XMLElement& e, const std::string& name, const Macro& macro, XacroScope& scope,
              Frame& frame) {
    const std::shared_ptr<XMLDocument> all = contents_of(e, frame);
    const XMLElement* next = all->RootElement()->FirstChildElement();
    for (const Parameter& p : macro.parameters) {
      if (p.block == 0) continue;
      if (!next) fail("the macro '" + name + "' was given no element for its block '" + p.name + "'");
      auto holder = std::make_shared<XMLDocument>();
      if (p.block == 2) {
        holder->InsertEndChild(copy_of_xml(*next, *holder));
      } else {
        XMLElement* outer = holder->NewElement("holder");
        holder->InsertEndChild(outer);
        outer->InsertEndChild(copy_of_xml(*next, *holder));
      }
      scope.blocks[std::string(static_cast<std::size_t>(p.block), '*') + p.name] = holder;
      next = next->NextSiblingElement();
    }
    if (next)
      fail("the macro '" + name + "' has no parameter for the element <" + std::string(next->Name()) + ">");
  }

  /// Defaults are evaluated at the call, not inside the macro.
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
    } else if (std::string_view(e.Name()) == "include") {  // without a prefix it may be the word of others
      warnings_.warning("no-file", {frame.file.string(), e.GetLineNum()},
                        "there is no file '" + path.string() + "' to include; the line is ignored");
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
      const XMLElement* root = load(read_file(file, bounds::kXmlBytes), file);
      Frame inner{file, scope};
      const Inside there(*this, Step{file, root->GetLineNum(), ""});
      take_namespaces(*root, out);
      reading_.push_back(file);
      children(*root, out, inner);
      reading_.pop_back();
    }
  }

  XMLDocument output_;
  std::vector<std::unique_ptr<XMLDocument>> documents_;
  std::size_t included_ = 0, elements_ = 0;
  std::set<std::string> unprefixed_;  ///< tags that a warning has named
};

}  // namespace

std::string expand_xacro_text(std::string_view text, const fs::path& file, const XacroOptions& options,
                              Problems& warnings, XacroReport* report) {
  return Expander(options, warnings, report).expand(text, file);
}

std::string expand_xacro(const fs::path& file, const XacroOptions& options, Problems& warnings,
                         XacroReport* report) {
  return expand_xacro_text(read_file(file, bounds::kXmlBytes), file, options, warnings, report);
}

bool uses_xacro(std::string_view text) {
  return text.find("<xacro:") != std::string_view::npos || text.find("xmlns:xacro") != std::string_view::npos;
}

}  // namespace polyarm::description
