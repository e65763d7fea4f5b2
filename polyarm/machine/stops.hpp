#pragma once
/// What a stop took, and whether somebody has moved the robot since it stands.
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/control/control_loop.hpp"
#include "polyarm/protocol/motion.hpp"
#include "polyarm/setup/robots.hpp"

namespace polyarm::cell {

/// A stop that has ended: from the first cycle that was to slow down until nothing was commanded to move.
struct StopReport {
  struct Way {
    std::string name;
    double way = 0;
  };
  Nanoseconds begun = 0;  ///< cell time
  double time_s = 0;
  /// As IEC 60204-1 brakes: 0: each joint at once as hard as it can, 1 and 2: on the path. After an asked-for 1
  /// the drives are switched off; after a contact (0 or 1) they hold, so that the robot can be moved away.
  int category = 2;
  std::string cause;
  std::string cause_code;   ///< as control::code
  std::vector<Way> tcps;    ///< of each robot that moved, m along its path
  std::vector<Way> joints;  ///< of each joint that moved, rad or m
  /// In one line.
  std::string sentence() const;
  /// {cause, category, time_s, robot?, tcp_m?}: the robot whose TCP came furthest.
  Facts facts() const;
};

protocol::StopFacts facts_of(const StopReport& stop);

/// The joints of all robots in a snapshot.
class JointPlaces {
 public:
  struct Place {
    std::string name;
    std::size_t robot;
    int state, command;   ///< index of its position, -1: none
    bool slides = false;  ///< its position is in m, else in rad
  };
  JointPlaces() = default;
  JointPlaces(const CellRobots& robots, const hardware::InterfaceTable& table);
  const std::vector<Place>& all() const { return places_; }
  /// Those of one robot, in the order of its joints.
  std::span<const Place> of(std::size_t robot) const;
  /// The commanded position of each where there is one, else the measured one, else 0; rad or m. `out` is
  /// resized.
  void commanded(const control::Snapshot& snapshot, std::vector<double>& out) const;
  std::vector<double> commanded(const control::Snapshot& snapshot) const {
    std::vector<double> out;
    commanded(snapshot, out);
    return out;
  }

 private:
  std::vector<Place> places_;
  std::vector<std::size_t> first_;  // of each robot, and the end
};

/// Adds up the ways of a stop from tick to tick, so to one tick exactly. Cell thread.
class StopWatch {
 public:
  /// The report once a stop in which something moved has ended.
  std::optional<StopReport> tick(const control::Snapshot& snapshot, const CellRobots& robots,
                                 const JointPlaces& places);
  /// Of the stop under way, or of the next one.
  void set_category(int category) { category_ = category; }

 private:
  void add(const CellRobots& robots, const JointPlaces& places, const std::vector<double>& now);

  Nanoseconds seen_ = -1;  // the stop that was told last, or is under way
  bool under_way_ = false;
  int category_ = 2;
  std::vector<double> before_, now_, joint_way_, tcp_way_;
};

/// Where the joints are beside their commands while the cell is held. Cell thread.
class HeldPlace {
 public:
  /// `excused`: who jogs or what is touched moves the joints now; they settle anew after that.
  void tick(const control::Snapshot& snapshot, const JointPlaces& places, bool excused = false);
  /// Where they are is where they are to be; they settle anew.
  void forget();
  /// The joint that was moved furthest since the hold had settled, if it was moved at all.
  std::optional<Problem> pushed() const;

 private:
  Nanoseconds since_ = -1;
  std::vector<double> settled_;  // measured less commanded; empty: not yet
  std::string joint_;
  bool slides_ = false;
  double most_ = 0;
};

}  // namespace polyarm::cell
