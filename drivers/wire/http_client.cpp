#include "drivers/wire/http_client.hpp"

#include <openssl/rand.h>

#include <array>

#include "polyarm/base/bounds.hpp"
#include "polyarm/realtime/periodic.hpp"

namespace polyarm::wire {

namespace {

constexpr const char* kClosed = "it closed the connection";
constexpr std::size_t kMostCookies = bounds::kHttpCookies, kMostCookieBytes = bounds::kHttpCookieBytes;

std::string random_text() {
  std::array<unsigned char, 8> bytes{};
  ::RAND_bytes(bytes.data(), static_cast<int>(bytes.size()));
  std::string out;
  for (const unsigned char byte : bytes) {
    out += "0123456789abcdef"[byte >> 4];
    out += "0123456789abcdef"[byte & 15];
  }
  return out;
}

}  // namespace

bool HttpClient::fail(Failure failure, const std::string& why) {
  failure_ = failure;
  why_ = why;
  channel_.close();
  return false;
}

void HttpClient::close() {
  channel_.close();
  cookies_.clear();
  challenge_.clear();
}

bool HttpClient::connect() {
  if (settings_.tls && !context_) context_.emplace(TlsContext::End::client);
  std::string why;
  Descriptor socket = connect_tcp(settings_.host, settings_.port, settings_.timeout, why);
  if (!socket) return fail(Failure::unreachable, why);
  own_address_ = local_address(socket.number());
  peer_address_ = wire::peer_address(socket.number());
  channel_ = Channel(std::move(socket), context_ ? &*context_ : nullptr);
  reader_ = HttpReader(HttpReader::Kind::answer);
  if (!channel_.handshake(settings_.timeout, why))
    return why == kConnectionClosed ? fail(Failure::silent, kClosed) : fail(Failure::tls, why);
  seen_fingerprint_ = channel_.fingerprint();
  if (!settings_.fingerprint.empty() && settings_.fingerprint != seen_fingerprint_)
    return fail(Failure::certificate, seen_fingerprint_);
  return true;
}

void HttpClient::keep_cookies(const HttpMessage& answer) {
  for (const auto& [key, value] : answer.headers) {
    if (key != "Set-Cookie" && key != "set-cookie") continue;
    const std::string pair = value.substr(0, value.find(';'));
    const std::size_t equals = pair.find('=');
    if (equals == std::string::npos || pair.size() > kMostCookieBytes) continue;
    if (cookies_.size() < kMostCookies || cookies_.contains(pair.substr(0, equals)))
      cookies_[pair.substr(0, equals)] = pair.substr(equals + 1);
  }
}

std::string HttpClient::authorization(const HttpMessage& request) {
  if (challenge_.starts_with("Basic"))  // readable for everybody without TLS
    return settings_.tls ? http_basic(settings_.user, settings_.password) : "";
  if (challenge_.empty()) return {};
  return http_digest(challenge_, settings_.user, settings_.password, request.method, request.target, ++count_,
                     random_text());
}

std::optional<HttpMessage> HttpClient::receive_answer() {
  const Nanoseconds deadline = realtime::monotonic_now() + settings_.timeout;
  std::array<std::uint8_t, 8192> bytes;
  for (;;) {
    if (auto answer = reader_.next()) {
      if (answer->status / 100 == 1) continue;
      return answer;
    }
    if (reader_.failed()) {
      fail(Failure::bad_answer, "what came is not an HTTP answer");
      return std::nullopt;
    }
    const Received got = channel_.read(bytes);
    if (got.got == Got::bytes) {
      reader_.take({reinterpret_cast<const char*>(bytes.data()), got.count});
    } else if (got.got != Got::nothing) {
      reader_.end();
      if (auto answer = reader_.next()) return answer;
      fail(Failure::silent, kClosed);
      return std::nullopt;
    } else if (const Nanoseconds left = deadline - realtime::monotonic_now();
               left <= 0 || !wait_readable(channel_.descriptor(), left)) {
      if (realtime::monotonic_now() < deadline) continue;
      fail(Failure::silent, "it does not answer in time");
      return std::nullopt;
    }
  }
}

std::optional<HttpMessage> HttpClient::ask_once(HttpMessage request) {
  request.headers.emplace_back("Host", settings_.host);
  std::string cookies;
  for (const auto& [name, value] : cookies_) cookies += (cookies.empty() ? "" : "; ") + name + "=" + value;
  if (!cookies.empty()) request.headers.emplace_back("Cookie", cookies);
  if (const std::string login = authorization(request); !login.empty())
    request.headers.emplace_back("Authorization", login);
  if (!channel_.write(http_text(request), settings_.timeout)) {
    fail(Failure::silent, kClosed);
    return std::nullopt;
  }
  auto answer = receive_answer();
  if (answer) {
    keep_cookies(*answer);
    if (const auto kept = answer->header("Connection"); kept && *kept == "close") channel_.close();
  }
  return answer;
}

std::optional<HttpMessage> HttpClient::ask(const HttpMessage& request) {
  failure_ = Failure::none;
  const bool old = static_cast<bool>(channel_);
  if (!old && !connect()) return std::nullopt;
  auto answer = ask_once(request);
  // A connection that was idle may be closed by now. A request that changes something is not sent again: it
  // may have been carried out.
  if (!answer && old && failure_ == Failure::silent && why_ == kClosed && request.method == "GET") {
    if (!connect()) return std::nullopt;
    failure_ = Failure::none;
    answer = ask_once(request);
  }
  if (!answer || answer->status != 401) return answer;
  const auto challenge = answer->header("WWW-Authenticate");
  if (!challenge || settings_.user.empty()) return answer;
  challenge_ = *challenge;
  count_ = 0;
  if (!channel_ && !connect()) return std::nullopt;
  return ask_once(request);
}

}  // namespace polyarm::wire
