#pragma once
/// Client of a running cell's socket, for verbs that send requests.
#include <sys/types.h>

#include <filesystem>
#include <functional>
#include <initializer_list>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>

#include "apps/options.hpp"

namespace polyarm::apps {

using Json = nlohmann::json;

/// Options common to all these verbs.
struct ClientOptions {
  std::string cell;
  bool json = false;
  void add_to(CommandLine& app);
};

/// A connection to a cell. Throws Error("no-cell") if no cell runs, or if several run and none is named.
class Client {
 public:
  explicit Client(const std::string& cell);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  /// Connects to the cell that listens at this socket.
  static std::unique_ptr<Client> at(const std::filesystem::path& socket);
  /// Process id of the cell.
  pid_t peer() const;
  int descriptor() const { return fd_; }

  void send(const Json& request);
  /// The next line; null after `timeout_ms` (-1: no timeout) or after a signal. Throws Error("cell-gone")
  /// when the connection is closed.
  Json receive(int timeout_ms = -1);
  /// Sends a request, waits, and returns the result. Throws the cell's refusal as an Error.
  Json ask(Json request);
  /// The result of an answer; throws the answer's error.
  static Json result_of(const Json& answer);

 private:
  Client() = default;
  void connect(const std::filesystem::path& socket);

  int fd_ = -1;
  std::string in_;
};

/// Prints rows under headings; columns are as wide as their contents.
void print_table(const std::vector<std::string>& headings, const std::vector<std::vector<std::string>>& rows);
/// A JSON value as text for people.
std::string shown(const Json& value);

/// The value at `path` in an answer; null if there is no such value.
const Json& part(const Json& from, std::initializer_list<const char*> path);
// Values of an answer; a missing value or one of another type gives 0, empty or false.
double number_of(const Json& value);
std::string text_of(const Json& value);
bool flag_of(const Json& value);

/// Runs a verb whose first word selects an action; each action has its own options.
int run_actions(CommandLine& app, int argc, char** argv, const std::function<int()>& act);

/// True after Ctrl-C, while a verb follows a request.
bool interrupted();
void catch_interrupts();

}  // namespace polyarm::apps
