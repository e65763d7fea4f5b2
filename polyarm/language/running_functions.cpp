#include "polyarm/language/running_functions.hpp"

#include <optional>
#include <string_view>
#include <utility>

namespace polyarm::program {

using data::Kind;

namespace {
using W = Wanted;
using Parameters = std::vector<FunctionParameter>;

/// The running program executes it.
Function& add(std::vector<Function>& out, std::string_view name, std::string_view signature,
              std::string_view meaning, Parameters parameters, Kind kind, std::optional<Dimension> dimension,
              Live which) {
  out.push_back({name, signature, meaning, std::move(parameters), false, false, kind, dimension, nullptr,
                 false, nullptr, which});
  return out.back();
}

/// Joints and poses of the robot.
void add_joint_functions(std::vector<Function>& out) {
  add(out, "here_joints", "here_joints()", "the joints of the robot; waits until it has arrived", {},
      Kind::joints, {}, Live::here_joints)
      .waits = true;
  add(out, "ik", "ik(place, near)",
      "the joints at a point: those it was taught with, else the nearest to `near`, or to the present ones; "
      "waits until the robot has arrived where `near` is left out",
      {{"place", W::place, {}}, {"near", W::joints, 0.0}}, Kind::joints, {}, Live::ik)
      .waits = true;
  add(out, "fk", "fk(joints)", "the pose of the tool centre point at these joints",
      {{"joints", W::joints, {}}}, Kind::pose, {}, Live::fk);
}

/// Chance and time.
void add_program_functions(std::vector<Function>& out) {
  Function& by_chance =
      add(out, "random", "random(), random(a, b)",
          "a number between 0 and 1, or between a and b; `seed` in cell.yaml selects the series",
          {{"a", W::number, 0.0}, {"b", W::number, 1.0}}, Kind::number, {}, Live::random);
  by_chance.open = true;
  Function& clock =
      add(out, "clock", "clock()", "the time since the program began; waits until the robot has arrived", {},
          Kind::number, Dimension::time, Live::clock);
  clock.open = clock.waits = true;
}

/// Forces at the tool, and how moves with `until` ended.
void add_force_functions(std::vector<Function>& out) {
  const auto measured = [&](std::string_view name, std::string_view signature, std::string_view meaning,
                            Kind kind, std::optional<Dimension> dimension, Live which, bool waits) {
    Function& function = add(out, name, signature, meaning, {}, kind, dimension, which);
    function.open = true;
    function.waits = waits;
  };
  measured("force", "force()", "the size of the force at the robot's force sensor", Kind::number,
           Dimension::force, Live::force, true);
  measured("wrench", "wrench()",
           "the forces x, y, z and torques rx, ry, rz at the robot's force sensor, in its axes", Kind::record,
           {}, Live::wrench, true);
  measured("zero_force", "zero_force()",
           "the present wrench counts as zero from now on, such as the weight of the tool", Kind::boolean, {},
           Live::zero_force, true);
  measured("met", "met()", "true if the condition of the last `until` of this task came", Kind::boolean, {},
           Live::met, false);
  measured("travelled", "travelled()", "how far the tool went in the last move with `until` of this task",
           Kind::number, Dimension::length, Live::travelled, false);
  Function& comply = add(out, "comply", "comply(axes, force, stiffness, damping, most, reach)",
                         "from now on the tool yields to forces along and about these axes of the flange, "
                         "such as \"x y rz\"; waits "
                         "until the robot has arrived",
                         {{"axes", W::text, {}},
                          {"force", W::number, 0.0},
                          {"stiffness", W::scalar, 0.0},
                          {"damping", W::scalar, 1000.0},
                          {"most", W::number, 0.0},
                          {"reach", W::length, 0.02}},
                         Kind::boolean, {}, Live::comply);
  comply.waits = true;
  measured("stiff", "stiff()",
           "the robot stays where the tool is and yields no more; waits until it has arrived", Kind::boolean,
           {}, Live::stiff, true);
}

/// Parts on belts.
void add_belt_functions(std::vector<Function>& out) {
  const auto on_belt = [&](std::string_view name, std::string_view signature, std::string_view meaning,
                           Parameters parameters, Kind kind, Live which) {
    Function& function = add(out, name, signature, meaning, std::move(parameters), kind, {}, which);
    function.open = true;
    function.waits = which == Live::next_part;
  };
  on_belt("next_part", "next_part(belt)",
          "true if a part comes that the robot can still reach: the frame with the name of the belt then "
          "moves with this part; "
          "waits until the robot has arrived",
          {{"belt", W::text, {}}}, Kind::boolean, Live::next_part);
  on_belt("waiting_parts", "waiting_parts(belt)", "how many parts come that a robot can still reach",
          {{"belt", W::text, {}}}, Kind::number, Live::waiting_parts);
  on_belt("missed_parts", "missed_parts(belt)", "how many parts no robot has taken in time",
          {{"belt", W::text, {}}}, Kind::number, Live::missed_parts);
  on_belt("add_part", "add_part(belt, pose)",
          "a part that a camera sees now, at this pose in the frame that stands where the belt reads zero",
          {{"belt", W::text, {}}, {"pose", W::pose, {}}}, Kind::boolean, Live::add_part);
}

/// Tables in files. As for data files, what is in one now counts in `check`.
void add_table_functions(std::vector<Function>& out) {
  add(out, "rows_of", "rows_of(file)",
      "the rows of a table in the folder of the cell, such as a CSV: records if its first line names the "
      "columns, else lists",
      {{"file", W::text, {}}}, Kind::list, {}, Live::rows_of);
}

/// Lines of text over streams.
void add_stream_functions(std::vector<Function>& out) {
  const auto on_stream = [&](std::string_view name, std::string_view signature, std::string_view meaning,
                             Parameters parameters, Kind kind, Live which) {
    Function& function = add(out, name, signature, meaning, std::move(parameters), kind, {}, which);
    function.open = true;
    function.waits = which == Live::send_text;
  };
  on_stream("is_connected", "is_connected(stream)", "true while the stream has its other side",
            {{"stream", W::text, {}}}, Kind::boolean, Live::is_connected);
  on_stream("has_line", "has_line(stream)", "true if a line has come over the stream that is not taken yet",
            {{"stream", W::text, {}}}, Kind::boolean, Live::has_line);
  on_stream("next_line", "next_line(stream)",
            "takes the oldest line that the stream has received; an empty text if no line waits",
            {{"stream", W::text, {}}}, Kind::text, Live::next_line);
  on_stream("send_text", "send_text(stream, text)",
            "sends the text over the stream; waits until the robot has arrived",
            {{"stream", W::text, {}}, {"text", W::text, {}}}, Kind::boolean, Live::send_text);
}

}  // namespace

void add_running_functions(std::vector<Function>& out) {
  add_joint_functions(out);
  add_program_functions(out);
  add_force_functions(out);
  add_belt_functions(out);
  add_table_functions(out);
  add_stream_functions(out);
}

}  // namespace polyarm::program
