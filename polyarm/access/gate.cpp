#include "polyarm/access/gate.hpp"

#include <algorithm>
#include <cctype>
#include <cstdint>
#include <optional>

#include "polyarm/access/token.hpp"
#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::server {

namespace {

int hex(char c) {
  if (c >= '0' && c <= '9') return c - '0';
  if (c >= 'a' && c <= 'f') return c - 'a' + 10;
  if (c >= 'A' && c <= 'F') return c - 'A' + 10;
  return -1;
}

std::optional<std::string> decoded(std::string_view text) {
  std::string out;
  for (std::size_t i = 0; i < text.size(); ++i) {
    if (text[i] != '%') {
      out += text[i];
      continue;
    }
    if (i + 2 >= text.size() || hex(text[i + 1]) < 0 || hex(text[i + 2]) < 0) return std::nullopt;
    out += static_cast<char>(hex(text[i + 1]) * 16 + hex(text[i + 2]));
    i += 2;
  }
  return out;
}

/// Nothing if a character is not of base64, or the length is wrong.
std::optional<std::string> from_base64(std::string_view text) {
  constexpr std::string_view kAlphabet = "ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
  if (text.size() % 4 != 0) return std::nullopt;
  for (int n = 0; n < 2 && text.ends_with('='); ++n) text.remove_suffix(1);
  std::string out;
  std::uint32_t bits = 0;
  int count = 0;
  for (const char c : text) {
    const auto value = kAlphabet.find(c);
    if (value == std::string_view::npos) return std::nullopt;
    bits = ((bits << 6) | static_cast<std::uint32_t>(value)) & 0xffffff;
    if ((count += 6) >= 8) out += static_cast<char>((bits >> (count -= 8)) & 0xff);
  }
  return out;
}

bool is_number(std::string_view text, std::size_t most) {
  return !text.empty() && text.size() <= most &&
         std::all_of(text.begin(), text.end(), [](char c) { return c >= '0' && c <= '9'; });
}

/// Four numbers up to 255, separated by dots.
bool is_ipv4(std::string_view text) {
  int parts = 0;
  for (;; ++parts) {
    const auto point = text.find('.');
    const std::string_view part = text.substr(0, point);
    if (!is_number(part, 3) || std::stoi(std::string(part)) > 255) return false;
    if (point == std::string_view::npos) break;
    text.remove_prefix(point + 1);
  }
  return parts == 3;
}

/// The name in a Host header without its port; empty if it is malformed.
std::string name_of(std::string_view host) {
  std::string_view name = host, rest;
  if (host.starts_with('[')) {
    const auto end = host.find(']');
    if (end == std::string_view::npos) return {};
    name = host.substr(0, end + 1);
    rest = host.substr(end + 1);
  } else if (const auto colon = host.find(':'); colon != std::string_view::npos) {
    name = host.substr(0, colon);
    rest = host.substr(colon);
  }
  if (!rest.empty() && (rest[0] != ':' || !is_number(rest.substr(1), 5))) return {};
  return lower(std::string(name));
}

bool is_ipv6(std::string_view name) {
  return name.size() > 3 && name.front() == '[' && name.back() == ']' &&
         name.find_first_not_of("0123456789abcdef:.", 1) == name.size() - 1;
}

}  // namespace

std::string path_of(std::string_view target) {
  const std::string_view raw = target.substr(0, target.find_first_of("?#"));
  if (!raw.starts_with('/')) return {};
  const std::optional<std::string> path = decoded(raw);
  if (!path || path->find('\\') != std::string::npos || path->find('\0') != std::string::npos) return {};
  for (std::string_view rest = *path; !rest.empty();) {
    const auto slash = rest.find('/');
    if (rest.substr(0, slash) == "..") return {};
    if (slash == std::string_view::npos) break;
    rest.remove_prefix(slash + 1);
  }
  return *path;
}

std::string query_value(std::string_view target, std::string_view name) {
  const auto question = target.find('?');
  if (question == std::string_view::npos) return {};
  std::string_view rest = target.substr(question + 1);
  rest = rest.substr(0, rest.find('#'));
  while (!rest.empty()) {
    const std::string_view item = rest.substr(0, rest.find('&'));
    rest.remove_prefix(std::min(rest.size(), item.size() + 1));
    const auto equals = item.find('=');
    if (equals != std::string_view::npos && item.substr(0, equals) == name)
      return decoded(item.substr(equals + 1)).value_or("");
  }
  return {};
}

std::string cookie_value(std::string_view cookies, std::string_view name) {
  while (!cookies.empty()) {
    const std::string_view item = cookies.substr(0, cookies.find(';'));
    cookies.remove_prefix(std::min(cookies.size(), item.size() + 1));
    const std::string_view cookie = trim(item);
    const auto equals = cookie.find('=');
    if (equals != std::string_view::npos && cookie.substr(0, equals) == name)
      return std::string(cookie.substr(equals + 1));
  }
  return {};
}

bool host_allowed(std::string_view host, const GateRules& rules) {
  const std::string name = name_of(host);
  if (name == "localhost" || name == "[::1]" || (is_ipv4(name) && name.starts_with("127."))) return true;
  if (rules.loopback) return false;
  return is_ipv4(name) || is_ipv6(name) ||
         std::find(rules.names.begin(), rules.names.end(), name) != rules.names.end();
}

Claim claim_of(const Head& head, const GateRules& rules) {
  const auto judged = [&](std::string_view token, Shown as) {
    Claim out{Shown::wrong, protocol::Role::watch, nullptr, std::string(token)};
    if (same_token(token, rules.token)) out.how = as, out.role = protocol::Role::administer;
    for (const auto& [lesser, role] : rules.lesser)
      if (same_token(token, lesser)) out.how = as, out.role = role;
    if (out.how == Shown::wrong && rules.login) out.login = rules.login(token);
    if (out.login) out.how = as, out.role = out.login->role;
    return out;
  };
  constexpr std::string_view kBearer = "bearer ";
  if (lower(head.authorization.substr(0, kBearer.size())) == kBearer)
    return judged(std::string_view(head.authorization).substr(kBearer.size()), Shown::bearer);
  if (const std::string token = query_value(head.target, "token"); !token.empty())
    return judged(token, Shown::query);
  if (const std::string token = cookie_value(head.cookie, rules.cookie); !token.empty())
    return judged(token, Shown::cookie);
  return {};
}

Shown shown_token(const Head& head, const GateRules& rules) {
  return claim_of(head, rules).how;
}

protocol::Role shown_role(const Head& head, const GateRules& rules) {
  return claim_of(head, rules).role;
}

std::shared_ptr<Login> shown_login(const Head& head, const GateRules& rules) {
  return claim_of(head, rules).login;
}

std::string shown_text(const Head& head, const GateRules& rules) {
  return claim_of(head, rules).token;
}

std::optional<std::pair<std::string, std::string>> basic_credentials(std::string_view authorization) {
  constexpr std::string_view kBasic = "basic ";
  if (lower(authorization.substr(0, kBasic.size())) != kBasic ||
      authorization.size() > bounds::kCredentialsBytes)
    return std::nullopt;
  const std::optional<std::string> text = from_base64(trim(authorization.substr(kBasic.size())));
  if (!text) return std::nullopt;
  const auto colon = text->find(':');
  if (colon == std::string::npos || colon == 0) return std::nullopt;
  return std::pair{text->substr(0, colon), text->substr(colon + 1)};
}

Verdict judge_origin(const Head& head, const GateRules& rules) {
  if (!host_allowed(head.host, rules))
    return {421, "this address is not served: open the link that polyarm printed"};
  if (!head.origin.empty() && head.origin != (head.secure ? "https://" : "http://") + head.host)
    return {403, "a page from another site is refused"};
  if (!head.fetch_site.empty() && head.fetch_site != "same-origin" && head.fetch_site != "none")
    return {403, "a page from another site is refused"};
  return {};
}

Verdict judge(const Head& head, const GateRules& rules, bool changes) {
  if (const Verdict verdict = judge_origin(head, rules); verdict.status != 200) return verdict;
  const Shown shown = shown_token(head, rules);
  if (shown == Shown::nothing) return {401, "the token is missing: open the link that polyarm printed"};
  if (shown == Shown::wrong) return {403, "the token is wrong: open the link that polyarm printed last"};
  if (changes && head.origin.empty() && shown == Shown::cookie)
    return {403, "the Origin is missing: programs send the token themselves"};
  return {};
}

Verdict judge_viewer(const Head& head, const GateRules& rules) {
  if (!host_allowed(head.host, rules))
    return {421, "this address is not served: open the link that polyarm printed"};
  const Shown shown = shown_token(head, rules);
  if (shown == Shown::query || shown == Shown::bearer) return {};
  return judge(head, rules, true);
}

}  // namespace polyarm::server
