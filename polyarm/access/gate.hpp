#pragma once
/// Access control: decides from the head of an HTTP request whether to serve it. Pure functions.
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "polyarm/access/logins.hpp"
#include "polyarm/protocol/facts.hpp"

namespace polyarm::server {

/// The parts of the head that are checked, as received. Empty: the header is missing.
struct Head {
  std::string method, target;
  std::string host, origin, cookie, authorization, fetch_site;
  bool secure = false;  ///< received through TLS
};

struct GateRules {
  std::string token;                                           ///< allows everything
  std::vector<std::pair<std::string, protocol::Role>> lesser;  ///< tokens that allow less
  /// Finds the log-in with this token; null if the token belongs to no user. The function may be empty.
  std::function<std::shared_ptr<Login>(std::string_view)> login;
  std::string cookie;              ///< name of the cookie that carries the token
  bool loopback = true;            ///< only names of the loopback interface are accepted
  std::vector<std::string> names;  ///< names of this machine, lower case; accepted if `loopback` is false
};

/// The path of a target, with %XX decoded. Empty if it is invalid: it does not begin with '/', or contains a
/// NUL, a backslash, a broken %XX or a step `..`.
std::string path_of(std::string_view target);
/// The value of `name` in the target's query, decoded; empty if it is missing.
std::string query_value(std::string_view target, std::string_view name);
/// The value of a cookie; empty if it is missing.
std::string cookie_value(std::string_view cookies, std::string_view name);

/// True if the Host header names this machine, by an address or one of its own names. This keeps out a page
/// elsewhere whose name was made to resolve to this machine (DNS rebinding).
bool host_allowed(std::string_view host, const GateRules& rules);

/// How a request carries the token.
enum class Shown { nothing, wrong, cookie, query, bearer };
/// What a request shows. Log-ins end at any time: who needs several of these takes them from one claim.
struct Claim {
  Shown how = Shown::nothing;
  protocol::Role role = protocol::Role::watch;  ///< that the token allows; `watch` if it is missing or wrong
  std::shared_ptr<Login> login;                 ///< of a user; null: another token, or none
  std::string token;                            ///< as sent, right or wrong
};
Claim claim_of(const Head& head, const GateRules& rules);
Shown shown_token(const Head& head, const GateRules& rules);
/// The role that the request's token allows; `watch` if the token is missing or wrong.
protocol::Role shown_role(const Head& head, const GateRules& rules);

/// The log-in whose token the request carries; null: another token, or none.
std::shared_ptr<Login> shown_login(const Head& head, const GateRules& rules);
/// The token that the request carries, right or wrong; empty: none.
std::string shown_text(const Head& head, const GateRules& rules);

/// Name and password of `Authorization: Basic …` (RFC 7617); nothing if it is missing or malformed.
std::optional<std::pair<std::string, std::string>> basic_credentials(std::string_view authorization);

struct Verdict {
  int status = 200;  ///< 401, 403 or 421 if refused
  const char* why = "";
};
/// Decides about a request that needs no token but changes something: a log-in. Only a page of this port, or
/// a program, may send it.
Verdict judge_origin(const Head& head, const GateRules& rules);
/// Decides about a request that needs the token. `changes`: the method is not GET, or the request opens a
/// WebSocket; then its Origin must equal the Host, or be missing while the token is sent by other means than
/// the cookie.
Verdict judge(const Head& head, const GateRules& rules, bool changes);
/// Decides whether the request may open a read-only viewer. A page of another tool may, from any origin, if
/// it sends the token itself; with the cookie alone, judge() applies.
Verdict judge_viewer(const Head& head, const GateRules& rules);

}  // namespace polyarm::server
