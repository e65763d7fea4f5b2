#pragma once
/// Evaluates the texts of xacro files: names, `${…}` and `$(…)`, with error locations. Private to this room.
#include <tinyxml2.h>

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "polyarm/xacro/xacro.hpp"
#include "polyarm/xacro/xacro_value.hpp"

namespace polyarm::description {

namespace fs = std::filesystem;

/// The names visible at a place: in a file, in a macro under expansion, or in an include with a name space.
struct XacroScope {
  struct Property {
    XacroValue value;
    bool raw = false;      // a text that is evaluated on first use
    bool working = false;  // its evaluation has begun; a second use then means a cycle
  };
  struct Parameter {
    std::string name;
    int block = 0;  // number of stars
    bool forwards = false;
    std::optional<std::string> fallback;
  };
  struct Macro {
    std::vector<Parameter> parameters;
    const tinyxml2::XMLElement* body = nullptr;
    fs::path file;
  };
  XacroScope* parent = nullptr;
  XacroScope* otherwise = nullptr;  // the scope to search if a property is neither in this scope nor in its
                                    // parents
  bool is_space = false;
  std::map<std::string, Property> properties;
  std::map<std::string, std::shared_ptr<tinyxml2::XMLDocument>>
      blocks;  // "*name": the whole element, "**name": its content
  std::map<std::string, Macro> macros;
};

/// "a b:=2 c:=^|3 *origin": names and their defaults. Empty if the text is invalid.
std::optional<std::vector<XacroScope::Parameter>> xacro_parameters(const std::string& text);

/// Limits. A description beyond them is a mistake or an attack.
inline constexpr int kDeepest = 150;
inline constexpr std::size_t kMostElements = 500'000;
inline constexpr std::size_t kLongestText = 5'000'000;  // bytes
inline constexpr std::size_t kMostText = 100'000'000;   // of all evaluated texts in total

/// Evaluates texts at a place; the expander derives from it and traverses the elements.
class XacroTexts {
 public:
  XacroTexts(const XacroOptions& options, Problems& warnings, XacroReport* report)
      : options_(options), warnings_(warnings), report_(report) {
    for (const auto& [name, value] : options.arguments) arguments_[name] = value;
  }

 protected:
  struct Step {
    fs::path file;
    int line = 0;
    std::string what;  // "in the macro 'arm'", "included from here"; empty: only the place
  };
  /// The present place, for error messages.
  struct Inside {
    Inside(XacroTexts& e, Step step) : e_(e) {
      if (e_.steps_.size() > 2 * kDeepest)
        e_.fail("macros or includes lead deeper and deeper into themselves");
      e_.steps_.push_back(std::move(step));
    }
    ~Inside() { e_.steps_.pop_back(); }
    XacroTexts& e_;
  };

  [[noreturn]] void fail(const std::string& what, const std::string& advice = {}) const;

  /// Runs `work`. If it throws an error without a place, adds the present place.
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

  XacroScope& new_scope(XacroScope* parent);
  XacroValue* find_property(XacroScope* scope, const std::string& name);
  XacroNames names_for(XacroScope* scope);
  /// Evaluates every `${…}` and `$(…)` of a text. A text that consists of one `${…}` keeps the type of its
  /// value.
  XacroValue evaluate(const std::string& text, XacroScope* scope);
  /// The ')' that matches the '(' at `open`.
  static std::size_t closing(const std::string& text, std::size_t open);
  std::string text_of(const std::string& text, XacroScope* scope);
  /// The value of a property or parameter with this text.
  XacroValue value_of_text(const std::string& text, XacroScope* scope);
  /// `$(arg x)`, `$(find p)`, `$(env V)`, `$(eval …)` and similar.
  XacroValue substitution(const std::string& inner, XacroScope* scope);
  /// The names for $(eval …): arguments have priority, and a text argument that looks like a number becomes
  /// one.
  XacroNames eval_names(XacroScope* scope);
  /// xacro's own functions, for both `$(name …)` and `xacro.name(…)`.
  bool function(const std::string& name, const XacroList& a, XacroValue& out);
  int current_line() const { return steps_.back().line; }
  /// Resolves a relative name from the file of the innermost include, even in a macro from another file.
  fs::path resolve(const std::string& name) const;
  /// The file to read for a name. A package may have it deeper in its source folder than in its installed
  /// folder.
  fs::path file_for(const std::string& name) const;
  XacroValue load_yaml(const std::string& name);

  const XacroOptions& options_;
  Problems& warnings_;
  XacroReport* report_;
  PackageSearch find_package_;
  std::vector<std::unique_ptr<XacroScope>> scopes_;  // they live as long as the expansion
  std::map<std::string, std::string> arguments_;
  std::map<std::string, XacroValue> yamls_;
  std::vector<Step> steps_;
  std::vector<fs::path> reading_;  // the file and the chain of includes to the present place
  std::set<fs::path> packages_;    // found by $(find)
  bool keeps_unknown_packages_ = false;  // $(find) of a package that is not here gives package://NAME
  std::size_t evaluations_ = 0, written_ = 0;
  int depth_ = 0;
};

}  // namespace polyarm::description
