#pragma once
/// Prints without blocking the calling thread.
#include <cstddef>
#include <functional>
#include <memory>
#include <string>
#include <string_view>

namespace polyarm {

/// Writes texts to a file descriptor in order, on its own thread, so that a slow reader does not block the
/// caller. A pager on its first page, a terminal after Ctrl-S or a full pipe would otherwise stop the calling
/// thread, and with it a robot. Any thread may call put().
class Printer {
 public:
  enum class Full {
    waits,      ///< put() waits for the reader: for output that must be complete and may be slow
    leaves_out  ///< texts that do not fit are dropped and counted
  };
  /// The text written in place of `count` dropped texts.
  using Gap = std::function<std::string(std::size_t count)>;

  /// The descriptor stays the caller's, and open. @param most bytes that wait to be written.
  Printer(int descriptor, Full full, Gap gap, std::size_t most = std::size_t{1} << 20);
  /// Settles first; text that is unread by then is lost.
  ~Printer();
  Printer(const Printer&) = delete;
  Printer& operator=(const Printer&) = delete;

  /// True if a write has failed: the reader is gone or the terminal is closed.
  bool gone() const;
  /// Called once when a write fails, on the writing thread.
  void when_gone(std::function<void()> tell);

  /// A text longer than the whole buffer is accepted when the buffer is empty. After a failed write nothing
  /// more is written.
  void put(std::string_view text);
  /// Waits until all texts are written, so that other output may follow. With `leaves_out` it waits at most
  /// two seconds after the reader last took something. Returns false if that was not enough.
  bool settle();

 private:
  struct Work;
  std::shared_ptr<Work> work_;  ///< shared with the thread, which a reader may block for ever
};

}  // namespace polyarm
