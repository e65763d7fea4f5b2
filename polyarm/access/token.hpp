#pragma once
/// The secret token that a browser or program must send before it is served.
#include <filesystem>
#include <string>
#include <string_view>

#include "polyarm/protocol/facts.hpp"

namespace polyarm::server {

/// 256 random bits from the system as 43 characters of base64url. Throws Error("no-random").
std::string make_token();

/// Compares in constant time for texts of equal length; the lengths are not secret.
bool same_token(std::string_view a, std::string_view b) noexcept;

/// The token of a link that allows no more than `role`. It is derived from the full token, which cannot be
/// computed from it.
std::string token_for(const std::string& token, protocol::Role role);

/// The text with "…" in place of each token of a link, `?token=…`. Also for JSON text.
std::string without_tokens(std::string text);

/// The token in `file`, readable only by this user; it survives a restart, so an open page stays connected. A
/// new one is made if there is none or another user could have read it. Throws Error("no-token").
std::string kept_token(const std::filesystem::path& file);

}  // namespace polyarm::server
