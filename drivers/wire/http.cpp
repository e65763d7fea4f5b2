#include "drivers/wire/http.hpp"

#include <openssl/evp.h>

#include <algorithm>
#include <array>
#include <charconv>

#include "polyarm/base/bounds.hpp"

namespace polyarm::wire {

namespace {

constexpr std::size_t kMostHeaders = bounds::kHttpHeaders;

char lower(char c) {
  return c >= 'A' && c <= 'Z' ? static_cast<char>(c + 32) : c;
}

bool same(std::string_view a, std::string_view b) {
  return std::equal(a.begin(), a.end(), b.begin(), b.end(),
                    [](char x, char y) { return lower(x) == lower(y); });
}

std::string_view trimmed(std::string_view text) {
  while (!text.empty() && (text.front() == ' ' || text.front() == '\t')) text.remove_prefix(1);
  while (!text.empty() && (text.back() == ' ' || text.back() == '\t' || text.back() == '\r'))
    text.remove_suffix(1);
  return text;
}

/// A whole number without anything else.
std::optional<std::size_t> number_of(std::string_view text, int base = 10) {
  std::size_t out = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out, base);
  if (error != std::errc() || end != text.data() + text.size() || text.empty()) return std::nullopt;
  return out;
}

std::string md5(const std::string& text) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> digest{};
  std::size_t size = 0;
  if (::EVP_Q_digest(nullptr, "MD5", nullptr, text.data(), text.size(), digest.data(), &size) != 1) return {};
  constexpr const char* kDigits = "0123456789abcdef";
  std::string out;
  for (std::size_t i = 0; i < size; ++i) {
    out += kDigits[digest[i] >> 4];
    out += kDigits[digest[i] & 15];
  }
  return out;
}

bool plain(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || (c >= '0' && c <= '9') || c == '-' || c == '_' ||
         c == '.' || c == '~' || c == '/';
}

int hex_digit(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (lower(c) >= 'a' && lower(c) <= 'f') return lower(c) - 'a' + 10;
  return -1;
}

/// The answer of RFC 7616 with MD5. `tail`: of the nonces, when the challenge has a qop.
std::string digest_of(const std::string& user, const std::string& realm, const std::string& password,
                      const std::string& method, const std::string& target, const std::string& nonce,
                      const std::string& tail) {
  return md5(md5(user + ":" + realm + ":" + password) + ":" + nonce + ":" + tail +
             md5(method + ":" + target));
}

}  // namespace

std::optional<std::string> HttpMessage::header(std::string_view name) const {
  for (const auto& [key, value] : headers)
    if (same(key, name)) return value;
  return std::nullopt;
}

std::optional<HttpMessage> HttpReader::fail() {
  failed_ = true;
  bytes_.clear();
  return std::nullopt;
}

void HttpReader::take(std::string_view bytes) {
  if (failed_) return;
  if (bytes_.size() + bytes.size() > bounds::kHttpHeadBytes + bounds::kHttpBodyBytes) {
    fail();
    return;
  }
  bytes_.append(bytes);
}

void HttpReader::end() {
  ended_ = true;
}

bool HttpReader::read_start(std::string_view line) {
  const std::size_t first = line.find(' ');
  if (first == std::string_view::npos) return false;
  const std::string_view rest = line.substr(first + 1);
  const std::size_t second = rest.find(' ');
  if (kind_ == Kind::answer) {
    const auto status = number_of(rest.substr(0, second));
    if (!line.starts_with("HTTP/1.") || !status || *status < 100 || *status > 599) return false;
    message_.status = static_cast<int>(*status);
    return true;
  }
  if (second == std::string_view::npos || !rest.substr(second + 1).starts_with("HTTP/1.")) return false;
  message_.method = std::string(line.substr(0, first));
  message_.target = std::string(rest.substr(0, second));
  return !message_.method.empty() && message_.target.starts_with('/');
}

bool HttpReader::read_head(std::string_view head) {
  message_ = {};
  for (bool first = true; !head.empty(); first = false) {
    const std::size_t end = head.find('\n');
    const std::string_view line = trimmed(head.substr(0, end));
    head = end == std::string_view::npos ? std::string_view() : head.substr(end + 1);
    if (line.find('\0') != std::string_view::npos) return false;
    if (first) {
      if (!read_start(line)) return false;
      continue;
    }
    const std::size_t colon = line.find(':');
    if (colon == std::string_view::npos || colon == 0 || message_.headers.size() == kMostHeaders)
      return false;
    message_.headers.emplace_back(line.substr(0, colon), trimmed(line.substr(colon + 1)));
  }
  return choose_body();
}

/// Two lengths, or a length and chunks, are refused: they can hide a second message.
bool HttpReader::choose_body() {
  std::optional<std::size_t> length;
  bool chunked = false;
  for (const auto& [key, value] : message_.headers) {
    if (same(key, "transfer-encoding")) {
      if (!same(value, "chunked") || chunked) return false;
      chunked = true;
    }
    if (same(key, "content-length")) {
      if (length) return false;
      length = number_of(value);
      if (!length || *length > bounds::kHttpBodyBytes) return false;
    }
  }
  if (chunked && length) return false;
  const bool empty =
      message_.status == 204 || message_.status == 304 || message_.status / 100 == 1 || no_body_;
  left_ = length.value_or(0);
  if (empty || (kind_ == Kind::request && !chunked && !length))
    body_ = Body::none;
  else
    body_ = chunked ? Body::chunked : length ? Body::counted : Body::to_end;
  if (body_ == Body::chunked) left_ = 0;
  return true;
}

/// True when a chunk was taken; `body_` is `Body::none` after the last one.
bool HttpReader::read_chunk() {
  const std::size_t end = bytes_.find("\r\n");
  if (end == std::string::npos) {
    if (bytes_.size() > 128) fail();
    return false;
  }
  const std::string_view line = std::string_view(bytes_).substr(0, end);
  const auto size = number_of(trimmed(line.substr(0, line.find(';'))), 16);
  if (!size || *size > bounds::kHttpBodyBytes || message_.body.size() + *size > bounds::kHttpBodyBytes) {
    fail();
    return false;
  }
  if (bytes_.size() < end + 2 + *size + 2) return false;
  if (bytes_.compare(end + 2 + *size, 2, "\r\n") != 0) {  // trailers too: no controller sends them
    fail();
    return false;
  }
  message_.body.append(bytes_, end + 2, *size);
  bytes_.erase(0, end + 4 + *size);
  if (*size == 0) body_ = Body::none;
  return true;
}

/// True when the body is complete.
bool HttpReader::read_body() {
  switch (body_) {
    case Body::none:
      return true;
    case Body::counted:
      if (bytes_.size() < left_) return false;
      message_.body = bytes_.substr(0, left_);
      bytes_.erase(0, left_);
      return true;
    case Body::chunked:
      while (body_ == Body::chunked)
        if (!read_chunk()) return false;
      return true;
    case Body::to_end:
      if (bytes_.size() > bounds::kHttpBodyBytes) fail();
      if (!ended_ || failed_) return false;
      message_.body = std::exchange(bytes_, {});
      return true;
  }
  return false;
}

std::optional<HttpMessage> HttpReader::next() {
  if (failed_) return std::nullopt;
  if (!in_body_) {
    const std::size_t end = bytes_.find("\r\n\r\n");
    if (end == std::string::npos ? bytes_.size() > bounds::kHttpHeadBytes : end > bounds::kHttpHeadBytes)
      return fail();
    if (end == std::string::npos) return std::nullopt;
    if (!read_head(std::string_view(bytes_).substr(0, end))) return fail();
    bytes_.erase(0, end + 4);
    in_body_ = true;
  }
  if (!read_body()) return std::nullopt;
  in_body_ = false;
  return std::exchange(message_, {});
}

std::string http_text(const HttpMessage& message) {
  const bool answer = message.status != 0;
  std::string out = answer ? "HTTP/1.1 " + std::to_string(message.status) + " -\r\n"
                           : message.method + " " + message.target + " HTTP/1.1\r\n";
  for (const auto& [key, value] : message.headers) out += key + ": " + value + "\r\n";
  if (message.status != 204) out += "Content-Length: " + std::to_string(message.body.size()) + "\r\n";
  return out + "\r\n" + message.body;
}

std::optional<std::string> http_parameter(std::string_view header, std::string_view name) {
  for (std::size_t at = 0; (at = header.find(name, at)) != std::string_view::npos; at += name.size()) {
    const bool begins = at == 0 || header[at - 1] == ' ' || header[at - 1] == ',';
    std::string_view rest = header.substr(at + name.size());
    if (!begins || !rest.starts_with('=')) continue;
    rest.remove_prefix(1);
    if (!rest.starts_with('"')) return std::string(trimmed(rest.substr(0, rest.find(','))));
    const std::size_t end = rest.find('"', 1);
    if (end == std::string_view::npos) return std::nullopt;
    return std::string(rest.substr(1, end - 1));
  }
  return std::nullopt;
}

std::string http_basic(const std::string& user, const std::string& password) {
  const std::string both = user + ":" + password;
  std::string out(4 * ((both.size() + 2) / 3) + 1, '\0');
  const int size =
      ::EVP_EncodeBlock(reinterpret_cast<unsigned char*>(out.data()),
                        reinterpret_cast<const unsigned char*>(both.data()), static_cast<int>(both.size()));
  out.resize(static_cast<std::size_t>(std::max(0, size)));
  return "Basic " + out;
}

bool http_basic_matches(std::string_view header, const std::string& user, const std::string& password) {
  return header == http_basic(user, password);
}

std::string http_digest(std::string_view challenge, const std::string& user, const std::string& password,
                        const std::string& method, const std::string& target, unsigned count,
                        const std::string& own_nonce) {
  const auto realm = http_parameter(challenge, "realm"), nonce = http_parameter(challenge, "nonce");
  const auto qop = http_parameter(challenge, "qop"), opaque = http_parameter(challenge, "opaque");
  const std::string algorithm = http_parameter(challenge, "algorithm").value_or("MD5");
  if (!challenge.starts_with("Digest ") || !realm || !nonce || !same(algorithm, "MD5")) return {};
  if (qop && qop->find("auth") == std::string::npos) return {};
  std::string digits = std::to_string(count);
  digits.insert(0, 8 - std::min<std::size_t>(8, digits.size()), '0');
  const std::string tail = qop ? digits + ":" + own_nonce + ":auth:" : "";
  std::string out = "Digest username=\"" + user + "\", realm=\"" + *realm + "\", nonce=\"" + *nonce +
                    "\", uri=\"" + target + "\", algorithm=MD5, response=\"" +
                    digest_of(user, *realm, password, method, target, *nonce, tail) + "\"";
  if (qop) out += ", qop=auth, nc=" + digits + ", cnonce=\"" + own_nonce + "\"";
  if (opaque) out += ", opaque=\"" + *opaque + "\"";
  return out;
}

bool http_digest_matches(std::string_view header, const std::string& nonce, const std::string& user,
                         const std::string& password, const std::string& method) {
  const auto value = [&](std::string_view name) { return http_parameter(header, name).value_or(""); };
  if (!header.starts_with("Digest ") || value("nonce") != nonce || value("username") != user) return false;
  const std::string tail =
      value("qop").empty() ? "" : value("nc") + ":" + value("cnonce") + ":" + value("qop") + ":";
  return value("response") == digest_of(user, value("realm"), password, method, value("uri"), nonce, tail);
}

std::string form_value(std::string_view form, std::string_view key) {
  while (!form.empty()) {
    const std::size_t end = form.find('&');
    const std::string_view pair = form.substr(0, end);
    form = end == std::string_view::npos ? std::string_view() : form.substr(end + 1);
    const std::size_t equals = pair.find('=');
    if (equals == std::string_view::npos || pair.substr(0, equals) != key) continue;
    std::string out;
    const std::string_view value = pair.substr(equals + 1);
    for (std::size_t i = 0; i < value.size(); ++i) {
      const int high = i + 2 < value.size() ? hex_digit(value[i + 1]) : -1;
      const int low = i + 2 < value.size() ? hex_digit(value[i + 2]) : -1;
      if (value[i] == '%' && high >= 0 && low >= 0) {
        out += static_cast<char>(high * 16 + low);
        i += 2;
      } else {
        out += value[i] == '+' ? ' ' : value[i];
      }
    }
    return out;
  }
  return {};
}

std::string form_text(std::string_view value) {
  constexpr const char* kDigits = "0123456789ABCDEF";
  std::string out;
  for (const char c : value) {
    const auto byte = static_cast<unsigned char>(c);
    if (plain(c))
      out += c;
    else
      (out += '%') += kDigits[byte >> 4], out += kDigits[byte & 15];
  }
  return out;
}

}  // namespace polyarm::wire
