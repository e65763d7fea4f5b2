#include "polyarm/cell/socket_door.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <mutex>
#include <thread>

#include "polyarm/base/error.hpp"
#include "polyarm/cell/requests.hpp"

namespace polyarm::cell {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLongestLine = 4 << 20, kMostUnread = 16 << 20, kMostClients = 64;

bool address_of(const fs::path& path, sockaddr_un& out) {
  out = {};
  out.sun_family = AF_UNIX;
  if (path.string().size() >= sizeof out.sun_path) return false;
  std::strcpy(out.sun_path, path.c_str());
  return true;
}

/// Does somebody listen there?
bool answers(const fs::path& path) {
  sockaddr_un address;
  if (!address_of(path, address)) return false;
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return false;
  const bool out = ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  ::close(fd);
  return out;
}

/// The folder, made if need be; it must belong to this user and to nobody else.
void make_private(const fs::path& folder) {
  std::error_code error;
  fs::create_directories(folder.parent_path(), error);
  if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST)
    throw Error("no-socket", "the folder " + folder.string() + " cannot be made: " + std::strerror(errno));
  struct stat status {};
  if (::lstat(folder.c_str(), &status) != 0 || !S_ISDIR(status.st_mode) || status.st_uid != ::geteuid() ||
      (status.st_mode & 0077) != 0)
    throw Error("no-socket", "the folder " + folder.string() + " is not this user's own",
                "remove it, or set XDG_RUNTIME_DIR");
}

struct Client {
  int fd = -1;
  std::string in;
  std::mutex mutex;  // of what follows: the cell thread writes, the door's thread sends
  std::string out;
  std::atomic<bool> gone{false};
};

}  // namespace

class SocketDoor::Work {
 public:
  Work(const std::string& cell, const fs::path& folder) {
    make_private(folder);
    std::string safe;
    for (const char c : cell)
      safe += std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' ? c : '_';
    if (safe.empty()) safe = "cell";
    for (int n = 1; n < 100; ++n) {
      path_ = folder / (safe + (n > 1 ? "-" + std::to_string(n) : "") + ".sock");
      if (!answers(path_)) break;
    }
    listen_there();
    wake_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    thread_ = std::thread([this] { run(); });
  }

  ~Work() {
    over_ = true;
    wake();
    thread_.join();
    for (const auto& client : clients_) ::close(client->fd);
    ::close(listening_);
    ::close(wake_);
    std::error_code error;
    fs::remove(path_, error);
  }

  const fs::path& path() const { return path_; }

  void serve(Requests& requests) {
    std::vector<std::pair<std::shared_ptr<Client>, std::string>> lines;
    {
      const std::lock_guard lock(mutex_);
      lines.swap(lines_);
    }
    for (auto& [client, line] : lines)
      requests.handle(line, [this, c = client](const std::string& answer) {
        if (c->gone) return false;
        {
          const std::lock_guard lock(c->mutex);
          if (c->out.size() > kMostUnread) c->gone = true;  // it does not read
          c->out += answer + "\n";
        }
        wake();
        return !c->gone.load();
      });
  }

 private:
  void listen_there() {
    sockaddr_un address;
    if (!address_of(path_, address))
      throw Error("no-socket", "the path " + path_.string() + " is too long for a socket",
                  "set XDG_RUNTIME_DIR");
    ::unlink(path_.c_str());  // left by one that was killed
    listening_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    const mode_t before = ::umask(0177);
    const bool good = listening_ >= 0 &&
                      ::bind(listening_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
                      ::listen(listening_, 16) == 0;
    ::umask(before);
    if (good) return;
    const std::string why = std::strerror(errno);
    if (listening_ >= 0) ::close(listening_);
    throw Error("no-socket", "the socket " + path_.string() + " cannot be opened: " + why);
  }

  void wake() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(wake_, &one, sizeof one);
  }

  void run() {
    while (!over_) {
      std::vector<pollfd> waiting{{listening_, POLLIN, 0}, {wake_, POLLIN, 0}};
      for (const auto& client : clients_) {
        const std::lock_guard lock(client->mutex);
        waiting.push_back({client->fd, static_cast<short>(POLLIN | (client->out.empty() ? 0 : POLLOUT)), 0});
      }
      ::poll(waiting.data(), waiting.size(), 1000);
      std::uint64_t drained = 0;
      [[maybe_unused]] const auto got = ::read(wake_, &drained, sizeof drained);
      for (std::size_t i = 0; i + 2 < waiting.size(); ++i) {
        Client& client = *clients_[i];
        if (waiting[i + 2].revents & (POLLIN | POLLHUP | POLLERR)) take(clients_[i]);
        if (!client.gone) give(client);
      }
      std::erase_if(clients_, [](const std::shared_ptr<Client>& client) {
        if (!client->gone) return false;
        ::close(client->fd);
        return true;
      });
      if (waiting[0].revents & POLLIN) welcome();
    }
  }

  void welcome() {
    const int fd = ::accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) return;
    ucred who{};
    socklen_t size = sizeof who;
    const bool own = ::getsockopt(fd, SOL_SOCKET, SO_PEERCRED, &who, &size) == 0 &&
                     (who.uid == ::geteuid() || who.uid == 0);
    if (!own || clients_.size() >= kMostClients) {
      ::close(fd);
      return;
    }
    clients_.push_back(std::make_shared<Client>());
    clients_.back()->fd = fd;
  }

  void take(const std::shared_ptr<Client>& client) {
    char buffer[65536];
    const ssize_t n = ::recv(client->fd, buffer, sizeof buffer, 0);
    if (n == 0 || (n < 0 && errno != EAGAIN && errno != EINTR)) client->gone = true;
    if (n <= 0) return;
    client->in.append(buffer, static_cast<std::size_t>(n));
    std::size_t begin = 0;
    for (std::size_t end; (end = client->in.find('\n', begin)) != std::string::npos; begin = end + 1) {
      const std::lock_guard lock(mutex_);
      if (lines_.size() < 10'000) lines_.emplace_back(client, client->in.substr(begin, end - begin));
    }
    client->in.erase(0, begin);
    if (client->in.size() > kLongestLine) client->gone = true;
  }

  static void give(Client& client) {
    const std::lock_guard lock(client.mutex);
    if (client.out.empty()) return;
    const ssize_t n = ::send(client.fd, client.out.data(), client.out.size(), MSG_NOSIGNAL);
    if (n > 0) client.out.erase(0, static_cast<std::size_t>(n));
    if (n < 0 && errno != EAGAIN && errno != EINTR) client.gone = true;
  }

  fs::path path_;
  int listening_ = -1, wake_ = -1;
  std::atomic<bool> over_{false};
  std::vector<std::shared_ptr<Client>> clients_;  // the thread's
  std::mutex mutex_;
  std::vector<std::pair<std::shared_ptr<Client>, std::string>> lines_;
  std::thread thread_;
};

SocketDoor::SocketDoor(const std::string& cell, const fs::path& folder)
    : work_(std::make_unique<Work>(cell, folder)) {}
SocketDoor::~SocketDoor() = default;
const fs::path& SocketDoor::path() const {
  return work_->path();
}
void SocketDoor::serve(Requests& requests) {
  work_->serve(requests);
}

fs::path SocketDoor::folder_of_user() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  if (runtime && *runtime) return fs::path(runtime) / "polyarm";
  return fs::path("/tmp") / ("polyarm-" + std::to_string(::geteuid()));
}

std::vector<fs::path> SocketDoor::running() {
  std::vector<fs::path> out;
  std::error_code error;
  for (const auto& entry : fs::directory_iterator(folder_of_user(), error))
    if (entry.path().extension() == ".sock" && answers(entry.path())) out.push_back(entry.path());
  std::sort(out.begin(), out.end());
  return out;
}

}  // namespace polyarm::cell
