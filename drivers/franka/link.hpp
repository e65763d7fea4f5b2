#pragma once
/// The driver's end of the wires to one robot of Franka. While the link is open, one thread answers the
/// states that come every millisecond, and takes the replies to requests; another one serves the hand.
#include <array>
#include <atomic>
#include <cstdint>
#include <map>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "drivers/franka/hand.hpp"
#include "drivers/franka/limits.hpp"
#include "drivers/franka/port.hpp"
#include "drivers/franka/velocity.hpp"
#include "drivers/wire/link_base.hpp"
#include "drivers/wire/udp.hpp"

namespace polyarm::franka {

/// What the robot sends. rad, rad/s.
struct Sample {
  RobotState state;
  Seven q{};                   ///< measured
  std::uint64_t sequence = 0;  ///< id of the state; 0: nothing came
  std::uint64_t lost = 0, repeated = 0, strangers = 0;
  double behind = 0;         ///< rad, of the sent command behind the loop's
  std::uint64_t shaped = 0;  ///< commands that were not sent as the loop gave them
};

/// What the hand shows.
struct HandPanel {
  HandState state;
  bool busy = false;
};

/// What activating sets at the robot; nothing: it stays as Desk or another program has it.
struct RobotSettings {
  std::optional<CollisionBehavior> collision;
  std::optional<Seven> joint_stiffness;    ///< N m/rad
  std::optional<Six> cartesian_stiffness;  ///< N/m, N m/rad
  std::optional<Load> load;
  std::optional<std::array<bool, 7>> guiding;  ///< x y z, about x y z, elbow
};

struct LinkSettings : wire::StreamSettings {
  std::string host;
  int port = kRobotPort;
  int version = 0;  ///< of the interface that is tried first; 0: the newest
  Generator generator = Generator::joint_position;
  Controller controller = Controller::joint_impedance;
  RobotSettings robot;
  HandSettings hand;
  bool recover = true;           ///< activating recovers from an error
  Seven lower{}, upper{};        ///< rad, of the joints; equal: no range
  wire::AxisLimitsOf<7> limits;  ///< of commands, beside those of the robot
  double least_success = 0;      ///< share of commands in time; 0: it is not judged
};

class Link : public wire::StreamLink<wire::LinkBase<Cause>, Sample, HandPanel> {
 public:
  explicit Link(LinkSettings settings);
  ~Link() { close(); }

  /// Connects and reads states. Nothing moves. False: see reason().
  bool open();
  void close();
  /// Recovers, sets the robot up and starts a motion in which it stands still. False: see reason().
  bool start();
  /// Brakes the robot and ends the motion.
  void stop();
  /// One exchange with the hand, up to its state `id`. For simulated robots, whose clock waits.
  void serve_hand(std::uint32_t id);

  // --- control thread; nothing waits, locks or allocates ---
  /// The newest command: rad, or rad/s for a motion by velocities. Without `move` the robot comes to rest.
  void command(bool move, const Seven& joints) noexcept;
  void hand_wish(const HandWish& wish) noexcept { wishes_.write(wish); }

  /// Hz of the robot.
  double rate() const { return 1000; }
  /// Of the interface; valid after open().
  int version() const { return version_; }

 private:
  struct Wanted {
    bool move = false;
    std::uint64_t id = 0;  ///< of the state that the loop had read
    Seven joints{};
  };

  // how it begins and ends; link_setup.cpp
  bool connect();
  int bind_states(const std::string& address);
  bool await_first_state();
  std::optional<Status> request(Request what, const Data& data);
  bool set(Request what, const Data& data);
  bool recover();
  void await_newest_state();
  bool check_mode();
  bool set_up_robot();
  bool begin_motion();
  bool refuse_motion(Status status);
  void give_up_start();
  bool open_hand();
  void run_hand();

  // the thread of states and replies; link.cpp
  void run();
  void wait(Nanoseconds now);
  void begin_session(Nanoseconds now);
  void take_replies();
  void take_states(Nanoseconds now);
  bool is_robot(const wire::UdpAddress& from);
  void take_state(const RobotState& state, Nanoseconds now);
  void judge_motion();
  void explain_end();
  void end_with(Status status);
  void note_errors();
  void answer(Nanoseconds now);
  void take_command(Nanoseconds now);
  void go_on();
  Seven target_of(const Wanted& wanted) noexcept;
  void fit_limits(const Seven& wanted) noexcept;
  bool allowed(const Seven& wanted);
  double stopping_way(std::size_t joint, double velocity) const noexcept;
  void brake();
  void hold();
  void send(const Seven& joints, bool finished = false);
  void judge(Nanoseconds now);
  void end(Nanoseconds now);
  bool by_velocity() const noexcept { return settings_.generator == Generator::joint_velocity; }
  bool shaper_still() const noexcept { return by_velocity() ? velocities_.still() : shaper_.still(); }
  bool brakes() const noexcept { return phase_ == Phase::ending || fault_; }
  bool is_open() const noexcept { return answered_ != current_.sequence; }
  /// The robot carries out the motion of this link.
  bool moves() const noexcept {
    return current_.state.mode == RobotMode::move && current_.state.generator == settings_.generator;
  }

  LinkSettings settings_;
  int version_ = kNewestVersion;
  Port port_;
  Descriptor states_;
  std::uint32_t robot_host_ = 0;  // network byte order
  std::string own_address_;

  std::mutex hand_mutex_;  // the hand and its wish; never the control thread's of a real robot
  Hand hand_;
  bool hand_open_ = false;
  Descriptor hand_wake_;
  HandWish hand_wish_;

  realtime::Latest<Wanted> commands_;
  realtime::Latest<HandWish> wishes_;

  std::atomic<bool> over_{false};  // the robot ended the motion
  std::atomic<std::uint64_t> states_seen_{0};
  std::atomic<RobotMode> mode_{RobotMode::idle};
  std::string stranger_;                    // address of another sender; with mutex_
  ErrorFlags errors_;                       // of the newest state; with mutex_
  std::map<std::uint32_t, Frame> replies_;  // with mutex_
  std::optional<std::uint32_t> motion_;     // id of the request; with mutex_
  std::optional<Status> motion_reply_;      // the newest one; with mutex_

  // the thread of states
  Sample current_;
  wire::ShaperOf<7> shaper_;
  VelocityShaper velocities_;
  wire::AxisLimitsOf<7> limits_;
  wire::UdpAddress sender_;
  bool pinned_ = false;     ///< sender_ is known
  bool port_lost_ = false;  ///< the connection for requests is of no use
  bool commanded_ = false;  ///< the loop has commanded in this session
  bool late_ = false;       ///< what is behind was lost while no command came
  bool anchored_ = false;   ///< offset_ belongs to the last command
  Seven offset_{}, last_{};
  std::uint64_t answered_ = 0, answers_ = 0;
  int puzzled_ = 0;  ///< states since the motion ended for no known reason
  Nanoseconds heard_ = 0, commanded_at_ = 0, ending_since_ = 0;

  std::thread thread_, hand_thread_;
};

}  // namespace polyarm::franka
