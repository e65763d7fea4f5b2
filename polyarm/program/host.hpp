#pragma once
/// What a program needs from the cell it runs in. The interpreter knows no robot, file or clock of its own.
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/data/value.hpp"

namespace polyarm::program {

/// Something the cell was asked for and has not finished yet.
using Handle = std::int64_t;

struct Progress {
  enum class State { running, done, failed } state = State::running;
  std::optional<Problem> problem;  ///< why it failed; its place is filled in where it has none

  static Progress done() { return {State::done, {}}; }
  static Progress failed(Problem why) { return {State::failed, std::move(why)}; }
};

/// How a move is meant.
struct MoveOptions {
  bool exact = true;  ///< stop at the point
};

enum class LoadForm { load, import };

/// Implemented by the cell; called on the cell thread only; must not block. Any call may throw Error, which
/// ends the program as failed with the error's problem.
class Host {
 public:
  virtual ~Host() = default;

  /// The value of data, point or tag, or nullptr. Valid until the next call of set.
  virtual const data::Value* find(std::string_view name) const = 0;
  /// All names there are, for the nearest one in a message.
  virtual std::vector<std::string> names() const = 0;
  /// Changes a value, or makes a new name.
  virtual void set(const std::string& name, data::Value value, const Location& where) = 0;
  /// Grows whenever any value changes; a wait looks at its condition again only then.
  virtual std::uint64_t data_version() const = 0;

  /// Starts a joint move to a joint state or pose; `name` is how the program calls it.
  virtual Handle start_move(const data::Value& point, const std::string& name, const Location& where,
                            const MoveOptions& options) = 0;
  virtual Progress poll_move(Handle handle) = 0;
  /// Starts to replace the data set that comes from the file called `name` by the file as it is now.
  virtual Handle start_load(const std::string& name, LoadForm form, const Location& where) = 0;
  virtual Progress poll_load(Handle handle) = 0;
  /// Puts a question to whoever operates the cell.
  virtual Handle start_ask(const std::string& text, const Location& where) = 0;
  virtual Progress poll_ask(Handle handle) = 0;

  virtual Nanoseconds now() const = 0;
  virtual void log(const std::string& text, const Location& where) = 0;
};

}  // namespace polyarm::program
