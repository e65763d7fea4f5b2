#include "drivers/wire/tls.hpp"

#include <openssl/bio.h>
#include <openssl/err.h>
#include <openssl/evp.h>
#include <openssl/ssl.h>
#include <openssl/x509.h>
#include <poll.h>

#include <algorithm>
#include <array>
#include <utility>

#include "polyarm/base/error.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::wire {

namespace {

constexpr long kDay_s = 86400, kDays = 820;

template <auto free>
struct Free {
  template <typename T>
  void operator()(T* one) const {
    free(one);
  }
};
using Key = std::unique_ptr<EVP_PKEY, Free<EVP_PKEY_free>>;
using Certificate = std::unique_ptr<X509, Free<X509_free>>;

/// A key and a self-signed certificate, as a controller has.
bool identify(ssl_ctx_st* context) {
  const Key key(::EVP_EC_gen("P-256"));
  const Certificate made(::X509_new());
  if (!key || !made) return false;
  ::X509_set_version(made.get(), 2);
  ::ASN1_INTEGER_set(::X509_get_serialNumber(made.get()), 1);
  ::X509_gmtime_adj(::X509_getm_notBefore(made.get()), -kDay_s);
  ::X509_gmtime_adj(::X509_getm_notAfter(made.get()), kDays * kDay_s);
  ::X509_set_pubkey(made.get(), key.get());
  X509_NAME* const name = ::X509_get_subject_name(made.get());
  constexpr unsigned char kCommon[] = "simulated controller";
  ::X509_NAME_add_entry_by_txt(name, "CN", MBSTRING_ASC, kCommon, -1, -1, 0);
  ::X509_set_issuer_name(made.get(), name);
  return ::X509_sign(made.get(), key.get(), ::EVP_sha256()) > 0 &&
         ::SSL_CTX_use_certificate(context, made.get()) == 1 &&
         ::SSL_CTX_use_PrivateKey(context, key.get()) == 1;
}

int number_of(BIO* bio) {
  return static_cast<int>(reinterpret_cast<std::intptr_t>(::BIO_get_data(bio)));
}

int write_bio(BIO* bio, const char* data, int size) {
  ::BIO_clear_retry_flags(bio);
  const auto sent = send_some(number_of(bio), {data, static_cast<std::size_t>(std::max(0, size))});
  if (sent && *sent > 0) return static_cast<int>(*sent);
  if (sent) ::BIO_set_retry_write(bio);
  return -1;
}

int read_bio(BIO* bio, char* data, int size) {
  ::BIO_clear_retry_flags(bio);
  const std::span<std::uint8_t> into(reinterpret_cast<std::uint8_t*>(data),
                                     static_cast<std::size_t>(std::max(0, size)));
  const Received got = receive(number_of(bio), into);
  if (got.got == Got::nothing) ::BIO_set_retry_read(bio);
  return got.got == Got::bytes ? static_cast<int>(got.count) : got.got == Got::closed ? 0 : -1;
}

long control_bio(BIO*, int command, long, void*) {
  return command == BIO_CTRL_FLUSH ? 1 : 0;
}

/// OpenSSL over these sockets. Its own calls would raise SIGPIPE when the other end is gone.
const BIO_METHOD* socket_method() {
  static BIO_METHOD* const method = [] {
    BIO_METHOD* const made = ::BIO_meth_new(::BIO_get_new_index() | BIO_TYPE_SOURCE_SINK, "polyarm socket");
    if (!made) return made;
    ::BIO_meth_set_write(made, write_bio);
    ::BIO_meth_set_read(made, read_bio);
    ::BIO_meth_set_ctrl(made, control_bio);
    return made;
  }();
  return method;
}

bool attach(SSL* ssl, int socket) {
  const BIO_METHOD* const method = socket_method();
  BIO* const bio = method ? ::BIO_new(method) : nullptr;
  if (!bio) return false;
  ::BIO_set_data(bio, reinterpret_cast<void*>(static_cast<std::intptr_t>(socket)));
  ::BIO_set_init(bio, 1);
  ::SSL_set_bio(ssl, bio, bio);
  return true;
}

std::string last_error() {
  const unsigned long code = ::ERR_get_error();
  std::array<char, 160> text{};
  if (code == 0 || ERR_GET_REASON(code) == SSL_R_UNEXPECTED_EOF_WHILE_READING) return kConnectionClosed;
  ::ERR_error_string_n(code, text.data(), text.size());
  return text.data();
}

}  // namespace

TlsContext::TlsContext(End end) : server_(end == End::server) {
  context_ = ::SSL_CTX_new(server_ ? ::TLS_server_method() : ::TLS_client_method());
  if (context_) {
    ::SSL_CTX_set_min_proto_version(context_, TLS1_2_VERSION);
    ::SSL_CTX_set_verify(context_, SSL_VERIFY_NONE, nullptr);
    ::SSL_CTX_set_mode(context_, SSL_MODE_ENABLE_PARTIAL_WRITE | SSL_MODE_ACCEPT_MOVING_WRITE_BUFFER);
  }
  if (!context_ || (server_ && !identify(context_)))
    throw Error("no-tls", "TLS cannot be set up: " + last_error(), "check the installation of OpenSSL");
}

TlsContext::~TlsContext() {
  ::SSL_CTX_free(context_);
}

Channel::Channel() = default;

Channel::Channel(Descriptor socket, const TlsContext* context) : socket_(std::move(socket)) {
  if (!context || !socket_) return;
  ssl_ = ::SSL_new(context->get());
  if (!ssl_ || !attach(ssl_, socket_.number())) {
    close();
    return;
  }
  context->server() ? ::SSL_set_accept_state(ssl_) : ::SSL_set_connect_state(ssl_);
}

Channel::~Channel() {
  close();
}

Channel::Channel(Channel&& other) noexcept
    : socket_(std::move(other.socket_)), ssl_(std::exchange(other.ssl_, nullptr)) {}

Channel& Channel::operator=(Channel&& other) noexcept {
  if (this == &other) return *this;
  close();
  socket_ = std::move(other.socket_);
  ssl_ = std::exchange(other.ssl_, nullptr);
  return *this;
}

void Channel::close() {
  if (ssl_) ::SSL_free(std::exchange(ssl_, nullptr));
  socket_ = Descriptor();
}

bool Channel::wait(int error, Nanoseconds deadline) const {
  const Nanoseconds left = deadline - realtime::monotonic_now();
  if (left <= 0) return false;
  const short events = error == SSL_ERROR_WANT_WRITE ? POLLOUT : POLLIN;
  pollfd one{socket_.number(), events, 0};
  const timespec time{static_cast<time_t>(left / 1'000'000'000), static_cast<long>(left % 1'000'000'000)};
  return ::ppoll(&one, 1, &time, nullptr) > 0;
}

bool Channel::handshake(Nanoseconds timeout, std::string& why) {
  if (!ssl_) return static_cast<bool>(socket_);
  const Nanoseconds deadline = realtime::monotonic_now() + timeout;
  for (;;) {
    ::ERR_clear_error();
    const int done = ::SSL_do_handshake(ssl_);
    if (done == 1) return true;
    const int error = ::SSL_get_error(ssl_, done);
    const bool waits = error == SSL_ERROR_WANT_READ || error == SSL_ERROR_WANT_WRITE;
    if (waits && wait(error, deadline)) continue;
    why = waits ? "no answer to the TLS handshake in time" : last_error();
    return false;
  }
}

Received Channel::read(std::span<std::uint8_t> into) {
  if (!socket_) return {Got::failed, 0};
  if (!ssl_) return receive(socket_.number(), into);
  ::ERR_clear_error();
  std::size_t count = 0;
  const int done = ::SSL_read_ex(ssl_, into.data(), into.size(), &count);
  if (done == 1) return {Got::bytes, count};
  const int error = ::SSL_get_error(ssl_, done);
  if (error == SSL_ERROR_WANT_READ || error == SSL_ERROR_WANT_WRITE) return {Got::nothing, 0};
  return {error == SSL_ERROR_ZERO_RETURN ? Got::closed : Got::failed, 0};
}

bool Channel::write(std::string_view text, Nanoseconds timeout) {
  const Nanoseconds deadline = realtime::monotonic_now() + timeout;
  while (!text.empty()) {
    std::size_t count = 0;
    int error = SSL_ERROR_WANT_WRITE;
    if (ssl_) {
      ::ERR_clear_error();
      const int done = ::SSL_write_ex(ssl_, text.data(), text.size(), &count);
      if (done != 1) error = ::SSL_get_error(ssl_, done);
      if (done != 1 && error != SSL_ERROR_WANT_READ && error != SSL_ERROR_WANT_WRITE) return false;
    } else {
      const auto sent = send_some(socket_.number(), text);
      if (!sent) return false;
      count = *sent;
    }
    text.remove_prefix(count);
    if (count == 0 && !wait(error, deadline)) return false;
  }
  return true;
}

std::string Channel::fingerprint() const {
  if (!ssl_) return {};
  const Certificate peer(::SSL_get1_peer_certificate(ssl_));
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  unsigned size = 0;
  if (!peer || ::X509_digest(peer.get(), ::EVP_sha256(), digest.data(), &size) != 1) return {};
  constexpr const char* kDigits = "0123456789ABCDEF";
  std::string out;
  for (unsigned i = 0; i < size; ++i) {
    if (i > 0) out += ':';
    out += kDigits[digest[i] >> 4];
    out += kDigits[digest[i] & 15];
  }
  return out;
}

}  // namespace polyarm::wire
