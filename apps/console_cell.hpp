#pragma once
/// The cell at the other end of the console: one that it has started, or one that runs anyway.
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

  /// Starts `polyarm run ARGUMENTS` in that folder as a process of its own, which ends when this one does,
  /// and returns once the cell answers. Throws Error("not-started") with what it said.
  void start(const std::filesystem::path& folder, const std::vector<std::string>& arguments);
  /// Throws Error("no-cell" | "which-cell").
  void attach(const std::string& name);
  /// Ends a cell of its own, which stops on its path, or lets go of another.
  void leave();

  bool runs() const { return client_ != nullptr; }
  bool is_own() const { return child_ > 0; }
  const std::string& name() const { return name_; }
  /// Where the cell looks for its files.
  const std::filesystem::path& folder() const { return folder_; }
  /// Robots of the cell, and the one that is moved; each request that takes one is told.
  const std::vector<std::string>& robots() const { return robots_; }
  const std::string& robot() const { return robot_; }
  void choose_robot(const std::string& robot) { robot_ = robot; }
  Client& client() const { return *client_; }

  /// The result of a request; throws what the cell refused, "no-answer" after 20 s, and "cell-gone" with what
  /// the cell said last.
  Json ask(Json request);
  /// In a simulation of its own, whose machine fell behind: goes on from the hold that this is answered with,
  /// and returns why it was held; empty where it is held for another reason, or not held.
  std::string catch_up();
  /// A request that is answered again and again: returns what receive() takes.
  int send(Json request);
  /// The next answer to it within so many ms, whole; null where there is none yet.
  Json receive(int id, int timeout_ms);
  /// What has happened since the last call, as the request `events` has it.
  std::vector<Json> take_events();
  /// The link of the cell's pendant; empty where none is served.
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
  std::uint64_t old_events_ = 0;  ///< those from before it was met
  std::vector<std::string> robots_;
  std::filesystem::path folder_, log_;
};

}  // namespace polyarm::apps
