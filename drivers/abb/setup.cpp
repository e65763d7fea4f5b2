#include "drivers/abb/setup.hpp"

#include <filesystem>
#include <memory>

#include "polyarm/base/file.hpp"

namespace polyarm::abb {

namespace {

constexpr const char* kServicePort = "192.168.125.1";  // of every controller of ABB

class Setup {
 public:
  Setup(const SetupOptions& options, SetupTalk& talk) : options_(options), talk_(talk) {
    if (options_.host.empty()) options_.host = kServicePort;
  }
  bool run() {
    if (!find()) return false;
    bool fine = check_software();
    fine = check_panel() && fine;
    if (!options_.folder.empty()) write_files();
    fine = check_module() && fine;
    say_device();
    rws_->log_out();
    talk_.say(fine ? "Everything that can be seen from here is ready."
                   : "Not everything is ready: see above. Then run this again.");
    return fine;
  }

 private:
  std::string where() const { return "the controller at " + options_.host; }
  void say_failure() {
    const Rws::Failure& why = rws_->failure();
    talk_.say("  " + sentence(why.cause, why.detail, where(), why.text));
  }
  bool try_version(int version) {
    RwsSettings settings;
    settings.version = version;
    settings.http = {options_.host,   options_.port, version == 2, options_.user, options_.password, "",
                     options_.timeout};
    if (settings.http.port == 0) settings.http.port = version == 2 ? 443 : 80;
    rws_ = std::make_unique<Rws>(settings);
    return rws_->identify(identity_);
  }
  bool find() {
    for (const int version : {2, 1}) {
      if (options_.rws != 0 && options_.rws != version) continue;
      talk_.say("Looking for Robot Web Services " + std::to_string(version) + " at " + options_.host + " …");
      if (try_version(version)) {
        talk_.say("  found: RobotWare " + identity_.software + "; write `rws: " + std::to_string(version) +
                  "`");
        if (!rws_->http().fingerprint().empty())
          talk_.say("  certificate: write `fingerprint: " + rws_->http().fingerprint() + "`");
        return true;
      }
      say_failure();
      if (rws_->failure().cause == Cause::login) return false;
    }
    return false;
  }
  bool check_software() {
    if (!identity_.recent()) talk_.say("  " + sentence(Cause::old_software, 0, where(), identity_.software));
    if (options_.forward) return identity_.recent();
    if (!identity_.guided()) talk_.say("  " + sentence(Cause::no_option, 0, where(), ""));
    if (identity_.recent() && identity_.guided()) talk_.say("  Externally Guided Motion is installed");
    return identity_.recent() && identity_.guided();
  }
  bool check_panel() {
    RwsState state;
    if (!rws_->read_state(state)) return say_failure(), false;
    talk_.say("  mode " + state.mode + ", " + state.control + ", the program is " + state.program);
    const Cause cause = cause_of_state(state.control, state.mode);
    if (cause == Cause::none || cause == Cause::motors_off) return true;
    talk_.say("  " + sentence(cause, 0, where(), ""));
    return false;
  }
  std::string module() const { return options_.forward ? kMovesModule : kModuleName; }
  std::string module_file() const { return options_.forward ? kMovesFile : kModuleFile; }
  std::string module_text() const {
    return options_.forward ? rapid_moves_module(rws_->http().peer_address(), options_.moves_port)
                            : rapid_module(options_.rapid);
  }
  bool check_module() {
    if (rws_->has_module(options_.task, module()))
      talk_.say("  the module " + module() + " is loaded in " + options_.task);
    else if (!say_missing() || !options_.install)
      return false;
    return !options_.install || install_module();
  }
  /// False: it is not known.
  bool say_missing() {
    const bool missing = rws_->failure().cause == Cause::no_module;
    if (missing && options_.forward)
      talk_.say("  " + sentence(Cause::no_moves_module, 0, where(), options_.task));
    else
      say_failure();
    return missing;
  }
  /// It replaces one of the same name.
  bool install_module() {
    const std::string other = options_.forward ? kModuleName : kMovesModule;
    if (rws_->has_module(options_.task, other)) {
      talk_.say("  the module " + other + " is loaded in " + options_.task +
                ": unload it first, because each of them has a main");
      return false;
    }
    if (rws_->failure().cause != Cause::no_module) return say_failure(), false;
    if (!talk_.agree("Write " + module_file() + " to the controller and load it into " + options_.task +
                     "? Its main() must be the only one there"))
      return false;
    if (!rws_->put_file(module_file(), module_text()) || !rws_->load_module(options_.task, module_file()))
      return say_failure(), false;
    talk_.say("  loaded");
    return true;
  }
  void write_files() {
    const std::filesystem::path folder = options_.folder;
    std::filesystem::create_directories(folder);
    write_file_atomically(folder / module_file(), module_text());
    if (options_.forward) return talk_.say("  written: " + (folder / module_file()).string());
    write_file_atomically(folder / "Polyarm_SIO.cfg",
                          device_text(rws_->http().own_address(), options_.egm_port));
    talk_.say("  written: " + (folder / kModuleFile).string() + ", " + (folder / "Polyarm_SIO.cfg").string());
  }
  void say_device() {
    if (options_.forward)
      return talk_.say(
          "The module listens at " + rws_->http().peer_address() + ", TCP port " +
          std::to_string(options_.moves_port) +
          ". IRC5: sockets need the option 616-1 PC Interface. OmniCore: enable RapidSockets for "
          "this network (configuration topic Communication, Firewall Manager).");
    talk_.say(
        "On the controller, configuration topic Communication (RobotWare 6: UDPUC in Transmission Protocol; "
        "RobotWare 7: UDPUC Device), there must be: Name " +
        std::string(kDeviceName) + ", Remote Address " + rws_->http().own_address() + ", Remote Port " +
        std::to_string(options_.egm_port) + ". Restart the controller after a change.");
  }

  SetupOptions options_;
  SetupTalk& talk_;
  std::unique_ptr<Rws> rws_;
  RwsIdentity identity_;
};

}  // namespace

bool set_up(const SetupOptions& options, SetupTalk& talk) {
  return Setup(options, talk).run();
}

}  // namespace polyarm::abb
