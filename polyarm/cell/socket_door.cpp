#include "polyarm/cell/socket_door.hpp"

#include <fcntl.h>
#include <poll.h>
#include <sys/eventfd.h>
#include <sys/file.h>
#include <sys/socket.h>
#include <sys/stat.h>
#include <sys/un.h>
#include <unistd.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <cstring>
#include <deque>
#include <iterator>
#include <mutex>
#include <nlohmann/json.hpp>
#include <thread>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/spare_descriptor.hpp"
#include "polyarm/inside/requests.hpp"

namespace polyarm::cell {

namespace fs = std::filesystem;

namespace {

constexpr std::size_t kLongestLine = bounds::kRequestBytes, kMostUnread = bounds::kSocketUnreadBytes,
                      kMostClients = bounds::kSocketClients, kLinesATick = bounds::kSocketLinesATick,
                      kMostWaiting = bounds::kSocketWaitingBytes;
/// Poll intervals: normal, and while a client that has ended its side waits for its answers.
constexpr int kTimeout_ms = 1000, kClosing_ms = 20;
/// Pause after accept() found no free file descriptor.
constexpr int kShortage_ms = 100;

bool address_of(const fs::path& path, sockaddr_un& out) {
  out = {};
  out.sun_family = AF_UNIX;
  if (path.string().size() >= sizeof out.sun_path) return false;
  std::strcpy(out.sun_path, path.c_str());
  return true;
}

/// True if a process listens on this socket.
bool answers(const fs::path& path) {
  sockaddr_un address;
  if (!address_of(path, address)) return false;
  const int fd = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
  if (fd < 0) return false;
  const bool out = ::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 ||
                   errno == EAGAIN;  // it listens, but its queue is full
  ::close(fd);
  return out;
}

/// Creates the folder if needed; it must belong to this user alone.
void make_private(const fs::path& folder) {
  std::error_code error;
  if (fs::is_symlink(folder.parent_path(), error))
    throw Error("no-socket", folder.parent_path().string() + " is a link, which may lead anywhere",
                "set XDG_RUNTIME_DIR to a folder of your own");
  fs::create_directories(folder.parent_path(), error);
  if (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST)
    throw Error("no-socket", "the folder " + folder.string() + " cannot be created: " + std::strerror(errno));
  struct stat status {};
  if (::lstat(folder.c_str(), &status) != 0 || !S_ISDIR(status.st_mode) || status.st_uid != ::geteuid() ||
      (status.st_mode & 0077) != 0)
    throw Error("no-socket", "the folder " + folder.string() + " is not this user's own",
                "remove it, or set XDG_RUNTIME_DIR");
}

/// Only one process at a time creates or removes sockets in a folder; otherwise two cells that start together
/// could take each other's name. A file lock, which the kernel releases if the process is killed.
class FolderLock {
 public:
  explicit FolderLock(const fs::path& folder)
      : fd_(::open((folder / ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600)) {
    for (int tries = 0; tries < 200 && !held_; ++tries) {
      held_ = fd_ >= 0 && ::flock(fd_, LOCK_EX | LOCK_NB) == 0;
      if (!held_) ::poll(nullptr, 0, 5);
    }
  }
  ~FolderLock() {
    if (fd_ >= 0) ::close(fd_);
  }
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;
  bool held() const { return held_; }

 private:
  int fd_;
  bool held_ = false;
};

/// SAX parser that finds the `id` member of the outermost object.
class IdSeeker : public nlohmann::json_sax<nlohmann::json> {
 public:
  nlohmann::json found;
  bool null() override { return !wanted(); }
  bool boolean(bool) override { return !wanted(); }
  bool number_integer(std::int64_t value) override { return take(value); }
  bool number_unsigned(std::uint64_t value) override { return take(value); }
  bool number_float(double value, const std::string&) override { return take(value); }
  bool string(std::string& value) override {
    return value.size() > bounds::kRequestIdBytes ? !wanted() : take(value);
  }
  bool binary(nlohmann::json::binary_t&) override { return false; }
  bool start_object(std::size_t) override { return start_array(0); }
  bool start_array(std::size_t) override { return !wanted() && ++depth_ <= bounds::kRequestNesting; }
  bool end_object() override { return --depth_ > 0; }
  bool end_array() override { return --depth_ > 0; }
  bool key(std::string& name) override {
    is_id_ = depth_ == 1 && name == "id";
    return true;
  }
  bool parse_error(std::size_t, const std::string&, const nlohmann::json::exception&) override {
    return false;
  }

 private:
  bool wanted() const { return is_id_ && depth_ == 1; }
  template <typename Value>
  bool take(const Value& value) {
    if (!wanted()) return true;
    found = value;
    return false;
  }
  std::size_t depth_ = 0;
  bool is_id_ = false;
};

/// The `id` of an incomplete request; null if it has none.
nlohmann::json id_within(const std::string& begun) {
  IdSeeker seeker;
  nlohmann::json::sax_parse(begun, &seeker);
  return std::move(seeker.found);
}

struct Client {
  int fd = -1;
  std::string in;
  bool ended = false;   // the client sends no more, but may still read
  std::string sending;  // used by the door's thread only: data being sent, from `sent` on
  std::size_t sent = 0;
  std::mutex mutex;  // guards the next four, shared by the cell thread and the door's thread
  std::string out;
  std::deque<std::string> urgent, lines;  // urgent: stops and holds; lines: all others
  std::size_t waiting = 0;                // bytes in both queues
  std::atomic<bool> gone{false};
};

}  // namespace

class SocketDoor::Work {
 public:
  Work(const std::string& cell, const fs::path& folder) {
    make_private(folder);
    const FolderLock lock(folder);
    if (!lock.held())
      throw Error("no-socket", "the folder " + folder.string() + " is locked by another program",
                  "look for a process that was stopped while it started a cell");
    path_ = free_path(cell, folder);
    wake_ = ::eventfd(0, EFD_CLOEXEC | EFD_NONBLOCK);
    if (wake_ < 0) throw Error("no-socket", std::string("no event can be made: ") + std::strerror(errno));
    listen_there();
    thread_ = std::thread([this] { run(); });
  }

  ~Work() {
    over_ = true;
    wake();
    thread_.join();
    for (const auto& client : clients_) {
      client->gone = true;
      ::close(client->fd);
    }
    ::close(listening_);
    remove_own();
    ::close(wake_);
  }

  const fs::path& path() const { return path_; }

  /// First the stops and holds of all clients, limited so no client blocks the others; then one line of each
  /// client in turn.
  void serve(Requests& requests) {
    std::vector<std::shared_ptr<Client>> clients;
    {
      const std::lock_guard lock(mutex_);
      clients = clients_;
    }
    bool taken = false;
    const auto hand_over = [&](const std::shared_ptr<Client>& client, bool urgent) {
      std::string line;
      {
        const std::lock_guard lock(client->mutex);
        auto& from = urgent ? client->urgent : client->lines;
        if (from.empty()) return false;
        line = std::move(from.front());
        from.pop_front();
        client->waiting -= line.size() + kLineCost;
      }
      requests.handle(
          line, [this, c = client](const std::string& answer) { return !c->gone && take_answer(*c, answer); },
          client.get());
      return taken = true;
    };
    for (const auto& client : clients)
      for (std::size_t n = 0; n < bounds::kUrgentLines && hand_over(client, true);) ++n;
    std::size_t empty = 0;
    for (std::size_t n = 0; n < kLinesATick && empty < clients.size();) {
      const bool had = hand_over(clients[++turn_ % clients.size()], false);
      n += had ? 1 : 0;
      empty = had ? 0 : empty + 1;
    }
    clients.clear();
    if (taken) wake();  // there is room to read more
  }

  realtime::WakeupHandle rope;

 private:
  /// Overhead of a queued line in addition to its text, bytes.
  static constexpr std::size_t kLineCost = 64;

  /// A short line that contains the name of an urgent request. It jumps the queue whatever else it contains;
  /// the cell parses it as usual.
  static bool is_urgent(const std::string& line) {
    return line.size() <= bounds::kUrgentBytes && (line.find("\"control.stop\"") != std::string::npos ||
                                                   line.find("\"control.hold\"") != std::string::npos);
  }

  bool take_answer(Client& client, const std::string& answer) {
    if (client.gone) return false;
    {
      const std::lock_guard lock(client.mutex);
      if (client.out.size() > kMostUnread) client.gone = true;  // the client does not read
      client.out += answer + "\n";
    }
    wake();
    return !client.gone.load();
  }

  /// `<cell>.sock`, or the name with the first number that no running cell uses.
  static fs::path free_path(const std::string& cell, const fs::path& folder) {
    std::string safe;
    for (const char c : cell)
      safe += std::isalnum(static_cast<unsigned char>(c)) || c == '_' || c == '-' ? c : '_';
    if (safe.empty()) safe = "cell";
    if (safe.size() > 60) safe.resize(60);
    for (int n = 1; n < 100; ++n) {
      const fs::path path = folder / (safe + (n > 1 ? "-" + std::to_string(n) : "") + ".sock");
      if (!answers(path)) return path;
    }
    throw Error("no-socket", "a hundred cells called '" + cell + "' are running");
  }

  void listen_there() {
    sockaddr_un address;
    if (!address_of(path_, address))
      throw Error("no-socket", "the path " + path_.string() + " is too long for a socket",
                  "set XDG_RUNTIME_DIR to a shorter one");
    ::unlink(path_.c_str());  // left by a process that was killed
    listening_ = ::socket(AF_UNIX, SOCK_STREAM | SOCK_CLOEXEC | SOCK_NONBLOCK, 0);
    // Nobody can connect before listen(), and chmod() has made it private by then.
    const bool good = listening_ >= 0 &&
                      ::bind(listening_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0 &&
                      ::chmod(path_.c_str(), 0600) == 0 && ::listen(listening_, 64) == 0 &&
                      ::lstat(path_.c_str(), &own_) == 0;
    if (good) return;
    const std::string why = std::strerror(errno);
    if (listening_ >= 0) ::close(listening_);
    ::close(wake_);
    throw Error("no-socket", "the socket " + path_.string() + " cannot be opened: " + why);
  }

  /// Removes the socket unless another process has replaced it.
  void remove_own() const {
    const FolderLock lock(path_.parent_path());
    struct stat there {};
    if (::lstat(path_.c_str(), &there) == 0 && there.st_ino == own_.st_ino && there.st_dev == own_.st_dev)
      ::unlink(path_.c_str());
  }

  void wake() {
    const std::uint64_t one = 1;
    [[maybe_unused]] const auto written = ::write(wake_, &one, sizeof one);
  }

  void run() {
    while (!over_) {
      int patience = kTimeout_ms;
      const bool listens = !std::exchange(short_of_descriptors_, false);  // otherwise skip one round
      if (!listens) patience = kShortage_ms;
      std::vector<pollfd> waiting{{listening_, static_cast<short>(listens ? POLLIN : 0), 0},
                                  {wake_, POLLIN, 0}};
      for (const auto& client : clients_) {
        waiting.push_back({client->fd, events_of(*client), 0});
        if (client->ended) patience = std::min(patience, kClosing_ms);
      }
      ::poll(waiting.data(), waiting.size(), patience);
      std::uint64_t drained = 0;
      [[maybe_unused]] const auto got = ::read(wake_, &drained, sizeof drained);
      for (std::size_t i = 0; i + 2 < waiting.size(); ++i) look_after(clients_[i], waiting[i + 2]);
      const std::lock_guard lock(mutex_);
      std::erase_if(clients_, [](const std::shared_ptr<Client>& client) {
        if (!client->gone) return false;
        ::close(client->fd);
        return true;
      });
      if (waiting[0].revents & POLLIN) welcome();
    }
  }

  /// Stops reading from a client with too many waiting lines; other clients are still read.
  short events_of(Client& client) {
    bool room;
    {
      const std::lock_guard lock(client.mutex);
      room = client.waiting < kMostWaiting;
    }
    return static_cast<short>((room && !client.ended ? POLLIN : 0) | (all_sent(client) ? 0 : POLLOUT));
  }

  void look_after(const std::shared_ptr<Client>& client, const pollfd& seen) {
    const bool hung_up = seen.revents & (POLLHUP | POLLERR);
    if ((seen.revents & POLLIN) || (hung_up && !client->ended))
      take(client);
    else if (hung_up)
      client->gone = true;
    if (!client->gone) give(*client);
    // The client has ended its side and every answer was sent.
    if (client->ended && nobody_answers(client) && all_sent(*client)) client->gone = true;
  }

  bool nobody_answers(const std::shared_ptr<Client>& client) {
    const std::lock_guard lock(mutex_);  // the cell thread copies clients_ only under this lock
    const std::lock_guard own(client->mutex);
    if (client->waiting > 0 || client.use_count() > 1) return false;
    std::atomic_thread_fence(std::memory_order_acquire);
    return true;
  }

  void welcome() {
    const int fd = ::accept4(listening_, nullptr, nullptr, SOCK_CLOEXEC | SOCK_NONBLOCK);
    if (fd < 0) {
      short_of_descriptors_ = SpareDescriptor::is_shortage(errno);
      if (short_of_descriptors_) spare_.turn_away(listening_);
      return;
    }
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
    if (n < 0 && errno != EAGAIN && errno != EINTR) client->gone = true;
    if (n == 0) client->ended = true;
    if (n <= 0) return;
    client->in.append(buffer, static_cast<std::size_t>(n));
    std::size_t begin = 0;
    for (std::size_t end; (end = client->in.find('\n', begin)) != std::string::npos; begin = end + 1) {
      if (end == begin) continue;
      std::string line = client->in.substr(begin, end - begin);
      const std::lock_guard lock(client->mutex);
      client->waiting += line.size() + kLineCost;
      (is_urgent(line) ? client->urgent : client->lines).push_back(std::move(line));
    }
    if (begin > 0) rope.pull();
    client->in.erase(0, begin);
    if (client->in.size() <= kLongestLine) return;
    refuse_too_long(*client);
    give(*client);
    client->gone = true;
  }

  void refuse_too_long(Client& client) {
    nlohmann::json answer{{"ok", false},
                          {"error",
                           {{"code", "too-long"},
                            {"what", "a request has at most 1 MB; the connection is closed"},
                            {"advice", "send it in parts, on a new connection"},
                            {"where", ""}}}};
    if (nlohmann::json id = id_within(client.in); !id.is_null()) answer["id"] = std::move(id);
    take_answer(client, answer.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace));
  }

  static void give(Client& client) {
    if (client.sent == client.sending.size()) {
      client.sending.clear();
      client.sent = 0;
      const std::lock_guard lock(client.mutex);
      client.sending.swap(client.out);
    }
    if (client.sending.empty()) return;
    const ssize_t n = ::send(client.fd, client.sending.data() + client.sent,
                             client.sending.size() - client.sent, MSG_NOSIGNAL);
    if (n > 0) client.sent += static_cast<std::size_t>(n);
    if (n < 0 && errno != EAGAIN && errno != EINTR) client.gone = true;
  }

  static bool all_sent(Client& client) {
    const std::lock_guard lock(client.mutex);
    return client.out.empty() && client.sent == client.sending.size();
  }

  fs::path path_;
  int listening_ = -1, wake_ = -1;
  SpareDescriptor spare_;
  bool short_of_descriptors_ = false;
  std::atomic<bool> over_{false};
  std::mutex mutex_;                              // held by the thread while it changes clients_
  std::vector<std::shared_ptr<Client>> clients_;  // owned by the thread; the cell thread copies it
  std::size_t turn_ = 0;                          // cell thread: index of the client served last
  struct stat own_ {};
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
void SocketDoor::set_wakeup(const std::shared_ptr<realtime::Bell>& bell) {
  work_->rope.tie(bell);
}

fs::path SocketDoor::folder_of_user() {
  const char* runtime = std::getenv("XDG_RUNTIME_DIR");
  if (runtime && *runtime) return fs::path(runtime) / "polyarm";
  return fs::path("/tmp") / ("polyarm-" + std::to_string(::geteuid()));
}

fs::path SocketDoor::own_folder() {
  const fs::path folder = folder_of_user();
  make_private(folder);
  return folder;
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
