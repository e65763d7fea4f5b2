#pragma once
/// What a name in a program or a data file can stand for.
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

/// Booleans and numbers stand in it; what is larger stands beside it and is shared between copies, which only
/// read it. Copies may be read and let go by several threads at once, one Value only by one.
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
  /// `other` may be a part of this.
  Value& operator=(Value&& other) noexcept {
    const Content content = other.content_;
    const Kind kind = other.kind_;
    other.forget();
    if (is_shared()) let_go();
    content_ = content;
    kind_ = kind;
    return *this;
  }
  ~Value() {
    if (is_shared()) let_go();
  }

  Kind kind() const { return kind_; }
  const bool* as_boolean() const { return kind_ == Kind::boolean ? &content_.truth : nullptr; }
  const Number* as_number() const { return kind_ == Kind::number ? &content_.number : nullptr; }
  const std::string* as_text() const { return held<std::string>(Kind::text); }
  const List* as_list() const { return held<List>(Kind::list); }
  const JointState* as_joints() const { return held<JointState>(Kind::joints); }
  const Point* as_point() const { return held<Point>(Kind::pose); }
  const Record* as_record() const { return held<Record>(Kind::record); }
  /// A joint state or a pose: something a robot can move to.
  bool is_place() const { return kind_ == Kind::joints || kind_ == Kind::pose; }

  /// As a person reads it: True, 0.04m, text without quotes, [1, 2], {elbow_joint: 0.5}, xyz(…) rpy(…),
  /// {red = 1}.
  std::string text() const;
  /// Its beginning, at most so many bytes of it; "…" where there is more.
  std::string excerpt(std::size_t bytes = 60) const;

  /// How many values it is: itself and, of a list or record, all that are in it; and how deep lists and
  /// records stand in one another. Counted once.
  struct Extent {
    std::uint32_t values = 1, depth = 0;
  };
  Extent extent() const;
  /// A list whose extent is known.
  Value(List value, Extent known);

  /// As assignment, for values that stand in it.
  void set(const Number& number) noexcept {
    if (is_shared()) let_go();
    content_.number = number;
    kind_ = Kind::number;
  }
  void set(bool truth) noexcept {
    if (is_shared()) let_go();
    content_.truth = truth;
    kind_ = Kind::boolean;
  }
  /// It stands beside this, for others to share.
  bool is_shared() const { return kind_ > Kind::number; }

  /// The number itself, to be changed; nullptr where it is none.
  Number* own_number() { return kind_ == Kind::number ? &content_.number : nullptr; }
  /// Nobody shares what stands beside it.
  bool is_alone() const {
    return !is_shared() || content_.shared->users.load(std::memory_order_acquire) == 1;
  }
  /// Both share the same.
  bool is_same(const Value& other) const {
    return is_shared() && kind_ == other.kind_ && content_.shared == other.content_.shared;
  }
  /// The values of a list or record, to be replaced by others of the same extent; its own copy where others
  /// share them. nullptr where it is neither.
  List* own_parts();
  /// What it is after a part of own_parts() has been replaced by one of another extent. The depth is that of
  /// the deepest part that it had since it was counted.
  void replaced(Extent before, Extent after);
  /// Adds `part` to a list, without a copy where nobody shares it.
  void append(Value part);
  /// Adds `more` to a text, without a copy where nobody shares it.
  void append(std::string_view more);

  /// Records are equal when every field is, in whatever order they stand.
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
  void let_go() noexcept;
  template <typename Large>
  const Large* held(Kind kind) const {
    return kind_ == kind ? &static_cast<const Held<Large>*>(content_.shared)->content : nullptr;
  }
  /// What it holds, its own copy where others share it.
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

/// Large lists and records that their last user on this thread has let go, while one of these is in force;
/// they are freed little by little. Of one thread.
class Remains {
 public:
  /// Keeps what is let go until its end.
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
  /// Frees parts, for at most about so many steps, and says how many it took: kShared for one that stands
  /// beside the list, 1 for a number.
  int free(int steps);
  static constexpr int kShared = 8;

 private:
  friend class Value;
  std::vector<Value> wholes_;
};

/// The SI unit of `dimension` as the language spells it; empty for none.
const char* unit_text(Dimension dimension);

}  // namespace polyarm::data
