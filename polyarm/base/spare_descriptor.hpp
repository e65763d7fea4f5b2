#pragma once
/// For who accepts connections when the process has no descriptor left.
#include <cerrno>

namespace polyarm {

/// Keeps one descriptor back. With it a connection that waits can be accepted and closed; left waiting, it would
/// wake who listens again and again. One thread.
class SpareDescriptor {
 public:
  SpareDescriptor();
  ~SpareDescriptor();
  SpareDescriptor(const SpareDescriptor&) = delete;
  SpareDescriptor& operator=(const SpareDescriptor&) = delete;

  /// Was `error` of accept() that there are no descriptors or no memory for one?
  static bool is_shortage(int error);
  /// Accepts a connection of the socket and closes it, where one waits. The socket must not block.
  void turn_away(int listening);

 private:
  int fd_;
};

}  // namespace polyarm
