#include "drivers/kuka/setup.hpp"

#include <fmt/format.h>

#include <filesystem>

#include "drivers/kuka/eki.hpp"
#include "drivers/wire/udp.hpp"
#include "polyarm/base/file.hpp"

namespace polyarm::kuka {

namespace {

constexpr const char* kKli = "172.31.1.147";  // as the maker delivers it

class Setup {
 public:
  explicit Setup(SetupOptions& options)
      : o_(options), eki_(options.host, options.krl.eki_port, options.timeout) {}
  bool run() {
    find_own_address();
    if (!o_.folder.empty()) write_files();
    o_.say("Looking for PolyarmEki at " + o_.host + ":" + std::to_string(o_.krl.eki_port) + " …");
    const bool fine = look();
    say_network();
    o_.say(fine ? "Everything that can be seen from here is ready."
                : "Not everything is ready: see above. Then run this again.");
    return fine;
  }

 private:
  void find_own_address() {
    if (!o_.krl.own_address.empty()) return;
    std::string why;
    const Descriptor probe = wire::connect_udp(o_.rsi_host, o_.krl.rsi_port, why);
    if (probe) o_.krl.own_address = wire::local_address(probe.number());
    if (!o_.krl.own_address.empty()) return;
    o_.krl.own_address = "address.of.this.computer";
    o_.say("  no network interface reaches " + o_.rsi_host + ": write this computer's address with --own");
  }
  void write_files() {
    for (const KrlFile& file : krl_files(o_.krl)) {
      const auto folder = std::filesystem::path(o_.folder) / file.folder;
      std::filesystem::create_directories(folder);
      write_file_atomically(folder / file.name, file.text);
      o_.say("  written: " + (folder / file.name).string());
    }
  }
  bool wrong(Cause cause, int detail = 0, const std::string& text = {}) {
    o_.say("  " + sentence(cause, detail, "the controller at " + o_.host, text));
    return false;
  }
  bool look() {
    const auto reply = eki_.open() ? eki_.ask(EkiDo::state) : std::nullopt;
    if (!reply) return wrong(eki_.failure().cause, 0, eki_.failure().text);
    const EkiIdentity& i = reply->identity;
    if (i.version != kProgramVersion) return wrong(Cause::program_version, i.version);
    o_.say(fmt::format(
        "  found: {}, RSI {} with a cycle of {} ms, {} corrections up to {:g} degrees, which "
        "ends after {} late answers",
        i.robot, i.rsi, i.cycle_ms, i.relative ? "relative" : "absolute", i.correction_limit, i.late_limit));
    bool fine = true;
    if (i.rsi < 3) fine = wrong(Cause::old_rsi, i.rsi);
    if (i.axes != 6) fine = wrong(Cause::axes, i.axes);
    return check_panel(reply->state) && fine;
  }
  bool check_panel(const EkiState& s) {
    constexpr const char* kModes[] = {"", "T1", "T2", "AUT", "EXT"};
    o_.say(fmt::format("  mode {}, drives {}, override {} %", kModes[static_cast<std::size_t>(s.mode)],
                       s.drives ? "on" : "off", s.speed_override));
    bool fine = true;
    if (s.emergency_stop) fine = wrong(Cause::emergency_stop);
    if (s.guard_stop) fine = wrong(Cause::guard_stop);
    if (s.mode < OperatingMode::automatic) fine = wrong(Cause::manual_mode, static_cast<int>(s.mode));
    if (s.message) fine = wrong(Cause::message);
    return fine;
  }
  void say_network() {
    o_.say(
        fmt::format("PolyarmRsi.xml must name IP_NUMBER {} and PORT {}; a firewall of this computer must "
                    "let UDP in there.",
                    o_.krl.own_address, o_.krl.rsi_port));
  }

  SetupOptions& o_;
  Eki eki_;
};

}  // namespace

bool set_up(SetupOptions options) {
  if (options.host.empty()) options.host = kKli;
  if (options.rsi_host.empty()) options.rsi_host = options.host;
  return Setup(options).run();
}

}  // namespace polyarm::kuka
