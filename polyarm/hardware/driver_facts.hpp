#pragma once
/// A driver's description of itself: one declaration gives the table of `polyarm drivers`, the parameter
/// defaults and the checks of a user's values.
#include <limits>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"

namespace polyarm::hardware {

struct ComponentContext;

enum class ParameterKind : unsigned char { text, number, boolean };

/// One parameter of a driver.
struct DriverParameter {
  const char* name;
  ParameterKind kind;
  const char* fallback;                                     ///< as a user would write it; null: required
  const char* meaning;                                      ///< with the unit
  double least = -std::numeric_limits<double>::infinity();  ///< for a number, inclusive
  double most = std::numeric_limits<double>::infinity();
  const char* one_of = nullptr;  ///< for a text: "auto legacy none"; null: any
};

/// Lives as long as the program.
struct DriverFacts {
  const char* kind;    ///< "system", "sensor", "actuator"
  const char* drives;  ///< the devices, briefly
  const char* proof;   ///< what it was tested with, and what it was not
  std::span<const DriverParameter> parameters;
};

/// Reads a component's parameters against the driver's declaration. Every wrong value becomes a problem, and
/// so does a name similar to a declared one; other names are ignored, because they may be for others.
class DriverParameters {
 public:
  DriverParameters(const DriverFacts& facts, const ComponentContext& context);

  /// The value, or the default if the value is wrong. `name` must be declared.
  std::string text(const char* name);
  double number(const char* name);
  bool boolean(const char* name);
  bool given(const char* name) const;
  Problems& problems() { return problems_; }
  const Location& where() const { return where_; }  ///< of the <ros2_control> block, if there is one

 private:
  const DriverParameter& declared(const char* name) const;
  std::string written(const DriverParameter& parameter);
  void refuse(const DriverParameter& parameter, const std::string& value, const std::string& why);

  const DriverFacts& facts_;
  const std::map<std::string, std::string>& values_;
  std::string component_;
  Location where_;
  Problems problems_;
};

}  // namespace polyarm::hardware
