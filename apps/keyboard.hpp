#pragma once
/// Keys one by one from the terminal, for the verbs that move something while a key is held.
#include <chrono>
#include <string>

namespace polyarm::apps {

/// While one lives, keys come one by one, unseen, Ctrl-C among them; the terminal is as it was again on every
/// way out that leaves a moment for it. One at a time; one after another begins anew.
class Keyboard {
 public:
  /// Throws Error("no-terminal") where standard input is none; `verb` and `advice` are for its message.
  Keyboard(const std::string& verb, const std::string& advice);
  ~Keyboard();
  Keyboard(const Keyboard&) = delete;
  Keyboard& operator=(const Keyboard&) = delete;

  /// What was typed within the time; ends where the terminal is gone.
  static std::string wait(std::chrono::milliseconds time);
  /// Waits, keys or not; a signal ends it.
  static void pause(std::chrono::milliseconds time);
  /// Whether it is to end: a signal came, the terminal is gone, or end() was called.
  static bool ended();
  static void end();
};

}  // namespace polyarm::apps
