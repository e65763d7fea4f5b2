#pragma once
/// HTTP/1.1 messages, bounded, for drivers whose controllers speak it and for simulated ones. One thread.
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace polyarm::wire {

struct HttpMessage {
  int status = 0;              ///< of an answer
  std::string method, target;  ///< of a request
  std::vector<std::pair<std::string, std::string>> headers;
  std::string body;
  /// The first header of the name, in any case; nothing if there is none.
  std::optional<std::string> header(std::string_view name) const;
};

/// Takes the bytes of a connection and finds the messages in them. A head above bounds::kHttpHeadBytes, a
/// body above bounds::kHttpBodyBytes, and what is not HTTP end it: failed() from then on.
class HttpReader {
 public:
  enum class Kind : std::uint8_t { request, answer };
  explicit HttpReader(Kind kind) : kind_(kind) {}
  /// Never keeps more than the bounds; further bytes are a failure.
  void take(std::string_view bytes);
  /// The connection was closed: an answer without a length is complete now.
  void end();
  /// The next complete message.
  std::optional<HttpMessage> next();
  bool failed() const { return failed_; }
  /// Part of a message has come, the rest has not.
  bool unfinished() const { return in_body_ || !bytes_.empty(); }
  /// The answer to a HEAD request, or one with status 204 or 304, has no body: the caller sets this before
  /// the answer comes.
  void expect_no_body(bool on) { no_body_ = on; }

 private:
  enum class Body : std::uint8_t { none, counted, chunked, to_end };
  bool read_head(std::string_view head);
  bool read_start(std::string_view line);
  bool choose_body();
  bool read_body();
  bool read_chunk();
  std::optional<HttpMessage> fail();

  Kind kind_;
  std::string bytes_;
  HttpMessage message_;
  Body body_ = Body::none;
  std::size_t left_ = 0;
  bool in_body_ = false, ended_ = false, failed_ = false, no_body_ = false;
};

/// The bytes of a message, with its Content-Length.
std::string http_text(const HttpMessage& message);

/// `name="value"` pairs of a WWW-Authenticate or Authorization header, without its first word.
std::optional<std::string> http_parameter(std::string_view header, std::string_view name);
/// "user:password" in base64, for Basic.
std::string http_basic(const std::string& user, const std::string& password);
bool http_basic_matches(std::string_view header, const std::string& user, const std::string& password);
/// The value of an Authorization header for a Digest challenge (MD5, qop "auth" or none); empty if it asks
/// for something else.
std::string http_digest(std::string_view challenge, const std::string& user, const std::string& password,
                        const std::string& method, const std::string& target, unsigned count,
                        const std::string& own_nonce);
/// True if a Digest header answers the nonce with this user and password.
bool http_digest_matches(std::string_view header, const std::string& nonce, const std::string& user,
                         const std::string& password, const std::string& method);
/// `a=1&b=two%20words`: the value of a key; empty without it.
std::string form_value(std::string_view form, std::string_view key);
/// Percent-encodes a value of a form or a part of a path.
std::string form_text(std::string_view value);

}  // namespace polyarm::wire
