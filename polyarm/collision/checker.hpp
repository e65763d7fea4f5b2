#pragma once
/// Collision checks of one robot in one world: verdicts of many states side by side, exact distances, whole
/// edges with proof. Metres, radians; a joint state has one value for each of RobotModel::actuated; results
/// in the world.
///
/// A verdict by spheres never misses a contact of the shapes; it may be a false alarm where a sphere stands
/// out of its link. Exact calls resolve these. Links that do not move never touch the world: a robot stands
/// on something. Threads: Checker is const, any thread. A Probe has memory of its own: one for each thread.
/// Only constructors allocate or throw (and the texts of a Contact).
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/collision/robot_body.hpp"
#include "polyarm/collision/world.hpp"
#include "polyarm/simd/instruction_set.hpp"

namespace polyarm::collision {

struct CheckData;
struct CheckKernels;

struct CheckerOptions {
  Pose T_world_base;
  double clearance = 0;  ///< m that must stay between robot and world; contacts are "nearer than this"
  /// Names of a link and an obstacle that may touch.
  std::vector<std::pair<std::string, std::string>> allowed;
  kinematics::InstructionSet instructions = kinematics::wanted_instructions();
};

class Checker {
 public:
  /// Throws Error("bad-pose" | "bad-value") for a base or a clearance that is not finite.
  Checker(std::shared_ptr<const RobotBody> robot, const World& world, const CheckerOptions& options = {});
  ~Checker();
  Checker(const Checker&) = delete;
  Checker& operator=(const Checker&) = delete;

  const RobotBody& robot() const noexcept { return *robot_; }
  std::size_t variables() const noexcept { return robot_->variables(); }
  const std::vector<Obstacle>& obstacles() const noexcept { return obstacles_; }  ///< in the robot's base
  double clearance() const noexcept { return options_.clearance; }
  const Pose& base() const noexcept { return options_.T_world_base; }
  /// States that one call of a kernel checks.
  std::size_t width() const noexcept;
  const CheckData& data() const noexcept { return *data_; }
  const CheckKernels& kernels() const noexcept { return *kernels_; }
  /// False for NaN, infinity, and sliding joints outside their limits; such states count as touching.
  bool usable(std::span<const double> q) const noexcept;
  /// The value of a joint for the kernels: turns of a revolute joint are taken out.
  float value(std::size_t variable, double q) const noexcept;
  /// Rows of margins: bounds on the motion of each link and on the change of each pair's distance for the
  /// joint changes `size` (not negative), m.
  std::size_t rows() const noexcept;
  void motion(std::span<const double> size, std::span<double> rows) const noexcept;

 private:
  std::shared_ptr<const RobotBody> robot_;
  std::vector<Obstacle> obstacles_;
  CheckerOptions options_;
  std::unique_ptr<CheckData> data_;
  const CheckKernels* kernels_;
  std::vector<char> wraps_;         // by variable: whole turns change nothing
  std::vector<double> row_levers_;  // [row * variables + variable]
};

/// Two bodies that are nearest to each other, or overlap most.
struct Contact {
  std::string first, second;  ///< a link or attached body; an obstacle or another link
  double distance = 0;        ///< m; negative: how deep they overlap (see overlap())
  Vec3 on_first, on_second;   ///< nearest points in the world; if they overlap, both are near its middle
};

enum class EdgeVerdict {
  free,     ///< proven for every state of the edge
  touches,  ///< at the reported place
  close,    ///< neither: something comes closer than the resolution, or the work was at its bound
};

struct EdgeAnswer {
  EdgeVerdict verdict = EdgeVerdict::free;
  double at = 0;  ///< touches, close: the place, 0 to 1
  int calls = 0;  ///< of a kernel
};

struct EdgeOptions {
  /// Resolve false alarms of spheres by exact distances; slower near obstacles.
  bool exact = false;
  double resolution = 2e-4;  ///< m of motion between states below which an edge is called `close`
  int most_calls = 200;
};

/// Checks states and edges. Not copied: it refers to its checker, which must outlive it.
class Probe {
 public:
  explicit Probe(const Checker& checker);

  const Checker& checker() const noexcept { return checker_; }

  /// By spheres.
  bool touches(std::span<const double> q) noexcept;
  /// `states`: one after the other; `out[i]` is 1 if state i touches.
  void touches(std::span<const double> states, std::span<std::uint8_t> out) noexcept;
  /// By the exact shapes: a contact is reported unless a lower bound of the distance exceeds the clearance.
  bool touches_exactly(std::span<const double> q) noexcept;
  /// The smallest distance, or the deepest overlap, by the exact shapes. Returns a Contact with empty names
  /// and an infinite distance if nothing can meet.
  Contact nearest(std::span<const double> q);

  /// True if none of `states` states, evenly along the straight line and with its end, touches by spheres.
  bool sampled_edge(std::span<const double> from, std::span<const double> to, std::size_t states) noexcept;
  /// The whole straight line in joint space, by bounds on motion: `free` is a proof.
  EdgeAnswer edge(std::span<const double> from, std::span<const double> to,
                  const EdgeOptions& options = {}) noexcept;

  /// `states`, one after the other, and for each a size of joint changes: true if every state that differs
  /// from one of them by at most its size in each joint is proven free.
  bool proven_around(std::span<const double> states, std::span<const double> sizes,
                     bool use_exact = false) noexcept;

 private:
  struct Interval {
    double middle, half;
  };
  enum class ExactVerdict { free, near, touches };
  ExactVerdict exact(std::span<const double> q, std::span<const double> margins) noexcept;
  void fill_state(std::size_t lane, std::span<const double> q) noexcept;
  void fill_line(std::span<const double> from, std::span<const double> to, const Interval* intervals,
                 std::size_t count) noexcept;
  float* floats(std::size_t offset) noexcept { return aligned_ + offset; }

  const Checker& checker_;
  std::size_t width_;
  std::vector<float> memory_;
  float* aligned_ = nullptr;  // scratch, then states, then margins
  std::size_t states_at_ = 0, margins_at_ = 0;
  std::vector<double> rows_, scaled_, state_, size_;
  std::vector<Interval> open_;
};

}  // namespace polyarm::collision
