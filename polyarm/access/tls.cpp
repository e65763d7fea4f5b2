#include "polyarm/access/tls.hpp"

#include <fcntl.h>
#include <fmt/format.h>
#include <openssl/bio.h>
#include <openssl/ec.h>
#include <openssl/evp.h>
#include <openssl/pem.h>
#include <openssl/rand.h>
#include <openssl/x509.h>
#include <openssl/x509v3.h>
#include <sys/stat.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstring>
#include <memory>
#include <optional>

#include "polyarm/access/file_lock.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/base/error.hpp"

namespace polyarm::server {

namespace fs = std::filesystem;

namespace {

constexpr long kDays = 820, kDay_s = 86400;  // browsers refuse certificates that last longer than 825 days
constexpr long kRenew_s = 30 * kDay_s;
constexpr std::size_t kLargestFile = bounds::kPemBytes;

struct Free {
  void operator()(BIO* bio) const { ::BIO_free(bio); }
  void operator()(X509* certificate) const { ::X509_free(certificate); }
  void operator()(EVP_PKEY* key) const { ::EVP_PKEY_free(key); }
  void operator()(X509_EXTENSION* extension) const { ::X509_EXTENSION_free(extension); }
};
template <typename T>
using Held = std::unique_ptr<T, Free>;

[[noreturn]] void fail(const std::string& what, const std::string& advice = "") {
  throw Error("no-certificate", what, advice);
}

Held<BIO> reader(const std::string& pem) {
  return Held<BIO>(::BIO_new_mem_buf(pem.data(), static_cast<int>(pem.size())));
}

std::string text_of(const Held<BIO>& bio) {
  char* data = nullptr;
  const long size = ::BIO_get_mem_data(bio.get(), &data);
  return {data, static_cast<std::size_t>(std::max(0l, size))};
}

std::string fingerprint_of(X509* certificate) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (::X509_digest(certificate, ::EVP_sha256(), digest.data(), &size) != 1)
    fail("no fingerprint can be made");
  std::string out;
  for (unsigned i = 0; i < size; ++i) out += fmt::format("{}{:02X}", i > 0 ? ":" : "", digest[i]);
  return out;
}

/// What is wrong with the pair; empty: nothing. `expires`: it must be valid for another month. Sets the
/// fingerprint.
std::string judge(Certificate& both, bool expires) {
  const auto refuse_password = [](char*, int, int, void*) { return 0; };
  const Held<X509> first(::PEM_read_bio_X509(reader(both.chain).get(), nullptr, nullptr, nullptr));
  if (!first) return "the certificate file is not a PEM file";
  const Held<EVP_PKEY> key(
      ::PEM_read_bio_PrivateKey(reader(both.key).get(), nullptr, refuse_password, nullptr));
  if (!key) return "the key file is not a PEM file without a password";
  if (::X509_check_private_key(first.get(), key.get()) != 1)
    return "key and certificate do not belong together";
  std::time_t until = std::time(nullptr) + (expires ? kRenew_s : 0);
  if (::X509_cmp_time(::X509_get0_notAfter(first.get()), &until) < 0) return "the certificate has expired";
  both.fingerprint = fingerprint_of(first.get());
  return {};
}

/// The text of a file. Nothing if it cannot be read or, with `own`, if another user could read it.
std::optional<std::string> text_in(const fs::path& file, bool own) {
  const int fd = ::open(file.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK | (own ? O_NOFOLLOW : 0));
  if (fd < 0) return std::nullopt;
  struct stat status {};
  const bool good = ::fstat(fd, &status) == 0 && S_ISREG(status.st_mode) &&
                    (!own || (status.st_uid == ::geteuid() && (status.st_mode & 0077) == 0)) &&
                    static_cast<std::size_t>(status.st_size) <= kLargestFile;
  std::string out(good ? static_cast<std::size_t>(status.st_size) : 0, '\0');
  const ssize_t n = good ? ::read(fd, out.data(), out.size()) : -1;
  ::close(fd);
  if (n != static_cast<ssize_t>(out.size())) return std::nullopt;
  return out;
}

void write_private(const fs::path& file, const std::string& text) {
  ::unlink(file.c_str());
  const int fd = ::open(file.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC | O_NOFOLLOW, 0600);
  const bool written = fd >= 0 && ::write(fd, text.data(), text.size()) == static_cast<ssize_t>(text.size());
  const std::string why = std::strerror(errno);
  if (fd >= 0) ::close(fd);
  if (!written) fail("the certificate cannot be stored in " + file.string() + ": " + why);
}

void add_extension(X509* certificate, int kind, const std::string& value) {
  const Held<X509_EXTENSION> extension(::X509V3_EXT_conf_nid(nullptr, nullptr, kind, value.c_str()));
  if (extension) ::X509_add_ext(certificate, extension.get(), -1);
}

Certificate make_certificate(const std::string& host_name) {
  const Held<EVP_PKEY> key(::EVP_EC_gen("P-256"));
  const Held<X509> made(::X509_new());
  if (!key || !made) fail("no key can be made");
  std::uint64_t serial = 0;
  ::RAND_bytes(reinterpret_cast<unsigned char*>(&serial), sizeof serial);
  ::X509_set_version(made.get(), X509_VERSION_3);
  ::ASN1_INTEGER_set_uint64(::X509_get_serialNumber(made.get()), serial >> 1);
  ::X509_gmtime_adj(::X509_getm_notBefore(made.get()), -kDay_s);
  ::X509_gmtime_adj(::X509_getm_notAfter(made.get()), kDays * kDay_s);
  ::X509_set_pubkey(made.get(), key.get());
  const std::string common = "Polyarm on " + host_name.substr(0, 40);
  X509_NAME* const name = ::X509_get_subject_name(made.get());
  ::X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_UTF8,
                               reinterpret_cast<const unsigned char*>(common.data()),
                               static_cast<int>(common.size()), -1, 0);
  ::X509_set_issuer_name(made.get(), name);
  add_extension(made.get(), NID_basic_constraints, "critical,CA:FALSE");
  add_extension(made.get(), NID_ext_key_usage, "serverAuth");
  add_extension(made.get(), NID_subject_alt_name,
                "DNS:localhost,DNS:" + host_name + ",DNS:" + host_name + ".local,IP:127.0.0.1,IP:::1");
  if (::X509_sign(made.get(), key.get(), ::EVP_sha256()) == 0) fail("the certificate cannot be signed");
  const Held<BIO> chain(::BIO_new(::BIO_s_mem())), secret(::BIO_new(::BIO_s_mem()));
  ::PEM_write_bio_X509(chain.get(), made.get());
  ::PEM_write_bio_PrivateKey(secret.get(), key.get(), nullptr, nullptr, 0, nullptr, nullptr);
  return {text_of(chain), text_of(secret), fingerprint_of(made.get())};
}

}  // namespace

Certificate read_certificate(const fs::path& chain, const fs::path& key) {
  Certificate out;
  for (const auto& [file, text] : {std::pair{chain, &out.chain}, std::pair{key, &out.key}}) {
    auto read = text_in(file, false);
    if (!read) fail("the file " + file.string() + " cannot be read", "a PEM file of up to 1 MiB");
    *text = std::move(*read);
  }
  if (const std::string why = judge(out, false); !why.empty())
    fail(why + " (" + chain.string() + ", " + key.string() + ")",
         "--certificate takes the certificate with its chain, --key its key, both as PEM");
  return out;
}

Certificate kept_certificate(const fs::path& folder, const std::string& host_name) {
  const fs::path chain = folder / "pendant-certificate.pem", key = folder / "pendant-key.pem";
  std::error_code error;
  fs::create_directories(folder, error);
  const FileLock lock(chain);  // another process may be creating it
  auto kept_chain = text_in(chain, true), kept_key = text_in(key, true);
  if (kept_chain && kept_key) {
    Certificate out{std::move(*kept_chain), std::move(*kept_key), {}};
    if (judge(out, true).empty()) return out;
  }
  const Certificate made = make_certificate(host_name.empty() ? "localhost" : host_name);
  write_private(key, made.key);
  write_private(chain, made.chain);
  return made;
}

}  // namespace polyarm::server
