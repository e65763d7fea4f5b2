#include "apps/keyboard.hpp"

#include <poll.h>
#include <signal.h>
#include <termios.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cstdint>
#include <cstdlib>

#include "polyarm/base/error.hpp"

namespace polyarm::apps {

namespace {
std::atomic<bool> ending{false};
std::atomic<bool> changed{false};  // the terminal settings were changed
termios as_it_was;
constexpr std::array kEnding = {SIGINT, SIGTERM, SIGHUP, SIGQUIT, SIGTSTP};
std::array<struct sigaction, kEnding.size()> actions_before;

void give_back() {
  if (changed.exchange(false)) tcsetattr(STDIN_FILENO, TCSANOW, &as_it_was);
}
}  // namespace

Keyboard::Keyboard(const std::string& verb, const std::string& advice) {
  if (!isatty(STDIN_FILENO) || tcgetattr(STDIN_FILENO, &as_it_was) != 0)
    throw Error("no-terminal", verb + " reads keys from a terminal, but standard input is not one", advice);
  ending = false;
  struct sigaction action {};
  action.sa_handler = [](int) { ending = true; };
  for (std::size_t i = 0; i < kEnding.size(); ++i) sigaction(kEnding[i], &action, &actions_before[i]);
  action.sa_handler = [](int signal) {
    give_back();
    raise(signal);
  };
  action.sa_flags = static_cast<int>(SA_RESETHAND | SA_NODEFER);
  for (const int signal : {SIGSEGV, SIGABRT, SIGBUS, SIGFPE, SIGILL}) sigaction(signal, &action, nullptr);
  std::atexit(give_back);
  termios raw = as_it_was;
  raw.c_lflag &= ~static_cast<tcflag_t>(ICANON | ECHO | ISIG | IEXTEN);
  raw.c_iflag &= ~static_cast<tcflag_t>(IXON);
  raw.c_cc[VMIN] = 0;
  raw.c_cc[VTIME] = 0;
  changed = true;
  if (tcsetattr(STDIN_FILENO, TCSANOW, &raw) != 0)
    throw Error("no-terminal", "the terminal cannot be set to read single keys");
}

Keyboard::~Keyboard() {
  give_back();
  for (std::size_t i = 0; i < kEnding.size(); ++i) sigaction(kEnding[i], &actions_before[i], nullptr);
}

std::string Keyboard::wait(std::chrono::milliseconds time) {
  pollfd waiting{STDIN_FILENO, POLLIN, 0};
  const int ready = poll(&waiting, 1, static_cast<int>(std::max<std::int64_t>(time.count(), 0)));
  if (ready <= 0) return {};
  char keys[256];
  const ssize_t n = read(STDIN_FILENO, keys, sizeof keys);
  if (n <= 0 && (waiting.revents & (POLLHUP | POLLERR)) != 0) ending = true;
  return n > 0 ? std::string(keys, static_cast<std::size_t>(n)) : std::string();
}

void Keyboard::pause(std::chrono::milliseconds time) {
  poll(nullptr, 0, static_cast<int>(std::max<std::int64_t>(time.count(), 0)));
}

bool Keyboard::ended() {
  return ending;
}

void Keyboard::end() {
  ending = true;
}

}  // namespace polyarm::apps
