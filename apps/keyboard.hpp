#pragma once
/// Reads single keys from the terminal, for verbs that move something while a key is held.
#include <chrono>
#include <string>

namespace polyarm::apps {

/// While an object exists, keys arrive one by one, without echo, including Ctrl-C. The terminal settings are
/// restored on every exit that allows it. Only one object at a time.
class Keyboard {
 public:
  /// Throws Error("no-terminal") if standard input is no terminal; `verb` and `advice` are for its message.
  Keyboard(const std::string& verb, const std::string& advice);
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  /// Keys typed within the time; ends when the terminal is closed.
  static std::string wait(std::chrono::milliseconds time);
  /// Waits with or without keys; a signal ends the wait.
  static void pause(std::chrono::milliseconds time);
  /// True after a signal, when the terminal is closed, or after end().
  static bool ended();
  static void end();
};

}  // namespace polyarm::apps
