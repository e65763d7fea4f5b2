#include <fmt/format.h>
#include <poll.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <deque>

#include "apps/options.hpp"
#include "apps/setups.hpp"
#include "drivers/dynamixel/family.hpp"
#include "drivers/dynamixel/protocol2.hpp"
#include "drivers/feetech/family.hpp"
#include "drivers/feetech/protocol0.hpp"
#include "drivers/servo_bus/commissioning.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

constexpr const char* kSo101Joints = "shoulder_pan,shoulder_lift,elbow_flex,wrist_flex,wrist_roll,gripper";

/// Asks questions at the terminal; takes answers from --answer first.
class Terminal : public servo_bus::Dialogue {
 public:
  explicit Terminal(const std::vector<std::string>& answers) : answers_(answers.begin(), answers.end()) {}
  void say(const std::string& text) override {
    fmt::print("{}\n", text);
    std::fflush(stdout);
  }
  std::string ask(const std::string& question, const std::function<void()>& meanwhile) override {
    fmt::print("{}: ", question);
    std::fflush(stdout);
    if (!answers_.empty()) {
      const std::string answer = answers_.front();
      answers_.pop_front();
      if (meanwhile) meanwhile();
      fmt::print("{}\n", answer);
      return answer;
    }
    pollfd in{STDIN_FILENO, POLLIN, 0};
    while (meanwhile && ::poll(&in, 1, 5) == 0) meanwhile();
    std::string answer;
    for (int c = std::fgetc(stdin); c != '\n'; c = std::fgetc(stdin)) {
      if (c == EOF)
        throw Error("no-answer", "no answer to: " + question,
                    "run this in a terminal, or give answers with --answer");
      answer += static_cast<char>(c);
    }
    return answer;
  }

 private:
  std::deque<std::string> answers_;
};

struct SetupArguments {
  std::string family, restore, joints;
  servo_bus::CommissioningOptions options;
  std::vector<std::string> answers;
  bool scan = false, check = false, back_up = false;
  double timeout_ms = 5;
};

int run(const SetupArguments& a) {
  const bool feetech = a.family == "feetech";
  const servo_bus::Family& family = feetech ? feetech::sts_family() : dynamixel::x_family();
  const auto protocol = [feetech]() -> std::unique_ptr<servo_bus::Protocol> {
    if (feetech) return std::make_unique<feetech::Protocol0>();
    return std::make_unique<dynamixel::Protocol2>();
  };
  Terminal terminal(a.answers);
  servo_bus::Commissioning setup(family, protocol, a.options, terminal);
  if (a.scan) return setup.find().empty() ? kFailed : kOk;
  if (!a.restore.empty()) {
    setup.restore(a.restore);
    return kOk;
  }
  if (!a.check && !a.back_up) setup.assign_ids();
  setup.find();
  if (!setup.check()) {
    fmt::print(stderr, "some checks failed: see above\n");
    return kFailed;
  }
  if (a.check) return kOk;
  setup.back_up();
  if (!a.back_up) setup.calibrate();
  return kOk;
}
}  // namespace

int run_setup(int argc, char** argv) {
  const auto is_device = [](const char* text) { return text[0] != '-'; };
  char** const device = std::find_if(argv + 1, argv + argc, is_device);
  if (device != argv + argc && std::string(*device) == "abb") return run_setup_abb(argc, argv);
  if (device != argv + argc && std::string(*device) == "kuka") return run_setup_kuka(argc, argv);
  if (device != argv + argc && std::string(*device) == "yaskawa") return run_setup_yaskawa(argc, argv);
  if (device != argv + argc && std::string(*device) == "xarm") return run_setup_xarm(argc, argv);
  if (device != argv + argc && std::string(*device) == "franka") return run_setup_franka(argc, argv);
  if (device != argv + argc && std::string(*device) == "cia402") return run_setup_cia402(argc, argv);
  CommandLine app("Sets up the servos of an arm: port, ids, check, backup, ranges and zero", "polyarm setup");
  SetupArguments a;
  app.add_option(
         "device", a.family,
         "feetech, dynamixel, abb, kuka, yaskawa, xarm, franka or cia402; see also `polyarm setup abb "
         "--help`")
      ->required()
      ->one_of({"feetech", "dynamixel", "abb", "kuka", "yaskawa", "xarm", "franka", "cia402"});
  app.add_option("--port", a.options.port, "serial port; without it every port is searched");
  app.add_option("--baud", a.options.baud, "only this rate; default: all rates of the servos");
  app.add_option("--joints", a.joints,
                 "names from base to tip, separated by commas; ids follow from 1 (feetech: those of SO-101)");
  a.options.calibration = "calibration.yaml";
  a.options.backup = "servo_backup.yaml";
  app.add_option("--calibration", a.options.calibration,
                 "the file that the driver reads, and from which setup continues")
      ->capture_default_str();
  app.add_option("--backup", a.options.backup, "file for a copy of the registers, made before any change")
      ->capture_default_str();
  auto* scan = app.add_flag("--scan", a.scan, "only list the servos that answer");
  auto* check = app.add_flag("--check", a.check, "only check that all joints answer without a fault");
  auto* back_up = app.add_flag("--back-up", a.back_up, "only check and save the registers");
  auto* restore = app.add_option("--restore", a.restore, "write a backup back");
  scan->excludes(check)->excludes(back_up)->excludes(restore);
  check->excludes(back_up)->excludes(restore);
  back_up->excludes(restore);
  app.add_option("--highest-id", a.options.highest_id, "look for ids up to this one");
  app.add_option("--answer-timeout-ms", a.timeout_ms, "how long a servo may take to answer")
      ->range(1.0, 10000.0)
      ->capture_default_str();
  app.add_option("--answer", a.answers, "answer to a question, in order; may be repeated");
  app.footer(examples({"polyarm setup feetech --scan", "polyarm setup feetech --calibration so101.yaml",
                       "polyarm setup dynamixel --joints waist,shoulder,elbow,wrist --baud 1000000",
                       "polyarm setup feetech --restore servo_backup.yaml"}) +
             "\nSetup moves no joint. It switches the torque off after a yes, and never on.\n");
  if (const auto code = app.parse(argc, argv)) return *code;
  if (a.joints.empty() && a.family == "feetech") a.joints = kSo101Joints;
  if (a.joints.empty() && !a.scan && a.restore.empty()) {
    fmt::print(stderr, "polyarm setup: name the joints with --joints base,shoulder,… from base to tip\n");
    return kUsage;
  }
  a.options.joints = split_words(a.joints, ", ");
  a.options.answer_timeout = nanoseconds(a.timeout_ms / 1000);
  return run(a);
}

}  // namespace polyarm::apps
