#pragma once
/// The door through which other programs of the same user reach a running cell: a local socket, one JSON
/// object a line both ways.
#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "polyarm/realtime/bell.hpp"

namespace polyarm::cell {

class Requests;

/// Listens on a thread of its own, which carries lines and owns nothing else. A line may have 1 MB; who does
/// not read for long is dropped; who has ended its side is answered and then let go. The cell is given at
/// most 16 lines at once, and nothing more is read while it is behind.
class SocketDoor {
 public:
  /// Opens `<folder>/<cell>.sock` for this user alone; a name that a living cell has gets "-2", "-3", …
  /// Throws Error("no-socket").
  explicit SocketDoor(const std::string& cell, const std::filesystem::path& folder = folder_of_user());
  ~SocketDoor();
  const std::filesystem::path& path() const;
  /// Cell thread, each tick and when the bell was rung: hands over what has come in.
  void serve(Requests& requests);
  /// Rung when a line has come in; null: none is.
  void set_bell(const std::shared_ptr<realtime::Bell>& bell);

  /// `$XDG_RUNTIME_DIR/polyarm`, else `/tmp/polyarm-<user id>`.
  static std::filesystem::path folder_of_user();
  /// The same, made if need be; throws Error("no-socket") where it is a link, or not this user's alone.
  static std::filesystem::path own_folder();
  /// The sockets of cells that answer.
  static std::vector<std::filesystem::path> running();

 private:
  class Work;
  std::unique_ptr<Work> work_;
};

}  // namespace polyarm::cell
