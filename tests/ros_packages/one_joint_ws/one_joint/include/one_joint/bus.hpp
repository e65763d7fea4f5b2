#ifndef ONE_JOINT__BUS_HPP_
#define ONE_JOINT__BUS_HPP_
#include <one_joint_msgs/msg/note.hpp>
#ifdef _WIN32
#include <windows.h>
#endif

namespace one_joint {
one_joint_msgs::msg::Note note(double value);
}  // namespace one_joint
#endif
