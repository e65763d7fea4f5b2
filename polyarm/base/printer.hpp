#pragma once
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace polyarm {

/// Writes texts to a file descriptor in a thread of its own, in order, so that who tells what happens never
/// waits for who reads it: a pager that shows its first page, a terminal after Ctrl-S, or a pipe that nobody
/// empties would stop the thread that tells, and with it a robot. Any thread may put.
class Printer {
 public:
  enum class Full {
    waits,      ///< who puts waits for the reader: for what may be slow, and must be whole
    leaves_out  ///< what no longer fits is left out and counted
  };
  /// What is written in the place of `count` texts that were left out.
  using Gap = std::function<std::string(std::size_t count)>;

  /// The descriptor stays the caller's, and open. @param most bytes that wait to be written.
  Printer(int descriptor, Full full, Gap gap, std::size_t most = std::size_t{1} << 20);
  /// Settles; what nobody has read by then is lost.
  ~Printer();
  Printer(const Printer&) = delete;
  Printer& operator=(const Printer&) = delete;

  /// A write has failed: the reader is gone, or the terminal closed.
  bool gone() const;
  /// Called once when that happens, in the thread that writes.
  void when_gone(std::function<void()> tell);

  /// A text longer than all that may wait is taken when nothing else waits. After a failed write (a reader
  /// that is gone) nothing more is written.
  void put(std::string_view text);
  /// Waits until all that was put is written, so that something else may be written behind it; where it
  /// leaves out, no longer than two seconds after the reader last took something. False where that was not
  /// enough.
  bool settle();

 private:
  struct Work;
  std::shared_ptr<Work> work_;  ///< of the thread, too, which a reader may keep for ever
};

}  // namespace polyarm
