#pragma once
/// Jobs in INFORM on a simulated controller: our job POLYARM, line by line, and the ladder that holds the
/// robot when the heartbeat of the driver stops. Degrees, seconds. One thread.
#include <cstdint>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "drivers/forward/path_player.hpp"
#include "drivers/yaskawa/hses.hpp"
#include "drivers/yaskawa/machine.hpp"

namespace polyarm::yaskawa {

/// Registers, variables and network inputs as bytes of the wire; bounded by their numbers.
class Variables {
 public:
  using Key = std::pair<std::uint16_t, std::uint16_t>;  ///< command and number
  std::vector<std::uint8_t> get(Key key, std::size_t size) const;
  void set(Key key, std::vector<std::uint8_t> bytes) { values_[key] = std::move(bytes); }
  /// `name`: B000, I000 or D000.
  std::int32_t number(const std::string& name) const;
  void set_number(const std::string& name, std::int32_t value);
  HsesPosition place(int number) const;
  std::uint8_t signals(int byte) const;

 private:
  std::map<Key, std::vector<std::uint8_t>> values_;
};

/// Lines of a job that this controller can execute: SET, INC, MUL, DIV, JUMP, TIMER, DOUT, ABORT, MOVJ, MOVL,
/// MOVC, END. Three MOVC in a row are an arc. Throws Error("bad-job") with the line.
std::vector<std::vector<std::string>> parse_job(const std::string& text);

/// A hold stops the robot on its path, and a start goes on with the line under way. A path that the arm
/// cannot follow, and an axis that is too fast or beyond its limit, end in an alarm.
class FarJob {
 public:
  FarJob(Machine& machine, Variables& variables, const std::string& job);
  /// One cycle; the machine moves after it.
  void step(double dt);

  bool no_ladder = false;  ///< the ladder was not written
  double watchdog = 0.6;   ///< s, of its timer
  std::uint64_t lines() const { return lines_; }

 private:
  void watch(double dt);
  void follow(const Six& q);
  bool execute(double dt);
  void jump(const std::vector<std::string>& line);
  bool move(const std::vector<std::string>& line);
  bool holds(const std::string& condition) const;
  std::int32_t value(const std::string& word) const;
  bool start(forward::PlayedMove move);

  Machine& machine_;
  Variables& variables_;
  std::vector<std::vector<std::string>> job_;
  forward::PathPlayer player_;
  Six q_{};
  std::size_t next_ = 0;
  std::uint64_t selected_ = 0, lines_ = 0;
  double waited_ = 0, silence_ = 0;
  bool under_way_ = false, ended_ = false, held_ = false;
  std::uint8_t beat_ = 0;
  std::vector<Six> arc_;  ///< places of the MOVC so far
};

}  // namespace polyarm::yaskawa
