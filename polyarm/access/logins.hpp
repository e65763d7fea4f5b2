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

#include "polyarm/base/bounds.hpp"
#include "polyarm/users/user_list.hpp"

namespace polyarm::server {

/// The part of an address that one client chooses freely is left out: of IPv6, the lower 64 bits.
std::string network_of(const std::string& address);

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
  static constexpr std::size_t kMostLogins = bounds::kLogins, kMostLoginsOfOne = bounds::kLoginsOfUser,
                               kMostTracked = bounds::kTriesTracked;
  static constexpr double kLongest_s = 3600.0 * bounds::kLoginHours, kIdle_s = bounds::kLoginIdle_s,
                          kLongestWait_s = bounds::kLoginWait_s, kRereadEvery_s = 1;
  /// So many wrong passwords in a row are free: for a name at an address, and for all names at an address.
  /// Then the wait doubles, from 1 s.
  static constexpr int kFreeTries = bounds::kWrongOfUserAtAddress, kFreeOfAddress = bounds::kWrongOfAddress;
  /// Wrong passwords for a name from all addresses; one is forgotten in each such time. Addresses where this
  /// user has logged in are not counted and not refused: nobody elsewhere can lock a user out.
  static constexpr double kFreeOfName = bounds::kWrongOfUser, kForgetEvery_s = 60;

  /// `file`: the list of users; empty: nobody can log in. `longest_s`: every log-in ends after this time.
  explicit Logins(std::filesystem::path file, double longest_s = kLongest_s)
      : file_(std::move(file)), longest_s_(longest_s) {}

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
  /// Why the log-in of this token has ended: "time", "idle", "changed" (the user, or too many log-ins); empty
  /// for all other tokens.
  std::string why_ended(std::string_view token, double now) const;
  double longest_s() const { return longest_s_; }
  /// Ends log-ins that are too old or idle, and those of users who were removed or changed.
  void tick(double now);
  std::size_t count() const;

 private:
  struct Tries {
    int wrong = 0;
    double until = 0, last = 0;
    bool known = false;  ///< the user has logged in from this address
  };
  /// What tells one file from another, and from itself after a change.
  struct Seen {
    std::int64_t changed_ns = 0;  ///< also by a change of mode or owner
    std::uint64_t inode = 0, mode = 0, owner = 0;
    bool operator==(const Seen&) const = default;
  };
  void reread(double now);
  /// What is counted of one try.
  struct Keys {
    std::string pair, address, name;
  };
  double wait_of(const std::string& key, double now) const;
  double wait_of(const Keys& keys, double now) const;
  double level_of_name(const std::string& name, double now) const;
  void set_level_of_name(const std::string& name, double level, double now);
  Tries& tries_of(const std::string& key, double now);
  void note_try(const std::string& key, int free, double now);
  void note_try(const Keys& keys, double now);
  void note_success(const Keys& keys, double now);
  const char* why_invalid(const Login& login, double now) const;
  void remember_end(const std::string& token_hash, const char* why, double now);
  void end_invalid(double now);
  void make_room(const std::string& user, double now);

  const std::filesystem::path file_;
  const double longest_s_;
  mutable std::mutex mutex_;
  users::UserList users_;
  double read_at_ = -1e9;
  Seen seen_{-1};                                         // of the file that was read
  std::map<std::string, std::shared_ptr<Login>> logins_;  // by the SHA-256 of the token
  struct Ended {
    const char* why = "";
    double at = 0;
  };
  std::map<std::string, Ended> ended_;  // the latest, by the SHA-256 of the token
  std::map<std::string, Tries> tries_;  // by "at ADDRESS NAME" and "from ADDRESS"
  struct Level {
    double wrong = 0;  ///< passwords that are not forgotten
    double at = 0;
  };
  std::map<std::string, Level> names_;  // by name
};

}  // namespace polyarm::server
