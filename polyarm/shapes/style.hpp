#pragma once
/// The look of a maker's arms: proportions, colours and finish of a family, described from public knowledge.
/// No side effects; any thread.
#include <optional>
#include <string>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/description/robot_model.hpp"
#include "polyarm/shapes/solid.hpp"

namespace polyarm::shapes {

/// The way in which links are built.
enum class Build {
  cobot,  ///< round joint housings, tubes between them
  cast,   ///< turret, castings with motor covers, slim forearm
  soft,   ///< housings and links flow into each other
  servo,  ///< boxed servos, plates between them
  scara   ///< column, flat arms, quill
};

struct Style {
  std::string name;
  Build build = Build::cobot;
  Paint base, body, fore, wrist;  ///< of the plinth, the links up to the elbow, the forearm, and beyond it
  Paint joint;                    ///< of the housings' rings between two links
  Paint cap;                      ///< of the covers at the ends of the housings
  std::optional<Paint> housing;   ///< of the housings; empty: that of the link
  Paint flange{{0.72f, 0.73f, 0.75f}, 0.3f, 0.9f};
  double edge = 0.25;     ///< rounding of housings, relative to their radius
  double tube = 0.85;     ///< thickness of a link in its middle, relative to its housings
  double corner = 1;      ///< rounding of a link's section: 1 is round, 0 square
  double cap_size = 0.9;  ///< radius of the covers, relative to the housing
  double dome = 0.12;     ///< height of the covers, relative to the housing's radius
};

/// The style of a robot: that of its maker's family, changed by RobotModel::look. Unknown styles and colours
/// in `look` are reported and otherwise ignored.
Style style_of(const description::RobotModel& model, Problems& problems);

/// "#rrggbb" with the finish of castings; empty if the text is not a colour.
std::optional<Paint> read_color(const std::string& text);

/// The names of all styles, for `look: {style: …}`.
std::vector<std::string> style_names();

}  // namespace polyarm::shapes
