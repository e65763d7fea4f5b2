#pragma once
/// What a cell says of itself, as channels of messages: for a file and for whoever watches live.
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/base/time.hpp"
#include "polyarm/control/cycle_tap.hpp"
#include "polyarm/inside/view.hpp"
#include "polyarm/recording/channel.hpp"
#include "polyarm/recording/state_messages.hpp"

namespace polyarm::recording {

/// A message of a channel, at `time` ns of ROS; the payload is the caller's alone while it is told.
using Tell = std::function<void(std::size_t channel, std::int64_t time, std::span<const std::byte> payload)>;

/// How what happened is called in /rosout (rcl_interfaces/Log).
enum class LogLevel : std::uint8_t { debug = 10, info = 20, warn = 30, error = 40, fatal = 50 };

/// The channels of one cell. Made on the cell thread; then `sample` may be called by one other thread, the
/// rest by the cell thread, as each uses what the other leaves alone. The cell must outlive it.
///
/// Times given are of the cell; those of messages are `offset` later.
class CellChannels {
 public:
  explicit CellChannels(cell::CellView& cell, std::int64_t offset);

  /// ROS time − cell time, ns.
  std::int64_t offset() const { return offset_; }
  /// By number.
  const std::vector<Channel>& list() const { return list_; }

  /// Descriptions and the frames that never move.
  void tell_latched(Nanoseconds time, const Tell& tell) const;
  /// What a cycle was: joints, what they were commanded, frames, tool centre points, the loop.
  void tell_sample(const control::TappedCycle& cycle, std::span<const double> states,
                   std::span<const double> commands, const Tell& tell);
  /// Every interface that is measured.
  void tell_interfaces(Nanoseconds time, std::span<const double> states, const Tell& tell);
  /// Tags that have changed since the last time, a step as two messages; all of them where `all`.
  void tell_tags(Nanoseconds time, bool all, const Tell& tell);
  /// Where parts are that have moved since the last time, as frames part/NAME in the world; all of them where
  /// `all`. A part that is not in the world has none. At most 50 times a second.
  void tell_parts(Nanoseconds time, bool all, const Tell& tell);
  /// Where bases are that drive, in the world by way of their odometry's frames; at most 50 times a second.
  void tell_bases(Nanoseconds time, const Tell& tell);
  void tell_log(Nanoseconds time, LogLevel level, const std::string& who, const std::string& text,
                const Location& where, const Tell& tell);
  /// A task has come to a line.
  void tell_line(Nanoseconds time, const std::string& task, const Location& where, const std::string& source,
                 const Tell& tell);
  /// Loop and components, for tools that show diagnostics.
  void tell_health(Nanoseconds time, const Tell& tell);

 private:
  struct Tag {
    std::string name;
    std::size_t channel;
    std::optional<data::Value> told;
  };
  struct Commanded {
    int position, velocity, effort;
  };
  void add_descriptions();
  void add_commands();
  void add_interfaces();
  void add_tags();
  template <class Message>
  std::size_t add(std::string topic, const char* about, bool latched = false);
  std::size_t add_json(std::string topic, const char* name, const char* schema, const char* about);
  template <class Message>
  void say(std::size_t channel, std::int64_t time, const Message& message, std::vector<std::byte>& room,
           const Tell& tell) const;
  void say_tag(const Tag& tag, const data::Value& value, std::int64_t time, const Tell& tell);
  void tell_loop(const control::TappedCycle& cycle, std::int64_t time, const Tell& tell);

  cell::CellView& cell_;
  std::int64_t offset_;
  StateMessages state_;
  std::vector<Channel> list_;
  std::size_t joints_ = 0, commanded_ = 0, moving_ = 0, fixed_ = 0, interfaces_ = 0, loop_ = 0, log_ = 0,
              line_ = 0, health_ = 0;
  std::vector<std::size_t> descriptions_, tcps_;  ///< by robot
  messages::sensor_msgs::msg::JointState commands_;
  std::vector<Commanded> commands_of_;
  messages::geometry_msgs::msg::PoseStamped tcp_;
  struct TcpFrame {
    std::string name = "world";
    Pose pose;  ///< in the world, where it stands or as if it did
  };
  std::vector<TcpFrame> tcp_frames_;          ///< by robot: what its tool centre point is told in
  std::vector<std::vector<int>> tcp_states_;  ///< by robot: its joints' positions
  messages::control_msgs::msg::DynamicJointState dynamic_;
  std::vector<std::vector<std::size_t>> dynamic_states_;
  std::vector<Tag> tags_;
  messages::tf2_msgs::msg::TFMessage parts_;
  std::vector<std::optional<Pose>> parts_told_;  ///< by part; nothing: not in the world
  Nanoseconds parts_at_ = -1;
  messages::tf2_msgs::msg::TFMessage bases_;
  Nanoseconds bases_at_ = -1;
  std::vector<std::byte> sample_room_, event_room_;
};

/// Those channels as a table in Markdown, for docs/recording.md; a tag stands for all of its kind.
std::string channel_reference(const std::vector<Channel>& channels);

}  // namespace polyarm::recording
