#pragma once
/// A named stream of messages of one type, as MCAP and Foxglove define it.
#include <string>

namespace polyarm::recording {

struct Channel {
  std::string topic;            ///< "/joint_states"
  std::string encoding;         ///< of messages: "cdr" or "json"
  std::string schema_name;      ///< "sensor_msgs/msg/JointState"
  std::string schema_encoding;  ///< "ros2msg" or "jsonschema"
  std::string schema;
  std::string about;     ///< one sentence for the documentation
  bool latched = false;  ///< a client that connects later also gets the last message
};

}  // namespace polyarm::recording
