#pragma once
/// Measures stops: their duration and distance, and whether a joint was pushed away during a hold.
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

/// A stop that has ended: from the first cycle that should slow down until no motion is commanded.
struct StopReport {
  struct Way {
    std::string name;
    double way = 0;
  };
  Nanoseconds begun = 0;  ///< cell time
  double time_s = 0;
  /// Stop category of IEC 60204-1. 0: each joint brakes at its maximum; 1 and 2: on the path. After a
  /// requested stop of category 1 the drives are switched off; after a contact (0 or 1) they stay on, so the
  /// robot can be moved away.
  int category = 2;
  std::string cause;
  std::string cause_code;   ///< one of control::code
  std::vector<Way> tcps;    ///< for each robot that moved: distance along its path, m
  std::vector<Way> joints;  ///< for each joint that moved: rad or m
  /// The report in one line.
  std::string sentence() const;
  /// {cause, category, time_s, robot?, tcp_m?}; the robot is the one whose TCP moved furthest.
  Facts facts() const;
};

protocol::StopFacts facts_of(const StopReport& stop);

/// The joints of all robots, with their places in a snapshot.
class JointPlaces {
 public:
  struct Place {
    std::string name;
    std::size_t robot;
    int state, command;   ///< index of its position; -1 if there is none
    bool slides = false;  ///< prismatic: position in m instead of rad
  };
  JointPlaces() = default;
  JointPlaces(const CellRobots& robots, const hardware::InterfaceTable& table);
  const std::vector<Place>& all() const { return places_; }
  /// The joints of one robot, in its order.
  std::span<const Place> of(std::size_t robot) const;
  /// The commanded position of a joint, otherwise the measured one, otherwise 0; rad or m.
  static double commanded(const control::Snapshot& snapshot, const Place& place);
  /// The same of each joint. Resizes `out`.
  void commanded(const control::Snapshot& snapshot, std::vector<double>& out) const;
  std::vector<double> commanded(const control::Snapshot& snapshot) const {
    std::vector<double> out;
    commanded(snapshot, out);
    return out;
  }

 private:
  std::vector<Place> places_;
  std::vector<std::size_t> first_;  // first index of each robot, and the end
};

/// Adds up the distance of a stop from tick to tick; accurate to one tick. Cell thread.
class StopWatch {
 public:
  /// Returns the report when a stop with motion has ended.
  std::optional<StopReport> tick(const control::Snapshot& snapshot, const CellRobots& robots,
                                 const JointPlaces& places);
  /// Sets the category of the current stop, or of the next one.
  void set_category(int category) { category_ = category; }

 private:
  void add(const CellRobots& robots, const JointPlaces& places, const std::vector<double>& now);

  Nanoseconds seen_ = -1;  // the last reported stop, or the current one
  bool under_way_ = false;
  int category_ = 2;
  std::vector<double> before_, now_, joint_way_, tcp_way_;
};

/// Compares joint positions with their commands while the cell is held. A joint whose command changes (its
/// hardware or its controller was activated at the measured position) gets a new reference. Cell thread.
class HeldPlace {
 public:
  /// `excused`: a jog or a contact moves the joints now; their reference is taken again after that.
  void tick(const control::Snapshot& snapshot, const JointPlaces& places, bool excused = false);
  /// Accepts the present positions as the new reference.
  void forget();
  /// The joint that was pushed furthest since the reference was taken; empty if none was pushed.
  std::optional<Problem> pushed() const;

 private:
  struct Reference {
    double command = 0, settled = 0;  // settled: measured minus commanded
    Nanoseconds since = -1;           // of this command; -1: none yet
    bool taken = false;
  };
  std::vector<Reference> references_;  // of each joint; empty: the cell is not held
  std::string joint_;
  bool slides_ = false;
  double most_ = 0;
};

}  // namespace polyarm::cell
