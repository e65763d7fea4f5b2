#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstdio>

#include "apps/ending.hpp"
#include "apps/far_sides.hpp"
#include "apps/options.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {

std::atomic<bool> far_side_interrupted{false};

}  // namespace

/// Prints one event; also flushes, for pipes.
void tell(const std::string& text) {
  fmt::print("{}\n", text);
  std::fflush(stdout);
}

std::pair<int, int> wire_of(const std::string& text, int lowest, int highest) {
  const std::size_t equals = text.find('=');
  const auto output = parse_number(text.substr(0, equals));
  const auto input = equals == std::string::npos ? std::nullopt : parse_number(text.substr(equals + 1));
  const auto fits = [&](const std::optional<double>& n) { return n && *n >= lowest && *n <= highest; };
  if (!fits(output) || !fits(input))
    throw WrongUse("bad-value", "'" + text + "' is not OUTPUT=INPUT",
                   fmt::format("numbers from {} to {}, for example {}={}", lowest, highest, lowest, lowest));
  return {static_cast<int>(*output), static_cast<int>(*input)};
}

std::array<double, 6> start_of(const std::string& text, std::array<double, 6> otherwise) {
  if (text.empty()) return otherwise;
  const auto words = split_words(text, " ,;");
  for (std::size_t i = 0; i < 6; ++i) {
    const auto value = i < words.size() ? parse_number(words[i]) : std::nullopt;
    if (words.size() != 6 || !value || !(std::abs(*value) <= 720))
      throw WrongUse("bad-value", "'" + text + "' is not six angles",
                     "degrees, for example \"0 0 0 0 -90 0\"");
    otherwise[i] = *value;
  }
  return otherwise;
}

void serve_far_side(const std::function<void()>& show, const std::function<void(const std::string&)>& order) {
  struct sigaction action {};
  action.sa_handler = [](int) { far_side_interrupted = true; };
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) sigaction(number, &action, nullptr);
  const auto take_line = [&](const std::string& line) {
    const std::string word(trim(line));
    if (word.empty()) return;
    if (word == "state") return show();
    try {  // a wrong line is answered, not fatal
      order(word);
    } catch (const Error& e) {
      tell(e.what());
    }
  };
  bool open = true;
  std::string text;
  while (!far_side_interrupted) {
    pollfd in{open ? STDIN_FILENO : -1, POLLIN, 0};
    if (::poll(&in, 1, 200) <= 0 || !open) continue;
    char bytes[512];
    const ssize_t count = ::read(STDIN_FILENO, bytes, sizeof bytes);
    open = count > 0;  // without a terminal it runs until a signal
    if (count > 0) text.append(bytes, static_cast<std::size_t>(count));
    if (text.size() > 4096) text.clear();
    for (std::size_t end; (end = text.find('\n')) != std::string::npos; text.erase(0, end + 1))
      take_line(text.substr(0, end));
  }
}

int run_far_side(int argc, char** argv) {
  const auto is_maker = [](const char* text) { return text[0] != '-'; };
  char** const maker = std::find_if(argv + 1, argv + argc, is_maker);
  if (maker != argv + argc && std::string(*maker) == "ur") return run_far_side_ur(argc, argv);
  if (maker != argv + argc && std::string(*maker) == "fanuc") return run_far_side_fanuc(argc, argv);
  if (maker != argv + argc && std::string(*maker) == "abb") return run_far_side_abb(argc, argv);
  if (maker != argv + argc && std::string(*maker) == "kuka") return run_far_side_kuka(argc, argv);
  if (maker != argv + argc && std::string(*maker) == "yaskawa") return run_far_side_yaskawa(argc, argv);
  if (maker != argv + argc && std::string(*maker) == "xarm") return run_far_side_xarm(argc, argv);
  if (maker != argv + argc && std::string(*maker) == "franka") return run_far_side_franka(argc, argv);
  if (maker != argv + argc && std::string(*maker) == "cia402") return run_far_side_cia402(argc, argv);
  CommandLine app(
      "Simulates the controller of a robot byte for byte, for drivers and programs without a robot",
      "polyarm far-side");
  std::string name;
  app.add_option(
         "maker", name,
         "ur: Universal Robots; fanuc: FANUC; abb: ABB; kuka: KUKA; yaskawa: Yaskawa; xarm: "
         "UFACTORY; franka: Franka; cia402: CANopen servo drives; `polyarm far-side MAKER --help` has the "
         "rest")
      ->required()
      ->one_of({"ur", "fanuc", "abb", "kuka", "yaskawa", "xarm", "franka", "cia402"});
  app.footer(examples({"polyarm far-side ur", "polyarm far-side abb --help"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  return kOk;
}

}  // namespace polyarm::apps
