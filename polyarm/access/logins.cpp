#include "polyarm/access/logins.hpp"

#include <sys/stat.h>

#include <algorithm>
#include <cmath>

#include "polyarm/access/token.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/base/sha256.hpp"
#include "polyarm/realtime/periodic.hpp"
#include "polyarm/users/password.hpp"

namespace polyarm::server {

double steady_seconds() {
  return seconds(realtime::monotonic_now());
}

/// A list that became unreadable ends all log-ins: nobody keeps rights that cannot be checked.
void Logins::reread(double now) {
  if (file_.empty() || now - read_at_ < kRereadEvery_s) return;
  read_at_ = now;
  struct stat status {};
  Seen seen;
  if (::lstat(file_.c_str(), &status) == 0)
    seen = {status.st_ctim.tv_sec * 1'000'000'000 + status.st_ctim.tv_nsec, status.st_ino, status.st_mode,
            status.st_uid};
  if (seen == seen_) return;
  try {
    users_ = users::read_users(file_);
    seen_ = seen;
  } catch (const Error&) {
    users_ = {};
    seen_ = {-1};
  }
}

bool Logins::offered(double now) {
  const std::lock_guard lock(mutex_);
  reread(now);
  return !users_.all().empty();
}

double Logins::wait_of(const std::string& key, double now) const {
  const auto found = tries_.find(key);
  return found == tries_.end() ? 0 : std::max(0.0, found->second.until - now);
}

/// Counts a try before the password is checked, so that tries at the same time are counted, too.
void Logins::note_try(const std::string& key, double now) {
  if (tries_.size() >= kMostTracked && !tries_.contains(key)) {
    const auto oldest = std::min_element(tries_.begin(), tries_.end(), [](const auto& a, const auto& b) {
      return a.second.last < b.second.last;
    });
    tries_.erase(oldest);
  }
  Tries& tries = tries_[key];
  if (now - tries.last > 10 * kLongestWait_s) tries.wrong = 0;
  tries.last = now;
  tries.wrong = std::min(tries.wrong + 1, 64);
  if (tries.wrong > kFreeTries)
    tries.until = now + std::min(kLongestWait_s, std::ldexp(1.0, std::min(tries.wrong - kFreeTries - 1, 10)));
}

Logins::Result Logins::log_in(const std::string& name, const std::string& password, const std::string& from,
                              double now) {
  const std::string by_name = "user " + name.substr(0, users::kMostName), by_address = "from " + from;
  std::string hash = users::hash_of_nobody();
  protocol::Role role = protocol::Role::watch;
  bool known = false;
  {
    const std::lock_guard lock(mutex_);
    reread(now);
    if (users_.all().empty()) return {{}, nullptr, 0, "no-users"};
    if (const double wait = std::max(wait_of(by_name, now), wait_of(by_address, now)); wait > 0)
      return {{}, nullptr, wait, "too-fast"};
    note_try(by_name, now);
    note_try(by_address, now);
    if (const users::User* user = users_.find(name)) hash = user->hash, role = user->role, known = true;
  }
  if (!users::fits(password, hash) || !known) return {{}, nullptr, 0, "wrong-password"};
  auto login = std::make_shared<Login>();
  login->user = name;
  login->role = role;
  login->hash = hash;
  login->begun = now;
  login->used = now;
  std::string token = make_token();
  const std::lock_guard lock(mutex_);
  tries_.erase(by_name);
  tries_.erase(by_address);
  end_invalid(now);
  make_room(name);
  logins_[sha256(token)] = login;
  return {std::move(token), std::move(login), 0, {}};
}

/// Ends the oldest log-in of this user, or of all, if there are too many.
void Logins::make_room(const std::string& user) {
  const auto oldest_of = [&](bool own) {
    auto out = logins_.end();
    for (auto each = logins_.begin(); each != logins_.end(); ++each)
      if ((!own || each->second->user == user) &&
          (out == logins_.end() || each->second->begun < out->second->begun))
        out = each;
    return out;
  };
  const auto own = static_cast<std::size_t>(std::count_if(
      logins_.begin(), logins_.end(), [&](const auto& each) { return each.second->user == user; }));
  if (own < kMostLoginsOfOne && logins_.size() < kMostLogins) return;
  const auto leaving = oldest_of(own >= kMostLoginsOfOne);
  leaving->second->over = true;
  logins_.erase(leaving);
}

bool Logins::is_valid(const Login& login, double now) const {
  if (login.over || now - login.begun > kLongest_s || now - login.used > kIdle_s) return false;
  const users::User* const user = users_.find(login.user);
  return user && user->role == login.role && user->hash == login.hash;
}

void Logins::end_invalid(double now) {
  std::erase_if(logins_, [&](const auto& each) {
    if (is_valid(*each.second, now)) return false;
    each.second->over = true;
    return true;
  });
}

std::shared_ptr<Login> Logins::find(std::string_view token, double now) {
  if (token.empty() || token.size() > 100) return nullptr;
  const std::lock_guard lock(mutex_);
  if (logins_.empty()) return nullptr;
  const auto found = logins_.find(sha256(token));
  if (found == logins_.end() || !is_valid(*found->second, now)) return nullptr;
  found->second->used = now;
  return found->second;
}

void Logins::log_out(std::string_view token) {
  const std::lock_guard lock(mutex_);
  const auto found = logins_.find(sha256(token));
  if (found == logins_.end()) return;
  found->second->over = true;
  logins_.erase(found);
}

void Logins::tick(double now) {
  const std::lock_guard lock(mutex_);
  if (logins_.empty()) return;
  reread(now);
  end_invalid(now);
}

std::size_t Logins::count() const {
  const std::lock_guard lock(mutex_);
  return logins_.size();
}

}  // namespace polyarm::server
