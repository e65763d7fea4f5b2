#include "drivers/yaskawa/setup.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "drivers/yaskawa/hses.hpp"
#include "drivers/yaskawa/inform.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::yaskawa {

namespace {

constexpr const char* kMakersAddress = "192.168.255.1";
constexpr int kWatchdog_ms = 600;

class Setup {
 public:
  explicit Setup(SetupOptions& options) : o_(options) {}
  bool run() {
    if (!o_.folder.empty()) write_files();
    const bool hses = look_at_hses(), moto = o_.forward ? hses && look_at_robot() : look_at_moto();
    if (o_.forward)
      say_forward_steps();
    else
      say_steps();
    o_.say(hses && moto ? "Everything that can be seen from here is ready."
                        : "Not everything is ready: see above. Then run this again.");
    return hses && moto;
  }

 private:
  void write_files() {
    const std::filesystem::path folder(o_.folder);
    std::filesystem::create_directories(folder);
    const auto write = [&](const char* name, const std::string& text) {
      write_file_atomically(folder / name, text);
      o_.say("  written: " + (folder / name).string());
    };
    if (!o_.forward) return write("INIT_ROS.JBI", init_ros_job());
    write("POLYARM.JBI", moves_job());
    write("LADDER.TXT", ladder_text(kWatchdog_ms));
  }
  bool wrong(Cause cause, int detail = 0, const std::string& text = {}) {
    o_.say("  " + sentence(cause, detail, "the controller at " + o_.host, text));
    return false;
  }
  bool look_at_hses() {
    o_.say(fmt::format("Looking for the Ethernet server at {}:{} (UDP) …", o_.host, o_.hses_port));
    Hses hses(o_.host, o_.hses_port, o_.timeout);
    const auto status = hses.open() ? hses.status() : std::nullopt;
    if (!status) return wrong(hses.failure().cause, hses.failure().detail, hses.failure().text);
    const std::string version = hses.system(kFirstRobot, 1), model = hses.system(kFirstRobot, 2);
    o_.say(fmt::format("  found: {}, software {}", model.empty() ? "no model" : model,
                       version.empty() ? "unknown" : version));
    o_.say(fmt::format("  mode {}, remote {}, servos {}, {}", status->teach ? "teach" : "play",
                       status->remote ? "yes" : "no", status->servo ? "on" : "off",
                       status->running ? "a job runs" : "no job runs"));
    bool fine = true;
    if (status->alarm || status->error) {
      const auto alarm = hses.alarm();
      const int code = alarm ? static_cast<int>(alarm->code) : 0;
      fine = wrong(status->alarm ? Cause::alarm : Cause::error, code, alarm ? alarm->name : "");
    }
    if (status->holds()) fine = wrong(Cause::hold, status->pendant_hold ? 1 : status->external_hold ? 2 : 3);
    if (status->teach) fine = wrong(Cause::teach_mode);
    if (!status->teach && !status->remote) fine = wrong(Cause::not_remote);
    return fine;
  }
  /// The first state shows group and byte order.
  bool read_state(MotoPort& state, std::optional<MotoFeedback>& feedback, std::optional<MotoStatus>& status) {
    const Nanoseconds deadline = realtime::monotonic_now() + o_.timeout;
    while (!status || !feedback) {
      if (!state.receive()) return wrong(state.failure().cause);
      while (const auto message = state.next()) {
        if (auto one = decode_feedback(*message, state.order()); one && one->group == o_.group)
          feedback = one;
        if (auto one = decode_status(*message, state.order())) status = one;
      }
      const Nanoseconds left = deadline - realtime::monotonic_now();
      if (left <= 0) return wrong(status ? Cause::no_group : Cause::state_silent, o_.group);
      if (!status || !feedback) wire::wait_readable(state.descriptor(), left);
    }
    return true;
  }
  bool look_at_moto() {
    o_.say(fmt::format("Looking for MotoROS at {}, TCP ports {}, {} and {} …", o_.host, o_.motion_port,
                       o_.state_port, o_.io_port));
    MotoPort state(o_.host, o_.state_port), motion(o_.host, o_.motion_port), io(o_.host, o_.io_port);
    if (!state.open(o_.timeout, std::nullopt)) return wrong(state.failure().cause, 0, state.failure().text);
    std::optional<MotoFeedback> feedback;
    std::optional<MotoStatus> status;
    if (!read_state(state, feedback, status)) return false;
    o_.say(fmt::format("  found: {}-endian, group {}, joints {:.4f} rad",
                       state.order() == ByteOrder::little ? "little" : "big", feedback->group,
                       fmt::join(feedback->position.begin(), feedback->position.begin() + 6, " ")));
    if (status->in_motion == 1) return wrong(Cause::moves);
    for (MotoPort* port : {&motion, &io})
      if (!port->open(o_.timeout, state.order()))
        return wrong(port->failure().cause, 0, port->failure().text);
    const auto ready = motion.control(MotoCommand::check_ready, o_.group, o_.timeout);
    if (!ready) return wrong(motion.failure().cause);
    if (ready->result == MotoResult::success) return true;
    const Why why = why_not(static_cast<int>(MotoResult::not_ready), ready->subcode);
    // The driver starts the job and switches servos on.
    if (why.cause == Cause::not_started || why.cause == Cause::servo_off) return true;
    return wrong(why.cause, why.cause == Cause::alarm ? status->alarm_code : why.detail);
  }
  /// What `pulses`, `tool_number` and `base_height` are compared with.
  bool look_at_robot() {
    Hses hses(o_.host, o_.hses_port, o_.timeout);
    const auto pulses = hses.open() ? hses.pulses() : std::nullopt;
    const auto pose = pulses ? hses.pose() : std::nullopt;
    if (!pose) return wrong(hses.failure().cause, hses.failure().detail, hses.failure().text);
    const auto& p = pulses->values;
    const auto& v = pose->values;
    o_.say(fmt::format("  axes S L U R B T: {} pulses", fmt::join(p.begin(), p.begin() + 6, " ")));
    o_.say(fmt::format(
        "  tool {} in base coordinates: x {:.3f}, y {:.3f}, z {:.3f} mm, Rx {:.4f}, Ry {:.4f}, Rz "
        "{:.4f} degrees",
        pose->tool, v[0] / 1e3, v[1] / 1e3, v[2] / 1e3, v[3] / 1e4, v[4] / 1e4, v[5] / 1e4));
    const auto shared = hses.doubles(SharedDoubles::first, SharedDoubles::count);
    if (!shared) return wrong(hses.failure().cause, hses.failure().detail, hses.failure().text);
    return true;
  }
  void say_forward_steps() {
    o_.say("At the pendant, in management mode or maintenance mode:");
    o_.say("  - load the job POLYARM.JBI; it needs P080 to P085, I080 to I087 and D080 to D087 for itself");
    o_.say("  - write the rungs of LADDER.TXT into the user part of the ladder");
    o_.say("  - enter the TCP of the cell into a tool file, and select that tool");
    o_.say("  - option function: Ethernet server on; a fixed address in the network of this computer");
    o_.say("  - allow command remote; turn the key to REMOTE for motion");
  }
  void say_steps() {
    o_.say("At the pendant, in management mode or maintenance mode:");
    o_.say("  - load MotoROS of ROS-Industrial for this controller, and allow MotoPlus applications");
    o_.say("  - load the job INIT_ROS; output 889 must go on when it waits, output 890 ends it");
    o_.say("  - option function: Ethernet server on; a fixed address in the network of this computer");
    o_.say("  - allow command remote; turn the key to REMOTE for motion");
  }

  SetupOptions& o_;
};

}  // namespace

std::string init_ros_job() {
  return "/JOB\r\n//NAME INIT_ROS\r\n//POS\r\n///NPOS 0,0,0,0,0,0\r\n//INST\r\n///DATE 2026/11/28 "
         "12:00\r\n///ATTR SC,RW\r\n///GROUP1 RB1\r\nNOP\r\n'POLYARM WAITS HERE FOR MOTOROS\r\nDOUT OT#(889) "
         "OFF\r\nDOUT OT#(890) OFF\r\nTIMER T=0.05\r\nDOUT OT#(889) ON\r\nWAIT OT#(890)=ON\r\nDOUT OT#(889) "
         "OFF\r\nDOUT OT#(890) OFF\r\nEND\r\n";
}

std::string ladder_text(int watchdog_ms) {
  return fmt::format(
      "The heartbeat of forward mode, for the user part of the ladder (concurrent I/O).\n"
      "\n"
      "The driver writes two network inputs: {0}1 is on while a session of moves is open, and {0}0 changes\n"
      "some ten times a second. The ladder holds the robot when {0}0 does not change any more. Before each\n"
      "session the driver tries this: without these rungs it starts nothing.\n"
      "\n"
      "  rung 1: timer A, {1:.1f} s, runs while {0}1 is on and {0}0 is on\n"
      "  rung 2: timer B, {1:.1f} s, runs while {0}1 is on and {0}0 is off\n"
      "  rung 3: timer A or timer B has run out: the system input EXTERNAL HOLD holds the robot;\n"
      "          whatever else gives that input stays as it is\n"
      "\n"
      "The numbers of the relays and of that system input are those of your controller: its manual of the\n"
      "concurrent I/O has them. On controllers before the YRC1000 network inputs begin elsewhere (often at\n"
      "25010): write their number here and in `heartbeat_byte`, without the last digit.\n",
      kHeartbeatByte, watchdog_ms / 1000.0);
}

bool set_up(SetupOptions options) {
  if (options.host.empty()) options.host = kMakersAddress;
  return Setup(options).run();
}

}  // namespace polyarm::yaskawa
