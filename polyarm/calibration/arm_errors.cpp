#include "polyarm/calibration/arm_errors.hpp"

#include <fmt/format.h>

#include "polyarm/base/error.hpp"
#include "polyarm/calibration/fit.hpp"
#include "polyarm/calibration/hand_eye.hpp"
#include "polyarm/kinematics/chain.hpp"

namespace polyarm::calibration {

namespace {
using description::Joint;
using description::RobotModel;

/// The joints from the root to the tip.
std::vector<int> way_to(const RobotModel& model, int tip) {
  std::vector<int> out;
  for (int link = tip; link >= 0 && model.links[static_cast<std::size_t>(link)].parent_joint >= 0;) {
    const int joint = model.links[static_cast<std::size_t>(link)].parent_joint;
    out.insert(out.begin(), joint);
    link = model.joints[static_cast<std::size_t>(joint)].parent_link;
  }
  return out;
}

/// An arm as a product of exponentials.
struct Screws {
  struct Axis {
    std::size_t joint = 0;
    bool slides = false;
    Vec3 direction, point;
  };
  std::vector<Axis> axes;
  Pose tip_at_zero;
};

Screws screws_of(const RobotModel& model, int tip) {
  const kinematics::Chain chain(model, tip);
  Screws out;
  for (const kinematics::Chain::Axis& each : chain.axes()) {
    if (each.ratio != 1)
      throw Error("bad-model",
                  "the arm has a joint that follows another one; its geometry cannot be calibrated");
    out.axes.push_back({each.joint, each.slides, each.direction, each.point});
  }
  out.tip_at_zero = chain.forward(std::vector<double>(chain.joints()));
  return out;
}

/// The motion of everything behind an axis.
Pose motion(const Screws::Axis& axis, double value) {
  if (axis.slides) return {value * axis.direction, {}};
  const Quaternion by = from_axis_angle(axis.direction, value);
  return {axis.point - by * axis.point, by};
}

Pose forward(const Screws& arm, const std::vector<double>& q, const std::vector<double>& offsets) {
  Pose out;
  for (std::size_t i = 0; i < arm.axes.size(); ++i)
    out = out * motion(arm.axes[i], q[arm.axes[i].joint] + offsets[i]);
  return out * arm.tip_at_zero;
}

/// Two directions that are square to the axis.
std::pair<Vec3, Vec3> beside(const Vec3& axis) {
  const Vec3 start = std::abs(axis.z) < 0.9 ? Vec3{0, 0, 1} : Vec3{1, 0, 0};
  const Vec3 one = normalized(cross(axis, start));
  return {one, cross(axis, one)};
}

/// The unknowns: base, target, and the numbers of the arm.
struct ArmState {
  Pose base, target;
  Vector numbers;
};

/// The problem of one call.
class ArmFit {
 public:
  ArmFit(Screws arm, std::vector<std::string> names, std::span<const ArmSample> samples,
         const ArmOptions& options)
      : arm_(std::move(arm)), names_(std::move(names)), samples_(samples), options_(options) {
    // With free axes, the place of the tip behind the last axis is free, too.
    if (options_.axes) options_.target_known = false;
    poses_ = (options.base_known ? 0 : 6) + (options_.target_known ? 0 : options.positions_only ? 3 : 6);
  }
  Eigen::Index poses() const { return poses_; }
  Eigen::Index numbers_of_axis() const { return options_.axes ? 4 : 1; }
  Eigen::Index numbers() const { return numbers_of_axis() * static_cast<Eigen::Index>(arm_.axes.size()); }
  Eigen::Index rows_of_one() const { return options_.positions_only ? 3 : 6; }
  const Screws& nominal() const { return arm_; }

  std::string name(Eigen::Index k) const {
    static const char* const kWhich[] = {"tilt 1", "tilt 2", "shift 1", "shift 2"};
    const Eigen::Index each = numbers_of_axis();
    return names_[static_cast<std::size_t>(k / each)] + " " + (options_.axes ? kWhich[k % each] : "offset");
  }

  Screws corrected(const ArmState& at) const {
    Screws out = arm_;
    if (!options_.axes) return out;
    for (std::size_t i = 0; i < out.axes.size(); ++i) {
      const auto [one, two] = beside(arm_.axes[i].direction);
      const auto n = at.numbers.segment<4>(4 * static_cast<Eigen::Index>(i));
      out.axes[i].direction = turn(n[0] * eigen(one) + n[1] * eigen(two)) * out.axes[i].direction;
      out.axes[i].point = out.axes[i].point + n[2] * one + n[3] * two;
    }
    return out;
  }
  std::vector<double> offsets(const ArmState& at) const {
    std::vector<double> out(arm_.axes.size());
    if (options_.axes) return out;  // tilts and shifts of the axes that follow contain them
    for (std::size_t i = 0; i < out.size(); ++i) out[i] = at.numbers[static_cast<Eigen::Index>(i)];
    return out;
  }

  ArmState moved_by(const ArmState& at, const Vector& step) const {
    ArmState out = at;
    Eigen::Index k = 0;
    if (!options_.base_known) {
      out.base = moved(at.base, step.segment<6>(k));
      k += 6;
    }
    if (!options_.target_known && options_.positions_only) {
      out.target.position = at.target.position + vec3(step.segment<3>(k));
      k += 3;
    } else if (!options_.target_known) {
      out.target = moved(at.target, step.segment<6>(k));
      k += 6;
    }
    if (step.size() > k) out.numbers += step.tail(step.size() - k);
    return out;
  }

  Vector residual(const ArmState& at, double position_noise, double rotation_noise) const {
    const Screws arm = corrected(at);
    const std::vector<double> offset = offsets(at);
    Vector out(rows_of_one() * static_cast<Eigen::Index>(samples_.size()));
    Eigen::Index row = 0;
    for (const ArmSample& sample : samples_) {
      const Pose predicted = at.base * forward(arm, sample.q, offset) * at.target;
      out.segment<3>(row) = eigen(predicted.position - sample.measured.position) / position_noise;
      if (!options_.positions_only)
        out.segment<3>(row + 3) =
            rotation_vector(predicted.rotation * inverse(sample.measured.rotation)) / rotation_noise;
      row += rows_of_one();
    }
    return out;
  }

  Residuals residuals(const ArmState& at) const {
    const Vector all = residual(at, 1, 1);
    std::vector<Residual> each;
    for (Eigen::Index row = 0; row < all.size(); row += rows_of_one())
      each.push_back(
          {all.segment<3>(row).norm(), options_.positions_only ? 0 : all.segment<3>(row + 3).norm()});
    return summarised(std::move(each));
  }

  /// Base and target from closed forms: the arm as described.
  ArmState start() const {
    ArmState out{{}, {}, Vector::Zero(numbers())};
    const std::vector<double> zero(arm_.axes.size());
    if (samples_.empty() || (options_.base_known && options_.positions_only)) return out;
    const Pose flange = forward(arm_, samples_.front().q, zero);
    if (options_.base_known) {
      if (!options_.target_known) out.target = inverse(flange) * samples_.front().measured;
      return out;
    }
    out.base = samples_.front().measured * inverse(flange);
    if (!options_.positions_only && !options_.target_known) {
      // The device sees the target as a camera beside the robot sees a marker on its hand.
      std::vector<Sighting> seen;
      for (const ArmSample& each : samples_) seen.push_back({forward(arm_, each.q, zero), each.measured});
      const HandEye found = hand_eye(seen, CameraPlace::beside);
      out.base = inverse(found.camera.pose);
      out.target = found.marker.pose;
    }
    if (!options_.positions_only) return out;
    // Rotation of the base from the spread of the positions.
    Eigen::Vector3d from = Eigen::Vector3d::Zero(), to = from;
    for (const ArmSample& each : samples_) {
      from += eigen(forward(arm_, each.q, zero).position) / static_cast<double>(samples_.size());
      to += eigen(each.measured.position) / static_cast<double>(samples_.size());
    }
    Eigen::Matrix3d H = Eigen::Matrix3d::Zero();
    for (const ArmSample& each : samples_)
      H += (eigen(each.measured.position) - to) *
           (eigen(forward(arm_, each.q, zero).position) - from).transpose();
    const Eigen::Matrix3d R = best_rotation(H);
    out.base = {vec3(to - R * from), quaternion(R)};
    return out;
  }

 private:
  Screws arm_;
  std::vector<std::string> names_;
  std::span<const ArmSample> samples_;
  ArmOptions options_;
  Eigen::Index poses_ = 0;
};

/// The numbers of a least-squares problem that its samples determine.
struct Rank {
  Matrix inverse;                  ///< pseudo-inverse of the normal matrix
  std::vector<bool> identifiable;  ///< of each unknown
  int directions = 0;              ///< of the unknowns that the samples determine
};
Rank rank_of(const Matrix& jacobian) {
  constexpr double kSmallest = 1e-5, kShare = 0.1;
  Vector scale = jacobian.colwise().norm();
  for (double& each : scale) each = each > 1e-12 ? each : 1;
  const Matrix scaled = jacobian * scale.cwiseInverse().asDiagonal();
  const Eigen::SelfAdjointEigenSolver<Matrix> found(scaled.transpose() * scaled);
  Rank out{Matrix::Zero(scale.size(), scale.size()), {}, 0};
  Vector free = Vector::Zero(scale.size());
  for (Eigen::Index k = 0; k < scale.size(); ++k) {
    const Vector direction = found.eigenvectors().col(k);
    const double size = found.eigenvalues()[k];
    if (std::sqrt(std::max(0.0, size)) < kSmallest) {
      free += direction.cwiseAbs2();
    } else {
      out.inverse += direction * direction.transpose() / size;
      ++out.directions;
    }
  }
  out.inverse = scale.cwiseInverse().asDiagonal() * out.inverse * scale.cwiseInverse().asDiagonal();
  for (const double share : free) out.identifiable.push_back(std::sqrt(share) < kShare);
  return out;
}

void require_samples(const RobotModel& model, std::span<const ArmSample> samples, const ArmFit& fit,
                     Eigen::Index unknowns) {
  const Eigen::Index least = (unknowns + fit.rows_of_one() - 1) / fit.rows_of_one() + 1;
  if (static_cast<Eigen::Index>(samples.size()) < least)
    refuse(fmt::format("{} numbers need {} poses, here are {}", unknowns, least, samples.size()),
           "measure 30 or more poses all over the workspace");
  for (std::size_t i = 0; i < samples.size(); ++i)
    if (samples[i].q.size() != model.actuated.size())
      refuse(fmt::format("sample {} has {} joint values, the robot has {} joints", i + 1, samples[i].q.size(),
                         model.actuated.size()),
             "give one value for each joint");
}

/// The best fit; numbers that the samples do not determine stay as small as possible, because each number
/// also counts as a measurement of zero with a standard deviation of 10 rad or 10 m. The fit that is returned
/// is without these.
Fit solve(const ArmFit& problem, ArmState& state, bool with_numbers, double position, double rotation) {
  constexpr double kUnknown = 10;  // rad or m
  const Eigen::Index numbers = with_numbers ? problem.numbers() : 0;
  const auto residual = [&](const ArmState& at) {
    Vector out = problem.residual(at, position, rotation);
    out.conservativeResize(out.size() + numbers);
    out.tail(numbers) = at.numbers.head(numbers) / kUnknown;
    return out;
  };
  Fit out = fit(state, problem.poses() + numbers, residual,
                [&](const ArmState& at, const Vector& step) { return problem.moved_by(at, step); });
  const Eigen::Index rows = out.residual.size() - numbers;
  return {out.jacobian.topRows(rows), out.residual.head(rows)};
}

std::map<std::string, Pose> corrected_origins(const RobotModel& model, int tip, const Screws& arm,
                                              const std::vector<double>& offsets, const Pose& behind) {
  // With an offset d, exp(S (q + d)) = exp(S d) exp(S q): the part behind the axis turns by d at zero, and so
  // do the axes that follow.
  std::vector<AxisLine> axes;
  Pose carried;
  for (std::size_t i = 0; i < arm.axes.size(); ++i) {
    axes.push_back({carried.rotation * arm.axes[i].direction, carried * arm.axes[i].point});
    carried = carried * motion(arm.axes[i], offsets[i]);
  }
  return origins_for(model, tip, axes, carried * arm.tip_at_zero * behind);
}

Vec3 across(const Vec3& v, const Vec3& axis) {
  return v - dot(v, axis) * axis;
}

/// The joints between root and tip at zero joint values.
struct Way {
  std::vector<const Joint*> axes;
  std::vector<Pose> frames;  ///< of the axes, as described
  std::vector<Pose>
      between;  ///< from the frame of the axis before (or the root) to the parent link of this one
  std::vector<const Joint*> behind;  ///< fixed joints between the last axis and the tip
  Pose tip;
};
Way way_of(const RobotModel& model, int tip) {
  Way out;
  Pose between;
  for (const int index : way_to(model, tip)) {
    const Joint& joint = model.joints[static_cast<std::size_t>(index)];
    out.tip = out.tip * joint.origin;
    if (!joint.moves()) {
      between = between * joint.origin;
      out.behind.push_back(&joint);
      continue;
    }
    if (joint.mimic)
      throw Error("bad-model", "the joint '" + joint.name + "' of '" + model.name + "' follows another one",
                  "only a plain series of joints can be calibrated");
    out.axes.push_back(&joint);
    out.frames.push_back(out.tip);
    out.between.push_back(between);
    out.behind.clear();
    between = {};
  }
  return out;
}

/// Frames whose axes are `axes`: each on the point of its axis that is nearest to the frame as described, and
/// turned about its axis so that its link points at the next axis.
std::vector<Pose> frames_on(const Way& way, std::span<const AxisLine> axes, const Pose& tip_at_zero) {
  constexpr double kLever = 1e-3;  // m
  const std::size_t n = way.axes.size();
  std::vector<Vec3> points(n + 1, tip_at_zero.position), described(n + 1, way.tip.position);
  for (std::size_t i = 0; i < n; ++i) {
    described[i] = way.frames[i].position;
    const Vec3 off = described[i] - axes[i].point;
    points[i] = axes[i].point + dot(off, axes[i].direction) * axes[i].direction;
  }
  if (n > 0) {  // the last frame keeps its distance from the tip along its axis
    const Vec3 axis = normalized(way.frames.back().rotation * way.axes.back()->axis);
    const double ahead = dot(way.tip.position - way.frames.back().position, axis);
    const AxisLine& last = axes.back();
    points[n - 1] =
        last.point + (dot(tip_at_zero.position - last.point, last.direction) - ahead) * last.direction;
  }
  std::vector<Pose> out;
  const Quaternion of_tip = tip_at_zero.rotation * inverse(way.tip.rotation);
  for (std::size_t i = 0; i < n; ++i) {
    const Vec3 axis = normalized(way.frames[i].rotation * way.axes[i]->axis), now = axes[i].direction;
    const Quaternion tilt = rotation_between(axis, now);
    Vec3 from = across(tilt * (described[i + 1] - described[i]), now),
         to = across(points[i + 1] - points[i], now);
    if (norm(from) < kLever || norm(to) < kLever) {
      const bool last = i + 1 == n;
      const Vec3 next =
          last ? beside(axis).first : normalized(way.frames[i + 1].rotation * way.axes[i + 1]->axis);
      from = across(tilt * next, now);
      to = across(last ? of_tip * next : axes[i + 1].direction, now);
    }
    const bool turns = norm(from) > 0.01 * kLever && norm(to) > 0.01 * kLever;
    const Quaternion about = turns ? rotation_between(normalized(from), normalized(to)) : Quaternion{};
    out.push_back({points[i], normalized(about * tilt * way.frames[i].rotation)});
  }
  return out;
}

}  // namespace

std::map<std::string, Pose> origins_for(const RobotModel& model, int tip, std::span<const AxisLine> axes,
                                        const Pose& tip_at_zero) {
  const Way way = way_of(model, tip);
  if (way.axes.size() != axes.size())
    throw Error("bad-model",
                fmt::format("'{}' has {} joints up to the tool, and the calibration has {}", model.name,
                            way.axes.size(), axes.size()),
                "choose the robot that was calibrated");
  if (way.behind.empty())
    throw Error("bad-model", "the arm of '" + model.name + "' has no fixed joint behind its last axis",
                "choose the link behind it as the tip, for example tool0");
  const std::vector<Pose> frames = frames_on(way, axes, tip_at_zero);
  std::map<std::string, Pose> out;
  Pose now;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    out[way.axes[i]->name] = inverse(now * way.between[i]) * frames[i];
    now = frames[i];
  }
  // What is left goes into the first fixed joint behind the last axis.
  Pose rest;
  for (std::size_t k = 1; k < way.behind.size(); ++k) rest = rest * way.behind[k]->origin;
  out[way.behind.front()->name] = inverse(now) * tip_at_zero * inverse(rest);
  return out;
}

namespace {
ArmFit problem_of(const RobotModel& model, int tip, std::span<const ArmSample> samples,
                  const ArmOptions& options) {
  const Screws arm = screws_of(model, tip);
  std::vector<std::string> names;
  for (const Screws::Axis& each : arm.axes)
    names.push_back(model.joints[static_cast<std::size_t>(model.actuated[each.joint])].name);
  return {arm, names, samples, options};
}

/// The sample that the others contradict. `state` and `fit`: those of all samples, with these weights.
std::optional<Outlier> outlier_of(const RobotModel& model, int tip, std::span<const ArmSample> samples,
                                  const ArmOptions& options, const ArmState& state, const Fit& fit,
                                  double position, double rotation, double unknowns) {
  const std::vector<ArmSample> all(samples.begin(), samples.end());
  const Eigen::Index rows = options.positions_only ? 3 : 6;
  std::vector<double> each;
  for (Eigen::Index row = 0; row < fit.residual.size(); row += rows)
    each.push_back(fit.residual.segment(row, rows).squaredNorm());
  return find_outlier(each, static_cast<double>(rows), unknowns, [&](std::size_t k) -> std::optional<double> {
    const std::vector<ArmSample> others = without(all, k);
    const ArmFit rest = problem_of(model, tip, others, options);
    ArmState near = state;
    return solve(rest, near, true, position, rotation).cost();
  });
}
}  // namespace

Residuals arm_residuals(const RobotModel& model, int tip, std::span<const ArmSample> samples,
                        const ArmOptions& options) {
  const ArmFit problem = problem_of(model, tip, samples, options);
  require_samples(model, samples, problem, problem.poses());
  ArmState state = problem.start();
  solve(problem, state, false, 1e-3, 1e-3);
  return problem.residuals(state);
}

ArmErrors arm_errors(const RobotModel& model, int tip, std::span<const ArmSample> samples,
                     const ArmOptions& options) {
  const ArmFit problem = problem_of(model, tip, samples, options);
  require_samples(model, samples, problem, problem.poses() + problem.numbers());
  double position = 1e-3, rotation = 1e-3;
  ArmState state = problem.start();
  solve(problem, state, false, position, rotation);
  ArmErrors out;
  out.before = problem.residuals(state);
  Fit fit;
  double weight = position;
  for (int round = 0; round < 3; ++round) {
    weight = position;
    fit = solve(problem, state, true, weight, rotation);
    const Residuals now = problem.residuals(state);
    if (!options.positions_only && now.rms.position > 1e-12 && now.rms.rotation > 1e-12)
      position = rotation * std::clamp(now.rms.position / now.rms.rotation, 0.02, 20.0);
  }
  out.after = problem.residuals(state);
  const Rank rank = rank_of(fit.jacobian);
  out.after.outlier = outlier_of(model, tip, samples, options, state, fit, weight, rotation,
                                 static_cast<double>(rank.directions));
  const Matrix covariance = variance_of(fit) * rank.inverse;
  for (Eigen::Index k = 0; k < problem.numbers(); ++k) {
    const Eigen::Index at = problem.poses() + k;
    const bool known = rank.identifiable[static_cast<std::size_t>(at)];
    out.numbers.push_back(
        {problem.name(k), state.numbers[k], std::sqrt(std::max(0.0, covariance(at, at))), known});
  }
  if (!options.base_known) out.base = estimate(state.base, covariance.topLeftCorner<6, 6>());
  const Eigen::Index target = options.base_known ? 0 : 6, size = problem.poses() - target;
  Matrix of_target = Matrix::Zero(6, 6);
  of_target.topLeftCorner(size, size) = covariance.block(target, target, size, size);
  out.target = estimate(state.target, of_target);
  const bool in_arm = options.axes && options.target_known;
  out.origins = corrected_origins(model, tip, problem.corrected(state), problem.offsets(state),
                                  in_arm ? state.target : Pose{});
  return out;
}

Residual difference_of(const RobotModel& one, const RobotModel& other, int tip) {
  constexpr int kStates = 200;
  const kinematics::Chain a(one, tip), b(other, tip);
  Residual out;
  std::vector<double> q(a.joints());
  for (int k = 0; k < kStates; ++k) {
    for (std::size_t j = 0; j < q.size(); ++j) {
      const double lower = std::max(a.lower()[j], -M_PI), upper = std::min(a.upper()[j], M_PI);
      const double share = std::fmod(0.5 + (k + 1) * std::sqrt(2.0 + 3.0 * static_cast<double>(j)), 1.0);
      q[j] = lower + share * (upper - lower);
    }
    const Pose there = a.forward(q), here = b.forward(q);
    out.position = std::max(out.position, norm(there.position - here.position));
    out.rotation = std::max(out.rotation, angle_between(there.rotation, here.rotation));
  }
  return out;
}

}  // namespace polyarm::calibration
