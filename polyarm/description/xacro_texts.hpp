#pragma once
/// The texts of xacro files: what names mean where, `${…}` and `$(…)`, and where something went wrong.
/// Private to the room.
#include <tinyxml2.h>

#include <filesystem>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "polyarm/description/xacro.hpp"
#include "polyarm/description/xacro_value.hpp"

namespace polyarm::description {

namespace fs = std::filesystem;

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
    const tinyxml2::XMLElement* body = nullptr;
    fs::path file;
  };
  XacroScope* parent = nullptr;
  XacroScope* otherwise = nullptr;  // where properties are looked for that neither this nor its parents have
  bool is_space = false;
  std::map<std::string, Property> properties;
  std::map<std::string, std::shared_ptr<tinyxml2::XMLDocument>>
      blocks;  // "*name": whole, "**name": its contents
  std::map<std::string, Macro> macros;
};

/// "a b:=2 c:=^|3 *origin": names, and what each is when it is not given. None: it is not understood.
std::optional<std::vector<XacroScope::Parameter>> xacro_parameters(const std::string& text);

/// More than this is no description any more, but a mistake or an attack.
inline constexpr int kDeepest = 150;
inline constexpr std::size_t kMostElements = 500'000;
inline constexpr std::size_t kLongestText = 5'000'000;  // bytes
inline constexpr std::size_t kMostText = 100'000'000;   // of all evaluated texts together

/// Evaluates texts at a place; an expansion derives from it and walks the elements.
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
    std::string what;  // "in the macro 'arm'", "included from here"; empty: just there
  };
  /// Where we are, for what goes wrong below.
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

  XacroScope& new_scope(XacroScope* parent);
  XacroValue* find_property(XacroScope* scope, const std::string& name);
  XacroNames names_for(XacroScope* scope);
  /// Everything in `${…}` and `$(…)` of a text. A text that is one `${…}` keeps the type of its value.
  XacroValue evaluate(const std::string& text, XacroScope* scope);
  /// The ')' that belongs to the '(' at `open`.
  static std::size_t closing(const std::string& text, std::size_t open);
  std::string text_of(const std::string& text, XacroScope* scope);
  /// What a property or a parameter becomes that is given this text.
  XacroValue value_of_text(const std::string& text, XacroScope* scope);
  /// `$(arg x)`, `$(find p)`, `$(env V)`, `$(eval …)` and their like.
  XacroValue substitution(const std::string& inner, XacroScope* scope);
  /// In $(eval …) arguments come first, and a number in one is a number.
  XacroNames eval_names(XacroScope* scope);
  /// The functions of xacro itself, which `$(name …)` and `xacro.name(…)` both mean.
  bool function(const std::string& name, const XacroList& a, XacroValue& out);
  int current_line() const { return steps_.back().line; }
  /// Relative names begin beside the file that was included last, wherever the macro was written that says
  /// them.
  fs::path resolve(const std::string& name) const;
  /// The file to read for a name. A package may keep it deeper in its sources than it installs it.
  fs::path file_for(const std::string& name) const;
  XacroValue load_yaml(const std::string& name);

  const XacroOptions& options_;
  Problems& warnings_;
  XacroReport* report_;
  PackageSearch find_package_;
  std::vector<std::unique_ptr<XacroScope>> scopes_;  // which live as long as the expansion
  std::map<std::string, std::string> arguments_;
  std::map<std::string, XacroValue> yamls_;
  std::vector<Step> steps_;
  std::vector<fs::path> reading_;  // the file and the includes that lead to where we are
  std::set<fs::path> packages_;    // that $(find) found
  std::size_t evaluations_ = 0, written_ = 0;
  int depth_ = 0;
};

}  // namespace polyarm::description
