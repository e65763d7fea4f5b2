#pragma once
/// Runs a program of Polyarm in a child process with separate memory: starts it, monitors it and reports how
/// it ended.
#include <sys/types.h>

#include <chrono>
#include <cstddef>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "polyarm/process/channel.hpp"

namespace polyarm::process {

/// Path of a program built with Polyarm: beside the module or program that contains this code, or in the
/// modules folder. Empty if not found.
std::string find_program(const std::string& name);
/// The folders that find_program searches, for messages.
std::string program_folders();

/// How a process ended.
struct Ending {
  int code = 0, signal = 0;  ///< signal 0: it exited with the code
  std::string last_words;    ///< the last line of its error output, printable
  /// "was ended by SIGABRT (…: Assertion … failed)"
  std::string text() const;
};

/// One child at a time; one thread. The child is killed when the thread that started it ends.
class Child {
 public:
  Child() = default;
  ~Child() { kill(); }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  /// Starts the program. It gets the descriptors `handed` as 3 and up, the null device as 0 and 1, its own
  /// process group (so Ctrl-C does not reach it), and default signals. Throws Error("no-process").
  void start(const std::string& program, std::vector<std::string> words, std::span<const int> handed);
  bool running() const { return process_ > 0; }
  pid_t process() const { return process_; }
  /// Descriptors to poll for its end and for its error output; -1 if none.
  int end() const { return end_.number(); }
  int errors() const { return errors_.number(); }
  /// Reads its error output so far. Never waits.
  void listen();
  /// How it ended; empty while it runs. Never waits.
  std::optional<Ending> ended();
  /// Waits at most `patience` until it ends, then kills it.
  Ending finish(std::chrono::milliseconds patience);
  void kill();

 private:
  pid_t process_ = 0;
  Descriptor end_, errors_;
  std::string words_;
};

struct ChildRules {
  int handed = 0;                                  ///< count of inherited descriptors, from 3 up
  pid_t parent = 0;                                ///< process id of the starting process
  std::size_t most_memory = std::size_t{1} << 30;  ///< limit for its data, bytes; beyond it the process is
                                                   ///< killed
};
/// Call it first in the child's main(). The child then ends with its parent, gains no rights, keeps no other
/// descriptors, writes no core file and has a memory limit. Returns false if the parent has already ended.
bool become_child(const ChildRules& rules);

}  // namespace polyarm::process
