#pragma once
/// The driver's end of the wires to one controller of Universal Robots: RTDE, primary interface, dashboard,
/// and the stream of commands to the program on the robot. A thread of its own does all input and output.
#include <array>
#include <atomic>
#include <condition_variable>
#include <cstdint>
#include <limits>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "drivers/ur/move_shape.hpp"
#include "drivers/ur/primary.hpp"
#include "drivers/ur/rtde.hpp"
#include "drivers/ur/script.hpp"
#include "drivers/ur/words.hpp"
#include "drivers/wire/link_base.hpp"
#include "drivers/wire/pacer.hpp"
#include "drivers/wire/tcp.hpp"
#include "polyarm/realtime/latest.hpp"

namespace polyarm::ur {

/// Values that the driver reads, in the order of its recipe. rad, m, N, A.
enum Field : std::size_t {
  kTimestamp,
  kPosition,
  kVelocity,
  kCurrent,
  kPose,
  kWrench,
  kSpeedScaling,
  kSpeedSlider,
  kRobotMode,
  kSafetyMode,
  kRuntimeState,
  kDigitalIn,
  kDigitalOut,
  kAnalogIn0,
  kAnalogIn1,
  kAnalogOut0,
  kAnalogOut1,
  kSequence,
  kScriptState,
  kMoveEnded,  ///< registers of the program that makes moves
  kMoveHalted,
  kTorque,   ///< optional: software 5.23 and newer
  kPayload,  ///< optional: e-Series
  kFields
};
/// Where a field begins among the elements of a sample.
std::size_t place_of(Field field) noexcept;
inline constexpr std::size_t kMostElements = 64;  // more than all fields together

struct Sample {
  std::array<double, kMostElements> values{};  ///< NaN: the controller does not have it
  std::uint64_t count = 0;                     ///< of packages since the connection began
  std::uint64_t lost = 0, repeated = 0;
  bool streaming = false;  ///< the robot's program is connected
  double operator[](Field field) const noexcept { return values[place_of(field)]; }
};

/// Outputs of the controller; NaN leaves one as it is.
struct Outputs {
  static constexpr std::size_t kDigital = 18, kAnalog = 2;
  std::array<double, kDigital> digital;
  std::array<double, kAnalog> analog;  ///< share of the range, 0 to 1
  double speed_slider;
  Outputs() noexcept {
    digital.fill(std::numeric_limits<double>::quiet_NaN());
    analog.fill(std::numeric_limits<double>::quiet_NaN());
    speed_slider = std::numeric_limits<double>::quiet_NaN();
  }
};

struct LinkSettings {
  std::string host, own_address;  ///< own_address empty: the one that reaches the host
  int rtde_port = 30004, primary_port = 30001, dashboard_port = 29999, own_port = 0;
  double rate = 0;  ///< Hz; 0: the controller's own
  bool io = true, dashboard = true;
  Nanoseconds connect_timeout = 2'000'000'000, start_timeout = 5'000'000'000;
  Nanoseconds silence = 200'000'000;  ///< without a package, until the link counts as lost
  int watchdog_ms = 100;              ///< without a command, until the robot's program stops the robot
  ScriptSettings script;
  std::optional<MoveFrame> forward;  ///< the controller makes moves; nothing: it follows commands
};

/// The on_… calls come from one thread at a time and may wait; the calls marked control thread do not.
class Link : public wire::LinkBase<Cause> {
 public:
  explicit Link(LinkSettings settings);
  ~Link() { close(); }
  Link(const Link&) = delete;
  Link& operator=(const Link&) = delete;

  /// Connects and sets up; reads states from then on. Nothing moves. False: see reason().
  bool open();
  /// Ends the program, and all connections.
  void close();
  /// Sends the program and waits until it has connected back. The robot stands still. False: see reason().
  bool start();
  /// Ends the program: the robot stops and holds.
  void stop();

  // --- control thread; nothing waits, locks or allocates ---
  /// The newest sample; true if there is a new one since the last call.
  bool fetch() noexcept { return samples_.fetch(); }
  const Sample& sample() const noexcept { return samples_.value(); }
  /// The newest command; returns its sequence number.
  std::int32_t command(Mode mode, const std::array<double, 6>& values) noexcept;
  /// What the outputs shall be. Only what changed is sent: somebody at the pendant may have switched the
  /// others. Call it before command(): then the outputs arrive before that command.
  void outputs(const Outputs& outputs) noexcept;
  /// In forward mode; else null. command() is the sign of life of the loop then, and its values count
  /// nothing.
  MoveQueue* moves() noexcept { return moves_.get(); }

  /// The controller's rate, Hz; valid after open().
  double rate() const { return rate_; }
  const std::string& version() const { return version_; }
  /// What the controller says of its kinematics; empty until it has said so.
  std::optional<Kinematics> kinematics() const;

 private:
  struct Command {
    std::int32_t sequence = 0;
    Mode mode = Mode::hold;
    std::array<double, 6> values{};
  };
  enum class Phase : std::uint8_t { idle, starting, streaming };

  // setting up, before the thread runs
  void drop();
  bool connect(int port, Descriptor& socket);
  std::optional<std::vector<std::uint8_t>> ask(PackageType type, const wire::Writer& payload);
  bool negotiate();
  bool set_up_outputs();
  bool set_up_inputs();
  bool ask_for_inputs();
  bool check_remote();
  bool check_robot();
  std::string ask_dashboard(const std::string& line);

  // the thread
  void run();
  void wait();
  void take_rtde(Nanoseconds now);
  void take_package(Bytes payload, Nanoseconds now);
  void take_primary();
  void take_stream();
  void accept_stream();
  void take_commands(Nanoseconds now);
  void send_command(const Command& command);
  void send_end();
  void send(std::int32_t sequence, std::span<const std::uint8_t> bytes);
  MoveReport move_report() const;
  void take_moves();
  void hold_slider();
  void end_at_the_controller();
  void send_outputs();
  void judge(Nanoseconds now);
  void judge_program(Nanoseconds now);
  void finish_stopping(Nanoseconds now);
  void end_stream();
  bool streams() const { return static_cast<bool>(stream_); }

  LinkSettings settings_;
  Descriptor rtde_, primary_, listener_, stream_;
  int protocol_ = 2;
  double rate_ = 500;
  std::string version_, controller_;  // controller_: its address
  FrameStream frames_;
  PrimaryStream messages_;
  Recipe recipe_, inputs_;
  std::vector<Field> fields_;  // in the order of the recipe
  std::array<double, kMostElements> decoded_{};

  realtime::Latest<Sample> samples_;
  realtime::Latest<Command> commands_;
  realtime::Latest<Outputs> outputs_;
  std::int32_t sequence_ = 0;  // the control thread's

  // with mutex_
  std::optional<Kinematics> nominal_, calibrated_;
  Phase phase_ = Phase::idle;
  bool stop_wanted_ = false;
  std::string exception_, refusal_;  // of the primary interface since start()

  std::unique_ptr<MoveQueue> moves_;

  // the thread's
  Sample current_;
  Outputs written_;  // what was sent of the outputs, or was wanted before
  wire::Pacer pacer_;
  bool primary_lost_ = false;
  bool played_ = false;
  bool commanded_ = false;
  bool ending_ = false;
  double sent_sequence_ = 0, taken_sequence_ = 0;
  std::optional<double> slider_before_;  // until a program that changed it has ended in order
  unsigned long unread_ = 0;             // cycles in which the robot's program took no command
  Nanoseconds heard_ = 0, closed_ = 0, ended_ = 0;
  std::atomic<bool> quit_{false};
  std::thread thread_;
};

}  // namespace polyarm::ur
