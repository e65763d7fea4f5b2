#pragma once
/// Hashes of passwords: yescrypt, computed by libcrypt. Any thread; a hash takes tens of milliseconds.
#include <string>

#include "polyarm/base/bounds.hpp"

namespace polyarm::users {

inline constexpr std::size_t kLeastPassword = 8, kMostPassword = bounds::kPasswordBytes;  ///< bytes
inline constexpr std::size_t kMostHash = bounds::kPasswordHashBytes;

/// Throws Error("bad-password") if the password is too short or too long, or has control characters.
void require_good_password(const std::string& password);
/// A new hash with its own salt, as one word. Throws Error("no-random" | "bad-password").
std::string hash_of(const std::string& password);
/// False for every text that is not a hash.
bool fits(const std::string& password, const std::string& hash);
/// A hash that no password fits. A check against it takes as long as any other.
const std::string& hash_of_nobody();

}  // namespace polyarm::users
