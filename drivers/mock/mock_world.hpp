#pragma once
/// Simulates tools, parts and machines without physics. Metres, radians, seconds; poses in the world. Control
/// thread; step() allocates nothing.
#include <span>
#include <string>
#include <vector>

#include "polyarm/hardware/component.hpp"

namespace polyarm::drivers {

/// Tools, feeders, outfeeds, movers and parts without physics, so that programs run on mock hardware. A
/// gripper that is switched on holds the nearest part within 15 mm of the TCP after 0.1 s. A released part
/// moves down onto the fixture, the part or the floor below it; if there is none, to the height of its goal or
/// its start. Movers follow their set points at their speed and carry the parts that lie on them.
class MockWorld {
 public:
  MockWorld(const hardware::ComponentContext& context, std::vector<hardware::InterfaceDescription>& states,
            std::vector<hardware::InterfaceDescription>& commands);

  /// Advances by one cycle. `asked` has the last finite command of each interface, `states` the joint
  /// positions.
  void step(const hardware::Cycle& cycle, std::span<const double> asked, std::span<double> states) noexcept;
  const hardware::WorldState& state() const { return state_; }

 private:
  struct Step {  // one joint of the chain from base to TCP
    Pose fixed;
    Vec3 axis;
    int position_state = -1;  ///< -1: fixed
    bool prismatic = false;
    double multiplier = 1, offset = 0;
  };
  struct Arm {
    Pose base, last;
    std::vector<Step> chain;
    int command = -1, level_state = -1, present_state = -1;
    int robot = 0;  ///< for PartState::held_by
    double on_for = 0;
    int held = -1;
    Pose grasp;        ///< T_tcp_part
    int touched = -1;  ///< the part of another robot that the cup is at: it is taken over when that lets go
    Pose at;           ///< of the TCP in the world, while the vacuum is on
  };
  struct Feeder {
    int command, presented_state, remaining_state, present_state, count_state, kind_state;
    std::vector<int> parts;
    int presented = 0;
    Pose pose;
  };
  struct Region {
    int command = -1, present_state = -1, taken_state = -1;
    Vec3 lower, upper;
    int taken = 0;
  };
  struct Mover {
    int command, state;
    double at = 0, speed = 0.1, lower = 0, upper = 0;
    Vec3 axis;
    Vec3 offset() const { return at * axis; }
  };
  /// An upright shape of a fixture that parts may lie on.
  struct Support {
    const description::Shape* shape;
    Pose pose;  ///< in the world, with its mover at 0
    int mover = -1;
  };
  Pose tcp(const Arm& arm, std::span<const double> states) const noexcept;
  void grip(Arm& arm, double dt, std::span<const double> asked, std::span<double> states) noexcept;
  void release_now(Arm& arm) noexcept;
  void add_supports();
  struct Below {
    double top = 0;  ///< m; minus infinity: there is nothing
    int mover = -1;
  };
  /// The highest top on the vertical line below a point of the part, whose underside is at `bottom`.
  Below below(std::size_t part, const Vec3& point, double bottom) const noexcept;
  /// The height at which the part comes to rest, m; remembers the mover that carries it. It lies on what is
  /// below its middle, or below two opposite points of its underside. Minus infinity: there is nothing.
  double top_below(std::size_t part) noexcept;
  void carry(std::size_t mover, double by) noexcept;
  bool is_free(const Feeder& feeder) const noexcept;
  void feed(Feeder& feeder, std::span<const double> asked, std::span<double> states) noexcept;
  void watch(Region& region, std::span<const double> asked, std::span<double> states) noexcept;

  const description::Scene* scene_ = nullptr;
  std::vector<int> kinds_;  // of each part, from 1
  std::vector<Arm> arms_;
  std::vector<Feeder> feeders_;
  std::vector<Region> regions_;
  std::vector<Mover> movers_;
  struct Belt {
    int command, position_state, speed_state;
    double most, at = 0;
  };
  std::vector<Belt> belts_;
  std::vector<Support> supports_;
  std::vector<int> carried_by_;  // mover of each part, or -1
  hardware::WorldState state_;
};

}  // namespace polyarm::drivers
