#include "one_joint_msgs/msg/note.hpp"
