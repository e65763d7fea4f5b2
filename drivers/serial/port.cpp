#include "drivers/serial/port.hpp"

#include <asm/termbits.h>  // termios2: any rate; conflicts with <termios.h>
#include <fcntl.h>
#include <grp.h>
#include <linux/serial.h>
#include <poll.h>
#include <sys/ioctl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdlib>
#include <cstring>
#include <utility>

#include "drivers/serial/ports.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::serial {

namespace {

std::string which_ports() {
  const std::vector<std::string> ports = list_ports();
  if (ports.empty())
    return "this machine has no serial port with a device: plug the adapter in, and look at `dmesg`";
  return "the ports here are: " + join(ports, ", ");
}

std::string who_may(const std::string& path) {
  struct stat facts {};
  if (stat(path.c_str(), &facts) != 0) return "look at the permissions of " + path;
  const group* owner = getgrgid(facts.st_gid);
  const bool group_may = (facts.st_mode & 0060) == 0060 && facts.st_gid != 0;
  if (!group_may || !owner)
    return "only its owner may use it: give it to the group dialout with a udev rule "
           "(SUBSYSTEM==\"tty\", GROUP=\"dialout\", MODE=\"0660\"), and join that group";
  const std::string name = owner->gr_name;
  return "join the group " + name + ": `sudo usermod -aG " + name + " $USER`, then log out and in again";
}

[[noreturn]] void refuse_open(const std::string& path, int error) {
  const std::string reason = std::strerror(error);
  switch (error) {
    case ENOENT:
    case ENODEV:
    case ENXIO:
      throw Error("no-such-port",
                  path.empty() ? "no serial port is named" : "there is no serial port " + path,
                  which_ports());
    case EACCES:
    case EPERM:
      throw Error("port-not-permitted", path + " may not be opened: " + reason, who_may(path));
    case EBUSY:
      throw Error("device-in-use", path + " is in use by another program",
                  "`fuser " + path + "` shows which; ModemManager uses new adapters for some seconds");
    default:
      throw Error("port-failed", path + " cannot be opened: " + reason, which_ports());
  }
}

/// Returns 0 or an errno. `actual`: the rate that the kernel chose.
int apply_baud(int file, termios2& settings, int baud, int& actual) {
  settings.c_cflag &= ~static_cast<tcflag_t>(CBAUD | (CBAUD << IBSHIFT));
  settings.c_cflag |= BOTHER | (BOTHER << IBSHIFT);
  settings.c_ispeed = settings.c_ospeed = static_cast<speed_t>(baud);
  termios2 done{};
  if (ioctl(file, TCSETS2, &settings) != 0 || ioctl(file, TCGETS2, &done) != 0) return errno;
  actual = static_cast<int>(done.c_ospeed);
  return 0;
}

/// A UART tolerates about 2 percent; a larger deviation garbles every byte.
bool near_enough(int asked, int got) {
  return std::abs(static_cast<long>(got) - asked) * 50 <= asked;
}

void require_baud(int file, termios2& settings, int baud, const std::string& path) {
  int actual = 0;
  const int error = baud > 0 ? apply_baud(file, settings, baud, actual) : EINVAL;
  if (error == 0 && near_enough(baud, actual)) return;
  throw Error("baud-not-supported",
              path + " cannot do " + std::to_string(baud) + " bit/s" +
                  (error ? std::string(": ") + std::strerror(error) : ", only " + std::to_string(actual)),
              "set the devices to a rate that the adapter has, or take another adapter");
}

void make_raw(termios2& settings) {
  settings.c_iflag = 0;
  settings.c_oflag = 0;
  settings.c_lflag = 0;
  settings.c_cflag &= ~static_cast<tcflag_t>(CSIZE | PARENB | CSTOPB | CRTSCTS | HUPCL);
  settings.c_cflag |= CS8 | CREAD | CLOCAL;
  settings.c_cc[VMIN] = 1;
  settings.c_cc[VTIME] = 0;
}

/// USB adapters collect bytes for up to 16 ms by default. A pty does not support this.
bool ask_low_latency(int file) {
  serial_struct line{};
  if (ioctl(file, TIOCGSERIAL, &line) != 0) return false;
  line.flags |= ASYNC_LOW_LATENCY;
  return ioctl(file, TIOCSSERIAL, &line) == 0;
}

bool is_gone(int error) {
  return error == EIO || error == ENXIO || error == ENODEV || error == EBADF;
}
}  // namespace

Port::Port(const PortOptions& options) : path_(options.path) {
  if (access(path_.c_str(), F_OK) == 0)  // else the lock would have the name of something that is no port
    lock_ = hardware::DeviceLock(path_, options.holder.empty() ? "another session" : options.holder);
  file_ = open(path_.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (file_ < 0) refuse_open(path_, errno);
  try {
    termios2 settings{};
    if (ioctl(file_, TCGETS2, &settings) != 0)
      throw Error("not-a-serial-port", path_ + " is not a serial port: " + std::strerror(errno),
                  which_ports());
    if (ioctl(file_, TIOCEXCL) != 0) refuse_open(path_, errno);
    make_raw(settings);
    require_baud(file_, settings, options.baud, path_);
    low_latency_ = options.low_latency && ask_low_latency(file_);
    if (const Transfer flushed = flush(); !flushed) refuse_open(path_, flushed.error);
  } catch (...) {
    close();
    throw;
  }
}

Port Port::handed_over(int file, int lock, std::string path) noexcept {
  Port out;
  out.file_ = file;
  out.foreign_lock_ = lock;
  out.path_ = std::move(path);
  return out;
}

Port::~Port() {
  close();
}

Port::Port(Port&& other) noexcept
    : path_(std::move(other.path_)),
      lock_(std::move(other.lock_)),
      file_(std::exchange(other.file_, -1)),
      foreign_lock_(std::exchange(other.foreign_lock_, -1)),
      low_latency_(other.low_latency_) {}

Port& Port::operator=(Port&& other) noexcept {
  if (this == &other) return *this;
  close();
  path_ = std::move(other.path_);
  lock_ = std::move(other.lock_);
  file_ = std::exchange(other.file_, -1);
  foreign_lock_ = std::exchange(other.foreign_lock_, -1);
  low_latency_ = other.low_latency_;
  return *this;
}

void Port::close() noexcept {
  if (file_ < 0) return;
  ioctl(file_, TIOCNXCL);  // fails without harm on a lost port
  ::close(std::exchange(file_, -1));
  lock_ = hardware::DeviceLock();
  if (foreign_lock_ >= 0) ::close(std::exchange(foreign_lock_, -1));
}

void Port::set_baud(int baud) {
  termios2 settings{};
  if (ioctl(file_, TCGETS2, &settings) != 0)
    throw Error("port-failed", path_ + ": " + explain(Status::failed, errno));
  termios2 before = settings;
  try {
    require_baud(file_, settings, baud, path_);
  } catch (...) {
    ioctl(file_, TCSETS2, &before);  // the former settings are still valid
    throw;
  }
}

Transfer Port::wait(short events, Nanoseconds deadline) noexcept {
  for (;;) {
    const Nanoseconds left = std::max<Nanoseconds>(0, deadline - realtime::monotonic_now());
    pollfd watched{file_, events, 0};
    const timespec limit{static_cast<time_t>(left / 1'000'000'000), static_cast<long>(left % 1'000'000'000)};
    const int ready = ppoll(&watched, 1, &limit, nullptr);
    if (ready < 0 && errno == EINTR) continue;
    if (ready < 0) return {Status::failed, 0, errno};
    if (ready == 0) return {Status::timeout, 0, 0};
    if (watched.revents & POLLNVAL) return {Status::gone, 0, EBADF};
    if (watched.revents & events) return {};
    return {Status::gone, 0, EIO};  // POLLHUP or POLLERR alone
  }
}

Transfer Port::read(std::span<std::uint8_t> into, Nanoseconds deadline) noexcept {
  if (into.empty()) return {};
  for (;;) {
    const ssize_t count = ::read(file_, into.data(), into.size());
    if (count > 0) return {Status::ok, static_cast<std::size_t>(count), 0};
    if (count == 0) return {Status::gone, 0, EIO};
    if (errno == EINTR) continue;
    if (errno != EAGAIN) return {is_gone(errno) ? Status::gone : Status::failed, 0, errno};
    if (const Transfer waited = wait(POLLIN, deadline); !waited) return waited;
  }
}

Transfer Port::read_exactly(std::span<std::uint8_t> into, Nanoseconds deadline) noexcept {
  std::size_t done = 0;
  while (done < into.size()) {
    Transfer part = read(into.subspan(done), deadline);
    done += part.count;
    if (!part) return {part.status, done, part.error};
  }
  return {Status::ok, done, 0};
}

Transfer Port::write(std::span<const std::uint8_t> bytes, Nanoseconds deadline) noexcept {
  std::size_t done = 0;
  while (done < bytes.size()) {
    const ssize_t count = ::write(file_, bytes.data() + done, bytes.size() - done);
    if (count >= 0) {
      done += static_cast<std::size_t>(count);
      continue;
    }
    if (errno == EINTR) continue;
    if (errno != EAGAIN) return {is_gone(errno) ? Status::gone : Status::failed, done, errno};
    if (const Transfer waited = wait(POLLOUT, deadline); !waited) return {waited.status, done, waited.error};
  }
  return {Status::ok, done, 0};
}

Transfer Port::flush() noexcept {
  if (ioctl(file_, TCFLSH, TCIFLUSH) == 0) return {};
  return {is_gone(errno) ? Status::gone : Status::failed, 0, errno};
}

std::string explain(Status status, int error) {
  switch (status) {
    case Status::ok:
      return "done";
    case Status::timeout:
      return "no answer in time: check power, wiring and baud rate";
    case Status::gone:
      return "the port is gone: the adapter was unplugged or has reset; plug it in and start again";
    case Status::failed:
      break;
  }
  return std::string("the system refused: ") + std::strerror(error);
}

}  // namespace polyarm::serial
