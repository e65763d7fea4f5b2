#pragma once
/// A torso with two arms of four joints and a gripper each, as URDF and SRDF. Metres, radians.
#include <string>

namespace polyarm::test {

/// `side`: "left" at y = 0.2, or "right" at y = -0.2. The first link of an arm reaches into the torso. An arm
/// slides along x, y and z, and turns its hand. At zero tool0 is at x = 0.37, z = 0.5 and points down;
/// fingers are on top of the hand.
inline std::string arm_on_torso(const std::string& side) {
  const std::string y = side == "left" ? "0.2" : "-0.2";
  const auto box = [](const std::string& size, const std::string& at) {
    return "<collision><origin xyz=\"" + at + "\"/><geometry><box size=\"" + size +
           "\"/></geometry></collision><inertial><mass value=\"1\"/><inertia ixx=\"0.01\" iyy=\"0.01\" "
           "izz=\"0.01\" "
           "ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";
  };
  const auto link = [&](const std::string& name, const std::string& body = "") {
    return "<link name=\"" + side + "_" + name + "\">" + body + "</link>";
  };
  const auto joint = [&](const std::string& name, const std::string& type, const std::string& parent,
                         const std::string& child, const std::string& at, const std::string& axis,
                         const std::string& more = "") {
    return "<joint name=\"" + side + "_" + name + "\" type=\"" + type + "\"><parent link=\"" + parent +
           "\"/><child link=\"" + side + "_" + child + "\"/><origin xyz=\"" + at + "\"/><axis xyz=\"" + axis +
           "\"/><limit lower=\"-0.6\" upper=\"0.6\" velocity=\"1\" effort=\"200\"/>" + more + "</joint>";
  };
  return link("mount", box("0.06 0.06 0.06", "0 0 0")) + link("rail", box("0.1 0.04 0.04", "0.03 0 0")) +
         link("lift") + link("arm", box("0.2 0.04 0.04", "0 0 0")) +
         link("hand", box("0.06 0.04 0.04", "0.02 0 0")) + link("tool0") +
         link("finger", box("0.02 0.01 0.02", "0 0 0")) + link("thumb", box("0.02 0.01 0.02", "0 0 0")) +
         joint("fixed", "fixed", "torso", "mount", "0 " + y + " 0.5", "1 0 0") +
         joint("x", "prismatic", side + "_mount", "rail", "0 0 0", "1 0 0") +
         joint("y", "prismatic", side + "_rail", "lift", "0.1 0 0", "0 1 0") +
         joint("z", "prismatic", side + "_lift", "arm", "0.1 0 0", "0 0 1") +
         joint("turn", "revolute", side + "_arm", "hand", "0.12 0 0", "1 0 0") +
         joint("flange", "fixed", side + "_hand", "tool0", "0.05 0 0\" rpy=\"3.141592653589793 0 0",
               "0 1 0") +
         joint("grip", "prismatic", side + "_hand", "finger", "0 0.01 0.05", "0 1 0") +
         joint("thumb_joint", "prismatic", side + "_hand", "thumb", "0 -0.01 0.05", "0 -1 0",
               "<mimic joint=\"" + side + "_grip\"/>");
}

inline std::string hardware_of_arm(const std::string& side) {
  std::string out = "<ros2_control name=\"" + side +
                    "_hardware\" type=\"system\"><hardware><plugin>"
                    "mock_components/GenericSystem</plugin></hardware>";
  for (const char* joint : {"x", "y", "z", "turn", "grip"})
    out += "<joint name=\"" + side + "_" + joint +
           "\"><command_interface name=\"position\"/><state_interface name=\"position\"/></joint>";
  return out + "</ros2_control>";
}

/// `more`: further elements.
inline std::string two_arms(const std::string& more = "") {
  return "<robot name=\"pair\"><link name=\"torso\"><collision><origin xyz=\"0 0 0.3\"/><geometry><box "
         "size=\"0.1 0.5 0.6\"/></geometry></collision></link>" +
         arm_on_torso("left") + arm_on_torso("right") + more + "</robot>";
}

/// A third arm on the torso: a base and a first link that both reach into it. At zero its last link is above.
inline std::string head_on_torso() {
  const auto box = [](const std::string& at) {
    return "<collision><origin xyz=\"" + at +
           "\"/><geometry><box size=\"0.06 0.06 0.06\"/></geometry></collision><inertial><mass "
           "value=\"1\"/><inertia "
           "ixx=\"0.01\" iyy=\"0.01\" izz=\"0.01\" ixy=\"0\" ixz=\"0\" iyz=\"0\"/></inertial>";
  };
  const std::string limits = "<limit lower=\"-1\" upper=\"1\" velocity=\"1\" effort=\"100\"/>";
  return "<robot name=\"head\"><link name=\"base\">" + box("0 0 0") + "</link><link name=\"neck\">" +
         box("0 0 0.02") + "</link><link name=\"head\">" + box("0 0 0") +
         "</link><joint name=\"turn\" type=\"revolute\"><parent link=\"base\"/><child link=\"neck\"/><axis "
         "xyz=\"0 0 "
         "1\"/>" +
         limits +
         "</joint><joint name=\"nod\" type=\"revolute\"><parent link=\"neck\"/><child link=\"head\"/><origin "
         "xyz=\"0 0 "
         "0.2\"/><axis xyz=\"0 1 0\"/>" +
         limits + "</joint></robot>";
}

inline std::string two_arms_srdf() {
  return R"(<robot name="pair">
<group name="left_arm"><chain base_link="torso" tip_link="left_hand"/></group>
<group name="right_arm"><chain base_link="torso" tip_link="right_hand"/></group>
<group name="left_fingers"><joint name="left_grip"/></group>
<group name="right_fingers"><joint name="right_grip"/></group>
<group name="both"><group name="left_arm"/><group name="right_arm"/></group>
<group_state name="home" group="both"><joint name="left_x" value="0.1"/><joint name="right_x" value="0.2"/></group_state>
<group_state name="raised" group="right_arm"><joint name="right_z" value="0.3"/></group_state>
<group_state name="wide" group="both"><joint name="left_y" value="0.3"/><joint name="right_y" value="-0.3"/></group_state>
<end_effector name="right_gripper" group="right_fingers" parent_link="right_tool0" parent_group="right_arm"/>
<disable_collisions link1="left_arm" link2="left_hand" reason="Adjacent"/>
<disable_collisions link1="left_hand" link2="right_hand" reason="Never"/>
<disable_collisions link1="right_arm" link2="right_hand" reason="Adjacent"/>
<disable_collisions link1="torso" link2="left_rail" reason="Adjacent"/>
<disable_collisions link1="torso" link2="right_rail" reason="Adjacent"/>
</robot>)";
}

}  // namespace polyarm::test
