#include "polyarm/access/token.hpp"

#include <fcntl.h>
#include <openssl/evp.h>
#include <openssl/hmac.h>
#include <sys/random.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cctype>
#include <cerrno>
#include <cstdint>
#include <cstring>

#include "polyarm/access/file_lock.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::server {

namespace {

constexpr std::size_t kBytes = 32, kCharacters = 43;
constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789-_";

bool is_token(std::string_view text) {
  return text.size() == kCharacters && text.find_first_not_of(kAlphabet) == std::string_view::npos;
}

std::string base64url(const std::array<std::uint8_t, kBytes>& bytes) {
  std::string out;
  std::uint32_t bits = 0;
  int count = 0;
  for (const std::uint8_t byte : bytes) {
    bits = (bits << 8) | byte;
    for (count += 8; count >= 6; count -= 6) out += kAlphabet[(bits >> (count - 6)) & 63];
  }
  if (count > 0) out += kAlphabet[(bits << (6 - count)) & 63];
  return out;
}

/// The content of a file that only this user can read; else empty.
std::string read_private(const std::filesystem::path& file) {
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NOFOLLOW | O_NONBLOCK);
  if (fd < 0) return {};
  struct stat status {};
  std::array<char, kCharacters + 1> text{};
  const bool own = ::fstat(fd, &status) == 0 && S_ISREG(status.st_mode) && status.st_uid == ::geteuid() &&
                   (status.st_mode & 0077) == 0;
  const ssize_t n = own ? ::read(fd, text.data(), text.size()) : 0;
  ::close(fd);
  return n == static_cast<ssize_t>(kCharacters) ? std::string(text.data(), kCharacters) : std::string{};
}

}  // namespace

std::string make_token() {
  std::array<std::uint8_t, kBytes> random{};
  for (std::size_t got = 0; got < random.size();) {
    const ssize_t n = ::getrandom(random.data() + got, random.size() - got, 0);
    if (n < 0 && errno == EINTR) continue;
    if (n <= 0)
      throw Error("no-random", std::string("the system gives no random numbers: ") + std::strerror(errno));
    got += static_cast<std::size_t>(n);
  }
  return base64url(random);
}

std::string token_for(const std::string& token, protocol::Role role) {
  if (role == protocol::Role::administer) return token;
  const std::string what = std::string("polyarm pendant ") + protocol::name(role);
  std::array<std::uint8_t, kBytes> made{};
  unsigned size = kBytes;
  ::HMAC(::EVP_sha256(), token.data(), static_cast<int>(token.size()),
         reinterpret_cast<const unsigned char*>(what.data()), what.size(), made.data(), &size);
  return base64url(made);
}

bool same_token(std::string_view a, std::string_view b) noexcept {
  if (a.size() != b.size()) return false;
  volatile unsigned char different = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    different = static_cast<unsigned char>(
        different | (static_cast<unsigned char>(a[i]) ^ static_cast<unsigned char>(b[i])));
  return different == 0;
}

std::string without_tokens(std::string text) {
  constexpr std::string_view kKey = "token=";
  for (std::size_t at = text.find(kKey); at != std::string::npos; at = text.find(kKey, at)) {
    at += kKey.size();
    const auto in_token = [](unsigned char c) { return std::isalnum(c) != 0 || c == '-' || c == '_'; };
    std::size_t end = at;
    while (end < text.size() && in_token(static_cast<unsigned char>(text[end]))) ++end;
    text.replace(at, end - at, "…");
  }
  return text;
}

std::string kept_token(const std::filesystem::path& file) {
  if (const std::string kept = read_private(file); is_token(kept)) return kept;
  const FileLock lock(file);
  if (const std::string kept = read_private(file); is_token(kept)) return kept;  // of another process
  ::unlink(file.c_str());
  const std::string token = make_token();
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  const bool written =
      fd >= 0 && ::write(fd, token.data(), token.size()) == static_cast<ssize_t>(token.size());
  const std::string why = std::strerror(errno);
  if (fd >= 0) ::close(fd);
  if (!written)
    throw Error("no-token", "the pendant's token cannot be stored in " + file.string() + ": " + why);
  return token;
}

}  // namespace polyarm::server
