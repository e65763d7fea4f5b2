#pragma once
/// Lines of text to and from other devices: TCP client, TCP server, serial line. Cell thread; no call waits.
#include <cstddef>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/hardware/device_lock.hpp"
#include "polyarm/io/stream_entries.hpp"

namespace polyarm::cell {

/// One stream. It opens when a program first uses it, and opens again after it was lost. A server has one
/// client; a new one replaces it.
class Stream {
 public:
  /// Longer lines are cut off and dropped; more waiting lines drop the oldest.
  static constexpr std::size_t kLongestLine = 64 * 1024, kMostLines = 1000;
  /// Bytes that wait for being sent; more are refused.
  static constexpr std::size_t kMostToSend = 64 * 1024;

  explicit Stream(StreamEntry entry) : entry_(std::move(entry)) {}
  ~Stream();
  Stream(const Stream&) = delete;
  Stream& operator=(const Stream&) = delete;

  /// Sends and receives what is possible now. `now`: ns of any clock. Throws Error if it can never open: the
  /// port is taken, the device is missing.
  void tick(long long now);
  bool connected() const { return file_ >= 0 && !connecting_; }
  bool has_line() const { return !lines_.empty(); }
  /// The oldest line, without its end; empty if there is none.
  std::string next_line();
  /// Throws Error("signal") if it is not connected, or too much waits already.
  void send(const std::string& text);
  /// Lines that were dropped, because they were too long or too many.
  std::size_t dropped() const { return dropped_; }
  int port() const;  ///< that it listens at, for tests

 private:
  void open(long long now);
  void open_device();
  void listen_there();
  void connect_there();
  void accept_client();
  void receive();
  void send_now();
  void take_lines();
  void lose();
  void close_all();

  StreamEntry entry_;
  int file_ = -1, listener_ = -1;
  bool connecting_ = false, discards_ = false;
  long long next_try_ = 0;
  std::string in_, out_;
  std::deque<std::string> lines_;
  std::size_t dropped_ = 0;
  hardware::DeviceLock lock_;
};

/// All streams of a cell. Errors of kind `signal`.
class Streams {
 public:
  /// What may open: streams at all, and devices.
  struct May {
    bool open = true, real = false;
  };
  Streams(const std::vector<StreamEntry>& entries, May may);
  /// Throws Error if there is no such stream, or it may not be opened. `now` as for Stream::tick().
  Stream& used(const std::string& name, long long now);
  /// False for a stream that may not be opened. Otherwise as used().
  bool is_connected(const std::string& name, long long now);
  /// Ticks the streams in use.
  void tick(long long now);

 private:
  struct Entry {
    StreamEntry entry;
    std::unique_ptr<Stream> stream;  ///< null until a program uses it
  };
  Entry& entry_of(const std::string& name);
  bool may_open(const StreamEntry& entry) const;

  std::map<std::string, Entry> entries_;
  May may_;
};

}  // namespace polyarm::cell
