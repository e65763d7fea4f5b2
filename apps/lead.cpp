/// Holds the clutch of a leader and its follower while a key is held.
#include <fmt/format.h>

#include <chrono>
#include <optional>
#include <string>

#include "apps/client.hpp"
#include "apps/keyboard.hpp"
#include "apps/options.hpp"
#include "apps/terminal.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {
using Clock = std::chrono::steady_clock;

constexpr std::chrono::milliseconds kAskEvery{50};
constexpr double kValid = 0.3;  // s, of one request

struct LeadArguments {
  ClientOptions client;
  std::string pair;
  double first = 0.7, hold = 0.3;  // s
};

class Lead {
 public:
  Lead(Client& client, const LeadArguments& a) : client_(client), a_(a) {}

  void run() {
    fmt::print("hold the space bar to lead, release it to stop; Ctrl-C ends\n");
    while (!Keyboard::ended()) {
      for (const char key : Keyboard::wait(kAskEvery)) take(key);
      if (held_ && Clock::now() >= until_) held_ = false;
      const bool released = !held_ && sent_;
      ask(held_ ? std::optional(kValid) : released ? std::optional(0.0) : std::nullopt);
      sent_ = held_;
    }
    if (sent_) ask(0);
  }

 private:
  void take(char key) {
    if (key == '\x03' || key == '\x04' || key == '\x1c') Keyboard::end();
    // The first repeat of a key comes late, the others follow quickly.
    until_ = Clock::now() + std::chrono::duration_cast<Clock::duration>(
                                std::chrono::duration<double>(held_ ? a_.hold : a_.first));
    held_ = key == ' ';
  }

  /// Holds the clutch, releases it (0), or only looks.
  void ask(std::optional<double> hold) {
    Json request{{"request", "teleop"}};
    if (hold) request["hold"] = *hold;
    if (!a_.pair.empty()) request["pair"] = a_.pair;
    const Json pairs = client_.ask(request)["pairs"];
    if (pairs.size() != 1)
      throw Error("which-pair",
                  "the cell has " + std::to_string(pairs.size()) + " pairs of leader and follower",
                  pairs.empty() ? "write a `teleop` block into the cell" : "name one: polyarm lead NAME");
    show(pairs.front());
  }

  void show(const Json& pair) {
    std::string text = fmt::format("{} -> {}: {}", pair["leader"].get<std::string>(),
                                   pair["follower"].get<std::string>(), pair["state"].get<std::string>());
    if (pair["state"] == "approaching")
      text += fmt::format(", {} is {:.2f} away", pair["furthest"].get<std::string>(),
                          pair["distance"].get<double>());
    if (const std::string reason = pair["reason"]; !reason.empty()) text += " (" + reason + ")";
    if (text == shown_) return;
    shown_ = text;
    fmt::print("{}{}{}", own_return(), own_escape("[K"), text);
    std::fflush(stdout);
  }

  Client& client_;
  const LeadArguments& a_;
  bool held_ = false, sent_ = false;
  Clock::time_point until_;
  std::string shown_;
};

}  // namespace

int run_lead(int argc, char** argv) {
  CommandLine app("Leads an arm of a running cell by another while a key is held", "polyarm lead");
  LeadArguments a;
  app.add_option("pair", a.pair, "the name under `teleop` of the cell, if there are several");
  app.add_option("--hold", a.hold, "s without a repeat of the key until the follower stops")
      ->range(0.05, 1.0)
      ->capture_default_str();
  app.add_option("--first", a.first, "s until the first repeat of a key, as the keyboard is set")
      ->range(0.05, 2.0)
      ->capture_default_str();
  app.add_option("--cell", a.client.cell, "which cell, where several run");
  app.footer(examples({"polyarm lead", "polyarm lead left --cell lab"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  Client client(a.client.cell);
  {
    const Keyboard keyboard("lead", "a program holds the clutch by the request `teleop`");
    try {
      Lead(client, a).run();
    } catch (const Error&) {
      fmt::print("\n");
      throw;
    }
  }
  fmt::print("\n");
  return kOk;
}

}  // namespace polyarm::apps
