#include <fmt/format.h>

#include <cstdio>

#include "apps/options.hpp"
#include "apps/setups.hpp"
#include "drivers/abb/setup.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

/// The terminal; `yes` answers every question.
class AbbTalk : public abb::SetupTalk {
 public:
  explicit AbbTalk(bool yes) : yes_(yes) {}
  void say(const std::string& text) override {
    fmt::print("{}\n", text);
    std::fflush(stdout);
  }
  bool agree(const std::string& question) override {
    fmt::print("{} (yes/no): ", question);
    std::fflush(stdout);
    std::string answer = yes_ ? "yes" : "";
    if (yes_) fmt::print("yes\n");
    for (int c = yes_ ? '\n' : std::fgetc(stdin); c != '\n' && c != EOF; c = std::fgetc(stdin))
      answer += static_cast<char>(c);
    return answer == "yes";
  }

 private:
  bool yes_;
};

}  // namespace

int run_setup_abb(int argc, char** argv) {
  CommandLine app(
      "Looks at a controller of ABB and offers the RAPID module that the driver needs; nothing moves",
      "polyarm setup");
  abb::SetupOptions o;
  std::string device, password_file, motion = "stream";
  bool yes = false;
  app.add_option("device", device, "abb")->required()->one_of({"abb"});
  app.add_option("--host", o.host,
                 "address of the controller; without it that of its service port, 192.168.125.1");
  app.add_option("--rws", o.rws, "Robot Web Services: 1 (IRC5) or 2 (OmniCore); without it both are tried")
      ->range(0, 2);
  app.add_option("--rws-port", o.port, "of Robot Web Services; without it 443 or 80")->range(0, 65535);
  app.add_option("--user", o.user, "of Robot Web Services")->capture_default_str();
  app.add_option("--password-file", password_file,
                 "file with the password; without it the maker's default one");
  app.add_option("--task", o.task, "RAPID task of the robot")->capture_default_str();
  app.add_option("--motion", motion,
                 "stream: the module PolyarmEGM; forward: PolyarmMoves, whose moves the controller makes")
      ->one_of({"stream", "forward"})
      ->capture_default_str();
  app.add_option("--moves-port", o.moves_port, "forward: TCP port where PolyarmMoves listens")
      ->range(1, 65535)
      ->capture_default_str();
  app.add_option("--egm-port", o.egm_port, "UDP port of this computer for EGM")
      ->range(1, 65535)
      ->capture_default_str();
  app.add_option("--sampling", o.rapid.sampling_ms, "ms, of EGM; a multiple of 4")
      ->range(4, 48)
      ->capture_default_str();
  app.add_option("--max-speed", o.rapid.max_speed, "degrees/s, the highest speed that EGM lets a joint have")
      ->range(0.1, 1000.0)
      ->capture_default_str();
  app.add_option("--write", o.folder, "a folder for the RAPID module and the device's configuration");
  app.add_flag("--install", o.install, "loads the module into the controller, after a question");
  app.add_flag("--yes", yes, "answers the question with yes");
  app.footer(examples({"polyarm setup abb --host 192.168.1.10 --write abb_files",
                       "polyarm setup abb --host 192.168.1.10 --install",
                       "polyarm setup abb --host 192.168.1.10 --motion forward --install"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  if (!password_file.empty()) o.password = std::string(trim(read_file(password_file)));
  o.forward = motion == "forward";
  AbbTalk talk(yes);
  return abb::set_up(o, talk) ? kOk : kFailed;
}

}  // namespace polyarm::apps
