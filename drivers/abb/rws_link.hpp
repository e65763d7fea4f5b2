#pragma once
/// What every link to an ABB controller does over Robot Web Services: version, panel, motors and the program
/// before its robot moves, states and signals while it is open, and why the robot stopped.
#include <array>
#include <atomic>
#include <string>
#include <thread>
#include <vector>

#include "drivers/abb/rws.hpp"
#include "drivers/abb/words.hpp"
#include "drivers/wire/link_base.hpp"
#include "drivers/wire/shaper.hpp"

namespace polyarm::abb {

inline constexpr std::size_t kMostSignals = 32;

/// What Robot Web Services show.
struct Panel {
  enum class Control : std::uint8_t { other, motors_on, motors_off, guard_stop, emergency_stop, failure };
  Control control = Control::other;
  bool automatic = false, running = false;
  double speed_ratio = 1;
  std::array<bool, kMostSignals> inputs{}, outputs{};
  wire::Six joints{};  ///< rad, while EGM is silent
  std::uint64_t count = 0;
};

/// NaN: stays as it is.
struct Outputs {
  std::array<double, kMostSignals> digital;
  double speed_ratio;
  Outputs() noexcept;
};

struct ControllerSettings {
  RwsSettings rws;
  std::string task = "T_ROB1";
  std::vector<std::string> inputs, outputs;  ///< names of signals
  bool motors_on = true;                     ///< activating may switch the motors on
};

/// A thread of its own asks for states and signals. The derived class halts it before it ends.
class RwsLink : public wire::LinkBase<Cause> {
 public:
  /// Asks for states and signals once, and writes what changed. For simulated controllers, whose clock waits.
  void serve_services();
  /// Control thread; nothing waits, locks or allocates.
  void outputs(const Outputs& outputs) noexcept { outputs_.write(outputs); }

  /// Valid after connecting.
  const RwsIdentity& identity() const { return identity_; }
  std::string fingerprint() const { return fingerprint_; }

 protected:
  /// What made the robot stop, as the program's own wire shows it.
  enum class Sign : std::uint8_t { none, motors, program, egm, error, silence, restart };

  /// `stepped`: rounds only in serve_services().
  RwsLink(ControllerSettings settings, bool stepped, Nanoseconds start_timeout);
  ~RwsLink() = default;

  // Each of these returns false if the link is refused, with its cause. The caller holds rws_mutex_.
  bool refuse_rws();
  bool connect_services();
  /// The first reading of states and signals, which is shown.
  bool read_first();
  /// What a person has to change first; motors are switched on, and a program that runs is stopped.
  bool check_panel();
  /// The program begins at its main; `forever`: it begins again whenever it ends.
  bool begin_program(bool forever);
  /// The event log first, then `otherwise`.
  bool refuse_why(Cause otherwise, const std::string& text = {});
  /// What was wanted and seen before counts no more.
  bool begin_services();
  /// What the controller itself says first, then its event log, then what `sign` showed.
  Rws::Failure find_why(Sign sign);

  void read_states_next() { round_ = 0; }
  void run_service_thread();
  void halt_service_thread();
  /// The services shall say why the robot stopped, and note it. Any thread.
  void ask_why(Sign sign);

  /// The joints come over another wire now.
  virtual bool guided() const = 0;
  virtual void show(const Panel& panel) = 0;
  /// When the controller does not say why.
  virtual Cause vague_cause() const = 0;

  std::recursive_timed_mutex
      rws_mutex_;  // the client, and what belongs to it; never the control thread's, nor that of motion
  Rws rws_;
  Panel current_panel_;
  bool open_ = false;             ///< states and signals may be asked for
  std::uint32_t controller_ = 0;  ///< its address, network byte order
  std::atomic<Sign> asked_{Sign::none};

 private:
  bool switch_motors_on();
  bool read_all();
  bool read_signals(Panel& panel);
  bool write_outputs();
  void run_services();
  void serve_round();
  void say_why();

  ControllerSettings controller_settings_;
  bool stepped_;
  Nanoseconds start_timeout_;
  Descriptor services_wake_;
  RwsIdentity identity_;
  std::string fingerprint_;
  long seen_event_ = 0;
  Outputs wanted_, written_;
  int round_ = 0, failures_ = 0;
  realtime::Latest<Outputs> outputs_;
  std::atomic<bool> services_quit_{false};
  std::thread services_;
};

}  // namespace polyarm::abb
