#include "polyarm/moves/torque_limits.hpp"

#include <algorithm>
#include <cmath>
#include <random>
#include <string>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/description/model_builder.hpp"
#include "polyarm/moves/holding.hpp"

namespace polyarm::moves {

namespace {

constexpr double kEvery = 0.004;     // s between two checked places
constexpr std::size_t kLeast = 200;  // number of places
constexpr double kWithin = 1e-6;     // relative: tolerance at the limit
constexpr int kRandomPlaces = 256;
constexpr double kLeastShare = 0.05;  // smallest fraction of the acceleration; below it the motion slows down
                                      // instead

/// The model with a point mass at its tool link.
description::RobotModel carrying(description::RobotModel model, const Payload& payload) {
  if (!(payload.mass > 0)) return model;
  description::Link& link = model.links[static_cast<std::size_t>(model.tool_link())];
  const description::Inertial before = link.inertial.value_or(description::Inertial{});
  description::Inertial both = before;
  both.mass = before.mass + payload.mass;
  both.center = (1 / both.mass) * (before.mass * before.center + payload.mass * payload.center);
  const auto add = [&](double mass, const Vec3& from) {  // Steiner's theorem: moves a mass at `from` to the
                                                         // common centre
    const Vec3 r = from - both.center;
    both.inertia[0] += mass * (r.y * r.y + r.z * r.z);
    both.inertia[1] -= mass * r.x * r.y;
    both.inertia[2] -= mass * r.x * r.z;
    both.inertia[3] += mass * (r.x * r.x + r.z * r.z);
    both.inertia[4] -= mass * r.y * r.z;
    both.inertia[5] += mass * (r.x * r.x + r.y * r.y);
  };
  add(before.mass, before.center);
  add(payload.mass, payload.center);
  link.inertial = both;
  return model;
}

kinematics::Dynamics dynamics_of(const description::RobotModel& model, const Pose& base) {
  kinematics::TreeOptions options;
  options.T_world_base = base;
  return kinematics::Dynamics(kinematics::Tree(model, options));
}

bool has_limit(double effort) {
  return effort > 0 && std::isfinite(effort);
}

/// True if the catalogue has estimated the effort limits.
bool estimated_effort(const description::RobotModel& model) {
  const auto says = [](const std::string& note) {
    const auto at = note.find("effort limit");
    return at != std::string::npos && note.find("estimate", at) != std::string::npos;
  };
  return std::any_of(model.provenance.notes.begin(), model.provenance.notes.end(), says);
}

}  // namespace

Payload joined(const Payload& a, const Payload& b) {
  const double mass = a.mass + b.mass;
  if (!(mass > 0)) return {};
  return {mass, (1 / mass) * (a.mass * a.center + b.mass * b.center)};
}

kinematics::Dynamics loaded_dynamics(const description::RobotModel& model, const Pose& T_world_base,
                                     const Payload& payload) {
  return dynamics_of(carrying(model, payload), T_world_base);
}

TorqueLimits::TorqueLimits(const description::RobotModel& model, const Pose& T_world_base,
                           const Payload& payload, std::vector<double> effort)
    : payload_(payload),
      effort_(std::move(effort)),
      loaded_(loaded_dynamics(model, T_world_base, payload)),
      bare_(dynamics_of(model, T_world_base)) {
  if (bare_.tree().velocities() != effort_.size() || bare_.tree().positions() != effort_.size())
    throw Error("bad-model", "torques are checked only for joints with one value each");
  leave_out_what_holds_not_itself(model);
}

void TorqueLimits::leave_out_what_holds_not_itself(const description::RobotModel& model) {
  const std::size_t n = effort_.size();
  std::vector<double> q(n), tau(n), most(n, 0.0);
  std::mt19937_64 engine(1);
  for (int k = 0; k < kRandomPlaces; ++k) {
    for (std::size_t j = 0; j < n; ++j) {
      const description::Joint& joint = model.joints[static_cast<std::size_t>(model.actuated[j])];
      const double low = joint.limits.lower.value_or(-M_PI), high = joint.limits.upper.value_or(M_PI);
      // Builds the number from the engine's bits, so that every standard library gives the same values.
      const double share = static_cast<double>(engine() >> 11) * 0x1p-53;
      q[j] = low + (high - low) * share;
    }
    bare_.gravity(q, tau);
    for (std::size_t j = 0; j < n; ++j) most[j] = std::max(most[j], std::abs(tau[j]));
  }
  for (std::size_t j = 0; j < n; ++j)
    if (most[j] > effort_[j]) effort_[j] = 0;
}

TorqueLimits::Judgement TorqueLimits::judge(const timing::TimedPath& path) const {
  const std::size_t n = effort_.size();
  kinematics::Dynamics loaded = loaded_;  // a copy, because it contains scratch memory
  std::vector<double> q(n), v(n), a(n), tau(n), still(n);
  Judgement out;
  double furthest = 0, heaviest = 0;
  const auto places = std::max(kLeast, static_cast<std::size_t>(path.duration() / kEvery));
  std::size_t hint = 0;
  for (std::size_t k = 0; k <= places; ++k) {
    const double t = path.duration() * static_cast<double>(k) / static_cast<double>(places);
    path.sample(t, q, v, a, {}, hint);
    loaded.inverse(q, v, a, tau);
    loaded.gravity(q, still);
    for (std::size_t j = 0; j < n; ++j) {
      const double limit = effort_[j];
      if (!has_limit(limit)) continue;
      const double over = std::abs(tau[j]) / limit, held = std::abs(still[j]) / limit;
      if (held > 1 + kWithin) {
        if (held > heaviest) heaviest = held, out.too_heavy = Load{j, still[j], limit, t};
        continue;
      }
      if (over <= 1 + kWithin) continue;
      if (over > furthest) furthest = over, out.most = Load{j, tau[j], limit, t};
      const double moving = tau[j] - still[j];
      const double left = std::max((moving > 0 ? limit : -limit) / moving - still[j] / moving, 0.0);
      out.acceleration = std::min(out.acceleration, std::max(left, kLeastShare));
      out.slower = std::max(out.slower, 1 / std::sqrt(std::max(left, 1e-4)));
    }
  }
  return out;
}

std::vector<Overload> overloads_at(const description::RobotModel& model, const Pose& T_world_base,
                                   const Payload& payload, const std::vector<double>& q) {
  std::vector<Overload> out;
  description::RobotModel heavy = model;
  for (description::Link& link : heavy.links)
    if (link.inertial && !description::plausible(*link.inertial)) link.inertial.reset();
  const auto mimicked = [&](int index) {
    return std::any_of(model.joints.begin(), model.joints.end(), [&](const description::Joint& joint) {
      return joint.mimic && joint.mimic->joint == index;
    });
  };
  Problems ignored;
  collect(ignored, [&] {
    kinematics::Dynamics dynamics = dynamics_of(carrying(heavy, payload), T_world_base);
    if (dynamics.tree().positions() != q.size() || dynamics.tree().velocities() != q.size()) return;
    std::vector<double> tau(q.size());
    dynamics.gravity(q, tau);
    for (std::size_t j = 0; j < q.size(); ++j) {
      const int index = model.actuated[j];
      const double limit = model.joints[static_cast<std::size_t>(index)].limits.effort.value_or(0);
      if (has_limit(limit) && std::abs(tau[j]) > limit && !mimicked(index))
        out.push_back({j, std::abs(tau[j]), limit});
    }
  });
  return out;
}

std::shared_ptr<const TorqueLimits> torque_limits_of(const description::RobotModel& model,
                                                     const Pose& T_world_base, const Payload& payload,
                                                     std::vector<double> effort) {
  if (std::none_of(effort.begin(), effort.end(), has_limit)) return nullptr;
  if (estimated_effort(model) && payload.mass <= model.provenance.payload_kg.value_or(0)) return nullptr;
  try {
    auto made = std::make_shared<const TorqueLimits>(model, T_world_base, payload, std::move(effort));
    return made;
  } catch (const Error&) {
    return nullptr;  // the caller that uses the tree reports the fault
  }
}

}  // namespace polyarm::moves
