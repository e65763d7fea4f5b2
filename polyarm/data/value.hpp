#pragma once
/// The values of names in programs and data files: kinds, numbers with dimension, joint states, points, lists
/// and records. SI units.
#include <atomic>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/base/quantity.hpp"

namespace polyarm::data {

enum class Kind : std::uint8_t { boolean, number, text, list, joints, pose, record };

/// "a boolean", "a number", …: for sentences.
const char* name(Kind kind);

/// A number in SI units and its dimension.
struct Number {
  double value = 0;
  Dimension dimension = Dimension::none;
  friend bool operator==(const Number&, const Number&) = default;
};

/// One position per joint, radians or metres. Joints are identified by name, never by order; without names
/// the positions are in the order of the robot that uses them.
struct JointState {
  std::vector<std::string> names;
  std::vector<double> positions;
  /// The unit in which each position was given: angle, length, or none if it had none. May be shorter than
  /// `positions`. Whoever knows the joints compares them: a joint that turns takes no length.
  std::vector<Dimension> given = {};
  Dimension given_at(std::size_t index) const {
    return index < given.size() ? given[index] : Dimension::none;
  }
  void note_given(std::size_t index, Dimension dimension);
  /// The position of `joint`, or nullptr.
  const double* find(std::string_view joint) const;
  /// Equal if every joint has the same position, in any order.
  friend bool operator==(const JointState& a, const JointState& b);
};

/// How a point was taught; an empty text means unknown.
struct Taught {
  std::string frame;  ///< frame of its pose; empty: the world
  std::string tool;   ///< the tool whose tool centre point it is
  std::string robot;  ///< model of the robot
  JointState joints;  ///< the joint state of that robot at the point
  Quaternion axes;    ///< axes along which offset() shifts it, in the coordinates of its pose
  friend bool operator==(const Taught&, const Taught&) = default;
};

/// A pose of the tool centre point, in the world unless a frame is named. It also stores whether the pose was
/// written with a quaternion.
struct Point {
  Pose pose;
  bool quaternion_given = false;
  std::shared_ptr<const Taught> taught = nullptr;  ///< shared between copies, read-only
  std::string frame() const { return taught ? taught->frame : std::string{}; }
  /// Ignores the way in which it was written.
  friend bool operator==(const Point& a, const Point& b) {
    return a.pose == b.pose && (a.taught == b.taught || (a.taught && b.taught && *a.taught == *b.taught));
  }
};

class Value;
using List = std::vector<Value>;

/// Named values, in the order of writing.
struct Record {
  std::vector<std::string> names;
  List values;
  /// The value of `field`, or nullptr.
  const Value* find(std::string_view field) const;
};

/// A value of any kind. Booleans and numbers are stored inside. Larger content is stored separately and
/// shared between copies, which only read it. Several threads may read and destroy copies at the same time;
/// one Value object belongs to one thread.
class Value {
 public:
  Value() noexcept = default;
  template <std::same_as<bool> Boolean>
  Value(Boolean value) noexcept {
    content_.truth = value;
  }
  Value(double value) noexcept : Value(Number{value}) {}
  Value(int value) noexcept : Value(Number{static_cast<double>(value)}) {}
  Value(Number value) noexcept : kind_{Kind::number} { content_.number = value; }
  Value(std::string value);
  Value(const char* value) : Value(std::string(value)) {}
  Value(List value);
  Value(JointState value);
  Value(Point value);
  Value(Record value);
  Value(const Value& other) noexcept : content_{other.content_}, kind_{other.kind_} {
    if (is_shared()) content_.shared->users.fetch_add(1, std::memory_order_relaxed);
  }
  Value(Value&& other) noexcept : content_{other.content_}, kind_{other.kind_} { other.forget(); }
  Value& operator=(const Value& other) noexcept { return *this = Value(other); }
  /// `other` may be a part of this value.
  Value& operator=(Value&& other) noexcept {
    const Content content = other.content_;
    const Kind kind = other.kind_;
    other.forget();
    if (is_shared()) release_now();
    content_ = content;
    kind_ = kind;
    return *this;
  }
  ~Value() {
    if (is_shared()) release_now();
  }

  Kind kind() const { return kind_; }
  const bool* as_boolean() const { return kind_ == Kind::boolean ? &content_.truth : nullptr; }
  const Number* as_number() const { return kind_ == Kind::number ? &content_.number : nullptr; }
  const std::string* as_text() const { return held<std::string>(Kind::text); }
  const List* as_list() const { return held<List>(Kind::list); }
  const JointState* as_joints() const { return held<JointState>(Kind::joints); }
  const Point* as_point() const { return held<Point>(Kind::pose); }
  const Record* as_record() const { return held<Record>(Kind::record); }
  /// A joint state or a pose: a target for a robot.
  bool is_place() const { return kind_ == Kind::joints || kind_ == Kind::pose; }

  /// Readable text: True, 0.04m, text without quotes, [1, 2], {elbow_joint: 0.5}, xyz(…) rpy(…), {red = 1}.
  std::string text() const;
  /// The beginning of text(), at most `bytes` bytes; "…" follows if there is more.
  std::string excerpt(std::size_t bytes = 60) const;

  /// The number of values (itself and, for a list or record, all inside) and the nesting depth of lists and
  /// records. Counted once.
  struct Extent {
    std::uint32_t values = 1, depth = 0;
  };
  Extent extent() const;
  /// A list with known extent.
  Value(List value, Extent known);

  /// The same as assignment, for numbers and booleans.
  void set(const Number& number) noexcept {
    if (is_shared()) release_now();
    content_.number = number;
    kind_ = Kind::number;
  }
  void set(bool truth) noexcept {
    if (is_shared()) release_now();
    content_.truth = truth;
    kind_ = Kind::boolean;
  }
  /// True if the content is stored separately, so that copies can share it.
  bool is_shared() const { return kind_ > Kind::number; }

  /// The number itself, to change it in place; nullptr for other kinds.
  Number* own_number() { return kind_ == Kind::number ? &content_.number : nullptr; }
  /// True if no other copy shares the content.
  bool is_alone() const {
    return !is_shared() || content_.shared->users.load(std::memory_order_acquire) == 1;
  }
  /// True if both share the same content.
  bool is_same(const Value& other) const {
    return is_shared() && kind_ == other.kind_ && content_.shared == other.content_.shared;
  }
  /// The values of a list or record, to replace them by values of the same extent. Makes its own copy if
  /// other values share the content. nullptr for other kinds.
  List* own_parts();
  /// Updates the extent after a part of own_parts() was replaced by one of another extent. The depth does not
  /// shrink: it stays the largest depth since it was counted.
  void replaced(Extent before, Extent after);
  /// Appends `part` to a list; copies the list only if it is shared.
  void append(Value part);
  /// Appends `more` to a text; copies the text only if it is shared.
  void append(std::string_view more);

  /// Records are equal if all fields are equal, in any order.
  friend bool operator==(const Value& a, const Value& b);

 private:
  struct Shared {
    std::atomic<std::uint32_t> users{1};
    std::atomic<std::uint64_t> extent{0};  ///< depth and number of values; 0: not counted yet
  };
  template <typename Content>
  struct Held : Shared {
    explicit Held(Content of) : content(std::move(of)) {}
    Content content;
  };
  union Content {
    Content() : number{} {}
    Number number;
    bool truth;
    Shared* shared;
  };

  void forget() {
    kind_ = Kind::boolean;
    content_.truth = false;
  }
  void release_now() noexcept;
  template <typename Large>
  const Large* held(Kind kind) const {
    return kind_ == kind ? &static_cast<const Held<Large>*>(content_.shared)->content : nullptr;
  }
  /// The content; makes its own copy if others share it.
  template <typename Large>
  Large& own() {
    if (content_.shared->users.load(std::memory_order_acquire) != 1) part_from_others<Large>();
    return static_cast<Held<Large>*>(content_.shared)->content;
  }
  template <typename Large>
  void part_from_others();

  Content content_;
  Kind kind_ = Kind::boolean;
};

/// Collects the large lists and records that this thread releases while a Keeping exists, and frees them in
/// small steps. One thread.
class Remains {
 public:
  /// Collects released content until it is destroyed.
  class Keeping {
   public:
    explicit Keeping(Remains& remains);
    ~Keeping();
    Keeping(const Keeping&) = delete;
    Keeping& operator=(const Keeping&) = delete;

   private:
    Remains* before_;
  };
  bool empty() const { return wholes_.empty(); }
  /// Frees parts in at most about `steps` steps and returns the number used: kShared for separately stored
  /// content, 1 for a number.
  int free(int steps);
  static constexpr int kShared = 8;

 private:
  friend class Value;
  std::vector<Value> wholes_;
};

/// The SI unit of `dimension` as the language writes it; empty if it has none.
const char* unit_text(Dimension dimension);

}  // namespace polyarm::data
