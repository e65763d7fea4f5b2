#pragma once
/// The secret that a browser or program has to show before it is served.
#include <filesystem>
#include <string>
#include <string_view>

#include "polyarm/protocol/facts.hpp"

namespace polyarm::server {

/// 256 random bits from the system as 43 characters of base64url. Throws Error("no-random").
std::string make_token();

/// Takes the same time whatever the texts have in common; their lengths are no secret.
bool same_token(std::string_view a, std::string_view b) noexcept;

/// The token of a link that allows no more than `role`, made from the one that allows everything, which cannot be
/// found from it.
std::string token_for(const std::string& token, protocol::Role role);

/// The token that `file` keeps, readable for this user alone, so that a page that is open outlives a restart;
/// made anew where there is none or somebody else could have read it. Throws Error("no-token").
std::string kept_token(const std::filesystem::path& file);

}  // namespace polyarm::server
