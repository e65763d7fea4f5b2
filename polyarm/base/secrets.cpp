#include "polyarm/base/secrets.hpp"

#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <mutex>
#include <set>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/base/reach.hpp"

namespace polyarm {

namespace {
namespace fs = std::filesystem;

struct Marked {
  std::mutex mutex;
  std::set<fs::path> files;
};
Marked& marked() {
  static Marked only;
  return only;
}

constexpr std::size_t kLargestKey = 1 << 20;
constexpr std::array kEndings = {".key",  ".password", ".passwd",   ".secret", ".token",
                                 ".p12",  ".pfx",      ".jks",      ".keytab", ".kdbx",
                                 ".pass", ".pgpass",   ".htpasswd", ".netrc",  ".credentials"};
constexpr std::array kWords = {"password", "passwd", "passphrase", "secret", "credential"};
constexpr std::array kKeys = {"password", "passwd", "passphrase", "secret", "token", "api_key", "apikey"};

bool has_private_key(std::string_view content) {
  const auto at = content.find("-----BEGIN ");
  return at != std::string_view::npos && content.find("PRIVATE KEY-----", at) != std::string_view::npos;
}

bool named_as_secret(const fs::path& file) {
  const std::string name = lower(file.filename().string()), ending = lower(file.extension().string());
  if (ending == ".script" || ending == ".cpp" || ending == ".hpp" || ending == ".so") return false;
  const bool by_word = std::any_of(kWords.begin(), kWords.end(), [&](const char* word) {
    return file.stem() == word || name.ends_with(std::string("_") + word) ||
           name.starts_with(std::string(word) + ".") || name.starts_with(std::string(word) + "s.");
  });
  return by_word || name == "id_rsa" || name == "id_ed25519" || name == "id_ecdsa" ||
         std::find(kEndings.begin(), kEndings.end(), ending) != kEndings.end();
}
}  // namespace

fs::path secret_file(const std::string& name) {
  const fs::path plain = name;
  const fs::path file = config_folder() / "secrets" / plain;
  const auto refuse = [&](std::string what, std::string advice) {
    throw Error(Problem{"bad-secret", {file.string()}, std::move(what), std::move(advice)});
  };
  if (name.empty() || name.starts_with('.') || plain.filename() != plain)
    refuse("'" + name + "' is not the name of a secret", "write secret:NAME, without folders");
  struct stat status {};
  if (::stat(file.c_str(), &status) != 0 || !S_ISREG(status.st_mode))
    refuse("there is no secret '" + name + "' on this machine",
           "write it into this file and type chmod 600 " + file.string());
  if (status.st_uid != ::geteuid() && status.st_uid != 0)
    refuse("this secret belongs to another user, and could be replaced", "write it as a file of your own");
  if ((status.st_mode & 0077) != 0) refuse("other users may read this secret", "chmod 600 " + file.string());
  return file;
}

void mark_secret(const fs::path& file) {
  const std::lock_guard lock(marked().mutex);
  marked().files.insert(resolved(file));
}

bool is_secret(const fs::path& file, std::string_view content) {
  if (named_as_secret(file) || has_private_key(content)) return true;
  const std::lock_guard lock(marked().mutex);
  return marked().files.contains(resolved(file));
}

bool is_secret(const fs::path& file) {
  std::error_code error;
  const std::uintmax_t size = fs::file_size(file, error);
  std::string content;
  Problems ignored;
  if (!error && size < kLargestKey) collect(ignored, [&] { content = read_file(file, kLargestKey); });
  return is_secret(file, content);
}

std::string without_secrets(std::string_view text) {
  constexpr std::string_view kLeftOut = "(left out)";
  if (text.find('\0') != std::string_view::npos) return std::string(text);  // a picture, or the like
  const std::string small = lower(text);
  std::string out;
  std::size_t done = 0;
  const auto is_word = [&](std::size_t at) {
    return at < small.size() && (std::isalnum(static_cast<unsigned char>(small[at])) || small[at] == '_');
  };
  for (std::size_t at = 0; at < text.size(); ++at) {
    const auto key = std::find_if(kKeys.begin(), kKeys.end(), [&](const char* k) {
      return std::string_view(small).substr(at).starts_with(k);
    });
    if (key == kKeys.end()) continue;
    std::size_t value = at + std::string_view(*key).size();
    if (is_word(value)) continue;  // password_file names a file, and is none
    if (value + 1 < text.size() && text[value] == ':' && is_word(value + 1)) continue;  // secret:NAME, the same
    while (value < text.size() && (text[value] == '"' || text[value] == '\'' || text[value] == ' ')) ++value;
    if (value >= text.size() || (text[value] != ':' && text[value] != '>' && text[value] != '=')) continue;
    ++value;
    while (value < text.size() && (text[value] == ' ' || text[value] == '\t')) ++value;
    const std::size_t end = std::min(text.find_first_of("\n\r,}<", value), text.size());
    if (end == value) continue;
    out.append(text.substr(done, value - done)).append(kLeftOut);
    done = end;
    at = end - 1;
  }
  return out.append(text.substr(done));
}

}  // namespace polyarm
