#pragma once
/// HTTP as text: heads of replies, and the Accept-Encoding header. Pure.
#include <string>
#include <string_view>

#include "polyarm/server/port.hpp"

namespace polyarm::server {

/// The head of a reply, including the empty line at its end.
std::string head_of(const HttpReply& reply, bool keep_alive);

/// True if an Accept-Encoding header allows gzip; false if it is empty or says q=0.
bool accepts_gzip(std::string_view accept_encoding);

}  // namespace polyarm::server
