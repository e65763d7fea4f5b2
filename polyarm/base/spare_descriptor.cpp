#include "polyarm/base/spare_descriptor.hpp"

#include <fcntl.h>
#include <sys/socket.h>
#include <unistd.h>

namespace polyarm {

namespace {
int spare() {
  return ::open("/dev/null", O_RDONLY | O_CLOEXEC);
}
}  // namespace

SpareDescriptor::SpareDescriptor() : fd_(spare()) {}
SpareDescriptor::~SpareDescriptor() {
  if (fd_ >= 0) ::close(fd_);
}

bool SpareDescriptor::is_shortage(int error) {
  return error == EMFILE || error == ENFILE || error == ENOBUFS || error == ENOMEM;
}

void SpareDescriptor::turn_away(int listening) {
  if (fd_ >= 0) ::close(fd_);
  const int came = ::accept4(listening, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
  if (came >= 0) ::close(came);
  fd_ = spare();
}

}  // namespace polyarm
