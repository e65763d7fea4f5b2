#include "polyarm/ros2/typed_topic.hpp"

#include <algorithm>
#include <utility>

namespace polyarm::ros2 {

namespace {
/// How long a type stays offered after its last publisher has left, so that its last messages are still
/// received.
constexpr auto kStays = std::chrono::milliseconds(250);
}  // namespace

TypedTopic::TypedTopic(Bridge& bridge, const std::string& group, std::string topic,
                       const std::vector<std::string>& types, const std::vector<std::string>& at_once,
                       Listen listen)
    : bridge_{bridge}, topic_{std::move(topic)}, listen_{std::move(listen)} {
  for (const std::string& type : types) {
    const bool stands = std::find(at_once.begin(), at_once.end(), type) != at_once.end();
    types_.push_back({type, group + topic_ + " " + type, stands, false, {}});
  }
  look();
}

TypedTopic::~TypedTopic() {
  for (const Type& type : types_) bridge_.wire().remove_node(type.group);
}

void TypedTopic::look() {
  std::vector<bool> published;
  for (const Type& type : types_)
    published.push_back(types_.size() > 1 && bridge_.wire().offered(topic_, bridge_.type(type.name)));
  const bool nobody = std::find(published.begin(), published.end(), true) == published.end();
  for (std::size_t i = 0; i < types_.size(); ++i)
    offer(types_[i], published[i] || (nobody && types_[i].at_once));
}

void TypedTopic::offer(Type& type, bool wanted) {
  const auto now = Clock::now();
  if (wanted) {
    type.wanted = now;
    if (!std::exchange(type.open, true)) listen_(type.group, type.name);
  } else if (type.open && now - type.wanted > kStays) {
    type.open = false;
    bridge_.wire().remove_node(type.group);
  }
}

}  // namespace polyarm::ros2
