#pragma once
/// A named stream of messages of one kind, as MCAP and Foxglove describe it.
#include <string>

namespace polyarm::recording {

struct Channel {
  std::string topic;            ///< "/joint_states"
  std::string encoding;         ///< of messages: "cdr" or "json"
  std::string schema_name;      ///< "sensor_msgs/msg/JointState"
  std::string schema_encoding;  ///< "ros2msg" or "jsonschema"
  std::string schema;
  std::string about;     ///< one sentence, for the page of channels
  bool latched = false;  ///< who comes later is told the last message, too
};

}  // namespace polyarm::recording
