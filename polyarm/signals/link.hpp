#pragma once
/// Links: tags and values of a cell that are exchanged with another system over a network.
///
/// A LinkEntry describes the content of a link. A LinkPort speaks the protocol, in its own process if a
/// third-party library parses the input (remote_port.hpp). Link gives the port its own thread, reconnects
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

/// Direction as seen from the cell. both: a change on either side is sent to the other.
enum class Direction { in, out, both };
const char* name(Direction direction);

/// Permitted positions of a pose from outside. The default bounds are wide.
struct PoseRange {
  std::array<double, 3> lower{-100, -100, -100}, upper{100, 100, 100};  ///< m, in the pose's frame
  /// The reason if the pose is not allowed (not finite, invalid rotation, outside); else empty.
  std::optional<std::string> refuses(const Pose& pose) const;
};

/// One value of a link, under the name that the cell uses.
struct LinkTag {
  enum class Type { boolean, number, text, pose };
  /// Modbus: only the server may write discrete inputs and input registers.
  enum class Area { coil, discrete, holding, input };
  enum class Format { uint16, int16, uint32, int32, float32, float64 };

  std::string name;
  Direction direction = Direction::in;
  Type type = Type::boolean;
  double scale = 1, offset = 0;                ///< cell's number = scale · far side's number + offset
  std::optional<std::array<double, 2>> range;  ///< of the cell's number; other values are refused
  PoseRange within;
  double angle_scale = 1;   ///< pose: rad per unit of angle on the far side; `scale` applies to lengths
  bool cell_first = false;  ///< both: at the first connection the cell's value wins, not the far side's

  // Modbus
  Area area = Area::coil;
  int address = 0;
  Format format = Format::uint16;
  std::string group;  ///< poll group; Sparkplug: device

  // MQTT
  std::string topic;  ///< Sparkplug: name of the metric
  bool json = false;
  std::string field;  ///< of a JSON object, with dots; empty: the whole message
  bool retain = false;
  int qos = 1;
  Nanoseconds stale = 0;  ///< age at which the value becomes stale; 0: never

  // ROS 2; `topic` is the name of a topic or service, `field` a field of the message, `retain`: latched
  /// For a service: the tag that starts the call (true) and is reset by the reply (false), a field of the
  /// request, or a field of the reply.
  enum class Role { topic, call, request, answer };
  Role role = Role::topic;
  std::string message;  ///< "geometry_msgs/PoseStamped", "std_srvs/srv/Trigger"
  bool best_effort = false;
  std::map<std::string, std::string> constants;  ///< fixed fields of outgoing messages

  Location where;
  /// Count of registers (a pose has six numbers).
  int registers() const;
};

/// Count of numbers in a pose: x, y, z, roll, pitch, yaw.
constexpr int kPoseNumbers = 6;

/// The entry of one link in signals.yaml.
struct LinkEntry {
  enum class OnLoss { hold, go_on };
  std::string name;
  std::string kind;  ///< "modbus", "mqtt" or "ros2": selects the module that makes the port
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
  std::map<std::string, Nanoseconds> groups;  ///< poll groups and their periods

  // MQTT
  std::string client_id, user, password_file, will_topic, will_text;
  std::string password;  ///< content of the password file, set when a port is made
  bool will_retain = true;
  int will_qos = 1;
  bool tls = false;
  std::string ca_file, certificate, key;
  Nanoseconds keep_alive = 10'000'000'000;

  // ROS 2, Sparkplug
  std::map<std::string, std::string>
      graph;  ///< settings for joining: domain, range, namespace …; or group, node …

  /// "modbus at 127.0.0.1:502"
  std::string address() const;
};

struct LinkValue {
  std::size_t tag = 0;  ///< index into LinkEntry::tags
  data::Value value;
};

/// The result of one exchange of a port.
struct LinkReport {
  std::vector<LinkValue> values;                             ///< new values, or all after connecting
  std::vector<std::size_t> seen;                             ///< tags that were received, changed or not
  std::vector<std::pair<std::size_t, std::string>> refused;  ///< refused values with the reason
  std::vector<std::string> notes;  ///< for the user: events of the port that did not end the connection
  bool alive = true;               ///< the far side is active (server: it had a recent request)
  void refuse(std::size_t tag, std::string why) { refused.emplace_back(tag, std::move(why)); }
};

/// Speaks one protocol with one far side. One thread calls it; give_up() may be called from any thread.
class LinkPort {
 public:
  virtual ~LinkPort() = default;
  /// Connects (a server: listens). Throws Error with the reason.
  virtual void open() = 0;
  virtual void close() noexcept = 0;
  /// Sends `writes` and receives values that are due or pending; waits for news for at most `patience`.
  /// `now`: time of the caller's clock. Throws Error if the connection is lost; then none of `writes` counts
  /// as sent.
  virtual void exchange(const std::vector<LinkValue>& writes, Nanoseconds now, Nanoseconds patience,
                        LinkReport& news) = 0;
  /// True if exchange() itself waits for incoming data.
  virtual bool waits() const { return false; }
  /// Call it before the first open(), with the values that both sides knew before the port was created again.
  /// A server offers these values.
  virtual void remember(const std::vector<LinkValue>&) {}
  /// Any thread. The caller no longer waits; a call that waits for the far side may end with an Error.
  virtual void give_up() noexcept {}
};

/// Makes a port. Used by `polyarm_link_KIND`, a program (link_process.hpp), or by a module of that name,
/// which exports it as `extern "C" LinkPort* polyarm_link_1(const LinkEntry&)`.
using MakeLinkPort = LinkPort* (*)(const LinkEntry&);
/// Looks for `polyarm_link_KIND` in the folders: first a program, then a module (.so). A module must not
/// parse untrusted input. Throws Error("no-link-module") that says what to install.
std::unique_ptr<LinkPort> load_link_port(const LinkEntry& entry,
                                         const std::vector<std::filesystem::path>& folders);

struct LinkEvent {
  enum class Kind { value, refused, lost, found, note } kind = Kind::value;
  std::size_t tag = 0;
  data::Value value;
  std::string text;  ///< refused, lost: the reason; note: the text
};

/// The state of a link at one moment.
struct LinkState {
  bool up = false;
  bool was_up = false;
  std::string reason;  ///< why it is not up
  std::uint64_t losses = 0, exchanges = 0;
  Nanoseconds round_ns = 0;        ///< duration of the last exchange
  std::vector<char> stale, heard;  ///< by tag
};

struct LinkOptions {
  bool thread = true;                                                    ///< false: step() does the work
  Nanoseconds first_pause = 100'000'000, longest_pause = 5'000'000'000;  ///< before a reconnection, ns
};

/// Runs a port, from the first call of take_events(). Call post(), take_events() and state() on the cell
/// thread.
class Link {
 public:
  Link(LinkEntry entry, std::unique_ptr<LinkPort> port, LinkOptions options = {});
  /// Sends what was posted, within the link's timeout, then closes. A pending connection attempt is
  /// cancelled.
  ~Link();
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  const LinkEntry& entry() const;
  /// Sets the value for the far side. Only a tag's latest value is sent; after a loss it is sent again.
  void post(std::size_t tag, const data::Value& value);
  /// The events since the last call. A value of a tag that was posted after that value was read is left out.
  std::vector<LinkEvent> take_events();
  LinkState state() const;
  /// True if everything posted has been sent.
  bool idle() const;
  /// Runs one round on the calling thread at time `now`; for links without a thread.
  void step(Nanoseconds now);

 private:
  class Io;
  std::unique_ptr<Io> io_;
};

/// Converts a port's value to the cell's value: scales it, and checks that it is finite and in range, and has
/// the right type. Empty if it is refused, with the reason in `why`.
std::optional<data::Value> taken_number(const LinkTag& tag, double raw, std::string& why);
std::optional<data::Value> taken_pose(const LinkTag& tag, const std::vector<double>& raw, std::string& why);
/// The inverse: the value for the far side.
double given_number(const LinkTag& tag, const data::Value& value);
std::vector<double> given_pose(const LinkTag& tag, const data::Value& value);

}  // namespace polyarm::signals
