#pragma once
/// A topic that is heard in one of several types. Tools of ROS 2 refuse a topic that has two types on the
/// graph, so those are offered that others publish; where nobody does, those that are offered at once.
#include <chrono>
#include <functional>
#include <string>
#include <vector>

#include "polyarm/ros2/cell_door.hpp"

namespace polyarm::ros2 {

class TypedTopic {
 public:
  /// Listens to the topic in this type; the endpoint belongs to the group.
  using Listen = std::function<void(const std::string& group, const std::string& type)>;

  /// `types`: that there are; `at_once`: some of them; `group`: of each type's endpoint, before its name.
  TypedTopic(Bridge& bridge, const std::string& group, std::string topic,
             const std::vector<std::string>& types, const std::vector<std::string>& at_once, Listen listen);
  ~TypedTopic();
  TypedTopic(const TypedTopic&) = delete;
  TypedTopic& operator=(const TypedTopic&) = delete;

  /// Offers what others publish by now.
  void look();

 private:
  using Clock = std::chrono::steady_clock;
  struct Type {
    std::string name, group;
    bool at_once = false, open = false;
    Clock::time_point wanted;  ///< the last time
  };
  void offer(Type& type, bool wanted);

  Bridge& bridge_;
  const std::string topic_;
  const Listen listen_;
  std::vector<Type> types_;
};

}  // namespace polyarm::ros2
