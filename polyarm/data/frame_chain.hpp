#pragma once
/// The frames of points, followed outwards. Every part of Polyarm that needs the place of a frame begins
/// here.
#include <algorithm>
#include <array>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "polyarm/base/pose.hpp"
#include "polyarm/data/value.hpp"

namespace polyarm::data {

/// A frame, as a pose in the outermost frame of its chain.
struct FrameChain {
  Pose pose;          ///< T_root_frame
  std::string root;   ///< the first frame that is not a point; empty: the world
  std::string owner;  ///< the point that names the root; empty: the chain is the root alone
};

/// Throws Error("frame-cycle"): `name` follows the frames in `way`, which contain it or are too many.
[[noreturn]] void refuse_frames(const std::vector<std::string>& way, const std::string& name);

/// Follows the frames that are points. `find` returns the point with a name, or nullptr for other frames.
/// Throws Error("frame-cycle").
template <class Find>
FrameChain frame_chain(const std::string& frame, const Find& find) {
  constexpr std::size_t kDeepest = 64;
  FrameChain out;
  std::vector<std::string> way;
  for (std::string name = frame; !name.empty() && name != "world";) {
    const Point* point = find(name);
    if (!point) {
      out.root = name;
      break;
    }
    if (way.size() == kDeepest || std::find(way.begin(), way.end(), name) != way.end())
      refuse_frames(way, name);
    way.push_back(name);
    out.owner = name;
    out.pose = point->pose * out.pose;
    name = point->frame();
  }
  return out;
}

/// A frame on a robot, by its name: `base`, `ROBOT/base`, `ROBOT/flange`, `ROBOT/tool0`, `ROBOT/tcp`.
struct RobotFrame {
  enum class Part { base, flange, tcp };
  std::string robot;  ///< empty: the robot that moves
  Part part = Part::base;
};
/// The names of these parts.
inline constexpr std::array<std::pair<const char*, RobotFrame::Part>, 4> kRobotFrameParts{
    {{"base", RobotFrame::Part::base},
     {"flange", RobotFrame::Part::flange},
     {"tool0", RobotFrame::Part::flange},
     {"tcp", RobotFrame::Part::tcp}}};
/// Empty: no robot has a frame with this name.
inline std::optional<RobotFrame> robot_frame(const std::string& name) {
  if (name == "base") return RobotFrame{};
  const auto slash = name.find('/');
  if (slash == std::string::npos || slash == 0) return std::nullopt;
  for (const auto& [word, part] : kRobotFrameParts)
    if (name.compare(slash + 1, std::string::npos, word) == 0) return RobotFrame{name.substr(0, slash), part};
  return std::nullopt;
}
/// The frames that are no points: `world`, `base`, and those of these robots.
std::vector<std::string> named_frames(const std::vector<std::string>& robots);

/// For errors about unknown frames.
inline constexpr const char* kFramesAre =
    "a frame is a point of the data, 'world', 'base', or ROBOT/base, ROBOT/flange, ROBOT/tcp";

}  // namespace polyarm::data
