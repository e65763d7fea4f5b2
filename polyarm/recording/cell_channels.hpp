#pragma once
/// The state of a cell as channels of messages, for recordings and for live viewers.
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

/// Receives a message of a channel, at `time` (ROS time, ns). The payload is valid only during the call.
using WriteMessage = std::function<void(std::size_t channel, std::int64_t time, std::span<const std::byte> payload)>;

/// Severity levels of /rosout (rcl_interfaces/Log).
enum class LogLevel : std::uint8_t { debug = 10, info = 20, warn = 30, error = 40, fatal = 50 };

/// The channels of one cell. Create it on the cell thread. Then one other thread may call `record_latched`,
/// `record_sample` and `record_interfaces`, while the cell thread calls the rest: the two groups share no data.
/// The cell must outlive it.
///
/// Times passed in are cell times; times in messages are `offset` later.
class CellChannels {
 public:
  explicit CellChannels(cell::CellView& cell, std::int64_t offset);

  /// ROS time − cell time, ns.
  std::int64_t offset() const { return offset_; }
  /// The channel's number is its index.
  const std::vector<Channel>& list() const { return list_; }

  /// Sends the descriptions and the fixed frames.
  void record_latched(Nanoseconds time, const WriteMessage& tell) const;
  /// Sends the data of one cycle: measured joints, commands, frames, tool centre points and loop state.
  void record_sample(const control::TappedCycle& cycle, std::span<const double> states,
                   std::span<const double> commands, const WriteMessage& tell);
  /// Sends all state interfaces.
  void record_interfaces(Nanoseconds time, std::span<const double> states, const WriteMessage& tell);
  /// Sends tags that changed since the last call; with `all`, every tag. A change is sent as two messages, so
  /// that plots show a step.
  void report_tags(Nanoseconds time, bool all, const WriteMessage& tell);
  /// Sends parts that moved since the last call as frames part/NAME in the world; with `all`, every part that
  /// is in the world. At most 50 times per second.
  void record_parts(Nanoseconds time, bool all, const WriteMessage& tell);
  /// Sends the poses of mobile bases in the world, through their odometry frames. At most 50 times per
  /// second.
  void record_bases(Nanoseconds time, const WriteMessage& tell);
  void record_log(Nanoseconds time, LogLevel level, const std::string& who, const std::string& text,
                const Location& where, const WriteMessage& tell);
  /// A task has reached a line.
  void record_line(Nanoseconds time, const std::string& task, const Location& where, const std::string& source,
                 const WriteMessage& tell);
  /// Sends diagnostics of the control loop.
  void record_health(Nanoseconds time, const WriteMessage& tell);

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
           const WriteMessage& tell) const;
  void print_tag(const Tag& tag, const data::Value& value, std::int64_t time, const WriteMessage& tell);
  void report_loop(const control::TappedCycle& cycle, std::int64_t time, const WriteMessage& tell);

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
    Pose pose;  ///< of that frame in the world; fixed
  };
  std::vector<TcpFrame> tcp_frames_;          ///< by robot: the reference frame of its tool centre point
  std::vector<std::vector<int>> tcp_states_;  ///< by robot: the position states of its joints
  messages::control_msgs::msg::DynamicJointState dynamic_;
  std::vector<std::vector<std::size_t>> dynamic_states_;
  std::vector<Tag> tags_;
  messages::tf2_msgs::msg::TFMessage parts_;
  std::vector<std::optional<Pose>> parts_reported_;  ///< by part; nothing: not in the world
  Nanoseconds parts_at_ = -1;
  messages::tf2_msgs::msg::TFMessage bases_;
  Nanoseconds bases_at_ = -1;
  std::vector<std::byte> sample_room_, event_room_;
};

/// These channels as a Markdown table, for docs/recording.md. Of the tags, one row per message type.
std::string channel_reference(const std::vector<Channel>& channels);

}  // namespace polyarm::recording
