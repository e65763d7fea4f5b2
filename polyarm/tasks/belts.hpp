#pragma once
/// The belts of a cell while it runs: how far they have moved, and the parts that come on them. Cell thread.
#include <array>
#include <cstdint>
#include <deque>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/data/data_store.hpp"
#include "polyarm/machine/machine.hpp"
#include "polyarm/moves/frame_ride.hpp"
#include "polyarm/setup/belts.hpp"

namespace polyarm::cell {

/// Estimates travel, velocity and acceleration from samples with their times: a fading memory of a parabola.
class TravelFilter {
 public:
  void add(double travel, Nanoseconds time);
  const moves::FrameTravel& value() const { return value_; }

 private:
  moves::FrameTravel value_;
  int samples_ = 0;
};

/// A part on a belt: T_belt_part, and the travel of the belt at which it was there.
struct BeltPart {
  std::uint64_t number = 0;  ///< counts from 1
  Pose at;
  double travel = 0;
  bool missed = false;  ///< it is counted as missed
};

class Belts {
 public:
  /// The most parts that wait on one belt; older ones count as missed.
  static constexpr std::size_t kMostWaiting = 1000;

  /// The references must outlive this object. Throws Error that names encoders, sensors and latches that do
  /// not exist.
  Belts(const std::vector<BeltEntry>& entries, const Machine& machine, const data::DataStore& store);

  /// Call it in each tick: reads encoders and sensors.
  void tick();

  bool has(const std::string& belt) const { return belts_.contains(belt); }
  const BeltEntry& entry(const std::string& belt) const { return belts_.at(belt).entry; }
  const moves::FrameTravel& travel(const std::string& belt) const { return belts_.at(belt).filter.value(); }

  // The functions of the language. Throw Error("unknown-belt"), or Error("signal") if the encoder gives no
  // numbers.
  /// The robot's next part, which becomes its frame; false if none comes. Parts that are too late count as
  /// missed.
  bool next_part(const std::string& belt, const std::string& robot);
  std::size_t waiting(const std::string& belt);
  std::size_t missed(const std::string& belt);
  /// A part that a camera sees now, in the frame that stands where the belt reads zero.
  void add(const std::string& belt, const Pose& at);

  /// The part that the robot took last. Throws Error("no-part") if it took none.
  const BeltPart& part(const std::string& belt, const std::string& robot) const;
  /// Its pose in the world at a travel of the belt, and its place along the belt.
  Pose pose(const std::string& belt, const BeltPart& part, double travel) const;
  double place(const std::string& belt, const BeltPart& part) const;
  /// A robot was too late for this part of it, or has not finished with it in time. A part counts once.
  void note_missed(const std::string& belt, std::uint64_t part);

  /// In a rehearsal a part is where robots begin to follow, whenever a program asks for one.
  void suppose_part(const std::string& belt, const std::string& robot);
  void forget_supposed();

 private:
  struct Signal {
    std::optional<std::size_t> state;  ///< of the hardware
    std::string tag;                   ///< otherwise
  };
  struct Belt {
    BeltEntry entry;
    Signal encoder, sensor, latch;
    TravelFilter filter;
    std::optional<double> counts, seen;  ///< last reading of encoder and sensor
    double turns = 0;                    ///< counts before the encoder began again
    std::deque<BeltPart> parts;
    std::map<std::string, BeltPart> taken;  ///< by robot
    std::uint64_t numbers = 0;
    std::size_t missed = 0;
    bool silent = true;  ///< the encoder gives no numbers
  };
  Signal signal_of(const std::string& name, const char* what, const BeltEntry& entry) const;
  std::optional<double> read(const Signal& signal) const;
  Belt& known(const std::string& name);
  double unwrapped(const Belt& belt, double counts) const;
  void look_at_sensor(Belt& belt);
  void queue(Belt& belt, const Pose& at, double travel);

  const Machine& machine_;
  const data::DataStore& store_;
  std::map<std::string, Belt> belts_;
};

}  // namespace polyarm::cell
