#include "apps/console_cell.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <signal.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <algorithm>
#include <chrono>
#include <cstring>
#include <thread>
#include <utility>

#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/socket_door.hpp"

namespace polyarm::apps {

namespace {
namespace fs = std::filesystem;
using Clock = std::chrono::steady_clock;
using std::chrono::milliseconds;

constexpr milliseconds kStartPatience{120'000}, kEndPatience{10'000}, kLook{20};
constexpr int kTimeout_ms = 20'000;
constexpr std::size_t kLastLines = 15;

/// Path of this executable, whatever its name is.
std::string own_path() {
  std::error_code error;
  const fs::path path = fs::read_symlink("/proc/self/exe", error);
  if (error) throw Error("not-started", "the command does not find itself: " + error.message());
  return path.string();
}

/// Opens the log file for the cell's output, beside the other files of the run; /dev/null if that fails.
int open_log(const fs::path& log) {
  std::error_code error;
  const auto nowhere = [] { return ::open("/dev/null", O_WRONLY | O_CLOEXEC); };
  if (fs::is_symlink(log.parent_path(), error)) return nowhere();  // the cell reports it when it starts
  fs::create_directories(log.parent_path(), error);
  const fs::path ignore = log.parent_path() / ".gitignore";
  try {
    if (!fs::exists(ignore, error)) write_file_atomically(ignore, "*\n");
  } catch (const Error&) {
  }
  const int fd = ::open(log.c_str(), O_CREAT | O_TRUNC | O_RDWR | O_APPEND | O_CLOEXEC | O_NOFOLLOW, 0600);
  return fd >= 0 ? fd : nowhere();
}

/// Runs in the child process: changes its process group, so the terminal's Ctrl-C does not reach it, and
/// starts the cell.
[[noreturn]] void become(const fs::path& folder, const std::vector<char*>& argv, int log, pid_t parent) {
  ::setpgid(0, 0);
  ::prctl(PR_SET_PDEATHSIG, SIGTERM);
  if (::getppid() != parent) ::_exit(1);
  const int nothing = ::open("/dev/null", O_RDONLY);
  if (nothing < 0 || ::dup2(nothing, STDIN_FILENO) < 0 || ::dup2(log, STDOUT_FILENO) < 0 ||
      ::dup2(log, STDERR_FILENO) < 0 || ::chdir(folder.c_str()) != 0)
    ::_exit(126);
  ::execv(argv.front(), argv.data());
  ::_exit(127);
}
}  // namespace

ConsoleCell::~ConsoleCell() {
  leave();
}

void ConsoleCell::start(const fs::path& folder, const std::vector<std::string>& arguments) {
  leave();
  std::vector<std::string> words = {own_path(), "run", "--wait", "--quiet"};
  words.insert(words.end(), arguments.begin(), arguments.end());
  std::vector<char*> argv;
  for (std::string& word : words) argv.push_back(word.data());
  argv.push_back(nullptr);
  log_ = folder / ".state" / "console.log";
  const int log = open_log(log_);
  const pid_t parent = ::getpid();
  child_ = ::fork();
  if (child_ == 0) become(folder, argv, log, parent);
  ::close(log);
  if (child_ < 0)
    throw Error("not-started", std::string("no process could be made: ") + std::strerror(errno));
  try {
    meet(wait_for_door());
  } catch (...) {
    leave();
    throw;
  }
}

bool ConsoleCell::child_ended() {
  if (child_ <= 0 || ::waitpid(child_, nullptr, WNOHANG) == 0) return false;
  child_ = -1;
  return true;
}

/// Waits for the child's socket and connects to it.
std::unique_ptr<Client> ConsoleCell::wait_for_door() {
  for (const auto end = Clock::now() + kStartPatience; Clock::now() < end;) {
    for (const fs::path& socket : cell::SocketDoor::running()) {
      try {
        std::unique_ptr<Client> client = Client::at(socket);
        if (client->peer() != child_) continue;
        name_ = socket.stem().string();
        return client;
      } catch (const Error&) {  // another cell that has just ended
      }
    }
    if (child_ended())
      throw Error("not-started", "the simulation has not started:\n" + last_words(),
                  "all of it is in " + log_.string());
    std::this_thread::sleep_for(kLook);
  }
  throw Error("not-started", "the cell has not answered within two minutes", "see " + log_.string());
}

void ConsoleCell::attach(const std::string& name) {
  leave();
  auto client = std::make_unique<Client>(name);
  name_ = name;
  for (const fs::path& socket : cell::SocketDoor::running())
    if (name.empty()) name_ = socket.stem().string();
  meet(std::move(client));
}

void ConsoleCell::meet(std::unique_ptr<Client> client) {
  client_ = std::move(client);
  const Json state = ask({{"request", "program"}});
  folder_ = state["folder"].get<std::string>();
  events_ = Client::at(cell::SocketDoor::folder_of_user() / (name_ + ".sock"));
  events_->send({{"request", "events"}, {"since", 0}});
  old_events_ = state["events"].get<std::uint64_t>();
  pendant_.clear();
  std::vector<Json> old;
  if (const Json answer = events_->receive(kTimeout_ms); !answer.is_null())
    take(Client::result_of(answer), old);
  robots_ = state["robots"].get<std::vector<std::string>>();
  robot_ = robots_.empty() ? "" : robots_.front();
}

void ConsoleCell::leave() {
  client_.reset();
  events_.reset();
  if (child_ <= 0) return;
  for (const int signal : {SIGTERM, SIGTERM, SIGKILL}) {
    ::kill(child_, signal);
    for (const auto end = Clock::now() + kEndPatience; Clock::now() < end;) {
      if (child_ended()) return;
      std::this_thread::sleep_for(kLook);
    }
  }
}

std::string ConsoleCell::last_words() const {
  try {
    std::vector<std::string> lines = split_words(read_file(log_), "\n");
    if (lines.size() > kLastLines)
      lines.erase(lines.begin(), lines.end() - static_cast<std::ptrdiff_t>(kLastLines));
    return join(lines, "\n");
  } catch (const Error&) {
    return "(it said nothing)";
  }
}

void ConsoleCell::gone() {
  client_.reset();
  events_.reset();
  const bool own = child_ > 0;
  leave();
  throw Error("cell-gone", "the cell '" + name_ + "' has ended" + (own ? ":\n" + last_words() : ""),
              own ? "its output is in " + log_.string() : "");
}

int ConsoleCell::send(Json request) {
  if (!client_) throw Error("no-cell", "no cell is running", "start the simulation first");
  if (!robot_.empty() && robots_.size() > 1)
    for (const char* takes : {"jog", "jog.state", "target", "move"})
      if (request["request"] == takes && !request.contains("robot")) request["robot"] = robot_;
  request["id"] = ++last_id_;
  try {
    client_->send(request);
  } catch (const Error&) {
    gone();
  }
  return last_id_;
}

Json ConsoleCell::receive(int id, int timeout_ms) {
  try {
    const auto end = Clock::now() + milliseconds(timeout_ms);
    for (;;) {
      const auto left = std::chrono::duration_cast<milliseconds>(end - Clock::now()).count();
      Json answer = client_->receive(static_cast<int>(std::max<long>(left, 0)));
      if (answer.is_null() || answer.value("id", 0) == id) return answer;
    }
  } catch (const Error& e) {
    if (e.problems().front().code != "cell-gone") throw;
    gone();
  }
}

Json ConsoleCell::ask(Json request) {
  const int id = send(std::move(request));
  for (const auto end = Clock::now() + milliseconds(kTimeout_ms); Clock::now() < end;) {
    const Json answer = receive(id, 200);
    if (!answer.is_null()) return Client::result_of(answer);
  }
  throw Error("no-answer", "the cell has not answered for 20 seconds", "is its process stopped?");
}

std::string ConsoleCell::catch_up() {
  Json now = ask({{"request", "program"}});
  const std::string cause = now["cause"];
  const bool fell_behind =
      cause.find("silent") != std::string::npos || cause.find("wall time") != std::string::npos;
  if (!is_own() || !fell_behind || (now["control"] != "held" && now["control"] != "stopping")) return "";
  for (int tries = 0; tries < 1000 && now["control"] != "running"; ++tries) {
    if (now["control"] == "held") ask({{"request", "control.resume"}});
    std::this_thread::sleep_for(kLook);
    now = ask({{"request", "program"}});
  }
  return cause;
}

void ConsoleCell::take(const Json& events, std::vector<Json>& out) {
  for (const Json& event : events) {
    const std::string note = event["event"] == "note" ? event["text"].get<std::string>() : "";
    if (note.starts_with("pendant: ")) pendant_ = note.substr(9);
    if (event["number"].get<std::uint64_t>() > old_events_) out.push_back(event);
  }
}

std::vector<Json> ConsoleCell::take_events() {
  std::vector<Json> out;
  if (!events_) return out;
  try {
    for (;;) {
      const Json answer = events_->receive(0);
      if (answer.is_null()) return out;
      take(Client::result_of(answer), out);
    }
  } catch (const Error& e) {
    if (e.problems().front().code != "cell-gone") throw;
    events_.reset();
    return out;
  }
}

}  // namespace polyarm::apps
