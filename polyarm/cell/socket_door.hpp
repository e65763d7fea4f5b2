#pragma once
/// A local socket through which other programs of the same user reach a running cell: one JSON object per
/// line in both directions.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/realtime/bell.hpp"

namespace polyarm::cell {

class Requests;

/// Runs a thread that only transports lines. A line may have up to 1 MB. A client that does not read for long
/// is disconnected; a client that has ended its side still receives its answers, then the connection is
/// closed. The cell receives at most 16 lines per call, and nothing more is read while it is behind.
class SocketDoor {
 public:
  /// Opens `<folder>/<cell>.sock`, accessible to this user only. If a running cell uses the name, appends
  /// "-2", "-3", … Throws Error("no-socket").
  explicit SocketDoor(const std::string& cell, const std::filesystem::path& folder = folder_of_user());
  ~SocketDoor();
  const std::filesystem::path& path() const;
  /// Cell thread, each tick and after the bell rang: hands the received lines to `requests`.
  void serve(Requests& requests);
  /// The bell to ring when a line arrives; null: no bell.
  void set_wakeup(const std::shared_ptr<realtime::Bell>& bell);

  /// `$XDG_RUNTIME_DIR/polyarm`, or `/tmp/polyarm-<user id>` without it.
  static std::filesystem::path folder_of_user();
  /// The same folder, created if needed. Throws Error("no-socket") if it is a link or not private to this
  /// user.
  static std::filesystem::path own_folder();
  /// Sockets of all running cells.
  static std::vector<std::filesystem::path> running();

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::cell
