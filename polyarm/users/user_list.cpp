#include "polyarm/users/user_list.hpp"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdlib>
#include <cstring>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/printable.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/users/password.hpp"

namespace polyarm::users {

namespace fs = std::filesystem;

namespace {

constexpr std::string_view kHead = "polyarm users 1";

/// A descriptor that is closed at the end.
class Opened {
 public:
  explicit Opened(int fd) : fd_(fd) {}
  ~Opened() {
    if (fd_ >= 0) ::close(fd_);
  }
  Opened(const Opened&) = delete;
  Opened& operator=(const Opened&) = delete;
  int get() const { return fd_; }

 private:
  int fd_;
};

[[noreturn]] void refuse(const std::string& file, int line, const std::string& what) {
  throw Error(Problem{"bad-users",
                      {file, line, 0},
                      what,
                      "correct the line, or add the users again: polyarm users add NAME"});
}

std::string read_private(const fs::path& file) {
  const Opened opened(::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK));
  if (opened.get() < 0 && errno == ENOENT) return {};
  if (opened.get() < 0)
    throw Error("bad-users", file.string() + " cannot be opened: " + std::strerror(errno));
  struct stat status {};
  if (::fstat(opened.get(), &status) != 0 || !S_ISREG(status.st_mode) || status.st_uid != ::geteuid() ||
      (status.st_mode & 0077) != 0)
    throw Error("bad-users",
                file.string() + " is not private: others may read or write it, or it is not this user's",
                "chmod 600 " + file.string() + ", and change passwords that others could read");
  if (status.st_size > static_cast<off_t>(kMostListBytes))
    throw Error("bad-users", file.string() + " is larger than " + std::to_string(kMostListBytes) + " bytes");
  std::string out(kMostListBytes + 1, '\0');
  std::size_t got = 0;
  for (ssize_t n; got < out.size() && (n = ::read(opened.get(), out.data() + got, out.size() - got)) > 0;)
    got += static_cast<std::size_t>(n);
  out.resize(got);
  return out;
}

bool is_hash(std::string_view text) {
  return text.size() > 8 && text.size() <= kMostHash && text[0] == '$' &&
         std::all_of(text.begin(), text.end(), [](unsigned char c) { return c > 32 && c < 127; });
}

}  // namespace

void require_good_name(const std::string& name) {
  const auto letter = [](char c) { return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z'); };
  const auto good = [&](char c) {
    return letter(c) || (c >= '0' && c <= '9') || c == '.' || c == '_' || c == '-';
  };
  if (name.empty() || name.size() > kMostName || !letter(name[0]) ||
      !std::all_of(name.begin(), name.end(), good))
    throw Error("bad-user",
                "'" + printable_line(name.substr(0, 2 * kMostName)) + "' cannot be the name of a user",
                "begin with a letter; use letters, digits and . _ -; at most " + std::to_string(kMostName));
}

protocol::Role role_of_word(const std::string& word) {
  if (word == "view") return protocol::Role::watch;  // in files of earlier versions
  if (const auto role = protocol::role_named(word)) return *role;
  throw Error("bad-role", "there is no role '" + printable_line(word.substr(0, 60)) + "'",
              "watch, operate, program or administer");
}

const User* UserList::find(const std::string& name) const {
  const auto found =
      std::find_if(users_.begin(), users_.end(), [&](const User& each) { return each.name == name; });
  return found == users_.end() ? nullptr : &*found;
}

void UserList::add(User user) {
  require_good_name(user.name);
  if (find(user.name))
    throw Error("bad-user", "there is a user '" + user.name + "' already",
                "polyarm users password " + user.name);
  if (users_.size() >= kMostUsers)
    throw Error("too-many", "there are " + std::to_string(kMostUsers) + " users already");
  users_.push_back(std::move(user));
}

User& UserList::at(const std::string& name) {
  for (User& each : users_)
    if (each.name == name) return each;
  std::vector<std::string> names;
  for (const User& each : users_) names.push_back(each.name);
  throw Error("unknown-user",
              "there is no user '" + printable_line(name.substr(0, 60)) + "'" + did_you_mean(name, names),
              "polyarm users list");
}

void UserList::remove(const std::string& name) {
  const User& user = at(name);
  users_.erase(users_.begin() + (&user - users_.data()));
}

std::string UserList::text() const {
  std::string out = std::string(kHead) + "\n";
  for (const User& each : users_) out += each.name + " " + protocol::name(each.role) + " " + each.hash + "\n";
  return out;
}

UserList parse_users(std::string_view text, const std::string& file) {
  UserList out;
  if (text.empty()) return out;
  if (text.size() > kMostListBytes)
    refuse(file, 1, "the list is larger than " + std::to_string(kMostListBytes) + " bytes");
  int number = 0;
  while (!text.empty()) {
    const std::string_view line = text.substr(0, text.find('\n'));
    text.remove_prefix(std::min(text.size(), line.size() + 1));
    ++number;
    if (number == 1 && line != kHead)
      refuse(file, 1, "this is not a list of users: the first line is '" + std::string(kHead) + "'");
    if (number == 1 || trim(line).empty()) continue;
    const std::vector<std::string> words = split_words(line);
    if (words.size() != 3) refuse(file, number, "a line has a name, a role and a hash");
    if (!is_hash(words[2])) refuse(file, number, "the third word is not a hash");
    try {
      out.add({words[0], role_of_word(words[1]), words[2]});
    } catch (const Error& e) {
      refuse(file, number, e.problems().front().what);
    }
  }
  return out;
}

UserList read_users(const fs::path& file) {
  return parse_users(read_private(file), file.string());
}

void make_private_folder(const fs::path& folder) {
  std::error_code error;
  if (folder.has_parent_path()) fs::create_directories(folder.parent_path(), error);
  if (folder.empty() || (::mkdir(folder.c_str(), 0700) != 0 && errno != EEXIST))
    throw Error("no-folder",
                "the folder '" + folder.string() + "' cannot be created: " + std::strerror(errno),
                "set HOME or XDG_DATA_HOME, or name a folder");
  struct stat status {};
  if (::stat(folder.c_str(), &status) != 0 || !S_ISDIR(status.st_mode) || (status.st_mode & 0002) != 0)
    throw Error("no-folder", folder.string() + " is not a folder, or everybody may change it",
                "chmod o-w " + folder.string());
}

void change_users(const fs::path& file, const std::function<void(UserList&)>& change) {
  make_private_folder(file.parent_path());
  const Opened lock(
      ::open((file.string() + ".lock").c_str(), O_RDWR | O_CREAT | O_CLOEXEC | O_NOFOLLOW, 0600));
  if (lock.get() < 0 || ::flock(lock.get(), LOCK_EX) != 0)
    throw Error("unwritable", file.string() + ".lock cannot be locked: " + std::strerror(errno));
  UserList list = read_users(file);
  change(list);
  write_file_atomically(file, list.text(), 0600);
}

fs::path folder_of_user() {
  if (const char* data = std::getenv("XDG_DATA_HOME"); data && *data) return fs::path(data) / "polyarm";
  if (const char* home = std::getenv("HOME"); home && *home) return fs::path(home) / ".local/share/polyarm";
  return {};
}

}  // namespace polyarm::users
