#include "apps/client.hpp"

#include <fmt/format.h>
#include <poll.h>
#include <signal.h>
#include <sys/socket.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstring>
#include <utility>

#include "apps/ending.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/cell/socket_door.hpp"

namespace polyarm::apps {

namespace {
std::atomic<bool> interrupt{false};

std::filesystem::path find_cell(const std::string& name) {
  const auto running = cell::SocketDoor::running();
  if (running.empty())
    throw Error("no-cell", "no cell is running", "start one in another terminal: polyarm run examples/r6bot");
  std::vector<std::string> names;
  for (const auto& path : running) {
    if (path.stem() == name) return path;
    names.push_back(path.stem().string());
  }
  if (!name.empty())
    throw Error("no-cell", "no cell called '" + name + "' is running" + did_you_mean(name, names),
                "running: " + join(names, ", "));
  if (running.size() > 1)
    throw Error("which-cell", "several cells are running: " + join(names, ", "),
                "choose one: --cell " + names.front());
  return running.front();
}
}  // namespace

void ClientOptions::add_to(CommandLine& app) {
  app.add_option("--cell", cell, "which cell, where several run");
  app.add_flag("--json", json, "the answer as the cell gives it");
}

Client::Client(const std::string& cell) {
  connect(find_cell(cell));
}

std::unique_ptr<Client> Client::at(const std::filesystem::path& socket) {
  std::unique_ptr<Client> out(new Client);
  out->connect(socket);
  return out;
}

void Client::connect(const std::filesystem::path& path) {
  sockaddr_un address{};
  address.sun_family = AF_UNIX;
  std::strncpy(address.sun_path, path.c_str(), sizeof address.sun_path - 1);
  fd_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd_ >= 0 && ::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return;
  const std::string why = std::strerror(errno);
  if (fd_ >= 0) ::close(std::exchange(fd_, -1));
  throw Error("no-cell", "the cell at " + path.string() + " does not answer: " + why);
}

pid_t Client::peer() const {
  ucred who{};
  socklen_t size = sizeof who;
  return ::getsockopt(fd_, SOL_SOCKET, SO_PEERCRED, &who, &size) == 0 ? who.pid : -1;
}

Client::~Client() {
  if (fd_ >= 0) ::close(fd_);
}

void Client::send(const Json& request) {
  const std::string line = request.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n";
  if (line.size() > bounds::kRequestBytes)
    throw Error("too-long",
                fmt::format("this request has {:.2f} MiB, a cell takes {} MiB at once",
                            static_cast<double>(line.size()) / (1 << 20), bounds::kRequestBytes >> 20),
                "a trajectory gets shorter with fewer points, or numbers of fewer digits");
  for (std::size_t sent = 0; sent < line.size();) {
    const ssize_t n = ::send(fd_, line.data() + sent, line.size() - sent, MSG_NOSIGNAL);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0) throw Error("cell-gone", "the cell has ended");
    sent += static_cast<std::size_t>(n);
  }
}

Json Client::receive(int timeout_ms) {
  for (;;) {
    if (const auto end = in_.find('\n'); end != std::string::npos) {
      const std::string line = in_.substr(0, end);
      in_.erase(0, end + 1);
      const Json answer = Json::parse(line, nullptr, false);
      if (!answer.is_object())
        throw Error("bad-answer", "this is not an answer of a cell: " + line.substr(0, 80));
      return answer;
    }
    pollfd waiting{fd_, POLLIN, 0};
    const int ready = ::poll(&waiting, 1, timeout_ms);
    if (ready == 0 || (ready < 0 && errno == EINTR)) return nullptr;
    char buffer[65536];
    const ssize_t n = ::recv(fd_, buffer, sizeof buffer, 0);
    if (n <= 0) throw Error("cell-gone", "the cell has ended");
    in_.append(buffer, static_cast<std::size_t>(n));
  }
}

Json Client::result_of(const Json& answer) {
  if (flag_of(part(answer, {"ok"}))) return part(answer, {"result"});
  const Json &error = part(answer, {"error"}), &all = part(error, {"all"});
  const auto said = [](const Json& each, const char* key, const char* otherwise) {
    const std::string out = text_of(part(each, {key}));
    return out.empty() ? std::string(otherwise) : out;
  };
  std::vector<Problem> problems;
  for (const Json& each : all.is_array() ? all : Json::array({error}))
    problems.push_back({said(each, "code", "refused"),
                        {said(each, "where", ""), 0, 0},
                        said(each, "what", "the cell refused"),
                        said(each, "advice", "")});
  throw Error(std::move(problems));
}

Json Client::ask(Json request) {
  send(request);
  Json answer;
  for (int asked = 0; answer.is_null(); answer = receive(100))
    if (interrupted() && ++asked > 20) throw Error("no-answer", "the cell has not answered");
  return result_of(answer);
}

void print_table(const std::vector<std::string>& headings,
                 const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const std::string& heading : headings) widths.push_back(heading.size());
  for (const auto& row : rows)
    for (std::size_t k = 0; k < row.size(); ++k) widths[k] = std::max(widths[k], row[k].size());
  const auto line = [&](const std::vector<std::string>& row) {
    std::string out;
    for (std::size_t k = 0; k < row.size(); ++k)
      out += k + 1 == row.size() ? row[k] : fmt::format("{:<{}}  ", row[k], widths[k]);
    fmt::print("{}\n", out);
  };
  line(headings);
  for (const auto& row : rows) line(row);
}

std::string shown(const Json& value) {
  if (value.is_null()) return "-";
  if (value.is_string()) return value.get<std::string>();
  if (value.is_number_float()) return fmt::format("{:.6g}", value.get<double>());
  if (value.is_boolean()) return value.get<bool>() ? "yes" : "no";
  if (value.is_array()) {
    std::string out;
    for (const Json& item : value) out += (out.empty() ? "" : ", ") + shown(item);
    return out.empty() ? "-" : out;
  }
  return value.dump();
}

const Json& part(const Json& from, std::initializer_list<const char*> path) {
  static const Json none;
  const Json* at = &from;
  for (const char* key : path) {
    if (!at->is_object()) return none;
    const auto found = at->find(key);
    if (found == at->end()) return none;
    at = &*found;
  }
  return *at;
}

double number_of(const Json& value) {
  return value.is_number() ? value.get<double>() : 0;
}

std::string text_of(const Json& value) {
  return value.is_string() ? value.get<std::string>() : "";
}

bool flag_of(const Json& value) {
  return value.is_boolean() ? value.get<bool>() : value.is_number() && value.get<double>() != 0;
}

int run_actions(CommandLine& app, int argc, char** argv, const std::function<int()>& act) {
  app.require_subcommand();
  if (const auto code = app.parse(argc, argv)) return *code;
  return act();
}

bool interrupted() {
  return interrupt.load();
}

void catch_interrupts() {
  struct sigaction action {};
  action.sa_handler = [](int) { interrupt = true; };
  // A closed terminal, or an output that nobody reads any more, ends the verb and its motion.
  for (const int number : {SIGHUP, SIGQUIT, SIGUSR1, SIGUSR2}) sigaction(number, &action, nullptr);
  action.sa_flags = SA_RESETHAND;  // a second signal ends the verb in any case
  for (const int number : {SIGINT, SIGTERM}) sigaction(number, &action, nullptr);
  struct sigaction unread {};
  unread.sa_handler = [](int) {
    interrupt = true;
    write_to_nowhere();
  };
  sigaction(SIGPIPE, &unread, nullptr);
}

}  // namespace polyarm::apps
