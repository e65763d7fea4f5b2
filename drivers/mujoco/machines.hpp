#pragma once
/// Machines of the simulated scene. Metres, s; world frame. Control thread.
#include <span>
#include <string>
#include <vector>

#include "drivers/mujoco/parts.hpp"
#include "polyarm/hardware/component.hpp"

namespace polyarm::drivers {

/// Feeders, outfeeds, presence sensors and movers of the scene, with their interfaces.
class Machines {
 public:
  Machines(const description::Scene* scene, std::vector<hardware::InterfaceDescription>& states,
           std::vector<hardware::InterfaceDescription>& commands);

  void command(std::span<const double> commands) noexcept;
  /// One physics step: movers advance and carry the objects on them, feeders and outfeeds act. True if a
  /// mover advanced.
  bool step(ModelView& view, Parts& parts, double timestep) noexcept;
  /// Copies the present positions of the movers into another model.
  void lay_out(ModelView& view) const noexcept;
  void read(const Parts& parts, std::span<double> states) const noexcept;
  bool moving() const noexcept;

 private:
  struct Feeder {
    int command, presented_state, remaining_state, present_state, count_state, kind_state;
    std::vector<int> parts;
    int asked = 0, presented = 0;
    Pose pose;
    const description::Feeder* fact = nullptr;
  };
  struct Region {
    int command = -1, present_state = -1, taken_state = -1;
    Bounds bounds;
    int asked = 0, taken = 0;
    bool needs_rest = false;
  };
  struct Mover {
    int command, state;
    double at = 0, velocity = 0, target = 0;
    const description::Mover* fact = nullptr;
    std::vector<const description::Fixture*> fixtures;
    bool moves() const noexcept { return velocity != 0 || at != target; }
  };
  struct Belt {
    int command, position_state, speed_state, parts_state, latch_state;
    const description::Belt* fact = nullptr;
    Bounds surface{};
    double at = 0, velocity = 0, target = 0, latch = 0;
    int seen = 0;
    std::vector<double> before{};  ///< place of each part along the belt; NaN: not on it
  };
  Pose place_of_next(const Feeder& feeder) const noexcept;
  bool is_free(const Feeder& feeder, const Parts& parts) const noexcept;
  void advance(std::size_t index, Mover& mover, ModelView& view, Parts& parts, double dt) noexcept;

  void advance(Belt& belt, Parts& parts, double dt) noexcept;
  static double place_on(const Belt& belt, const Vec3& position) noexcept;

  const description::Scene* scene_;
  std::vector<Belt> belts_;
  std::vector<Feeder> feeders_;
  std::vector<Region> regions_;
  std::vector<Mover> movers_;
};

}  // namespace polyarm::drivers
