#pragma once
/// A topic that can be received in one of several types. Tools of ROS 2 refuse a topic with two types on the
/// graph. So only the types that others publish are offered; without publishers, the default types.
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "polyarm/ros2/cell_door.hpp"

namespace polyarm::ros2 {

class TypedTopic {
 public:
  /// Subscribes to the topic with this type; the endpoint belongs to the group.
  using Listen = std::function<void(const std::string& group, const std::string& type)>;

  /// `types`: all types; `at_once`: those offered while there is no publisher; `group`: prefix of the group
  /// name of each type's endpoint.
  TypedTopic(Bridge& bridge, const std::string& group, std::string topic,
             const std::vector<std::string>& types, const std::vector<std::string>& at_once, Listen listen);
  ~TypedTopic();
  TypedTopic(const TypedTopic&) = delete;
  TypedTopic& operator=(const TypedTopic&) = delete;

  /// Updates the offered types to those that others publish now.
  void look();

 private:
  using Clock = std::chrono::steady_clock;
  struct Type {
    std::string name, group;
    bool at_once = false, open = false;
    Clock::time_point wanted;  ///< when it was last wanted
  };
  void offer(Type& type, bool wanted);

  Bridge& bridge_;
  const std::string topic_;
  const Listen listen_;
  std::vector<Type> types_;
};

}  // namespace polyarm::ros2
