#pragma once
/// Works on large values in pieces, so that no step of a program takes long. Private to the interpreter's
/// files.
#include <cstddef>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/data/telling.hpp"
#include "polyarm/language/functions.hpp"

namespace polyarm::program {

/// Longer lists are processed in pieces.
inline constexpr std::size_t kLargeList = 256;
/// Size of a piece, in plain steps.
inline constexpr int kPiece = 2048;

/// Its inputs do not change until it is done, so it can start again.
class Work {
 public:
  virtual ~Work() = default;
  /// Does one piece; returns its approximate cost in plain steps.
  int go_on();
  bool done() const { return done_; }

 protected:
  /// Continues until `left` is used up or all is done; true only if all is done.
  virtual bool go_on(int& left) = 0;

 private:
  bool done_ = false;
};

/// Copies a list, or two lists one after the other, with capacity for at least `room` values.
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

/// Compares two values.
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
  /// False if they are known to differ.
  bool look(const Value& a, const Value& b, int& left);
  bool open(const Value& a, const Value& b);
  Value a_, b_;
  std::vector<Level> open_;
  bool equal_ = true, begun_ = false;
};

/// Writes several values as one text, separated by `between`. A text that is too long ends soon after the
/// limit.
class Writing : public Work {
 public:
  Writing(data::List parts, std::string_view between) : parts_(std::move(parts)), between_{between} {}
  std::string take() { return std::move(text_); }

 private:
  bool go_on(int& left) override;
  data::List parts_;
  std::string_view between_;
  std::size_t next_ = 0;
  std::vector<data::ValueWriter> telling_;  ///< of the present part
  std::string text_;
};

/// Produces the list of a function.
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

/// True if adding `more` values moves `list`, which takes long.
inline bool moves_when_growing(const data::List& list, std::size_t more) {
  return list.size() > kLargeList && list.size() + more > list.capacity();
}

/// True if copying, comparing or writing it takes long.
inline bool is_large(const Value& value) {
  return (value.as_list() || value.as_record()) && value.extent().values > kLargeList;
}

}  // namespace polyarm::program
