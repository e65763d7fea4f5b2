#include "apps/data_teach.hpp"

#include <fmt/format.h>

#include <memory>

#include "apps/client.hpp"
#include "apps/verb.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/calibration/touch.hpp"
#include "polyarm/data/literal.hpp"
#include "polyarm/data/point_in.hpp"
#include "polyarm/data/set_edit.hpp"

namespace polyarm::apps {

namespace {

using data::ImportFile;

/// The poses of the points, which must all be in one frame; returns its name in `frame`.
std::vector<Pose> poses_of(const ImportFile& set, const std::vector<std::string>& names, std::string& frame) {
  std::vector<Pose> out;
  for (const std::string& name : names) {
    const data::Value* value = set.values().value(name);
    if (!value || !value->as_point())
      throw Error(Problem{"unknown-name",
                          {set.file()},
                          value
                              ? "'" + name + "' is " + data::name(value->kind()) + ", not a pose"
                              : "there is no point '" + name + "'" + did_you_mean(name, set.values().names()),
                          "points that teach are poses: polyarm data set FILE NAME 'pose(…)'"});
    const data::Point& point = *value->as_point();
    if (!out.empty() && point.frame() != frame)
      throw Error(Problem{"bad-points",
                          {set.file()},
                          "'" + name + "' is in the frame '" + point.frame() + "', '" + names.front() +
                              "' in '" + frame + "'",
                          "teach all of them in one frame"});
    frame = point.frame();
    out.push_back(point.pose);
  }
  return out;
}

int teach_frame(const TeachArguments& a) {
  data::edit_set(a.file, "frame " + a.name, [&](ImportFile& set) {
    std::string frame;
    const std::vector<Pose> poses = poses_of(set, a.from, frame);
    Pose found;
    if (poses.size() == 3)
      found = calibration::frame_from_points(poses[0].position, poses[1].position, poses[2].position);
    else if (poses.size() == 1)
      found = poses[0];
    else
      throw Error("bad-points", "a frame comes from three points, or from one pose",
                  "--from ORIGIN ON_X IN_PLANE, or --from POSE --in FRAME");
    if (!a.in.empty()) frame = a.in;
    set.set(a.name, data::point_in(found, frame));
    fmt::print("{} is {}\n", a.name, set.values().value(a.name)->text());
  });
  return kOk;
}

int teach_tool(const TeachArguments& a) {
  data::edit_set(a.file, "tool " + a.name, [&](ImportFile& set) {
    std::string frame;
    const calibration::TouchedTool tool = calibration::tool_from_poses(poses_of(set, a.from, frame));
    const double largest = tool.residuals.largest.position;
    for (std::size_t k = 0; k < a.from.size(); ++k)
      fmt::print("{:<16} {:8.3f} mm\n", a.from[k], 1e3 * tool.residuals.each[k].position);
    fmt::print("{:<16} {:8.3f} mm rms, {:.3f} mm at most\n", "residual", 1e3 * tool.residuals.rms.position,
               1e3 * largest);
    if (1e3 * largest > a.most_mm && !a.yes)
      throw Error("bad-points",
                  fmt::format("the tip was up to {:.3f} mm off; nothing was changed", 1e3 * largest),
                  "teach the worst pose again, or use --most MM or --yes");
    set.set(a.name, data::point_in({tool.tcp, {}}, "tool0"));
    fmt::print("{} is {}\n", a.name, set.values().value(a.name)->text());
  });
  return kOk;
}

/// Teaches a point: the present position of a robot in a running cell, with everything that a point stores.
int teach_point(const TeachArguments& a) {
  Json request{{"request", "jog.state"}};
  if (!a.robot.empty()) request["robot"] = a.robot;
  const Json state = Client(a.cell).ask(request);
  if (flag_of(part(state, {"moving"}))) throw Error("moving", "the robot moves", "wait until it is at rest");
  const auto& at = state["position"];
  const auto& turn = state["orientation"];
  data::Point point{{{at[0], at[1], at[2]}, {turn[0], turn[1], turn[2], turn[3]}}, true};
  data::Taught taught{{}, state.value("tool", ""), state.value("model", ""), {}};
  for (const Json& joint : state["names"]) {
    taught.joints.names.push_back(text_of(joint));
    taught.joints.positions.push_back(number_of(state["joints"][text_of(joint)]));
  }
  point.taught = std::make_shared<data::Taught>(std::move(taught));
  data::edit_set(a.file, "teach " + a.name, [&](ImportFile& set) {
    if (set.values().value(a.name) && !a.yes)
      throw Error("in-use", "there is a '" + a.name + "' already",
                  "use --yes to overwrite it, or give another name");
    set.set(a.name, point);
  });
  fmt::print("{} is {}\n", a.name, data::Value(point).text());
  return kOk;
}

}  // namespace

void add_teaching(CommandLine& app, TeachArguments& a) {
  CommandLine* frame = app.add_subcommand(
      "frame", "a frame from three points (origin, on x, in the xy plane), or from a pose");
  CommandLine* tool =
      app.add_subcommand("tool", "a tool's TCP from four and more poses of tool0 with the tip at one point");
  for (CommandLine* sub : {frame, tool}) {
    sub->add_option("file", a.file, "the data set's file")->required();
    sub->add_option("name", a.name, "the point to create")->required();
    sub->add_option("--from", a.from, "points of the file")->required()->expected(1, 100);
  }
  CommandLine* teach =
      app.add_subcommand("teach", "store the position of the robot of a running cell as a point");
  teach->add_option("file", a.file, "the data set's file")->required();
  teach->add_option("name", a.name, "the point")->required();
  teach->add_option("--robot", a.robot, "which one, if the cell has several");
  teach->add_option("--cell", a.cell, "which cell, where several run");
  teach->add_flag("--yes,-y", a.yes, "overwrite an existing point");
  frame->add_option("--in", a.in,
                    "the frame that it is in: a point, ROBOT/flange, ROBOT/base; else that of its points");
  tool->add_option("--most", a.most_mm, "mm that the tip may be off");
  tool->add_flag("--yes,-y", a.yes, "accept it whatever the remaining error is");
}

int run_teaching(const std::string& action, const TeachArguments& a) {
  if (action == "teach") return teach_point(a);
  return action == "frame" ? teach_frame(a) : teach_tool(a);
}

}  // namespace polyarm::apps
