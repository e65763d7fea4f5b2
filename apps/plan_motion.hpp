#pragma once
/// A planned motion for the output of `polyarm plan`: joints over time, their limits, and the active limits.
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
  bool slides = false;  ///< prismatic: metres instead of radians
  trajectory::MotionLimits limits;
  double lower = -std::numeric_limits<double>::infinity(), upper = std::numeric_limits<double>::infinity();
};

/// Between the times `from` and `to` (s) this limit determines the speed: that of joint `row`, or, from
/// joints.size() on, one of `bounds`.
struct PlanBand {
  double from, to;
  std::size_t row;
  timing::LimitKind kind;
};

/// The point of the motion nearest to an obstacle, or with the deepest overlap.
struct PlanClearance {
  double distance = std::numeric_limits<double>::infinity();  ///< m; negative: penetration depth
  std::string first, second;
  double time = 0;  ///< s
  Vec3 point;       ///< in the world, on `second`
};

struct PlanSection {
  std::string name;
  double begin, end;
  std::optional<PlanClearance> clearance = {};  ///< empty without surroundings
};

/// State of all joints at one time.
struct PlanState {
  explicit PlanState(std::size_t joints) {
    for (auto& list : value) list.resize(joints);
  }
  std::array<std::vector<double>, 4> value;  ///< position, velocity, acceleration, jerk
  double tcp_speed = 0;                      ///< m/s
  Vec3 tcp;
};

/// Names of the four quantities in plots and tables.
inline constexpr std::array<const char*, 4> kQuantities = {"position", "velocity", "acceleration", "jerk"};
/// "rad/s²" or "m".
std::string unit_of(const PlanJoint& joint, std::size_t quantity);

struct PlannedMotion {
  std::string title;
  std::vector<PlanJoint> joints;
  std::vector<PlanSection> sections;
  std::vector<PlanBand> bands;      ///< ordered by time; empty for a trajectory with given times
  std::vector<std::string> bounds;  ///< limits other than those of joints: "the TCP's way"
  double duration = 0;
  double tcp_speed_limit = std::numeric_limits<double>::infinity();
  std::vector<Problem> problems;
  std::optional<PlanClearance> clearance;  ///< empty without surroundings
  std::function<void(double t, PlanState&)> at;
  /// For export: the timed paths of the sections, in sequence; empty for a trajectory with given times.
  std::vector<std::shared_ptr<const timing::TimedPath>> timed;

  const std::string& row_name(std::size_t row) const {
    return row < joints.size() ? joints[row].name : bounds[row - joints.size()];
  }
  bool has_errors() const;
};

/// Appends a timed path. `bounds`: names of the rows of `active` after the joints.
void add_section(PlannedMotion& motion, std::string name, std::shared_ptr<const timing::TimedPath> timed,
                 const std::vector<timing::ActiveLimit>& active, const std::vector<std::string>& bounds);
/// Call when all sections are added.
void finish(PlannedMotion& motion, const kinematics::Chain& chain);
/// Takes a trajectory with its given times; the problems say which limits it exceeds and where. `points`:
/// times of its points, for messages.
void take_trajectory(PlannedMotion& motion, const kinematics::Chain& chain, trajectory::Trajectory trajectory,
                     const std::vector<double>& points);

/// The sampled extremes of every joint, indexed by quantity.
struct PlanPeaks {
  std::array<double, 4> low, high;
};
std::vector<PlanPeaks> peaks_of(const PlannedMotion& motion, double* tcp_speed);
/// Merges bands shorter than `shortest` with the longer neighbour.
std::vector<PlanBand> merged(const std::vector<PlanBand>& bands, double shortest);

/// Output formats: text, one JSON object, CSV rows at a rate (Hz), and an SVG plot.
std::string report_of(const PlannedMotion& motion);
std::string json_of(const PlannedMotion& motion);
std::string csv_of(const PlannedMotion& motion, double rate);
std::string svg_of(const PlannedMotion& motion);

}  // namespace polyarm::apps
