#pragma once
/// The surroundings of the robot: tools, parts, fixtures, feeders. Plain facts, constant while the cell runs;
/// the world state has the present positions (hardware/world_state.hpp). Metres, kg; poses in the world.
#include <optional>
#include <string>
#include <vector>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description {

enum class GripperKind { none, suction, parallel };

/// A tool bolted to a robot's `tool0`.
struct Tool {
  std::string name = "none";
  Pose tcp;                 ///< T_tool0_tcp, z out of the tool
  double mass = 0;          ///< kg
  Vec3 center;              ///< centre of mass in tool0
  std::vector<Shape> body;  ///< in tool0; contact with these shapes is a contact finding
  GripperKind gripper = GripperKind::none;
  double cup_radius = 0.01;     ///< suction: radius of the lip; its centre is the TCP
  double holding_force = 60;    ///< suction: the part detaches above this force, N
  double reach = 0.0015;        ///< suction: largest distance between lip and surface for a grip, m
  double stroke = 0.05;         ///< parallel: distance between the open finger pads, m
  double grip_force = 40;       ///< parallel: force of each finger, N
  double finger_length = 0.04;  ///< parallel: length of the pads along z, ending at the TCP
  double finger_width = 0.02;
  double closing_speed = 0.1;  ///< parallel: m/s of each finger
};

/// The required final position of a part.
struct Goal {
  Vec3 at;          ///< of the part's origin (the centre of its shape)
  std::string bin;  ///< name of the bin that must contain it; empty: none
  double tolerance = 0.005;
};

struct Part {
  std::string name;
  std::string kind;
  Shape shape;  ///< its pose is the identity; the part's origin is the shape's centre, or a mesh's origin
  double mass = 0.05;
  double friction = 0.8;
  Pose start;  ///< in the world; unused while the part waits in a feeder
  std::optional<Goal> goal;
  std::string feeder;  ///< name of the feeder that brings it; empty: present from the start
};

/// An object that does not move unless it belongs to a mover.
struct Fixture {
  std::string name;
  std::vector<Shape> shapes;  ///< in the fixture's frame
  Pose pose;                  ///< in the world, or in the mover's frame at position zero
  std::string mover;          ///< name of the mover that carries it; empty: fixed to the world
  double friction = 0.8;
  std::string belt;  ///< name of the belt whose surface it is; empty: of none
};

/// A region of the world in which parts are counted. If it has walls, they are a fixture.
struct Bin {
  std::string name;
  Vec3 lower, upper;
};

/// An axis of a machine (door, vice, shuttle) that moves to commanded positions with a speed limit.
/// Interfaces: command and state `scene/<name>/position` (m along the axis, 0 at the start).
struct Mover {
  std::string name;
  Vec3 axis{1, 0, 0};
  double lower = 0, upper = 0.1;
  double speed = 0.1, acceleration = 0.5;
};

/// A conveyor belt, whose surface moves along its x axis, or a turntable, whose surface turns about its z
/// axis; its body is a fixture. Parts ride on it by friction. Command `scene/<name>/speed` (m/s or rad/s).
/// States `scene/<name>/position` (its encoder, m or rad), `scene/<name>/speed`, `scene/<name>/parts` (number
/// of parts whose middle has passed `sensor_at`), `scene/<name>/latch` (its encoder where the last of them
/// passed).
struct Belt {
  std::string name;
  Pose pose;  ///< of its frame: the middle of its surface
  bool turns = false;
  double speed = 1, acceleration = 1;  ///< the most, per s and per s²
  double sensor_at = 0;                ///< place of the light barrier along x, or about z, m or rad
  double half_width = 0.1;  ///< of the region across x that the barrier sees; of a turntable its radius
};

/// Brings the parts that name it to `pose`, one for each increment of its command `scene/<name>/feed` (a
/// count). States: `scene/<name>/presented` (number of parts so far), `scene/<name>/remaining`,
/// `scene/<name>/present` (1 while a part lies there), `scene/<name>/count` (number of parts there),
/// `scene/<name>/kind` (index into Scene::kinds of the last part, from 1).
struct Feeder {
  std::string name;
  Pose pose;
  /// Each part is beside `pose` by at most these lengths along its axes, and turned about its z axis by at
  /// most `turn`, by chance; a feeder makes the same places in every run.
  Vec3 spread;
  double turn = 0;
  Pose place(std::size_t part) const;
};

/// Removes the part that rests in its region, one for each increment of its command `scene/<name>/take` (a
/// count). States: `scene/<name>/present` (1 while a part rests in its region), `scene/<name>/taken` (count).
struct Outfeed {
  std::string name;
  Vec3 lower, upper;
};

/// State `scene/<name>/present`: 1 while a part's origin is inside the region.
struct PresenceSensor {
  std::string name;
  Vec3 lower, upper;
};

/// Sees the parts whose origin is inside its region (see cell/), sorted by distance from `eye`.
struct Camera {
  std::string name;
  Vec3 lower, upper;
  Vec3 eye;
};

struct Scene {
  std::vector<Fixture> fixtures;
  std::vector<Part> parts;
  std::vector<std::string> kinds;  ///< all kinds of parts, in the order of their first use
  std::vector<Bin> bins;
  std::vector<Mover> movers;
  std::vector<Belt> belts;
  std::vector<Feeder> feeders;
  std::vector<Outfeed> outfeeds;
  std::vector<PresenceSensor> sensors;
  std::vector<Camera> cameras;
  Vec3 gravity{0, 0, -9.81};
  bool floor = true;  ///< an infinite plane at z = floor_height
  double floor_height = 0;
};

}  // namespace polyarm::description
