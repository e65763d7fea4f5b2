#pragma once
/// The cell that the console controls: one that it has started, or one that was already running.
#include <sys/types.h>

#include <cstdint>
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "apps/client.hpp"

namespace polyarm::apps {

class ConsoleCell {
 public:
  ConsoleCell() = default;
  ~ConsoleCell();
  ConsoleCell(const ConsoleCell&) = delete;
  ConsoleCell& operator=(const ConsoleCell&) = delete;

  /// Starts `polyarm run ARGUMENTS` in that folder as a process of its own, which ends with this process.
  /// Returns once the cell answers. Throws Error("not-started") with the cell's output.
  void start(const std::filesystem::path& folder, const std::vector<std::string>& arguments);
  /// Connects to a running cell. Throws Error("no-cell" | "which-cell").
  void attach(const std::string& name);
  /// Ends the console's own cell, whose robots stop on their paths; only disconnects from any other cell.
  void leave();

  bool runs() const { return client_ != nullptr; }
  bool is_own() const { return child_ > 0; }
  const std::string& name() const { return name_; }
  /// Folder in which the cell looks for its files.
  const std::filesystem::path& folder() const { return folder_; }
  /// The robots of the cell, and the selected one; ask() and send() add it to each request that needs a
  /// robot.
  const std::vector<std::string>& robots() const { return robots_; }
  const std::string& robot() const { return robot_; }
  void choose_robot(const std::string& robot) { robot_ = robot; }
  Client& client() const { return *client_; }

  /// The result of a request. Throws the cell's refusal, "no-answer" after 20 s, and "cell-gone" with the
  /// last output of the cell.
  Json ask(Json request);
  /// For the console's own simulation after the machine was too slow: resumes from that hold and returns the
  /// cause of the hold. Empty if the cell is held for another reason, or not held.
  std::string catch_up();
  /// Sends a request that is answered repeatedly; returns the id for receive().
  int send(Json request);
  /// The next complete answer to request `id` within `timeout_ms`; null if it has not arrived.
  Json receive(int id, int timeout_ms);
  /// Events since the last call, in the form of the request `events`.
  std::vector<Json> take_events();
  /// The link of the cell's pendant; empty if the cell serves none.
  const std::string& pendant() const { return pendant_; }

 private:
  void meet(std::unique_ptr<Client> client);
  void take(const Json& events, std::vector<Json>& out);
  std::unique_ptr<Client> wait_for_door();
  [[noreturn]] void gone();
  std::string last_words() const;
  bool child_ended();

  std::unique_ptr<Client> client_, events_;
  pid_t child_ = -1;
  int last_id_ = 0;
  std::string name_, robot_, pendant_;
  std::uint64_t old_events_ = 0;  ///< number of the last event before the connection
  std::vector<std::string> robots_;
  std::filesystem::path folder_, log_;
};

}  // namespace polyarm::apps
