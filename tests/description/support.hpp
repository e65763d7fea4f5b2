#pragma once
/// What the tests of descriptions share: comparing models, walking joints, and damaging texts.
#include <gtest/gtest.h>

#include <cstdint>
#include <optional>
#include <random>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/description/robot_model.hpp"

namespace polyarm::description::test {

constexpr double kTolerance = 1e-9;

inline void expect_near(const Vec3& a, const Vec3& b, double tolerance = kTolerance) {
  EXPECT_NEAR(a.x, b.x, tolerance);
  EXPECT_NEAR(a.y, b.y, tolerance);
  EXPECT_NEAR(a.z, b.z, tolerance);
}

inline void expect_near(const Pose& a, const Pose& b, double tolerance = kTolerance) {
  expect_near(a.position, b.position, tolerance);
  for (const Vec3& axis : {Vec3{1, 0, 0}, Vec3{0, 1, 0}, Vec3{0, 0, 1}})
    expect_near(a.rotation * axis, b.rotation * axis, tolerance);
}

inline void expect_equal(const std::optional<double>& a, const std::optional<double>& b) {
  ASSERT_EQ(a.has_value(), b.has_value());
  EXPECT_NEAR(a.value_or(0), b.value_or(0), kTolerance);
}

inline void expect_equal(const Inertial& a, const Inertial& b) {
  EXPECT_NEAR(a.mass, b.mass, kTolerance);
  expect_near(a.center, b.center);
  for (std::size_t k = 0; k < 6; ++k) EXPECT_NEAR(a.inertia[k], b.inertia[k], kTolerance);
  EXPECT_EQ(a.estimated, b.estimated);
}

inline void expect_equal(const std::vector<Shape>& a, const std::vector<Shape>& b) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    EXPECT_EQ(a[i].kind, b[i].kind);
    expect_near(a[i].pose, b[i].pose);
    expect_near(a[i].size, b[i].size);
    EXPECT_NEAR(a[i].radius, b[i].radius, kTolerance);
    EXPECT_NEAR(a[i].length, b[i].length, kTolerance);
    EXPECT_EQ(a[i].mesh, b[i].mesh);
    expect_near(a[i].scale, b[i].scale);
  }
}

inline void expect_equal(const Link& a, const Link& b) {
  SCOPED_TRACE("link " + a.name);
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.parent_joint, b.parent_joint);
  ASSERT_EQ(a.inertial.has_value(), b.inertial.has_value());
  if (a.inertial) expect_equal(*a.inertial, *b.inertial);
  expect_equal(a.visuals, b.visuals);
  expect_equal(a.collisions, b.collisions);
}

inline void expect_equal(const JointLimits& a, const JointLimits& b) {
  expect_equal(a.lower, b.lower);
  expect_equal(a.upper, b.upper);
  expect_equal(a.velocity, b.velocity);
  expect_equal(a.effort, b.effort);
  expect_equal(a.acceleration, b.acceleration);
  expect_equal(a.jerk, b.jerk);
}

inline void expect_equal(const Joint& a, const Joint& b) {
  SCOPED_TRACE("joint " + a.name);
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.type, b.type);
  EXPECT_EQ(a.parent_link, b.parent_link);
  EXPECT_EQ(a.child_link, b.child_link);
  expect_near(a.origin, b.origin);
  if (a.moves()) expect_near(a.axis, b.axis);
  expect_equal(a.limits, b.limits);
  EXPECT_NEAR(a.damping, b.damping, kTolerance);
  EXPECT_NEAR(a.friction, b.friction, kTolerance);
  ASSERT_EQ(a.mimic.has_value(), b.mimic.has_value());
  if (!a.mimic) return;
  EXPECT_EQ(a.mimic->joint, b.mimic->joint);
  EXPECT_NEAR(a.mimic->multiplier, b.mimic->multiplier, kTolerance);
  EXPECT_NEAR(a.mimic->offset, b.mimic->offset, kTolerance);
}

inline void expect_equal(const Provenance& a, const Provenance& b) {
  EXPECT_EQ(a.maker, b.maker);
  EXPECT_EQ(a.model, b.model);
  EXPECT_EQ(a.source, b.source);
  EXPECT_EQ(a.licence, b.licence);
  EXPECT_EQ(a.notes, b.notes);
  EXPECT_EQ(a.payload_kg, b.payload_kg);
  EXPECT_EQ(a.reach_m, b.reach_m);
}

inline void expect_equal(const RobotModel& a, const RobotModel& b) {
  EXPECT_EQ(a.name, b.name);
  EXPECT_EQ(a.root, b.root);
  EXPECT_EQ(a.actuated, b.actuated);
  ASSERT_EQ(a.links.size(), b.links.size());
  for (std::size_t i = 0; i < a.links.size(); ++i) expect_equal(a.links[i], b.links[i]);
  ASSERT_EQ(a.joints.size(), b.joints.size());
  for (std::size_t i = 0; i < a.joints.size(); ++i) expect_equal(a.joints[i], b.joints[i]);
  EXPECT_EQ(a.named_states, b.named_states);
  EXPECT_EQ(a.allowed_collisions, b.allowed_collisions);
  expect_equal(a.provenance, b.provenance);
  EXPECT_EQ(a.provenance.controller_axes, b.provenance.controller_axes);
  ASSERT_EQ(a.controller_axes.size(), b.controller_axes.size());
  for (std::size_t i = 0; i < a.controller_axes.size(); ++i) {
    EXPECT_EQ(a.controller_axes[i].sign, b.controller_axes[i].sign);
    EXPECT_EQ(a.controller_axes[i].offset, b.controller_axes[i].offset);
    ASSERT_EQ(a.controller_axes[i].coupling.size(), b.controller_axes[i].coupling.size());
    for (std::size_t k = 0; k < a.controller_axes[i].coupling.size(); ++k)
      EXPECT_EQ(a.controller_axes[i].coupling[k].joint, b.controller_axes[i].coupling[k].joint);
  }
}

/// The pose of every link in the root's frame, joint by joint; `q` in the order of `actuated`.
inline std::vector<Pose> walk(const RobotModel& model, const std::vector<double>& q) {
  std::vector<double> values(model.joints.size(), 0.0);
  for (std::size_t i = 0; i < model.actuated.size(); ++i)
    values[static_cast<std::size_t>(model.actuated[i])] = q.at(i);
  std::vector<Pose> out(model.links.size());
  for (std::size_t i = 0; i < model.joints.size(); ++i) {
    const Joint& joint = model.joints[i];
    double value = values[i];
    if (joint.mimic)
      value = joint.mimic->multiplier * values[static_cast<std::size_t>(joint.mimic->joint)] +
              joint.mimic->offset;
    Pose motion;
    if (joint.type == JointType::prismatic)
      motion.position = value * joint.axis;
    else if (joint.moves())
      motion.rotation = from_axis_angle(joint.axis, value);
    out[static_cast<std::size_t>(joint.child_link)] =
        out[static_cast<std::size_t>(joint.parent_link)] * joint.origin * motion;
  }
  return out;
}

/// Damages a text the same way for the same seed: bytes changed, cut out, doubled, and numbers made odd.
class Mutator {
 public:
  explicit Mutator(std::uint32_t seed) : random_(seed) {}
  std::string operator()(std::string text) {
    for (std::size_t rounds = 1 + below(4); rounds > 0; --rounds) damage(text);
    return text;
  }

 private:
  std::size_t below(std::size_t end) { return end == 0 ? 0 : random_() % end; }
  void damage(std::string& text) {
    static const char* const kOdd[] = {"nan", "-1", "1e308", "<",  ">", "\"", "[",     "]",  "{",  "}",
                                       ":",   "\n", "&",     "*x", "-", "0",  "null",  "~",  "!!", "${x}",
                                       "",    " ",  "\t",    "#",  "'", "|",  "1e999", "mm", ",",  "- "};
    const std::size_t at = below(text.size() + 1), length = std::min(below(20), text.size() - at);
    switch (below(5)) {
      case 0:
        if (at < text.size()) text[at] = static_cast<char>(below(256));
        break;
      case 1:
        text.erase(at, length);
        break;
      case 2:
        text.insert(below(text.size() + 1), text.substr(at, length));
        break;
      case 3:
        text.replace(at, std::min<std::size_t>(length, 4), kOdd[below(std::size(kOdd))]);
        break;
      default:
        if (below(20) == 0) text.resize(at);
    }
  }
  std::mt19937 random_;
};

/// True if `text` has `piece` in it; says both where not.
inline ::testing::AssertionResult has(const std::string& text, const std::string& piece) {
  if (text.find(piece) != std::string::npos) return ::testing::AssertionSuccess();
  return ::testing::AssertionFailure() << "'" << piece << "' is not in: " << text;
}

}  // namespace polyarm::description::test
