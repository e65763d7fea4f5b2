#pragma once
/// Links: tags and values of a cell that go to and come from somewhere else, over a network.
///
/// A LinkEntry describes what a link carries; a LinkPort speaks the protocol, in a process of its own where a
/// library of others parses what comes (remote_port.hpp). Link gives the port a thread of its own, connects again
/// after a loss, and exchanges values with the cell thread, which never waits.
#include <array>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/base/time.hpp"
#include "polyarm/data/value.hpp"

namespace polyarm::signals {

/// As the cell sees it. both: whoever changes the value, the other side gets it.
enum class Direction { in, out, both };
const char* name(Direction direction);

/// Where a pose from outside may be; a bound that is not stated is wide.
struct PoseRange {
  std::array<double, 3> lower{-100, -100, -100}, upper{100, 100, 100};  ///< m, in the pose's frame
  /// Why the pose may not be used (not finite, no rotation, outside), or nothing.
  std::optional<std::string> refuses(const Pose& pose) const;
};

/// One value that a link carries, under the name that the cell has for it.
struct LinkTag {
  enum class Type { boolean, number, text, pose };
  /// Modbus: discrete inputs and input registers are the server's alone to write.
  enum class Area { coil, discrete, holding, input };
  enum class Format { uint16, int16, uint32, int32, float32, float64 };

  std::string name;
  Direction direction = Direction::in;
  Type type = Type::boolean;
  double scale = 1, offset = 0;                ///< the cell's number = scale · the far side's + offset
  std::optional<std::array<double, 2>> range;  ///< of the cell's number; outside of it nothing is taken
  PoseRange within;
  double angle_scale = 1;   ///< pose: rad in one of the far side's units of angle; `scale` is of its lengths
  bool cell_first = false;  ///< both: at the first connection the cell's value counts, not the far side's

  // Modbus
  Area area = Area::coil;
  int address = 0;
  Format format = Format::uint16;
  std::string group;  ///< poll group

  // MQTT
  std::string topic;
  bool json = false;
  std::string field;  ///< of a JSON object, with dots; empty: the whole message
  bool retain = false;
  int qos = 1;
  Nanoseconds stale = 0;  ///< older than this it is stale; 0: never by itself

  // ROS 2; `topic` is a topic's or a service's name, `field` stands in the message, `retain`: latched
  /// Of a service: the tag that asks (true) and is answered (false), a field of the request, one of the
  /// answer.
  enum class Role { topic, call, request, answer };
  Role role = Role::topic;
  std::string message;  ///< "geometry_msgs/PoseStamped", "std_srvs/srv/Trigger"
  bool best_effort = false;
  std::map<std::string, std::string> constants;  ///< fields of what goes out that stay as they are

  Location where;
  /// Registers that it takes (pose: six or seven numbers).
  int registers() const;
};

/// How many numbers stand for a pose: x, y, z, roll, pitch, yaw.
constexpr int kPoseNumbers = 6;

/// What signals.yaml says of one link.
struct LinkEntry {
  enum class OnLoss { hold, go_on };
  std::string name;
  std::string kind;  ///< "modbus", "mqtt" or "ros2": the module that makes its port
  bool server = false;
  std::string host = "127.0.0.1";
  int port = 0;
  Nanoseconds poll = 50'000'000, timeout = 500'000'000;
  OnLoss on_loss = OnLoss::hold;
  std::vector<LinkTag> tags;
  Location where;

  // Modbus
  int unit = 1;
  bool low_word_first = false;
  std::map<std::string, Nanoseconds> groups;  ///< poll groups: how often

  // MQTT
  std::string client_id, user, password_file, will_topic, will_text;
  std::string password;  ///< what the file holds, once a port is made
  bool will_retain = true;
  int will_qos = 1;
  bool tls = false;
  std::string ca_file, certificate, key;
  Nanoseconds keep_alive = 10'000'000'000;

  // ROS 2
  std::map<std::string, std::string> graph;  ///< how its graph is joined: domain, range, namespace …

  /// "modbus at 127.0.0.1:502"
  std::string address() const;
};

struct LinkValue {
  std::size_t tag = 0;  ///< index into LinkEntry::tags
  data::Value value;
};

/// What a round of a port brought.
struct LinkNews {
  std::vector<LinkValue> values;                             ///< new, or just connected
  std::vector<std::size_t> seen;                             ///< tags that were heard of, changed or not
  std::vector<std::pair<std::size_t, std::string>> refused;  ///< what could not be taken, and why
  std::vector<std::string> notes;  ///< for a person: what happened to the port itself, which goes on
  bool alive = true;               ///< the far side is there (a server: somebody has asked lately)
  void refuse(std::size_t tag, std::string why) { refused.emplace_back(tag, std::move(why)); }
};

/// Speaks one protocol with one far side. Called by one thread, but for give_up().
class LinkPort {
 public:
  virtual ~LinkPort() = default;
  /// Connects (a server: listens). Throws Error with the reason.
  virtual void open() = 0;
  virtual void close() noexcept = 0;
  /// Hands `writes` over and takes what is due or came, waiting for news for at most `patience`. `now` is the
  /// time of the caller's clock. Throws Error when the connection is lost; then none of `writes` counts as
  /// handed over.
  virtual void exchange(const std::vector<LinkValue>& writes, Nanoseconds now, Nanoseconds patience,
                        LinkNews& news) = 0;
  /// Whether exchange() itself waits for what comes.
  virtual bool waits() const { return false; }
  /// Before the first open(): values that both sides knew before the port was made anew. A server offers them.
  virtual void remember(const std::vector<LinkValue>&) {}
  /// Any thread: nobody waits for it any more. A call that waits for the far side may end with an Error.
  virtual void give_up() noexcept {}
};

/// What makes a port: of `polyarm_link_KIND`, a program (link_process.hpp), or of a module of that name, which
/// exports it as `extern "C" LinkPort* polyarm_link_1(const LinkEntry&)`.
using MakeLinkPort = LinkPort* (*)(const LinkEntry&);
/// Looks for `polyarm_link_KIND` in the folders, a program or else a module (.so) that parses nothing of strangers.
/// Throws Error("no-link-module") that says what to install.
std::unique_ptr<LinkPort> load_link_port(const LinkEntry& entry,
                                         const std::vector<std::filesystem::path>& folders);

struct LinkEvent {
  enum class Kind { value, refused, lost, found, note } kind = Kind::value;
  std::size_t tag = 0;
  data::Value value;
  std::string text;  ///< refused, lost: why; note: what
};

/// What is known of a link, at one moment.
struct LinkState {
  bool up = false;
  bool was_up = false;
  std::string reason;  ///< why it is not up
  std::uint64_t losses = 0, exchanges = 0;
  Nanoseconds round_ns = 0;        ///< what the last exchange took
  std::vector<char> stale, heard;  ///< by tag
};

struct LinkOptions {
  bool thread = true;                                                    ///< false: step() does the work
  Nanoseconds first_pause = 100'000'000, longest_pause = 5'000'000'000;  ///< before connecting again
};

/// A port at work, from the first take_events() on. post, take_events, state: the cell thread.
class Link {
 public:
  Link(LinkEntry entry, std::unique_ptr<LinkPort> port, LinkOptions options = {});
  /// Hands over what was posted, for as long as the link's timeout, then closes. Gives up a connection that is
  /// being made.
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  const LinkEntry& entry() const;
  /// The value that the far side shall have. Only the latest of a tag goes out; after a loss it goes out
  /// again.
  void post(std::size_t tag, const data::Value& value);
  /// Since the last call. A value of a tag that was posted later than it was read is left out.
  std::vector<LinkEvent> take_events();
  LinkState state() const;
  /// Whether all that was posted has been handed over.
  bool idle() const;
  /// One round on the calling thread at time `now`, where there is no thread.
  void step(Nanoseconds now);

 private:
  class Io;
  std::unique_ptr<Io> io_;
};

/// A value as a port got it, made into the cell's: scaled, checked for what is not finite, out of range or of
/// another kind. Nothing, and `why`, where it may not be taken.
std::optional<data::Value> taken_number(const LinkTag& tag, double raw, std::string& why);
std::optional<data::Value> taken_pose(const LinkTag& tag, const std::vector<double>& raw, std::string& why);
/// The other way: what the far side gets.
double given_number(const LinkTag& tag, const data::Value& value);
std::vector<double> given_pose(const LinkTag& tag, const data::Value& value);

}  // namespace polyarm::signals
