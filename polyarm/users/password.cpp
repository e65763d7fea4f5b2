#include "polyarm/users/password.hpp"

#include <crypt.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstring>
#include <memory>

#include "polyarm/base/error.hpp"

namespace polyarm::users {

namespace {

/// The prefix of yescrypt. 0: the library's own cost.
constexpr const char* kMethod = "$y$";
constexpr unsigned long kCost = 0;

/// Empty if the library refuses the setting.
std::string hashed(const std::string& password, const std::string& setting) {
  const auto room = std::make_unique<crypt_data>();
  const char* const out = ::crypt_rn(password.c_str(), setting.c_str(), room.get(), sizeof(crypt_data));
  const std::string text = out ? out : "";
  ::explicit_bzero(room.get(), sizeof(crypt_data));
  return text;
}

std::string new_setting() {
  std::array<char, CRYPT_GENSALT_OUTPUT_SIZE> text{};
  if (!::crypt_gensalt_rn(kMethod, kCost, nullptr, 0, text.data(), text.size()))
    throw Error("no-random", std::string("no salt can be made for a password: ") + std::strerror(errno));
  return text.data();
}

bool same(const std::string& a, const std::string& b) {
  if (a.size() != b.size()) return false;
  volatile unsigned char different = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    different = static_cast<unsigned char>(
        different | (static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i])));
  return different == 0;
}

}  // namespace

void require_good_password(const std::string& password) {
  const auto refuse = [](const std::string& what) {
    throw Error(
        "bad-password", "the password " + what,
        "use " + std::to_string(kLeastPassword) + " to " + std::to_string(kMostPassword) + " characters");
  };
  if (password.size() < kLeastPassword) refuse("is too short");
  if (password.size() > kMostPassword) refuse("is too long");
  if (std::any_of(password.begin(), password.end(), [](unsigned char c) { return c < 32 || c == 127; }))
    refuse("has control characters");
}

std::string hash_of(const std::string& password) {
  require_good_password(password);
  const std::string out = hashed(password, new_setting());
  if (out.empty() || out[0] != '$' || out.size() > kMostHash)
    throw Error("bad-password", "the password cannot be hashed: libcrypt has no yescrypt");
  return out;
}

bool fits(const std::string& password, const std::string& hash) {
  if (password.size() > kMostPassword || hash.size() > kMostHash || !hash.starts_with(kMethod)) return false;
  if (password.find('\0') != std::string::npos || hash.find('\0') != std::string::npos) return false;
  const std::string made = hashed(password, hash);
  return !made.empty() && made[0] == '$' && same(made, hash);
}

const std::string& hash_of_nobody() {
  static const std::string hash = [] {
    std::string out = hashed("nobody has this password", new_setting());
    if (!out.empty()) out.back() = out.back() == '.' ? '/' : '.';
    return out;
  }();
  return hash;
}

}  // namespace polyarm::users
