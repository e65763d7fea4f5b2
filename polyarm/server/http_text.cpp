#include "polyarm/server/http_text.hpp"

#include <cstdlib>
#include <optional>

#include "polyarm/base/text.hpp"

namespace polyarm::server {

namespace {

const char* reason(int status) {
  switch (status) {
    case 200:
      return "OK";
    case 302:
      return "Found";
    case 304:
      return "Not Modified";
    case 400:
      return "Bad Request";
    case 401:
      return "Unauthorized";
    case 403:
      return "Forbidden";
    case 404:
      return "Not Found";
    case 405:
      return "Method Not Allowed";
    case 413:
      return "Payload Too Large";
    case 421:
      return "Misdirected Request";
    case 429:
      return "Too Many Requests";
    case 503:
      return "Service Unavailable";
    default:
      return status < 400 ? "OK" : "Error";
  }
}

/// The weight in the parameters of a coding; 1 if there is none.
double weight_of(std::string_view parameters) {
  const auto at = parameters.find("q=");
  return at == std::string_view::npos ? 1 : std::atof(std::string(parameters.substr(at + 2)).c_str());
}

}  // namespace

std::string head_of(const HttpReply& reply, bool keep_alive) {
  std::string out = "HTTP/1.1 " + std::to_string(reply.status) + " " + reason(reply.status) + "\r\n";
  const auto line = [&](const std::string& name, const std::string& value) {
    out += name + ": " + value + "\r\n";
  };
  line("Content-Type", reply.type);
  line("Content-Length", std::to_string(reply.body ? reply.body->size() : 0));
  line("Connection", keep_alive ? "keep-alive" : "close");
  if (reply.gzip) line("Content-Encoding", "gzip");
  line("X-Content-Type-Options", "nosniff");
  line("Referrer-Policy", "no-referrer");
  line("X-Frame-Options", "DENY");
  line("Cross-Origin-Opener-Policy", "same-origin");
  line("Cross-Origin-Resource-Policy", "same-origin");
  line("Content-Security-Policy",
       "default-src 'self'; script-src 'self'; connect-src 'self' blob:; img-src 'self' data: blob:; "
       "style-src 'self' 'unsafe-inline'; worker-src 'self' blob:; font-src 'self'; object-src 'none'; "
       "base-uri 'none'; form-action 'none'; frame-ancestors 'none'");
  for (const auto& [name, value] : reply.headers) line(name, value);
  return out + "\r\n";
}

bool accepts_gzip(std::string_view accept_encoding) {
  std::optional<double> named, any;
  while (!accept_encoding.empty()) {
    const std::string_view item = accept_encoding.substr(0, accept_encoding.find(','));
    accept_encoding.remove_prefix(std::min(accept_encoding.size(), item.size() + 1));
    const auto semicolon = item.find(';');
    const std::string coding = lower(std::string(trim(item.substr(0, semicolon))));
    const double weight =
        semicolon == std::string_view::npos ? 1 : weight_of(lower(std::string(item.substr(semicolon))));
    if (coding == "gzip" || coding == "x-gzip") named = weight;
    if (coding == "*") any = weight;
  }
  return named.value_or(any.value_or(0)) > 0;
}

HttpReply plain(int status, const std::string& text) {
  HttpReply out;
  out.status = status;
  out.body = std::make_shared<const std::string>(text + "\n");
  out.headers.emplace_back("Cache-Control", "no-store");
  return out;
}

}  // namespace polyarm::server
