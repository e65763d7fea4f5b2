#include "drivers/xarm/setup.hpp"

#include <fmt/format.h>

#include <array>

#include "drivers/wire/six_axes.hpp"
#include "drivers/xarm/moves.hpp"
#include "drivers/xarm/ux_port.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::xarm {

namespace {

constexpr int kCounted = 20;  // reports for their rate
constexpr double kLeastRate = 50;

class Setup {
 public:
  explicit Setup(SetupOptions& options) : o_(options) {}
  bool run() {
    const bool commands = look_at_commands();
    const bool reports = commands && look_at_settings() && look_at_rate();
    say_steps();
    const bool fine = commands && reports && fine_;
    o_.say(fine ? "Everything that can be seen from here is ready."
                : "Not everything is ready: see above. Then run this again.");
    return fine;
  }

 private:
  bool wrong(Cause cause, int detail = 0, const std::string& text = {}) {
    o_.say("  " + sentence(cause, detail, "the controller at " + o_.host, text));
    return false;
  }
  bool look_at_commands() {
    o_.say(fmt::format("Looking for the controller at {}:{} …", o_.host, o_.command_port));
    UxPort port(o_.host, o_.command_port);
    const auto failed = [&] { return wrong(port.failure().cause, 0, port.failure().text); };
    if (!port.open(o_.timeout)) return failed();
    const auto answer = port.ask(Register::version, {}, o_.timeout);
    if (!answer) return failed();
    const Version version = parse_version(answer->data);
    o_.say(fmt::format("  found: an arm with {} axes (type {}), firmware {}", version.axes, version.type,
                       version.firmware()));
    const UxMoveForms forms = forms_of(version);
    o_.say(version.axes != 6 ? "  forward mode: no, it is for arms with six axes"
           : forms.joint_radius
               ? "  forward mode: yes"
               : "  forward mode: yes, but joint moves stop at corners; update the firmware to 1.5.20");
    if (std::pair(version.major, version.minor) < std::pair(kLeastMajor, kLeastMinor))
      fine_ = wrong(Cause::old_firmware, 0, version.firmware());
    const auto codes = port.ask(Register::get_error, {}, o_.timeout);
    if (!codes || codes->data.size() < 2) return codes ? wrong(Cause::bad_data) : failed();
    const int error = codes->data[0], warning = codes->data[1];
    if (error != 0) fine_ = wrong(cause_of_error(error), error);
    if (warning != 0) o_.say(fmt::format("  warning W{}: {}", warning, warning_words(warning)));
    return true;
  }
  /// The next report of a port; nothing after the timeout.
  std::optional<std::vector<std::uint8_t>> next_report(int socket, ReportReader& reader) {
    const Nanoseconds deadline = realtime::monotonic_now() + o_.timeout;
    std::array<std::uint8_t, 2048> buffer;
    for (;;) {
      if (auto report = reader.next()) return report;
      const Nanoseconds left = deadline - realtime::monotonic_now();
      if (left <= 0 || !wire::wait_readable(socket, left)) return std::nullopt;
      const wire::Received got = wire::receive(socket, buffer);
      if (got.got == wire::Got::nothing) continue;
      if (got.got != wire::Got::bytes || !reader.feed(Bytes(buffer).first(got.count))) return std::nullopt;
    }
  }
  bool look_at_settings() {
    std::string why;
    const Descriptor socket = wire::connect_tcp(o_.host, o_.rich_port, o_.timeout, why);
    if (!socket) return wrong(Cause::unreachable, 0, why);
    ReportReader reader;
    const auto bytes = next_report(socket.number(), reader);
    if (!bytes) return wrong(Cause::report_silent);
    const auto report = decode_report(*bytes, ReportKind::rich);
    const auto slow = decode_slow_report(*bytes);
    if (!report || !slow) return wrong(Cause::bad_data);
    o_.say(fmt::format("  mode {}, state {}, motors {}", mode_words(static_cast<int>(report->mode)),
                       static_cast<int>(report->state), slow->enabled != 0 ? "on" : "off"));
    o_.say(fmt::format("  joints {:.3f} degrees", fmt::join(in_degrees(report->position), " ")));
    o_.say(fmt::format("  tool: offset {:.1f} mm, load {:.3f} kg at {:.1f} mm",
                       fmt::join(slow->tcp_offset.begin(), slow->tcp_offset.begin() + 3, " "), slow->load,
                       fmt::join(slow->load_centre, " ")));
    o_.say(fmt::format("  sensitivity to collisions {} of 5{}", slow->collision_sensitivity,
                       slow->collision_sensitivity == 0 ? ": switched off; switch it on" : ""));
    if (slow->collision_sensitivity == 0) fine_ = false;
    if (report->state == State::moving) fine_ = wrong(Cause::moves);
    return true;
  }
  static Seven in_degrees(Seven radians) {
    for (double& one : radians) one *= wire::kDegrees;
    return radians;
  }
  bool look_at_rate() {
    std::string why;
    const Descriptor socket = wire::connect_tcp(o_.host, o_.real_port, o_.timeout, why);
    if (!socket) return wrong(Cause::unreachable, 0, why);
    ReportReader reader;
    Nanoseconds first = 0;
    for (int i = 0; i <= kCounted; ++i) {
      if (!next_report(socket.number(), reader)) return wrong(Cause::report_silent);
      if (i == 0) first = realtime::monotonic_now();
    }
    const double rate = kCounted / seconds(realtime::monotonic_now() - first);
    o_.say(
        fmt::format("  reports for motion: {:.0f} a second{}", rate,
                    rate < kLeastRate ? ", fewer than the 100 that the maker names: check the network" : ""));
    return true;
  }
  void say_steps() {
    o_.say("In UFACTORY Studio:");
    o_.say("  - a fixed address in the network of this computer (192.168.1.x at delivery)");
    o_.say("  - TCP payload, TCP offset and mounting, as the tool is; sensitivity to collisions 3 to 5");
    o_.say("  - manual mode off; no program running; close its live control while the driver is active");
  }

  SetupOptions& o_;
  bool fine_ = true;
};

}  // namespace

bool set_up(SetupOptions options) {
  return Setup(options).run();
}

}  // namespace polyarm::xarm
