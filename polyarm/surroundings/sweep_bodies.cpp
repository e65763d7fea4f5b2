#include "polyarm/surroundings/sweep_bodies.hpp"

#include <utility>

namespace polyarm::surroundings {

using collision::ConvexBody;
using collision::RobotBody;
using Body = SweptBody;
using Kind = BodyKind;

namespace {
/// So many pieces get a tree: a point cloud.
constexpr std::size_t kTreeFrom = 64;
void finish_body(Body& body) {
  for (const ConvexBody& piece : body.pieces) body.balls.push_back(collision::bounding_ball(piece));
  body.around = body.pieces.empty() ? collision::Ball{} : collision::bounding_ball(body.pieces);
  if (body.pieces.size() < kTreeFrom) return;
  std::vector<collision::Bounds> bounds;
  for (const ConvexBody& piece : body.pieces) bounds.push_back(collision::bounds_of(piece));
  body.tree = collision::BoxTree(bounds);
}
}  // namespace

SweepBodies::SweepBodies(std::vector<Robot> robots, const description::Scene& scene)
    : robots_(std::move(robots)), scene_(scene) {
  for (std::size_t r = 0; r < robots_.size(); ++r) add_robot(r);
  for (std::size_t f = 0; f < scene.fixtures.size(); ++f) add_fixture(f);
  if (scene.floor) {
    Body floor;
    floor.name = "floor";
    floor.kind = Kind::floor;
    floor.is_static = true;
    bodies_.push_back(std::move(floor));
  }
  for (std::size_t p = 0; p < scene.parts.size(); ++p) {
    Body part;
    part.name = "part " + scene.parts[p].name;
    part.kind = Kind::part;
    part.part = static_cast<int>(p);
    part.pieces = collision::bodies_of(scene.parts[p].shape);
    finish_body(part);
    bodies_.push_back(std::move(part));
  }
}

void SweepBodies::add_robot(std::size_t r) {
  const Robot& robot = robots_[r];
  models_.push_back(robot_body(robot));
  const RobotBody& model = *models_.back();
  const std::vector<char> rolling = links_on_floor(robot);
  first_body_.push_back(bodies_.size());
  for (const collision::LinkBody& link : model.links()) {
    Body body;
    body.name = robot.name.empty() ? link.name : robot.name + "/" + link.name;
    body.kind = !link.attached ? Kind::link : link.name == "fingers" ? Kind::fingers : Kind::tool;
    body.robot = static_cast<int>(r);
    body.frame = link.frame;
    body.link = link.link;
    body.pieces = link.bodies;
    body.lever = model.levers_of(link.frame, link.spheres);
    body.is_root = is_rigid_with_root(*robot.model, link.link);
    body.is_first = is_first_moving(*robot.model, link.link);
    body.rolls = !rolling.empty() && rolling[static_cast<std::size_t>(link.link)] != 0;
    finish_body(body);
    bodies_.push_back(std::move(body));
  }
  const std::vector<int> near = links_at_tool(*robot.model);
  near_tool_.emplace_back(robot.model->links.size(), 0);
  for (const int link : near) near_tool_.back()[static_cast<std::size_t>(link)] = 1;
  tool_frame_.push_back(model.frame_of(robot.model->tool_link()));
}

void SweepBodies::add_fixture(std::size_t f) {
  const description::Fixture& fixture = scene_.fixtures[f];
  Body body;
  body.name = "fixture " + fixture.name;
  body.kind = Kind::fixture;
  body.fixture = static_cast<int>(f);
  body.is_static = fixture.mover.empty();
  for (const description::Shape& shape : fixture.shapes)
    for (ConvexBody& piece : collision::bodies_of(shape)) body.pieces.push_back(std::move(piece));
  if (body.pieces.empty()) return;
  finish_body(body);
  bodies_.push_back(std::move(body));
}

/// Two bodies without a part, not of one robot.
bool SweepBodies::counts(const Body& a, const Body& b) const {
  if (a.of_robot() && b.of_robot()) {
    if (a.robot == b.robot || is_shared(a, b) || is_shared(b, a)) return false;
    return may_meet(a, b) && may_meet(b, a);
  }
  if (!a.of_robot() && !b.of_robot()) return false;
  const Body &own = a.of_robot() ? a : b, &other = a.of_robot() ? b : a;
  const Robot& robot = robots_[static_cast<std::size_t>(own.robot)];
  if (other.kind == Kind::floor && own.rolls) return false;
  if (!other.is_static || robot.is_free) return true;
  return !own.is_root && !own.is_first;
}

bool SweepBodies::counts(const Body& a, const Body& b, const std::vector<PartMode>& parts) const {
  const Body &part = a.part >= 0 ? a : b, &other = a.part >= 0 ? b : a;
  const PartMode& mode = parts[static_cast<std::size_t>(part.part)];
  if (!mode.in_world) return false;
  if (other.part >= 0) {
    const PartMode& second = parts[static_cast<std::size_t>(other.part)];
    return second.in_world && mode.held_by != second.held_by;
  }
  if (mode.held_by < 0) {
    if (!other.of_robot() || other.kind == Kind::fingers) return false;
    return !other.is_root || robots_[static_cast<std::size_t>(other.robot)].is_free;
  }
  if (!other.of_robot()) return true;
  if (other.robot != mode.held_by) return other.kind != Kind::fingers;
  return other.kind == Kind::link &&
         !near_tool_[static_cast<std::size_t>(other.robot)][static_cast<std::size_t>(other.link)];
}

std::vector<collision::Ball> SweepBodies::balls_in_hand(const Body& part, const Pose& in_hand) {
  std::vector<collision::Ball> out = part.balls;
  for (collision::Ball& ball : out) ball.center = in_hand * ball.center;
  return out;
}

/// Does the robot of `other` have this body, too?
bool SweepBodies::is_shared(const Body& body, const Body& other) const {
  return body.kind == Kind::link && robots_[static_cast<std::size_t>(body.robot)].shares(
                                        body.link, static_cast<std::size_t>(other.robot));
}

/// Is `a` something that `b` may not touch, as far as one robot carries the other, or none moves?
bool SweepBodies::may_meet(const Body& a, const Body& b) const {
  const Robot &ra = robots_[static_cast<std::size_t>(a.robot)],
              &rb = robots_[static_cast<std::size_t>(b.robot)];
  if (rb.carries(ra, static_cast<std::size_t>(b.robot)) && (a.is_root || a.is_first) && b.is_root)
    return false;
  return !(a.is_root && b.is_root && !ra.is_free && !rb.is_free);
}

}  // namespace polyarm::surroundings
