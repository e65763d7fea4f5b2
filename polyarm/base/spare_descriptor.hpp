#pragma once
/// Lets a server reject connections when the process has no file descriptor left.
#include <cerrno>

namespace polyarm {

/// Reserves one descriptor, with which a waiting connection can be accepted and closed. A connection left
/// waiting would wake the listener again and again. One thread.
class SpareDescriptor {
 public:
  SpareDescriptor();
  ~SpareDescriptor();
  SpareDescriptor(const SpareDescriptor&) = delete;
  SpareDescriptor& operator=(const SpareDescriptor&) = delete;

  /// True if `error` of accept() means that no descriptor, or no memory for one, is left.
  static bool is_shortage(int error);
  /// Accepts and closes a waiting connection, if any. The socket must be non-blocking.
  void turn_away(int listening);

 private:
  int fd_;
};

}  // namespace polyarm
