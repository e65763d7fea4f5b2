#include "polyarm/data/frame_chain.hpp"

#include <algorithm>

#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::data {

void refuse_frames(const std::vector<std::string>& way, const std::string& name) {
  const auto before = std::find(way.begin(), way.end(), name);
  std::vector<std::string> circle(before == way.end() ? way.begin() : before, way.end());
  circle.push_back(name);
  throw Error("frame-cycle",
              before == way.end()  ? "the frame '" + way.front() + "' is nested too deep"
              : circle.size() == 2 ? "the frame '" + name + "' is stated in itself"
                                   : "frames depend on each other in a circle: " + join(circle, " in "),
              "one frame of the chain must be in the world, or on a robot");
}

std::vector<std::string> named_frames(const std::vector<std::string>& robots) {
  std::vector<std::string> out = {"world", "base"};
  for (const std::string& robot : robots)
    for (const auto& [part, kind] : kRobotFrameParts) out.push_back(robot + "/" + part);
  return out;
}

}  // namespace polyarm::data
