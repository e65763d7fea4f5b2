#include "polyarm/fleet/cell_client.hpp"

#include <openssl/sha.h>
#include <openssl/x509.h>

#include <array>
#include <boost/asio/connect.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/beast/core.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket.hpp>
#include <chrono>
#include <nlohmann/json.hpp>

#include "polyarm/base/bounds.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/fleet/cell_stream.hpp"

namespace polyarm::fleet {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace ws = beast::websocket;
using tcp = net::ip::tcp;
using Failure = boost::system::error_code;
using Json = nlohmann::json;

namespace {

using Socket = ws::stream<CellStream>;

std::string fingerprint_of(SSL* connection) {
  X509* const certificate = ::SSL_get1_peer_certificate(connection);
  if (!certificate) return {};
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  unsigned size = digest.size();
  const bool good = ::X509_digest(certificate, ::EVP_sha256(), digest.data(), &size) == 1;
  ::X509_free(certificate);
  std::string out;
  constexpr const char* kDigits = "0123456789ABCDEF";
  for (const unsigned char byte : digest) out += kDigits[byte >> 4], out += kDigits[byte & 15];
  return good ? out : std::string{};
}

/// As the terminal of the cell prints it.
std::string with_colons(const std::string& digits) {
  std::string out;
  for (std::size_t i = 0; i < digits.size(); ++i) {
    if (i > 0 && i % 2 == 0) out += ':';
    out += digits[i];
  }
  return out;
}

}  // namespace

Json parse_answer(const std::string& text) {
  constexpr int kDeepest = bounds::kSiteNesting;  // copies and dumps call themselves for each level
  return Json::parse(
      text, [](int depth, Json::parse_event_t, Json&) { return depth < kDeepest; }, false);
}

class CellClient::Work {
 public:
  Work(SiteCell cell, double timeout_s) : cell_(std::move(cell)), timeout_s_(timeout_s) {}

  std::string get(const std::string& path) {
    context_.restart();
    http::request<http::empty_body> request{http::verb::get, path, 11};
    request.set(http::field::host, host());
    request.set(http::field::authorization, "Bearer " + cell_.token);
    CellStream stream(context_);
    connect(stream);
    return exchange(stream, request);
  }

  Json ask(Json request) {
    context_.restart();
    if (!socket_) open();
    const std::uint64_t id = ++last_id_;
    request["id"] = id;
    const std::string text = request.dump(-1, ' ', false, Json::error_handler_t::replace);
    try {
      return converse(text, id);
    } catch (const Error& e) {
      if (e.problems().front().code == kLost) close();
      throw;
    }
  }

  void close() noexcept {
    try {
      context_.restart();
      if (socket_) {
        beast::get_lowest_layer(*socket_).expires_after(std::chrono::seconds(1));
        socket_->async_close(ws::close_code::normal, [](Failure) {});
        context_.run();
      }
    } catch (...) {  // the connection is gone already
    }
    socket_.reset();
  }

 private:
  static constexpr const char* kLost = "no-cell-answer";

  [[noreturn]] void lose(const std::string& what) const {
    throw Error(kLost, cell_.name + " at " + host() + " " + what,
                "is the cell running, and reachable from here?");
  }
  void check(Failure failed, const char* what) const {
    if (failed) lose(std::string(what) + ": " + failed.message());
  }
  std::string host() const {
    const bool six = cell_.host.find(':') != std::string::npos;
    return (six ? "[" + cell_.host + "]" : cell_.host) + ":" + std::to_string(cell_.port);
  }
  auto limit() const { return std::chrono::milliseconds(static_cast<int>(timeout_s_ * 1000)); }

  /// Runs until the operation that was begun has ended; the stream's own time limit ends it.
  template <class Begin>
  void run(CellStream::Tcp& lowest, const char* what, Begin begin) {
    Failure result;
    lowest.expires_after(limit());
    begin(result);
    context_.run();
    context_.restart();
    check(result, what);
  }

  void connect(CellStream& stream) {
    Failure failed;
    tcp::resolver resolver(context_);
    const auto found = resolver.resolve(cell_.host, std::to_string(cell_.port), failed);
    check(failed, "has no address");
    CellStream::Tcp& lowest = stream.next_layer();
    run(lowest, "cannot be reached", [&](Failure& result) {
      lowest.async_connect(found, [&result](Failure f, const tcp::endpoint&) { result = f; });
    });
    lowest.socket().set_option(tcp::no_delay(true), failed);
    if (cell_.tls) shake_hands(stream);
  }

  /// The certificate is known by its fingerprint, as the terminal of the cell prints it; no authority is
  /// asked.
  void shake_hands(CellStream& stream) {
    CellStream::Tls& tls = stream.begin_tls(tls_);
    run(stream.next_layer(), "speaks no TLS", [&](Failure& result) {
      tls.async_handshake(net::ssl::stream_base::client, [&result](Failure f) { result = f; });
    });
    const std::string shown = fingerprint_of(tls.native_handle());
    if (shown != cell_.fingerprint)
      lose("has another certificate than the file of the site says: " + with_colons(shown));
  }

  std::string exchange(CellStream& stream, const http::request<http::empty_body>& request) {
    CellStream::Tcp& lowest = stream.next_layer();
    run(lowest, "takes no request", [&](Failure& result) {
      http::async_write(stream, request, [&result](Failure f, std::size_t) { result = f; });
    });
    beast::flat_buffer buffer;
    http::response_parser<http::string_body> parser;
    parser.body_limit(kMostAnswer);
    run(lowest, "does not answer", [&](Failure& result) {
      http::async_read(stream, buffer, parser, [&result](Failure f, std::size_t) { result = f; });
    });
    const int status = parser.get().result_int();
    if (status != 200)
      throw Error(
          "refused",
          cell_.name + " refuses (" + std::to_string(status) +
              "): " + std::string(trim(parser.get().body().substr(0, 200))),
          status == 401 || status == 403 ? "is the token in token_file that of the running cell?" : "");
    return std::move(parser.get().body());
  }

  void upgrade(Socket& socket) {
    // The lowest layer's time limit is used for each step; the WebSocket's own is off.
    socket.set_option(ws::stream_base::timeout{ws::stream_base::none(), ws::stream_base::none(), false});
    socket.set_option(ws::stream_base::decorator([token = cell_.token](ws::request_type& request) {
      request.set(http::field::authorization, "Bearer " + token);
    }));
    socket.read_message_max(kMostAnswer);
    run(beast::get_lowest_layer(socket), "opens no WebSocket", [&](Failure& result) {
      socket.async_handshake(host(), "/ws", [&result](Failure f) { result = f; });
    });
  }

  void open() {
    auto made = std::make_unique<Socket>(context_);
    connect(made->next_layer());
    upgrade(*made);
    socket_ = std::move(made);
  }

  Json converse(const std::string& text, std::uint64_t id) {
    Socket& socket = *socket_;
    CellStream::Tcp& lowest = beast::get_lowest_layer(socket);
    socket.text(true);
    run(lowest, "takes no request", [&](Failure& result) {
      socket.async_write(net::buffer(text), [&result](Failure f, std::size_t) { result = f; });
    });
    for (const auto until = std::chrono::steady_clock::now() + limit();
         std::chrono::steady_clock::now() < until;) {
      beast::flat_buffer buffer;
      run(lowest, "does not answer", [&](Failure& result) {
        socket.async_read(buffer, [&result](Failure f, std::size_t) { result = f; });
      });
      const Json answer = parse_answer(beast::buffers_to_string(buffer.data()));
      if (!answer.is_object() || answer.value("id", Json()) != id) continue;  // an event
      if (answer.contains("ok") && answer["ok"] == true) return answer.value("result", Json());
      const Json error = answer.value("error", Json::object());
      const auto part = [&](const char* key) {
        return error.is_object() && error.contains(key) && error[key].is_string()
                   ? error[key].get<std::string>().substr(0, 500)
                   : std::string();
      };
      throw Error(part("code").empty() ? "refused" : part("code"), part("what"), part("advice"));
    }
    lose("does not answer in time");
  }

  const SiteCell cell_;
  const double timeout_s_;
  net::io_context context_{1};
  net::ssl::context tls_{net::ssl::context::tls_client};
  std::unique_ptr<Socket> socket_;
  std::uint64_t last_id_ = 0;
};

CellClient::CellClient(SiteCell cell, double timeout_s)
    : work_(std::make_unique<Work>(std::move(cell), timeout_s)) {}
CellClient::~CellClient() = default;
std::string CellClient::get(const std::string& path) {
  return work_->get(path);
}
Json CellClient::ask(Json request) {
  return work_->ask(std::move(request));
}
void CellClient::close() noexcept {
  work_->close();
}

}  // namespace polyarm::fleet
