#pragma once
/// What a name in a program or a data file can stand for.
#include <concepts>
#include <memory>
#include <string>
#include <variant>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/base/quantity.hpp"

namespace polyarm::data {

enum class Kind { boolean, number, text, list, joints, pose, record };

/// "a boolean", "a number", …: as it stands in a sentence.
const char* name(Kind kind);

/// A number in SI units together with what it measures.
struct Number {
  double value = 0;
  Dimension dimension = Dimension::none;
  friend bool operator==(const Number&, const Number&) = default;
};

/// One position per joint, radians or metres. The names decide which joint is meant, never the order; without
/// names the positions are in the order of the robot that takes them.
struct JointState {
  std::vector<std::string> names;
  std::vector<double> positions;
  /// The position of `joint`, or nullptr.
  const double* find(std::string_view joint) const;
  /// Equal when every joint has the same position, in whatever order they stand.
  friend bool operator==(const JointState& a, const JointState& b);
};

/// What a point remembers of how it was taught; an empty text is not known.
struct Taught {
  std::string frame;  ///< that its pose is in; empty: the world
  std::string tool;   ///< whose tool centre point it is
  std::string robot;  ///< model of the robot
  JointState joints;  ///< in which that robot stood there
  friend bool operator==(const Taught&, const Taught&) = default;
};

/// A pose of the tool centre point, in the world unless it names a frame, and whether it was written as a
/// quaternion.
struct Point {
  Pose pose;
  bool quaternion_given = false;
  std::shared_ptr<const Taught> taught = nullptr;  ///< shared between copies, which only read it
  std::string frame() const { return taught ? taught->frame : std::string{}; }
  /// The way it was written does not matter.
  friend bool operator==(const Point& a, const Point& b) {
    return a.pose == b.pose && (a.taught == b.taught || (a.taught && b.taught && *a.taught == *b.taught));
  }
};

class Value;
using List = std::vector<Value>;

/// Named values, in the order they were written.
struct Record {
  std::vector<std::string> names;
  List values;
  /// The value of `field`, or nullptr.
  const Value* find(std::string_view field) const;
};

class Value {
 public:
  Value() : content_{false} {}
  template <std::same_as<bool> Boolean>
  Value(Boolean value) : content_{value} {}
  Value(double value) : content_{Number{value}} {}
  Value(int value) : content_{Number{static_cast<double>(value)}} {}
  Value(Number value) : content_{value} {}
  Value(std::string value) : content_{std::move(value)} {}
  Value(const char* value) : content_{std::string(value)} {}
  Value(List value) : content_{std::move(value)} {}
  Value(JointState value) : content_{std::move(value)} {}
  Value(Point value) : content_{std::move(value)} {}
  Value(Record value) : content_{std::move(value)} {}

  Kind kind() const { return static_cast<Kind>(content_.index()); }
  const bool* as_boolean() const { return std::get_if<bool>(&content_); }
  const Number* as_number() const { return std::get_if<Number>(&content_); }
  const std::string* as_text() const { return std::get_if<std::string>(&content_); }
  const List* as_list() const { return std::get_if<List>(&content_); }
  const JointState* as_joints() const { return std::get_if<JointState>(&content_); }
  const Point* as_point() const { return std::get_if<Point>(&content_); }
  const Record* as_record() const { return std::get_if<Record>(&content_); }
  /// A joint state or a pose: something a robot can move to.
  bool is_place() const { return as_joints() || as_point(); }

  /// As a person reads it: True, 0.04m, text without quotes, [1, 2], {elbow_joint: 0.5}, xyz(…) rpy(…),
  /// {red = 1}.
  std::string text() const;

  /// Records are equal when every field is, in whatever order they stand.
  friend bool operator==(const Value& a, const Value& b);

 private:
  std::variant<bool, Number, std::string, List, JointState, Point, Record> content_;
};

/// The SI unit of `dimension` as the language spells it; empty for none.
const char* unit_text(Dimension dimension);

}  // namespace polyarm::data
