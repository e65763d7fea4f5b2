#pragma once
/// The parameters of a controller: one call declares, checks and reads each. What is declared this way is
/// what the reference page lists, what `polyarm param` shows, and what unknown keys are compared with.
/// Standard types only: plugins include this.
#include <limits>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"

namespace polyarm::controllers {

/// What is said of a parameter beside its name, type and default.
struct ParameterNote {
  const char* text = "";    ///< one sentence, with the unit
  bool changeable = false;  ///< may be set while the controller runs; for bool, int and double only
  double least = -std::numeric_limits<double>::infinity();
  double most = std::numeric_limits<double>::infinity();
  std::vector<std::string> choices = {};  ///< of a text; empty: any
};

enum class ParameterType { boolean, integer, number, text, numbers, texts };
const char* name(ParameterType type);

/// A parameter that a controller has declared.
struct Declared {
  std::string key;
  ParameterType type;
  ParameterNote note;
  std::string fallback, value;  ///< as YAML would have them
  void* cell = nullptr;         ///< where a changeable one lives: bool, int or double
};

/// One value to be written between two cycles.
struct ParameterChange {
  std::string key;
  ParameterType type;
  void* cell = nullptr;
  double value = 0;
  void apply() const noexcept;  ///< control thread
};

/// The parameters of one controller as its file has them, flattened ("gains.elbow_joint.p" → {"100"}), and
/// those that the controller declares. Building thread only.
class Parameters {
 public:
  struct Entry {
    std::vector<std::string> values;
    Location where;
    bool list = false;  ///< written as a list
  };
  std::map<std::string, Entry> entries;

  bool has(std::string_view key) const;
  /// These look without declaring; they throw Error("bad-value") with the entry's place.
  std::string text(std::string_view key, std::string fallback = {}) const;
  double number(std::string_view key, double fallback) const;
  bool boolean(std::string_view key, bool fallback) const;
  std::vector<std::string> list(std::string_view key) const;
  /// Sets what the file does not say.
  void set(const std::string& key, std::vector<std::string> values);

  /// Declares the parameter and, where the file has it, reads it into `value`, which holds the default
  /// before. A wrong type or a value out of range becomes a problem and leaves the default.
  void read(const std::string& key, bool& value, ParameterNote note);
  void read(const std::string& key, int& value, ParameterNote note);
  void read(const std::string& key, double& value, ParameterNote note);
  void read(const std::string& key, std::string& value, ParameterNote note);
  void read(const std::string& key, std::vector<double>& value, ParameterNote note);
  void read(const std::string& key, std::vector<std::string>& value, ParameterNote note);
  /// A key that is understood and does nothing here; `why` says so where it is used.
  void superseded(const std::string& key, const char* instead);

  /// Forgets declarations and findings, before a controller is configured again.
  void begin();
  /// After on_configure: every key that nobody declared becomes a warning with the nearest declared one.
  void finish(const std::string& controller);
  Problems& problems() { return problems_; }
  const std::vector<Declared>& declared() const { return declared_; }
  const Declared* find_declared(std::string_view key) const;
  /// Checks a new value for a changeable parameter. Throws Error("unknown-parameter" | "not-changeable" |
  /// "bad-value").
  ParameterChange change(const std::string& key, const std::string& value) const;
  /// Notes that the change was made.
  void note_changed(const ParameterChange& change);

 private:
  const Entry* declare(const std::string& key, ParameterType type, std::string fallback, ParameterNote note,
                       void* cell);
  void refuse(const Entry& entry, const std::string& key, const std::string& wanted);
  bool in_range(const Entry& entry, const Declared& declared, double value);

  std::vector<Declared> declared_;
  Problems problems_;
};

/// Adds the problem that a controller has none of the `joints` that it is to move.
void refuse_no_joints(Parameters& parameters);

}  // namespace polyarm::controllers
