#include "polyarm/collision/checker.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "polyarm/base/error.hpp"
#include "polyarm/collision/check_data.hpp"
#include "polyarm/collision/check_model.hpp"

namespace polyarm::collision {

using kinematics::InstructionSet;

namespace {

const CheckKernels& kernels_for(InstructionSet wanted) {
#if defined(__x86_64__)
  switch (kinematics::supported(wanted)) {
    case InstructionSet::avx512:
      return avx512::kCheckKernels;
    case InstructionSet::avx2:
      return avx2::kCheckKernels;
    case InstructionSet::portable:
      break;
  }
#else
  (void)wanted;
#endif
  return portable::kCheckKernels;
}

std::vector<Obstacle> in_base(const World& world, const Pose& T_world_base) {
  const Pose back = inverse(T_world_base);
  std::vector<Obstacle> out = world.obstacles();
  for (Obstacle& o : out) {
    if (o.is_half_space) {
      o.half_space.offset -= dot(o.half_space.normal, T_world_base.position);
      o.half_space.normal = back.rotation * o.half_space.normal;
      continue;
    }
    o.body = moved(back, o.body);
    o.pose = back * o.pose;
  }
  return out;
}

std::vector<char> allowed_pairs(const RobotBody& robot, const std::vector<Obstacle>& obstacles,
                                const std::vector<std::pair<std::string, std::string>>& names) {
  if (names.empty()) return {};
  std::vector<char> out(robot.links().size() * obstacles.size(), 0);
  for (std::size_t l = 0; l < robot.links().size(); ++l)
    for (std::size_t i = 0; i < obstacles.size(); ++i)
      out[l * obstacles.size() + i] = std::any_of(names.begin(), names.end(), [&](const auto& name) {
        return name.first == robot.links()[l].name && name.second == obstacles[i].name;
      });
  return out;
}

}  // namespace

Checker::Checker(std::shared_ptr<const RobotBody> robot, const World& world, const CheckerOptions& options)
    : robot_(std::move(robot)),
      options_(options),
      data_(std::make_unique<CheckData>()),
      kernels_(&kernels_for(options.instructions)) {
  const Pose& base = options_.T_world_base;
  const Quaternion& r = base.rotation;
  const double sum = base.position.x + base.position.y + base.position.z + r.x + r.y + r.z + r.w;
  if (!std::isfinite(sum) || r.x * r.x + r.y * r.y + r.z * r.z + r.w * r.w < 1e-12)
    throw Error("bad-pose", "the pose of the robot's base contains NaN or infinity, or has no rotation");
  if (!std::isfinite(options_.clearance) || options_.clearance < 0)
    throw Error("bad-value", "the clearance is negative, NaN or infinite", "give metres");
  options_.T_world_base.rotation = normalized(r);
  obstacles_ = in_base(world, options_.T_world_base);
  make_check_data(*robot_, obstacles_, options_.clearance,
                  allowed_pairs(*robot_, obstacles_, options_.allowed), *data_);
  wraps_.assign(variables(), 1);
  for (const JointFrame& frame : robot_->frames())
    if (frame.ratio != 0 && (frame.slides || frame.ratio != std::round(frame.ratio)))
      wraps_[frame.variable] = 0;
  for (const std::size_t body : data_->body_of_link)
    for (std::size_t j = 0; j < variables(); ++j) row_levers_.push_back(robot_->lever(body, j));
  for (const LinkPairBody& pair : robot_->pairs())
    row_levers_.insert(row_levers_.end(), pair.lever.begin(), pair.lever.end());
}

Checker::~Checker() = default;

std::size_t Checker::width() const noexcept {
  return kernels_->width;
}

bool Checker::usable(std::span<const double> q) const noexcept {
  if (q.size() != variables()) return false;
  for (const double v : q)
    if (!std::isfinite(v)) return false;
  for (const JointFrame& frame : robot_->frames()) {
    if (frame.ratio == 0) continue;
    const double v = q[frame.variable];
    if (frame.slides && std::abs(frame.ratio * v + frame.offset) > frame.travel + 1e-6) return false;
    if (!frame.slides && !wraps_[frame.variable] && std::abs(frame.ratio * v) > 50) return false;
  }
  return true;
}

float Checker::value(std::size_t variable, double q) const noexcept {
  if (!wraps_[variable] || std::abs(q) <= 2 * std::numbers::pi) return static_cast<float>(q);
  return static_cast<float>(std::remainder(q, 2 * std::numbers::pi));
}

std::size_t Checker::rows() const noexcept {
  return data_->links.size() + data_->pairs.size();
}

void Checker::motion(std::span<const double> size, std::span<double> rows) const noexcept {
  const double* lever = row_levers_.data();
  for (double& row : rows) {
    row = 0;
    for (std::size_t j = 0; j < size.size(); ++j, ++lever)
      if (size[j] > 0) row += *lever * size[j];
  }
}

}  // namespace polyarm::collision
