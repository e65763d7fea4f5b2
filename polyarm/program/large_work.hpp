#pragma once
/// Work on values that are large, a piece at a time, so that no step of a program takes long; for the
/// interpreter's own files.
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/data/telling.hpp"
#include "polyarm/program/functions.hpp"

namespace polyarm::program {

/// Lists of more values than this are worked on in pieces.
inline constexpr std::size_t kLargeList = 256;
/// A piece, in plain steps.
inline constexpr int kPiece = 2048;

/// What it reads stays as it is until it is done, so that it can begin anew.
class Work {
 public:
  virtual ~Work() = default;
  /// A piece of it; returns about how many plain steps that was worth.
  int go_on();
  bool done() const { return done_; }

 protected:
  /// Goes on until `left` is used up or all is done, which alone is true.
  virtual bool go_on(int& left) = 0;

 private:
  bool done_ = false;
};

/// A list, or two behind one another, in room for at least `room` values.
class Copying : public Work {
 public:
  explicit Copying(Value first, Value second = Value(data::List{}), std::size_t room = 0);
  bool is_of(const Value& first) const { return first_.is_same(first); }
  Value take();

 private:
  bool go_on(int& left) override;
  Value first_, second_;
  data::List made_;
};

/// Whether two values are equal.
class Comparing : public Work {
 public:
  Comparing(Value a, Value b);
  bool equal() const { return equal_; }

 private:
  struct Level {
    const Value *a, *b;
    std::size_t next;
  };
  bool go_on(int& left) override;
  /// False where they are known to differ.
  bool look(const Value& a, const Value& b, int& left);
  bool open(const Value& a, const Value& b);
  Value a_, b_;
  std::vector<Level> open_;
  bool equal_ = true, begun_ = false;
};

/// Several values as one text, with `between` in between. A text that would be too long ends soon behind the
/// longest.
class Writing : public Work {
 public:
  Writing(data::List parts, std::string_view between) : parts_(std::move(parts)), between_{between} {}
  std::string take() { return std::move(text_); }

 private:
  bool go_on(int& left) override;
  data::List parts_;
  std::string_view between_;
  std::size_t next_ = 0;
  std::vector<data::Telling> telling_;  ///< of the part that is written
  std::string text_;
};

/// The list that a function makes.
class Making : public Work {
 public:
  explicit Making(Series series) : series_{std::move(series)} {}
  Value take();

 private:
  bool go_on(int& left) override;
  Series series_;
  data::List made_;
  Value::Extent extent_{1, 1};
};

/// Whether so many more make `list` move, which takes more than a moment.
inline bool moves_when_growing(const data::List& list, std::size_t more) {
  return list.size() > kLargeList && list.size() + more > list.capacity();
}

/// Whether it takes more than a moment to copy, compare or write.
inline bool is_large(const Value& value) {
  return (value.as_list() || value.as_record()) && value.extent().values > kLargeList;
}

}  // namespace polyarm::program
