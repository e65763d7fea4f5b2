#pragma once
/// HTTP as text: heads of answers, and what a header says. Pure.
#include <string>
#include <string_view>

#include "polyarm/server/port.hpp"

namespace polyarm::server {

/// The head of an answer with the empty line behind it.
std::string head_of(const HttpReply& reply, bool keep_alive);

/// Does an Accept-Encoding header allow gzip? Where it is not there, or says q=0, it does not.
bool accepts_gzip(std::string_view accept_encoding);

}  // namespace polyarm::server
