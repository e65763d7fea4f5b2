#pragma once
/// Who is let in: decided from the heads of HTTP requests alone, by pure functions.
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "polyarm/protocol/facts.hpp"

namespace polyarm::server {

/// What the gate looks at. Texts as they came; empty: the header was not there.
struct Head {
  std::string method, target;
  std::string host, origin, cookie, authorization, fetch_site;
  bool secure = false;  ///< it came through TLS
};

struct GateRules {
  std::string token;               ///< it allows everything
  std::vector<std::pair<std::string, protocol::Role>> lesser;  ///< tokens that allow less
  std::string cookie;              ///< name of the cookie that carries it
  bool loopback = true;            ///< only names of this machine itself are served
  std::vector<std::string> names;  ///< of this machine, lower case, served where not only loopback is
};

/// The path of a target, with %XX decoded; empty where it is none: it does not begin with '/', has a NUL, a
/// backslash, a broken %XX or a step `..`.
std::string path_of(std::string_view target);
/// The value of `name` in the target's query, decoded; empty where there is none.
std::string query_value(std::string_view target, std::string_view name);
/// The value of a cookie; empty where there is none.
std::string cookie_value(std::string_view cookies, std::string_view name);

/// Does the Host header name this machine by an address or a name of its own? A page elsewhere whose name was
/// made to point here (DNS rebinding) does not.
bool host_allowed(std::string_view host, const GateRules& rules);

/// How a request shows the token.
enum class Shown { nothing, wrong, cookie, query, bearer };
Shown shown_token(const Head& head, const GateRules& rules);
/// What the token that it shows allows; watch where it shows none that is right.
protocol::Role shown_role(const Head& head, const GateRules& rules);

/// May it read what only a holder of the token sees? `changes`: it is no GET, or opens a WebSocket: then its
/// Origin has to be the Host, or absent together with a token that is not the cookie.
struct Verdict {
  int status = 200;  ///< 401, 403 or 421 where it is refused
  const char* why = "";
};
Verdict judge(const Head& head, const GateRules& rules, bool changes);
/// May it watch, who can move nothing? A page of another tool, wherever it comes from, may where it shows the
/// token itself; with a cookie alone it is judged as every other.
Verdict judge_viewer(const Head& head, const GateRules& rules);

}  // namespace polyarm::server
