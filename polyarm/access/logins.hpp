#pragma once
/// Log-ins of users at the pendant's port: checks passwords, and knows who is logged in. Each log-in has a
/// token of its own, which lives in memory only: a restart of the cell ends all log-ins.
#include <atomic>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <string_view>
#include <utility>

#include "polyarm/users/user_list.hpp"

namespace polyarm::server {

/// The clock of log-ins, s.
double steady_seconds();

/// Somebody who is logged in. Shared by connections; any thread.
struct Login {
  std::string user;
  protocol::Role role = protocol::Role::watch;
  std::string hash;               ///< of the password at the time of the log-in
  double begun = 0;               ///< s, steady
  std::atomic<double> used{0};    ///< s, steady
  std::atomic<bool> over{false};  ///< logged out, ended, or the user was changed
};

/// Any thread. Times are those of steady_seconds().
class Logins {
 public:
  static constexpr std::size_t kMostLogins = 200, kMostLoginsOfOne = 20, kMostTracked = 1024;
  static constexpr double kLongest_s = 12 * 3600, kIdle_s = 3600, kLongestWait_s = 60, kRereadEvery_s = 1;
  /// So many wrong passwords in a row are free; then the wait doubles, from 1 s.
  static constexpr int kFreeTries = 4;

  /// `file`: the list of users; empty: nobody can log in.
  explicit Logins(std::filesystem::path file) : file_(std::move(file)) {}

  /// True if there are users. Reads the file when it has changed, at most once a second.
  bool offered(double now);
  struct Result {
    std::string token;  ///< empty: refused
    std::shared_ptr<Login> login;
    double wait_s = 0;  ///< > 0: too many wrong passwords; try again after this time
    std::string why;    ///< code of the refusal: wrong-password, too-fast, no-users
  };
  /// Takes tens of milliseconds: call it on a worker. `from`: address of the client.
  Result log_in(const std::string& name, const std::string& password, const std::string& from, double now);
  /// Null: the token is unknown or the log-in has ended. Renews the idle time.
  std::shared_ptr<Login> find(std::string_view token, double now);
  void log_out(std::string_view token);
  /// Ends log-ins that are too old or idle, and those of users who were removed or changed.
  void tick(double now);
  std::size_t count() const;

 private:
  struct Tries {
    int wrong = 0;
    double until = 0, last = 0;
  };
  /// What tells one file from another, and from itself after a change.
  struct Seen {
    std::int64_t changed_ns = 0;  ///< also by a change of mode or owner
    std::uint64_t inode = 0, mode = 0, owner = 0;
    bool operator==(const Seen&) const = default;
  };
  void reread(double now);
  double wait_of(const std::string& key, double now) const;
  void note_try(const std::string& key, double now);
  bool is_valid(const Login& login, double now) const;
  void end_invalid(double now);
  void make_room(const std::string& user);

  const std::filesystem::path file_;
  mutable std::mutex mutex_;
  users::UserList users_;
  double read_at_ = -1e9;
  Seen seen_{-1};                                         // of the file that was read
  std::map<std::string, std::shared_ptr<Login>> logins_;  // by the SHA-256 of the token
  std::map<std::string, Tries> tries_;                    // by "user NAME" and "from ADDRESS"
};

}  // namespace polyarm::server
