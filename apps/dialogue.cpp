#include "apps/dialogue.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cerrno>
#include <cmath>
#include <cstdlib>

#include "apps/jog_keys.hpp"
#include "apps/terminal.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::apps {

namespace {
std::atomic<int> interrupts{0};
std::atomic<bool> ending{false};
constexpr std::array kSignals = {SIGINT, SIGTERM, SIGHUP, SIGQUIT};
std::array<struct sigaction, kSignals.size()> before;
}  // namespace

Dialogue::Dialogue()
    : terminal_(::isatty(STDIN_FILENO) != 0),
      colour_(::isatty(STDOUT_FILENO) != 0 && !std::getenv("NO_COLOR")) {
  const char* kind = std::getenv("TERM");
  if (kind && std::string(kind) == "dumb") colour_ = false;
  struct sigaction action {};
  action.sa_handler = [](int signal) {
    if (signal == SIGINT)
      ++interrupts;
    else
      ending = true;
  };
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &action, &before[i]);
}

Dialogue::~Dialogue() {
  for (std::size_t i = 0; i < kSignals.size(); ++i) sigaction(kSignals[i], &before[i], nullptr);
}

bool Dialogue::ended() const {
  return ending;
}

bool Dialogue::take_interrupt() {
  return interrupts.exchange(0) > 0;
}

void Dialogue::say(const std::string& text) const {
  fmt::print("{}\n", text);
  std::fflush(stdout);
}

void Dialogue::complain(const std::string& text) {
  ++complaints_;
  say(bold("! ") + text);
}

void Dialogue::complain(const Error& error) {
  for (const Problem& problem : error.problems()) {
    const std::string where = problem.where.text();
    complain((where.empty() ? "" : where + ": ") + problem.what);
    if (!problem.advice.empty()) say("  " + problem.advice);
  }
}

std::string Dialogue::bold(const std::string& text) const {
  return colour_ ? own_escape("[1m") + text + own_escape("[0m") : text;
}

std::string Dialogue::dim(const std::string& text) const {
  return colour_ ? own_escape("[2m") + text + own_escape("[0m") : text;
}

/// Reads the input that has arrived; false if nothing has.
bool Dialogue::fill(int timeout_ms) {
  pollfd waiting{STDIN_FILENO, POLLIN, 0};
  if (::poll(&waiting, 1, timeout_ms) <= 0) return false;
  char text[4096];
  const ssize_t n = ::read(STDIN_FILENO, text, sizeof text);
  if (n > 0)
    in_.append(text, static_cast<std::size_t>(n));
  else if (n == 0 || (errno != EINTR && errno != EAGAIN))
    over_ = true;
  return n > 0;
}

std::optional<std::string> Dialogue::take_line() {
  const auto end = in_.find('\n');
  if (end == std::string::npos && !(over_ && !in_.empty())) return std::nullopt;
  std::string out(trim(std::string_view(in_).substr(0, end)));
  in_.erase(0, end == std::string::npos ? end : end + 1);
  return out;
}

std::optional<std::string> Dialogue::line_within(std::chrono::milliseconds time) {
  if (auto line = take_line()) return line;
  if (!over_) fill(static_cast<int>(time.count()));
  if (auto line = take_line()) return line;
  if (over_ || ending) throw EndOfAnswers{};
  return std::nullopt;
}

std::string Dialogue::line(const std::string& question) {
  fmt::print("{}", question);
  std::fflush(stdout);
  for (;;) {
    if (take_interrupt()) {
      fmt::print("\n");
      if (on_interrupt) on_interrupt();
      throw GivenUp{true};
    }
    if (ending) throw EndOfAnswers{};
    std::optional<std::string> line;
    try {
      line = line_within(std::chrono::milliseconds(100));
    } catch (const EndOfAnswers&) {
      fmt::print("\n");
      throw;
    }
    if (!line) continue;
    if (!terminal_) say(*line);
    return *line;
  }
}

std::string Dialogue::name(const std::string& question) {
  std::string out = line(question);
  if (out.empty()) throw GivenUp{};
  return out;
}

bool Dialogue::yes(const std::string& question, bool otherwise) {
  for (;;) {
    const std::string answer = lower(line(question + (otherwise ? " (Y/n): " : " (y/N): ")));
    if (answer.empty()) return otherwise;
    if (answer == "y" || answer == "yes") return true;
    if (answer == "n" || answer == "no") return false;
    complain("'" + answer + "' is neither y nor n");
  }
}

double Dialogue::quantity(const std::string& question, Dimension dimension, std::optional<double> otherwise) {
  for (;;) {
    const std::string answer = line(question);
    if (answer.empty() && otherwise) return *otherwise;
    if (answer.empty()) throw GivenUp{};
    const auto value = parse_quantity(answer, dimension);
    if (value && std::isfinite(*value)) return *value;
    const char* example = dimension == Dimension::length  ? "0.3 (m), 300mm"
                          : dimension == Dimension::angle ? "1.57 (rad), 90deg"
                          : dimension == Dimension::time  ? "2 (s), 500ms"
                                                          : "0.5";
    complain(fmt::format("'{}' is not {}; for example {}", answer, polyarm::name(dimension), example));
  }
}

int Dialogue::number(const std::string& question, int low, int high, std::optional<int> otherwise) {
  for (;;) {
    const std::string answer = line(question);
    if (answer.empty() && otherwise) return *otherwise;
    if (answer.empty()) throw GivenUp{};
    const auto value = parse_number(answer);
    if (value && *value >= low && *value <= high && *value == std::floor(*value))
      return static_cast<int>(*value);
    complain(fmt::format("'{}' is not a whole number from {} to {}", answer, low, high));
  }
}

int Dialogue::choose(const std::vector<MenuEntry>& entries) {
  for (;;) {
    const std::string answer = line("> ");
    if (answer.empty()) return -1;
    const auto value = parse_number(answer);
    if (lower(answer) == "exit" || lower(answer) == "q" || value == 0.0) return 0;
    for (const MenuEntry& entry : entries)
      if (value && *value == entry.number) return entry.number;
    complain(
        fmt::format("'{}' is not an entry of this menu, they are 0 to {}", answer, entries.back().number));
  }
}

void Dialogue::menu(const std::function<std::string()>& heading,
                    const std::function<std::vector<MenuEntry>()>& entries,
                    const std::function<bool()>& over) {
  while (!over || !over()) {
    try {
      const std::vector<MenuEntry> all = entries();
      say("\n" + bold(heading()));
      for (const MenuEntry& entry : all) say(fmt::format("{}->{}", entry.number, entry.text));
      say("0->Exit");
      const int chosen = choose(all);
      if (chosen == 0) return;
      for (const MenuEntry& entry : all)
        if (entry.number == chosen) entry.act();
    } catch (const GivenUp& why) {
      if (!why.by_signal) say(dim("nothing was changed"));
    } catch (const Error& e) {
      complain(e);
    }
  }
}

std::string flowing(const std::vector<std::string>& items, const std::string& indent) {
  const auto columns = static_cast<std::size_t>(terminal_columns()) - 1;
  std::string out, line = indent;
  for (const std::string& item : items) {
    if (line.size() + item.size() > columns && line.size() > indent.size()) {
      out += line + "\n";
      line = indent;
    }
    line += item + "  ";
  }
  return out + line + "\n";
}

std::string in_columns(const std::vector<std::string>& items) {
  std::size_t widest = 1;
  for (const std::string& item : items) widest = std::max(widest, item.size());
  const std::size_t columns =
      std::max<std::size_t>(1, (static_cast<std::size_t>(terminal_columns()) - 1) / (widest + 2));
  const std::size_t rows = (items.size() + columns - 1) / columns;
  std::string out;
  for (std::size_t r = 0; r < rows; ++r) {
    std::string line;
    for (std::size_t i = r; i < items.size(); i += rows) line += fmt::format("{:<{}}  ", items[i], widest);
    out += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return out;
}

}  // namespace polyarm::apps
