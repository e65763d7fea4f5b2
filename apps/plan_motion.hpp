#pragma once
/// A motion as `polyarm plan` shows it: what moves when, within which limits, and what bounds it.
#include <array>
#include <cstddef>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/kinematics/chain.hpp"
#include "polyarm/timing/timing.hpp"
#include "polyarm/trajectory/limit_use.hpp"
#include "polyarm/trajectory/trajectory.hpp"

namespace polyarm::apps {

struct PlanJoint {
  std::string name;
  bool slides = false;  ///< metres, else radians
  trajectory::MotionLimits limits;
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
};

/// From `from` to `to`, s, the motion is as fast as this limit allows: of joint `row`, or, from joints.size()
/// on, of one of `bounds`.
struct PlanBand {
  double from, to;
  std::size_t row;
  timing::LimitKind kind;
};

struct PlanSection {
  std::string name;
  double begin, end;
};

/// All joints at one time.
struct PlanState {
  explicit PlanState(std::size_t joints) {
    for (auto& list : value) list.resize(joints);
  }
  std::array<std::vector<double>, 4> value;  ///< position, velocity, acceleration, jerk
  double tcp_speed = 0;                      ///< m/s
  Vec3 tcp;
};

/// Values without peers: what the plots and tables call the four.
inline constexpr std::array<const char*, 4> kQuantities = {"position", "velocity", "acceleration", "jerk"};
/// "rad/s²" or "m".
std::string unit_of(const PlanJoint& joint, std::size_t quantity);

/// Where a motion is nearest to an obstacle, or overlaps it most.
struct PlanClearance {
  double distance = std::numeric_limits<double>::infinity();  ///< m; negative: how deep
  std::string first, second;
  double time = 0;  ///< s
  Vec3 point;       ///< in the world, on `second`
};

struct PlannedMotion {
  std::string title;
  std::vector<PlanJoint> joints;
  std::vector<PlanSection> sections;
  std::vector<PlanBand> bands;      ///< in order of time; empty where times were given
  std::vector<std::string> bounds;  ///< what bounds motion beside the joints: "the TCP's way"
  double duration = 0;
  double tcp_speed_limit = std::numeric_limits<double>::infinity();
  std::vector<Problem> problems;
  std::optional<PlanClearance> clearance;  ///< where the surroundings are known
  std::function<void(double t, PlanState&)> at;
  /// When the motion is passed on: the sections' paths in time, one behind the other; none where times were
  /// given.
  std::vector<std::shared_ptr<const timing::TimedPath>> timed;

  const std::string& row_name(std::size_t row) const {
    return row < joints.size() ? joints[row].name : bounds[row - joints.size()];
  }
  bool has_errors() const;
};

/// Puts a timed path behind what is there. `bounds`: the names of rows of `active` beyond the joints.
void add_section(PlannedMotion& motion, std::string name, std::shared_ptr<const timing::TimedPath> timed,
                 const std::vector<timing::ActiveLimit>& active, const std::vector<std::string>& bounds);
/// When all sections are there.
void finish(PlannedMotion& motion, const kinematics::Chain& chain);
/// A trajectory with the times it has; problems say which limits it exceeds where. `points`: their times, for
/// sentences.
void take_trajectory(PlannedMotion& motion, const kinematics::Chain& chain, trajectory::Trajectory trajectory,
                     const std::vector<double>& points);

/// The extremes of every joint, from samples; of `value` the index is the quantity.
struct PlanPeaks {
  std::array<double, 4> low, high;
};
std::vector<PlanPeaks> peaks_of(const PlannedMotion& motion, double* tcp_speed);
/// Bands that last less than `shortest` joined with the neighbour that lasts longer.
std::vector<PlanBand> merged(const std::vector<PlanBand>& bands, double shortest);

/// Text for people, one JSON object, rows of values at a rate (Hz), and the plot.
std::string report_of(const PlannedMotion& motion);
std::string json_of(const PlannedMotion& motion);
std::string csv_of(const PlannedMotion& motion, double rate);
std::string svg_of(const PlannedMotion& motion);

}  // namespace polyarm::apps
