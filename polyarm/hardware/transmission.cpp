#include "polyarm/hardware/transmission.hpp"

#include <algorithm>
#include <cassert>
#include <cmath>

#include "polyarm/base/text.hpp"

namespace polyarm::hardware {

namespace {

using description::TransmissionEnd;
using description::TransmissionInfo;
using Pair = std::array<double, 2>;

[[noreturn]] void refuse(const TransmissionInfo& info, const char* code, std::string what,
                         std::string advice) {
  throw Error(Problem{code, info.where, "the transmission '" + info.name + "' " + what, std::move(advice)});
}

enum class Kind { simple, differential, four_bar };

/// The class of "package/Class", for known packages.
Kind kind_of(const TransmissionInfo& info) {
  static const std::vector<std::string> kNames{"transmission_interface/SimpleTransmission",
                                               "transmission_interface/DifferentialTransmission",
                                               "transmission_interface/FourBarLinkageTransmission"};
  std::string wanted = info.plugin;
  if (wanted.starts_with("pr2_mechanism_model/"))
    wanted.erase(0, std::string_view("pr2_mechanism_model/").size());
  if (wanted.find('/') == std::string::npos) wanted = "transmission_interface/" + wanted;
  for (std::size_t k = 0; k < kNames.size(); ++k)
    if (wanted == kNames[k]) return static_cast<Kind>(k);
  refuse(info, "unknown-transmission",
         "is of the unknown type '" + info.plugin + "'" + did_you_mean(info.plugin, kNames),
         "write one of " + join(kNames, ", "));
}

void check_ratio(const TransmissionInfo& info, const TransmissionEnd& end) {
  if (end.reduction == 0 || !std::isfinite(end.reduction) || !std::isfinite(end.offset))
    refuse(info, "bad-reduction",
           "has a reduction of " + format_number(end.reduction) + " at '" + end.name +
               "', which nothing can be divided by",
           "write the turns of the actuator for one turn of the joint");
}

void check_count(const TransmissionInfo& info, std::size_t wanted) {
  if (info.joints.size() == wanted && info.actuators.size() == wanted) return;
  refuse(info, "bad-transmission",
         "has " + std::to_string(info.joints.size()) + " joints and " +
             std::to_string(info.actuators.size()) + " actuators, its type has " + std::to_string(wanted) +
             " of each",
         wanted == 1 ? "write one <joint> and one <actuator>" : "write two of each");
}

/// The two ends ordered by their roles; without roles, in file order.
std::array<const TransmissionEnd*, 2> by_role(const TransmissionInfo& info,
                                              const std::vector<TransmissionEnd>& ends,
                                              const std::string& kind) {
  const std::vector<std::string> roles{kind + "1", kind + "2"};
  if (ends[0].role.empty() && ends[1].role.empty()) return {&ends[0], &ends[1]};
  std::array<const TransmissionEnd*, 2> out{};
  for (const TransmissionEnd& end : ends) {
    const auto found = std::find(roles.begin(), roles.end(), end.role);
    if (found == roles.end())
      refuse(info, "bad-transmission",
             "gives '" + end.name + "' the unknown role '" + end.role + "'" + did_you_mean(end.role, roles),
             "write " + join(roles, " and "));
    const TransmissionEnd*& place = out[static_cast<std::size_t>(found - roles.begin())];
    if (place)
      refuse(info, "bad-transmission", "gives the role '" + end.role + "' twice",
             "write " + join(roles, " and "));
    place = &end;
  }
  return out;
}

/// Ignores the value if the factor is zero, even a NaN.
double times(double factor, double value) noexcept {
  return factor == 0 ? 0 : factor * value;
}

}  // namespace

std::optional<Quantity> quantity_of(std::string_view interface) {
  if (interface == "position" || interface == "absolute_position") return Quantity::position;
  if (interface == "velocity") return Quantity::velocity;
  if (interface == "effort" || interface == "torque" || interface == "force") return Quantity::effort;
  return std::nullopt;
}

Transmission::Transmission(const TransmissionInfo& info) : name_(info.name) {
  const Kind kind = kind_of(info);
  check_count(info, kind == Kind::simple ? 1 : 2);
  for (const auto* ends : {&info.joints, &info.actuators})
    for (const TransmissionEnd& end : *ends) check_ratio(info, end);
  if (kind == Kind::simple)
    simple(info);
  else
    pair(info, kind == Kind::differential);
  check(info);
}

void Transmission::simple(const TransmissionInfo& info) {
  const TransmissionEnd &joint = info.joints[0], &actuator = info.actuators[0];
  const double n = joint.reduction * actuator.reduction;
  motion_[0][0] = 1 / n;
  inverse_[0][0] = n;
  offset_[0] = joint.offset;
  joints_ = {joint.name};
  actuators_ = {actuator.name};
}

void Transmission::pair(const TransmissionInfo& info, bool differential) {
  size_ = 2;
  const auto joints = by_role(info, info.joints, "joint");
  const auto actuators = by_role(info, info.actuators, "actuator");
  const Pair nj{joints[0]->reduction, joints[1]->reduction};
  const Pair na{actuators[0]->reduction, actuators[1]->reduction};
  if (differential) {
    motion_ = {Pair{1 / (2 * nj[0] * na[0]), 1 / (2 * nj[0] * na[1])},
               Pair{1 / (2 * nj[1] * na[0]), -1 / (2 * nj[1] * na[1])}};
    inverse_ = {Pair{na[0] * nj[0], na[0] * nj[1]}, Pair{na[1] * nj[0], -na[1] * nj[1]}};
  } else {
    motion_ = {Pair{1 / (nj[0] * na[0]), 0}, Pair{-1 / (nj[0] * na[0] * nj[1]), 1 / (na[1] * nj[1])}};
    inverse_ = {Pair{nj[0] * na[0], 0}, Pair{na[1], na[1] * nj[1]}};
  }
  for (std::size_t k = 0; k < 2; ++k) {
    offset_[k] = joints[k]->offset;
    joints_.push_back(joints[k]->name);
    actuators_.push_back(actuators[k]->name);
  }
}

/// Products of finite reductions may overflow or underflow.
void Transmission::check(const TransmissionInfo& info) const {
  for (std::size_t i = 0; i < size_; ++i)
    for (const Matrix* m : {&motion_, &inverse_})
      if (!std::isnormal((*m)[i][i]) || !std::isfinite((*m)[i][1 - i]))
        refuse(info, "bad-reduction", "has reductions whose product is too large or too small",
               "write the turns of the actuator for one turn of the joint");
}

void Transmission::to_joints(Quantity quantity, std::span<const double> actuators,
                             std::span<double> joints) const noexcept {
  assert(actuators.size() >= size_ && joints.size() >= size_);
  const Pair in{actuators[0], size_ > 1 ? actuators[1] : 0};
  for (std::size_t i = 0; i < size_; ++i) {
    if (quantity == Quantity::effort)
      joints[i] = times(inverse_[0][i], in[0]) + times(inverse_[1][i], in[1]);
    else
      joints[i] = times(motion_[i][0], in[0]) + times(motion_[i][1], in[1]) +
                  (quantity == Quantity::position ? offset_[i] : 0);
  }
}

void Transmission::to_actuators(Quantity quantity, std::span<const double> joints,
                                std::span<double> actuators) const noexcept {
  assert(actuators.size() >= size_ && joints.size() >= size_);
  Pair in{joints[0], size_ > 1 ? joints[1] : 0};
  if (quantity == Quantity::position)
    for (std::size_t i = 0; i < size_; ++i) in[i] -= offset_[i];
  for (std::size_t i = 0; i < size_; ++i) {
    if (quantity == Quantity::effort)
      actuators[i] = times(motion_[0][i], in[0]) + times(motion_[1][i], in[1]);
    else
      actuators[i] = times(inverse_[i][0], in[0]) + times(inverse_[i][1], in[1]);
  }
}

}  // namespace polyarm::hardware
