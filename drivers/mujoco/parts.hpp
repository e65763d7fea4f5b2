#pragma once
/// States of the parts in the simulation. Metres, seconds; poses in the world.
#include <array>
#include <vector>

#include "drivers/mujoco/model_set.hpp"
#include "polyarm/description/shape_bounds.hpp"

namespace polyarm::drivers {

using description::Bounds;
using description::bounds_of;

/// The parts of the world and their states: waiting in a feeder, asleep (a fixed twin), awake (a free body),
/// held by a cup (part of the arm), or removed. Control thread; nothing allocates after construction.
class Parts {
 public:
  enum class Mode { magazine, asleep, awake, held, taken };
  struct Part {
    Mode mode = Mode::magazine;
    Pose pose;
    std::array<double, 6>
        velocity{};        ///< of the free joint: linear in the world, angular in the part, m/s and rad/s
    double speed = 0;      ///< approximate speed of its fastest point
    double still_for = 0;  ///< s
    double radius = 0;     ///< of its bounding sphere
    int robot = -1;        ///< that holds it
    Pose grasp;            ///< T_tool_part while held by a cup
    int mover = -1;        ///< that supports it
    int slot = -1;
    bool entered = false;
    bool wake_requested = false;
  };

  explicit Parts(const description::Scene* scene);

  std::size_t size() const noexcept { return parts_.size(); }
  Part& operator[](std::size_t i) noexcept { return parts_[i]; }
  const Part& operator[](std::size_t i) const noexcept { return parts_[i]; }
  const description::Part& fact(std::size_t i) const noexcept { return scene_->parts[i]; }
  bool in_world(std::size_t i) const noexcept {
    return parts_[i].mode != Mode::magazine && parts_[i].mode != Mode::taken;
  }
  std::size_t awake() const noexcept;
  Bounds bounds(std::size_t i) const noexcept { return bounds_of(scene_->parts[i].shape, parts_[i].pose); }

  void wake(std::size_t i) noexcept;
  void put_to_sleep(std::size_t i) noexcept;
  void present(std::size_t i, const Pose& at) noexcept;
  void take_away(std::size_t i) noexcept;
  void hold(std::size_t i, int robot, const Pose& grasp) noexcept;
  void release_now(std::size_t i) noexcept;
  /// Wakes the parts on or beside part `i`, because it now moves.
  void wake_neighbours(std::size_t i) noexcept;

  /// Reads the free bodies of `view` after a step, and counts how long each has been at rest.
  void pull(const ModelView& view, double timestep) noexcept;
  /// Writes the present states of the parts to slots, twins and held bodies of the model. No effect if
  /// nothing changed.
  bool changed() const noexcept { return changed_; }
  void lay_out(const ModelSet& models, ModelView& view) noexcept;
  void place_twin(const ModelView& view, std::size_t i) const noexcept;

  static constexpr double kStill = 1e-3;      ///< m/s
  static constexpr double kSleepAfter = 0.5;  ///< s

 private:
  const description::Scene* scene_;
  std::vector<Part> parts_;
  bool changed_ = true;
};

}  // namespace polyarm::drivers
