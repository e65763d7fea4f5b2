#pragma once
/// An HTTP client for one controller: keeps its connection, its cookies and its way to log in. One thread;
/// each call waits at most its limit.
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "drivers/wire/http.hpp"
#include "drivers/wire/tls.hpp"

namespace polyarm::wire {

struct HttpSettings {
  std::string host;
  int port = 80;
  bool tls = false;
  std::string user, password;
  std::string fingerprint;              ///< SHA-256 that the certificate must have; empty: any
  Nanoseconds timeout = 2'000'000'000;  ///< for connecting, and for each answer
};

class HttpClient {
 public:
  enum class Failure : std::uint8_t { none, unreachable, tls, certificate, silent, bad_answer };

  explicit HttpClient(HttpSettings settings) : settings_(std::move(settings)) {}
  /// Sends a request and waits for its answer. Logs in with Digest or Basic, as the server asks; connects
  /// again if the server closed an old connection. Nothing: failure() and why() say more.
  std::optional<HttpMessage> ask(const HttpMessage& request);
  void close();
  Failure failure() const { return failure_; }
  const std::string& why() const { return why_; }
  const std::string& fingerprint() const { return seen_fingerprint_; }
  /// The address of this machine that reaches the server, and the server's; empty before the first answer.
  const std::string& own_address() const { return own_address_; }
  const std::string& peer_address() const { return peer_address_; }

 private:
  bool connect();
  std::optional<HttpMessage> ask_once(HttpMessage request);
  std::optional<HttpMessage> receive_answer();
  void keep_cookies(const HttpMessage& answer);
  std::string authorization(const HttpMessage& request);
  bool fail(Failure failure, const std::string& why);

  HttpSettings settings_;
  std::optional<TlsContext> context_;
  Channel channel_;
  HttpReader reader_{HttpReader::Kind::answer};
  std::map<std::string, std::string> cookies_;
  std::string challenge_;  ///< of the last answer with status 401
  unsigned count_ = 0;     ///< of requests with its nonce
  Failure failure_ = Failure::none;
  std::string why_, seen_fingerprint_, own_address_, peer_address_;
};

}  // namespace polyarm::wire
