#include "polyarm/io/streams.hpp"

#include <arpa/inet.h>
#include <fcntl.h>
#include <netinet/in.h>
#include <netinet/tcp.h>
#include <sys/socket.h>
#include <termios.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <utility>

#include "polyarm/base/text.hpp"

namespace polyarm::cell {

namespace {
constexpr long long kTryAgain = 500'000'000;  // ns
/// Bytes that one tick receives at most.
constexpr std::size_t kChunk = 16 * 1024;

sockaddr_in address_of(const StreamEntry& entry) {
  sockaddr_in out{};
  out.sin_family = AF_INET;
  out.sin_port = htons(static_cast<std::uint16_t>(entry.port));
  inet_pton(AF_INET, entry.host.c_str(), &out.sin_addr);
  return out;
}

speed_t speed_of(int baud) {
  switch (baud) {
    case 1200:
      return B1200;
    case 2400:
      return B2400;
    case 4800:
      return B4800;
    case 9600:
      return B9600;
    case 19200:
      return B19200;
    case 38400:
      return B38400;
    case 57600:
      return B57600;
    case 115200:
      return B115200;
    default:
      return B0;
  }
}

bool only_later(int error) {
  return error == EAGAIN || error == EWOULDBLOCK || error == EINTR;
}
}  // namespace

Stream::~Stream() {
  close_all();
}

void Stream::close_all() {
  for (int* file : {&file_, &listener_})
    if (*file >= 0) close(std::exchange(*file, -1));
}

/// The other side has gone: what it had sent of a line is worthless.
void Stream::lose() {
  if (file_ >= 0) close(std::exchange(file_, -1));
  connecting_ = discards_ = false;
  in_.clear(), out_.clear();
}

void Stream::open(long long now) {
  if (now < next_try_) return;
  next_try_ = now + kTryAgain;
  if (entry_.kind == StreamEntry::Kind::device) return open_device();
  if (entry_.kind == StreamEntry::Kind::connect) return connect_there();
  if (listener_ < 0) listen_there();
}

void Stream::open_device() {
  const auto refuse = [&](const std::string& why) {
    lose();
    throw Error("signal", "the stream '" + entry_.name + "' cannot open " + entry_.device + ": " + why,
                "look at the cable and at `device` in cell.yaml");
  };
  if (!lock_.held()) lock_ = hardware::DeviceLock(entry_.device, "the stream " + entry_.name);
  file_ = ::open(entry_.device.c_str(), O_RDWR | O_NOCTTY | O_NONBLOCK | O_CLOEXEC);
  if (file_ < 0) refuse(std::strerror(errno));
  termios settings{};
  if (tcgetattr(file_, &settings) != 0) refuse("it is no serial line");
  const speed_t speed = speed_of(entry_.baud);
  if (speed == B0) refuse(std::to_string(entry_.baud) + " baud is not possible: 1200, 2400, … 115200 are");
  cfmakeraw(&settings);
  settings.c_cflag |= CREAD | CLOCAL;
  cfsetispeed(&settings, speed), cfsetospeed(&settings, speed);
  if (tcsetattr(file_, TCSANOW, &settings) != 0) refuse(std::strerror(errno));
}

void Stream::connect_there() {
  file_ = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  if (file_ < 0) return;
  const sockaddr_in address = address_of(entry_);
  const int failed = connect(file_, reinterpret_cast<const sockaddr*>(&address), sizeof address);
  connecting_ = failed != 0 && errno == EINPROGRESS;
  if (failed != 0 && !connecting_) lose();
}

void Stream::listen_there() {
  listener_ = socket(AF_INET, SOCK_STREAM | SOCK_NONBLOCK | SOCK_CLOEXEC, 0);
  const int on = 1;
  const sockaddr_in address = address_of(entry_);
  if (listener_ >= 0 && setsockopt(listener_, SOL_SOCKET, SO_REUSEADDR, &on, sizeof on) == 0 &&
      bind(listener_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
      listen(listener_, 1) == 0)
    return;
  const std::string why = std::strerror(errno);
  close_all();
  throw Error("signal",
              "the stream '" + entry_.name + "' cannot listen at " + entry_.host + ":" +
                  std::to_string(entry_.port) + ": " + why,
              "choose another port, or end the program that has it");
}

void Stream::accept_client() {
  const int client = accept4(listener_, nullptr, nullptr, SOCK_NONBLOCK | SOCK_CLOEXEC);
  if (client < 0) return;
  lose();
  file_ = client;
}

int Stream::port() const {
  sockaddr_in address{};
  socklen_t size = sizeof address;
  return getsockname(listener_, reinterpret_cast<sockaddr*>(&address), &size) == 0 ? ntohs(address.sin_port)
                                                                                   : 0;
}

void Stream::tick(long long now) {
  if (file_ < 0) open(now);
  if (listener_ >= 0) accept_client();
  if (connecting_) {
    sockaddr_in peer{};
    socklen_t size = sizeof peer, length = sizeof(int);
    int error = 0;
    getsockopt(file_, SOL_SOCKET, SO_ERROR, &error, &length);
    if (error != 0) return lose();
    connecting_ = getpeername(file_, reinterpret_cast<sockaddr*>(&peer), &size) != 0;
  }
  if (!connected()) return;
  send_now();
  if (connected()) receive();
}

void Stream::receive() {
  std::array<char, kChunk> bytes;
  const ssize_t count = read(file_, bytes.data(), bytes.size());
  if (count == 0) return lose();  // of a raw serial line: it was unplugged
  if (count < 0 && !only_later(errno)) return lose();
  if (count <= 0) return;
  in_.append(bytes.data(), static_cast<std::size_t>(count));
  take_lines();
}

void Stream::take_lines() {
  std::size_t begin = 0;
  for (std::size_t end; (end = in_.find(entry_.ends_with, begin)) != std::string::npos;) {
    std::string line = in_.substr(begin, end - begin);
    begin = end + entry_.ends_with.size();
    if (std::exchange(discards_, false) || line.size() > kLongestLine) {
      ++dropped_;
      continue;
    }
    if (entry_.ends_with == "\n" && line.ends_with('\r')) line.pop_back();
    lines_.push_back(std::move(line));
    if (lines_.size() > kMostLines) lines_.pop_front(), ++dropped_;
  }
  in_.erase(0, begin);
  if (in_.size() > kLongestLine + entry_.ends_with.size()) {
    in_.erase(0, in_.size() - entry_.ends_with.size() + 1);
    discards_ = true;
  }
}

void Stream::send_now() {
  if (out_.empty()) return;
  const bool serial = entry_.kind == StreamEntry::Kind::device;
  const ssize_t count =
      serial ? write(file_, out_.data(), out_.size()) : ::send(file_, out_.data(), out_.size(), MSG_NOSIGNAL);
  if (count < 0 && !only_later(errno)) return lose();
  if (count > 0) out_.erase(0, static_cast<std::size_t>(count));
}

std::string Stream::next_line() {
  if (lines_.empty()) return {};
  std::string out = std::move(lines_.front());
  lines_.pop_front();
  return out;
}

void Stream::send(const std::string& text) {
  if (!connected())
    throw Error("signal", "the stream '" + entry_.name + "' is not connected",
                "wait until it is: wait is_connected(\"" + entry_.name + "\") timeout 5s");
  if (out_.size() + text.size() > kMostToSend)
    throw Error("signal", "the stream '" + entry_.name + "' has more than 64 KiB to send",
                "the other side reads too slowly: send less, or wait");
  out_ += text;
  send_now();
}

Streams::Streams(const std::vector<StreamEntry>& entries, May may) : may_(may) {
  for (const StreamEntry& entry : entries) entries_[entry.name].entry = entry;
}

Streams::Entry& Streams::entry_of(const std::string& name) {
  const auto at = entries_.find(name);
  if (at == entries_.end()) {
    std::vector<std::string> names;
    for (const auto& each : entries_) names.push_back(each.first);
    throw Error("unknown-stream", "the cell has no stream '" + name + "'" + did_you_mean(name, names),
                names.empty() ? "describe it in cell.yaml: streams" : "known are: " + join(names, ", "));
  }
  return at->second;
}

bool Streams::may_open(const StreamEntry& entry) const {
  return may_.open && (may_.real || entry.kind != StreamEntry::Kind::device);
}

bool Streams::is_connected(const std::string& name, long long now) {
  return may_open(entry_of(name).entry) && used(name, now).connected();
}

Stream& Streams::used(const std::string& name, long long now) {
  auto& [entry, stream] = entry_of(name);
  if (!may_.open)
    throw Error("signal", "the stream '" + name + "' stays closed in lock-step, as links do",
                "run the cell with --links, or without --fast");
  if (!may_open(entry))
    throw Error("signal", "the stream '" + name + "' is a device, which is opened only with --real",
                "run the cell with --real, or use connect in a test");
  if (!stream) stream = std::make_unique<Stream>(entry);
  stream->tick(now);
  return *stream;
}

void Streams::tick(long long now) {
  for (auto& [name, entry] : entries_)
    if (entry.stream) try {
        entry.stream->tick(now);
      } catch (const Error&) {  // such as an unplugged device: not connected, and tried again
      }
}

}  // namespace polyarm::cell
