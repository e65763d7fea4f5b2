#pragma once
/// The other end of a running cell's socket, for the verbs that ask and tell.
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

/// What every such verb can be told.
struct ClientOptions {
  std::string cell;
  bool json = false;
  void add_to(CommandLine& app);
};

/// A connection. Throws Error("no-cell") when no cell runs, or several do and none is named.
class Client {
 public:
  explicit Client(const std::string& cell);
  ~Client();
  Client(const Client&) = delete;
  Client& operator=(const Client&) = delete;
  /// To the cell that listens at this socket.
  static std::unique_ptr<Client> at(const std::filesystem::path& socket);
  /// The process of the cell.
  pid_t peer() const;
  int descriptor() const { return fd_; }

  void send(const Json& request);
  /// The next line; null after `timeout_ms` (-1: none) or when a signal came. Throws Error("cell-gone") at
  /// the end.
  Json receive(int timeout_ms = -1);
  /// Asks, waits, and returns the result; throws what the cell refused as Error.
  Json ask(Json request);
  /// The result in an answer; throws its error.
  static Json result_of(const Json& answer);

 private:
  Client() = default;
  void connect(const std::filesystem::path& socket);

  int fd_ = -1;
  std::string in_;
};

/// Rows under headings, columns as wide as they must be.
void print_table(const std::vector<std::string>& headings, const std::vector<std::vector<std::string>>& rows);
/// A JSON value as a person reads it.
std::string shown(const Json& value);

/// The value at `path` within an answer; null where the answer has no such value.
const Json& part(const Json& from, std::initializer_list<const char*> path);
// What an answer says, whatever kind it has: a missing or other value is 0, empty or false.
double number_of(const Json& value);
std::string text_of(const Json& value);
bool flag_of(const Json& value);

/// A verb whose first word chooses an action; each has its own options.
int run_actions(CommandLine& app, int argc, char** argv, const std::function<int()>& act);

/// Set by Ctrl-C while a verb follows something.
bool interrupted();
void catch_interrupts();

}  // namespace polyarm::apps
