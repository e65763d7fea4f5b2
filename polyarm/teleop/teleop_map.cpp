#include "polyarm/teleop/teleop_map.hpp"

#include <algorithm>
#include <cmath>
#include <string>

#include "polyarm/base/text.hpp"

namespace polyarm::teleop {

namespace {
std::string short_name(const std::string& joint) {
  return joint.substr(joint.rfind('/') + 1);
}

/// The joint with this name, with or without the robot's name before it; the number of joints if none has it.
std::size_t joint_named(const kinematics::Chain& chain, const std::string& name) {
  std::size_t i = 0;
  while (i < chain.joints() && chain.names()[i] != name && short_name(chain.names()[i]) != name) ++i;
  return i;
}

std::size_t require_joint(const kinematics::Chain& chain, const std::string& robot, const std::string& name,
                          const Location& where) {
  const std::size_t found = joint_named(chain, name);
  if (found < chain.joints()) return found;
  std::vector<std::string> names;
  for (const std::string& each : chain.names()) names.push_back(short_name(each));
  throw Error(Problem{"unknown-joint", where,
                      "'" + robot + "' has no joint '" + name + "'" + did_you_mean(name, names),
                      "it has: " + join(names, ", ")});
}
}  // namespace

TeleopMap::TeleopMap(const PairSettings& settings, const kinematics::Chain& leader,
                     const kinematics::Chain& follower)
    : settings_(settings), leader_(leader), follower_(follower) {
  axes_ = normalized(follower.base().rotation * settings.turn * inverse(leader.base().rotation));
  if (settings.mapping == Mapping::tcp) return;
  if (!settings.joints.empty()) {
    match_as_set();
  } else {
    match_by_name();
    if (!moves_all()) match_in_order();
  }
}

void TeleopMap::match_as_set() {
  for (const JointPair& pair : settings_.joints) {
    const std::size_t from = require_joint(leader_, settings_.leader, pair.leader, settings_.where);
    const std::size_t to = require_joint(follower_, settings_.follower, pair.follower, settings_.where);
    if (leader_.slides(from) != follower_.slides(to) && pair.scale == 1)
      throw Error(Problem{"unlike-arms", settings_.where,
                          "'" + pair.leader + "' and '" + pair.follower + "': one turns and the other slides",
                          "write a scale, m for each rad or rad for each m"});
    links_.push_back({from, to, pair.scale, pair.offset});
  }
}

void TeleopMap::match_by_name() {
  for (std::size_t to = 0; to < follower_.joints(); ++to) {
    const std::size_t from = joint_named(leader_, short_name(follower_.names()[to]));
    if (from < leader_.joints() && leader_.slides(from) == follower_.slides(to))
      links_.push_back({from, to, 1, 0});
  }
}

/// True if each joint that moves the follower's TCP has one of the leader.
bool TeleopMap::moves_all() const {
  for (std::size_t to = 0; to < follower_.joints(); ++to)
    if (follower_.moves_tcp(to) &&
        std::none_of(links_.begin(), links_.end(), [&](const Link& link) { return link.to == to; }))
      return false;
  return true;
}

/// The joints that move the TCP, in order; others, such as a gripper, stay matched by name. Only arms with
/// equally many, of the same kinds, are alike.
void TeleopMap::match_in_order() {
  const auto on_path = [](const kinematics::Chain& chain) {
    std::vector<std::size_t> out;
    for (std::size_t i = 0; i < chain.joints(); ++i)
      if (chain.moves_tcp(i)) out.push_back(i);
    return out;
  };
  const std::vector<std::size_t> from = on_path(leader_), to = on_path(follower_);
  std::erase_if(links_, [&](const Link& link) { return follower_.moves_tcp(link.to); });
  bool alike = from.size() == to.size();
  for (std::size_t i = 0; alike && i < from.size(); ++i)
    alike = leader_.slides(from[i]) == follower_.slides(to[i]);
  if (!alike)
    throw Error(Problem{"unlike-arms", settings_.where,
                        "'" + settings_.leader + "' has " + std::to_string(from.size()) + " joints and '" +
                            settings_.follower + "' " + std::to_string(to.size()) +
                            ", or of other kinds, and their names differ",
                        "name the pairs under 'joints', or use 'mapping: tcp'"});
  for (std::size_t i = 0; i < from.size(); ++i) links_.push_back({from[i], to[i], 1, 0});
}

void TeleopMap::engage(std::span<const double> leader, std::span<const double> follower) noexcept {
  std::copy(leader.begin(), leader.end(), leader_at_.begin());
  std::copy(follower.begin(), follower.end(), follower_at_.begin());
  leader_tcp_ = leader_.forward(leader);
  follower_tcp_ = follower_.forward(follower);
}

double TeleopMap::wanted(const Link& link, std::span<const double> leader) const noexcept {
  const double q = settings_.relative
                       ? follower_at_[link.to] + link.scale * (leader[link.from] - leader_at_[link.from])
                       : link.scale * leader[link.from] + link.offset;
  const double lower = follower_.lower()[link.to], upper = follower_.upper()[link.to];
  return lower <= upper ? std::clamp(q, lower, upper) : q;
}

jog::JogSetpoint TeleopMap::target(std::span<const double> leader) const noexcept {
  jog::JogSetpoint out;
  if (settings_.mapping == Mapping::joints) {
    out.kind = jog::JogSetpoint::Kind::joint_target;
    out.joints = follower_at_;
    for (const Link& link : links_) out.joints[link.to] = wanted(link, leader);
    return out;
  }
  out.kind = jog::JogSetpoint::Kind::tcp_target;
  const Pose now = leader_.forward(leader);
  out.target.position =
      follower_tcp_.position + settings_.scale * (axes_ * (now.position - leader_tcp_.position));
  out.target.rotation = follower_tcp_.rotation;
  if (settings_.orientation)
    out.target.rotation = normalized(axes_ * (now.rotation * inverse(leader_tcp_.rotation)) * inverse(axes_) *
                                     follower_tcp_.rotation);
  return out;
}

TeleopMap::Distance TeleopMap::furthest(std::span<const double> leader,
                                        std::span<const double> follower) const noexcept {
  Distance out;
  for (const Link& link : links_) {
    const double much = std::abs(wanted(link, leader) - follower[link.to]);
    if (much > out.much) out = {link.to, much};
  }
  return out;
}

}  // namespace polyarm::teleop
