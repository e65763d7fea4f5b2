#include "polyarm/access/logins.hpp"

#include <arpa/inet.h>
#include <fmt/format.h>
#include <netinet/in.h>
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

std::string network_of(const std::string& address) {
  in6_addr six{};
  if (::inet_pton(AF_INET6, address.substr(0, address.find('%')).c_str(), &six) != 1) return address;
  const auto* const bytes = six.s6_addr;
  if (IN6_IS_ADDR_V4MAPPED(&six))
    return fmt::format("{}.{}.{}.{}", bytes[12], bytes[13], bytes[14], bytes[15]);
  std::string out;
  for (int i = 0; i < 8; ++i) out += fmt::format("{:02x}", bytes[i]);
  return out + "/64";
}

double Logins::wait_of(const std::string& key, double now) const {
  const auto found = tries_.find(key);
  return found == tries_.end() ? 0 : std::max(0.0, found->second.until - now);
}

double Logins::level_of_name(const std::string& name, double now) const {
  const auto found = names_.find(name);
  return found == names_.end()
             ? 0
             : std::max(0.0, found->second.wrong - (now - found->second.at) / kForgetEvery_s);
}

/// When there are too many names, the one with the fewest wrong passwords is forgotten: names that an
/// attacker invents do not push out the one that is guessed.
void Logins::set_level_of_name(const std::string& name, double level, double now) {
  if (names_.size() >= kMostTracked && !names_.contains(name))
    names_.erase(std::min_element(names_.begin(), names_.end(), [&](const auto& a, const auto& b) {
      return level_of_name(a.first, now) < level_of_name(b.first, now);
    }));
  names_[name] = {level, now};
}

double Logins::wait_of(const Keys& keys, double now) const {
  const double own = std::max(wait_of(keys.pair, now), wait_of(keys.address, now));
  const auto pair = tries_.find(keys.pair);
  if (pair != tries_.end() && pair->second.known) return own;
  const double over = level_of_name(keys.name, now) + 1 - kFreeOfName;
  return over > 0 ? std::max(own, over * kForgetEvery_s) : own;
}

/// When there are too many counts, the one that was used longest ago is forgotten: first of addresses where
/// nobody logged in.
Logins::Tries& Logins::tries_of(const std::string& key, double now) {
  if (tries_.size() >= kMostTracked && !tries_.contains(key))
    tries_.erase(std::min_element(tries_.begin(), tries_.end(), [](const auto& a, const auto& b) {
      return std::pair(a.second.known, a.second.last) < std::pair(b.second.known, b.second.last);
    }));
  Tries& out = tries_[key];
  if (now - out.last > 10 * kLongestWait_s) out.wrong = 0;
  return out;
}

void Logins::note_try(const std::string& key, int free, double now) {
  Tries& tries = tries_of(key, now);
  tries.last = now;
  tries.wrong = std::min(tries.wrong + 1, 64);
  if (tries.wrong > free)
    tries.until = now + std::min(kLongestWait_s, std::ldexp(1.0, std::min(tries.wrong - free - 1, 10)));
}

/// Counts a try before the password is checked, so that tries at the same time are counted, too.
void Logins::note_try(const Keys& keys, double now) {
  note_try(keys.pair, kFreeTries, now);
  note_try(keys.address, kFreeOfAddress, now);
  if (const auto pair = tries_.find(keys.pair); pair != tries_.end() && pair->second.known) return;
  set_level_of_name(keys.name, level_of_name(keys.name, now) + 1, now);
}

/// Takes back what this name added to the count of the address, and no more: a log-in of one's own does not
/// make guesses for others free.
void Logins::note_success(const Keys& keys, double now) {
  Tries& pair = tries_of(keys.pair, now);
  const int own = std::exchange(pair.wrong, 0);
  pair.until = 0;
  pair.last = now;
  if (!std::exchange(pair.known, true))
    set_level_of_name(keys.name, std::max(0.0, level_of_name(keys.name, now) - own), now);
  Tries& address = tries_of(keys.address, now);
  address.wrong = std::max(0, address.wrong - own);
  if (address.wrong <= kFreeOfAddress) address.until = 0;
}

Logins::Result Logins::log_in(const std::string& name, const std::string& password, const std::string& from,
                              double now) {
  const std::string shown = name.substr(0, users::kMostName), network = network_of(from);
  const Keys keys{"at " + network + " " + shown, "from " + network, shown};
  std::string hash = users::hash_of_nobody();
  protocol::Role role = protocol::Role::watch;
  bool known = false;
  {
    const std::lock_guard lock(mutex_);
    reread(now);
    if (users_.all().empty()) return {{}, nullptr, 0, "no-users"};
    if (const double wait = wait_of(keys, now); wait > 0) return {{}, nullptr, wait, "too-fast"};
    note_try(keys, now);
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
  note_success(keys, now);
  end_invalid(now);
  make_room(name, now);
  logins_[sha256(token)] = login;
  return {std::move(token), std::move(login), 0, {}};
}

/// Ends the oldest log-in of this user, or of all, if there are too many.
void Logins::make_room(const std::string& user, double now) {
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
  remember_end(leaving->first, "changed", now);
  logins_.erase(leaving);
}

void Logins::remember_end(const std::string& token_hash, const char* why, double now) {
  if (ended_.size() >= kMostLogins)
    ended_.erase(std::min_element(ended_.begin(), ended_.end(),
                                  [](const auto& a, const auto& b) { return a.second.at < b.second.at; }));
  ended_[token_hash] = {why, now};
}

std::string Logins::why_ended(std::string_view token, double now) const {
  if (token.empty() || token.size() > 100) return {};
  const std::lock_guard lock(mutex_);
  if (ended_.empty() && logins_.empty()) return {};
  const std::string hash = sha256(token);
  if (const auto found = ended_.find(hash); found != ended_.end()) return found->second.why;
  const auto found = logins_.find(hash);  // tick() may not have ended it yet
  const char* const why = found == logins_.end() ? nullptr : why_invalid(*found->second, now);
  return why ? why : "";
}

/// Null: the log-in is valid.
const char* Logins::why_invalid(const Login& login, double now) const {
  if (now - login.begun > longest_s_) return "time";
  if (now - login.used > kIdle_s) return "idle";
  const users::User* const user = users_.find(login.user);
  const bool same = user && user->role == login.role && user->hash == login.hash;
  return login.over || !same ? "changed" : nullptr;
}

void Logins::end_invalid(double now) {
  std::erase_if(logins_, [&](const auto& each) {
    const char* const why = why_invalid(*each.second, now);
    if (!why) return false;
    each.second->over = true;
    remember_end(each.first, why, now);
    return true;
  });
}

std::shared_ptr<Login> Logins::find(std::string_view token, double now) {
  if (token.empty() || token.size() > 100) return nullptr;
  const std::lock_guard lock(mutex_);
  if (logins_.empty()) return nullptr;
  const auto found = logins_.find(sha256(token));
  if (found == logins_.end() || why_invalid(*found->second, now)) return nullptr;
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
