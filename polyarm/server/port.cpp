#include "polyarm/server/port.hpp"

#include <atomic>
#include <boost/asio/error.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/asio/ip/v6_only.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/steady_timer.hpp>
#include <boost/asio/write.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/detect_ssl.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <boost/beast/http/parser.hpp>
#include <boost/beast/http/read.hpp>
#include <boost/beast/http/string_body.hpp>
#include <boost/beast/websocket.hpp>
#include <boost/beast/websocket/ssl.hpp>
#include <chrono>
#include <list>
#include <map>
#include <set>
#include <thread>

#include "polyarm/base/error.hpp"
#include "polyarm/base/spare_descriptor.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/server/http_text.hpp"
#include "polyarm/server/wire.hpp"

namespace polyarm::server {

namespace net = boost::asio;
namespace beast = boost::beast;
namespace http = beast::http;
namespace ws = beast::websocket;
using tcp = net::ip::tcp;
using Failure = boost::system::error_code;

namespace {

constexpr std::size_t kMostAnnounced = 64 << 20, kMostHead = bounds::kHeadBytes, kMostMessage = bounds::kRequestBytes,
                      kBuffer = 64 << 10;
/// Send buffer of a WebSocket in the system: more data would be old by the time it is read.
constexpr int kSendBuffer = 128 << 10;
constexpr double kClosing_s = 0.5;
/// Pauses in accepting: after the process ran out of descriptors, and after too many connections came.
constexpr double kShortage_s = 0.1, kCrowd_s = 0.02;

std::chrono::nanoseconds duration(double seconds) {
  return std::chrono::nanoseconds(static_cast<std::int64_t>(seconds * 1e9));
}

double steady_now() {
  return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count();
}

}  // namespace

class Port::Work {
 public:
  Work(PortOptions given, Site& behind) : site(behind), options(std::move(given)), acceptor_(context) {
    if (!options.certificate.empty()) make_tls();
    listen();
    GateRules& rules = options.rules;
    if (rules.cookie.empty()) rules.cookie = "polyarm_token_" + std::to_string(number());
    accept();
    thread_ = std::thread([this] { context.run(); });
  }

  ~Work() {
    net::post(context, [this] { close_in_order(); });
    thread_.join();
  }

  std::uint16_t number() const { return acceptor_number_; }

  void wake();

  class Http;
  class Socket;

  Site& site;
  PortOptions options;

 private:
  // Connections. They outlive the context, whose destructor destroys sockets.
  std::size_t known_ = 0;  // count of connections that have shown a token
  std::size_t uploads_ = 0;
  std::list<Http*> unauthenticated_;  // connections that have not, oldest first
  std::set<Socket*> sockets_;

 public:
  net::io_context context{1};
  std::atomic<std::uint64_t> connections{0}, refused{0}, requests{0}, timed_out{0};

  /// Counts a connection that has shown a token. Returns false if there are too many.
  bool know(Http* connection) {
    if (known_ >= options.most_connections) return false;
    unauthenticated_.remove(connection);
    ++known_;
    return true;
  }
  void known_left() { --known_; }
  void unauthenticated_left(Http* connection) { unauthenticated_.remove(connection); }
  bool begin_upload() {
    if (uploads_ >= bounds::kUploads) return false;
    ++uploads_;
    return true;
  }
  void end_upload() { --uploads_; }
  /// Null: this port has no TLS.
  net::ssl::context* tls() { return tls_.get(); }
  void add(Socket* socket) { sockets_.insert(socket); }
  void remove(Socket* socket) { sockets_.erase(socket); }

 private:
  friend class Http;

  void make_tls() {
    tls_ = std::make_unique<net::ssl::context>(net::ssl::context::tls_server);
    try {
      tls_->set_options(net::ssl::context::no_tlsv1 | net::ssl::context::no_tlsv1_1 |
                        net::ssl::context::no_compression);
      tls_->use_certificate_chain(net::buffer(options.certificate));
      tls_->use_private_key(net::buffer(options.key), net::ssl::context::pem);
    } catch (const boost::system::system_error& e) {
      throw Error("no-certificate", std::string("the certificate cannot be used: ") + e.what());
    }
  }

  void listen() {
    Failure failed;
    const auto address = net::ip::make_address(options.address, failed);
    if (failed)
      throw Error("no-port", "'" + options.address + "' is not an address of this machine",
                  "for example 0.0.0.0");
    const tcp::endpoint where(address, options.port);
    const auto step = [&](auto action) {
      if (!failed) action();
    };
    acceptor_.open(where.protocol(), failed);
    step([&] { acceptor_.set_option(net::socket_base::reuse_address(true), failed); });
    if (address.is_v6()) step([&] { acceptor_.set_option(net::ip::v6_only(false), failed); });
    step([&] { acceptor_.bind(where, failed); });
    step([&] { acceptor_.listen(64, failed); });
    if (failed)
      throw Error(
          "no-port",
          "port " + std::to_string(options.port) + " of " + options.address +
              " cannot be opened: " + failed.message(),
          failed == net::error::address_in_use ? "another program has it: choose one with --port N" : "");
    acceptor_.native_non_blocking(true, failed);
    acceptor_number_ = acceptor_.local_endpoint().port();
  }

  void accept();
  bool may_accept();
  void rest_from_accepting(double seconds);
  void make_room_for_unauthenticated();
  void close_in_order();

  std::unique_ptr<net::ssl::context> tls_;
  SpareDescriptor spare_;
  tcp::acceptor acceptor_;
  std::unique_ptr<net::steady_timer> rest_;
  std::uint16_t acceptor_number_ = 0;
  std::atomic<bool> woken_{false};
  double may_come_ = bounds::kAcceptBurst, accepted_at_ = 0;
  bool over_ = false;
  std::unique_ptr<net::steady_timer> closing_answer_;
  std::thread thread_;
};

namespace {

/// The stream of a client that sends requests and gets answers and events.
class ClientStream : public Stream {
 public:
  explicit ClientStream(std::shared_ptr<Client> client) : client_(std::move(client)) {}
  const char* take(std::string message, bool binary, double now) override {
    if (binary) return "requests are text";
    return client_->take(std::move(message), now) ? nullptr : "too many requests a second";
  }
  std::optional<Client::Out> next() override { return client_->next(); }
  bool gone() const override { return client_->gone(); }
  void leave() override { client_->leave(); }

 private:
  std::shared_ptr<Client> client_;
};

}  // namespace

/// A WebSocket and the stream that it carries.
class Port::Work::Socket : public std::enable_shared_from_this<Socket> {
 public:
  /// `login`: of a user; null: the client came by a link.
  Socket(Work& work, Wire wire, std::shared_ptr<Stream> client, std::shared_ptr<Login> login)
      : work_(work), stream_(std::move(wire)), client_(std::move(client)), login_(std::move(login)) {
    work_.add(this);
  }
  ~Socket() {
    client_->leave();
    work_.remove(this);
    work_.known_left();
  }

  /// `protocol`: the chosen subprotocol; empty: none.
  void accept(const http::request<http::string_body>& request, const std::string& protocol) {
    Failure ignored;
    if (!protocol.empty())
      stream_.set_option(ws::stream_base::decorator([protocol](ws::response_type& response) {
        response.set(http::field::sec_websocket_protocol, protocol);
      }));
    beast::get_lowest_layer(stream_).socket().set_option(net::socket_base::send_buffer_size(kSendBuffer),
                                                         ignored);
    beast::get_lowest_layer(stream_).socket().set_option(tcp::no_delay(true), ignored);
    stream_.set_option(
        ws::stream_base::timeout{duration(work_.options.head_s), duration(work_.options.idle_s), true});
    stream_.read_message_max(kMostMessage);
    stream_.auto_fragment(false);
    stream_.async_accept(request, [self = this->shared_from_this()](Failure failed) {
      if (failed) return self->client_->leave();
      self->open_ = true;
      if (self->goes_away_) return self->close(ws::close_code::going_away, "the cell has ended");
      self->read();
      self->pump();
    });
  }

  void pump() {
    if (!open_ || closing_) return;
    if (login_ && login_->over) return close(ws::close_code::policy_error, "the log-in has ended");
    if (login_) login_->used = steady_seconds();
    if (client_->gone()) return close(ws::close_code::policy_error, "it does not read its answers");
    if (writing_) return;
    auto out = client_->next();
    if (!out) return;
    writing_ = true;
    stream_.text(!out->binary);
    const auto buffer = net::buffer(*out->body);
    stream_.async_write(
        buffer, [self = this->shared_from_this(), body = std::move(out->body)](Failure failed, std::size_t) {
          self->writing_ = false;
          if (failed) return self->client_->leave();
          self->pump();
        });
  }

  /// If the handshake is not finished, the WebSocket is closed after it.
  void go_away() {
    goes_away_ = true;
    close(ws::close_code::going_away, "the cell has ended");
  }

  void close(ws::close_code code, const char* why) {
    if (!open_ || std::exchange(closing_, true)) return;
    client_->leave();
    stream_.async_close(ws::close_reason(code, why), [self = this->shared_from_this()](Failure) {});
  }

 private:
  void read() {
    stream_.async_read(
        buffer_, [self = this->shared_from_this()](Failure failed, std::size_t) { self->took(failed); });
  }

  void took(Failure failed) {
    if (failed) {
      if (failed == beast::error::timeout) ++work_.timed_out;
      return client_->leave();
    }
    const char* const why =
        client_->take(beast::buffers_to_string(buffer_.data()), !stream_.got_text(), steady_now());
    buffer_.consume(buffer_.size());
    if (buffer_.capacity() > kBuffer) buffer_.shrink_to_fit();
    if (why) return close(ws::close_code::policy_error, why);
    read();
  }

  Work& work_;
  ws::stream<Wire, false> stream_;
  std::shared_ptr<Stream> client_;
  const std::shared_ptr<Login> login_;
  beast::flat_buffer buffer_;
  bool open_ = false, closing_ = false, writing_ = false, goes_away_ = false;
};

/// An HTTP connection, until it becomes a WebSocket.
class Port::Work::Http : public std::enable_shared_from_this<Http> {
 public:
  Http(Work& work, tcp::socket socket) : work_(work), wire_(std::move(socket)), buffer_(kBuffer) {
    Failure failed;
    const auto peer = wire_.next_layer().socket().remote_endpoint(failed).address();
    local_ = !failed && peer.is_loopback();
    address_ = failed ? "" : peer.to_string();
  }
  ~Http() {
    if (uploads_) work_.end_upload();
    if (handed_on_) return;
    if (known_)
      work_.known_left();
    else
      work_.unauthenticated_left(this);
  }
  const std::string& address() const { return address_; }

  /// Without TLS if the port has none; else the first bytes decide, and only this machine may go without TLS.
  void begin() {
    if (!work_.tls()) return read();
    set_timeout(work_.options.head_s);
    beast::async_detect_ssl(wire_.next_layer(), buffer_,
                            [self = this->shared_from_this()](Failure failed, bool tls) {
                              if (failed) return self->gave_up(failed);
                              if (tls) return self->shake_hands();
                              self->in_clear_ = !self->local_ || !self->work_.options.local_in_clear;
                              self->read();
                            });
  }

  void read() {
    parser_.emplace();
    parser_->header_limit(kMostHead);
    parser_->body_limit(kMostAnnounced);  // for the head; the path decides how much of the body is read
    set_timeout(first_ ? work_.options.head_s : work_.options.idle_s);
    first_ = false;
    http::async_read_header(
        wire_, buffer_, *parser_,
        [self = this->shared_from_this()](Failure failed, std::size_t) { self->on_head(failed); });
  }

  /// Closes this connection to make room for another.
  void give_way() { wire_.next_layer().close(); }

 private:
  static std::string text(beast::string_view view) { return std::string(view.data(), view.size()); }
  std::string header(http::field field) const { return text(parser_->get()[field]); }

  void set_timeout(double seconds) { wire_.next_layer().expires_after(duration(seconds)); }
  void gave_up(Failure failed) {
    if (failed == beast::error::timeout) ++work_.timed_out;
  }

  void shake_hands() {
    wire_.begin_tls(*work_.tls())
        .async_handshake(net::ssl::stream_base::server, buffer_.data(),
                         [self = this->shared_from_this()](Failure failed, std::size_t used) {
                           if (failed) return self->gave_up(failed);
                           self->buffer_.consume(used);
                           self->read();
                         });
  }

  void on_head(Failure failed) {
    gave_up(failed);
    if (failed == http::error::header_limit) return refuse(400, "the head of the request is too long");
    if (failed) return;
    ++work_.requests;
    const auto& request = parser_->get();
    head_ = {text(request.method_string()),  text(request.target()),      header(http::field::host),
             header(http::field::origin),    header(http::field::cookie), header(http::field::authorization),
             text(request["Sec-Fetch-Site"]), wire_.tls() != nullptr};
    if (in_clear_)
      return refuse(403, "only https is served to other machines: open the link that polyarm printed");
    path_ = path_of(head_.target);
    if (path_.empty()) return refuse(400, "the path is malformed");
    claim_ = claim_of(head_, work_.options.rules);
    const Shown shown = claim_.how;
    if (!known_ && shown != Shown::nothing && shown != Shown::wrong) {
      known_ = work_.know(this);
      if (!known_) return refuse(503, "too many are connected already");
    }
    const bool upgrade = ws::is_upgrade(request);
    const bool open = !upgrade && work_.site.is_open(head_.method, path_);
    const bool changes = upgrade || (head_.method != "GET" && head_.method != "HEAD");
    if (!host_allowed(head_.host, work_.options.rules)) return refuse(421, "this address is not served");
    protocol_ = upgrade ? work_.site.viewer_protocol(header(http::field::sec_websocket_protocol)) : "";
    const Verdict verdict = open ? (changes ? judge_origin(head_, work_.options.rules) : Verdict{})
                            : protocol_.empty() ? judge(head_, work_.options.rules, changes)
                                                : judge_viewer(head_, work_.options.rules);
    if (verdict.status != 200) return refuse(verdict.status, verdict.why);
    if (upgrade) return become_socket();
    const std::size_t most = work_.site.most_body(head_.method, path_);
    if (parser_->content_length() && *parser_->content_length() > most)
      return refuse(413, "the body is too large");
    parser_->body_limit(most);
    if (parser_->is_done()) return on_body({});
    if (!(uploads_ = work_.begin_upload())) return refuse(503, "too many bodies are received at once");
    if (lower(header(http::field::expect)) == "100-continue") return go_on();
    read_body();
  }

  void go_on() {
    static constexpr char kContinue[] = "HTTP/1.1 100 Continue\r\n\r\n";
    net::async_write(wire_, net::buffer(kContinue, sizeof kContinue - 1),
                     [self = this->shared_from_this()](Failure failed, std::size_t) {
                       if (!failed) self->read_body();
                     });
  }

  void read_body() {
    set_timeout(work_.options.body_s);
    http::async_read(
        wire_, buffer_, *parser_,
        [self = this->shared_from_this()](Failure failed, std::size_t) { self->on_body(failed); });
  }

  void on_body(Failure failed) {
    if (std::exchange(uploads_, false)) work_.end_upload();
    if (failed == http::error::body_limit) return refuse(413, "the body is too large");
    if (failed) return;
    keep_alive_ = parser_->get().keep_alive();
    HttpRequest request;
    request.method = head_.method;
    request.target = head_.target;
    request.path = path_;
    request.if_none_match = header(http::field::if_none_match);
    request.gzip = accepts_gzip(header(http::field::accept_encoding));
    request.secure = head_.secure;
    const Claim claim =
        claim_of(head_, work_.options.rules);  // the log-in may have ended while the body came
    request.token = claim.how;
    request.role = claim.role;
    request.login = claim.login;
    request.shown = claim.token;
    request.authorization = head_.authorization;
    request.from = address_;
    request.body = std::move(parser_->get().body());
    wire_.next_layer().expires_never();
    work_.site.handle(std::move(request), [self = this->shared_from_this()](HttpReply reply) {
      net::post(self->work_.context,
                [self, reply = std::move(reply)]() mutable { self->send(std::move(reply)); });
    });
  }

  void refuse(int status, const char* why) {
    ++work_.refused;
    keep_alive_ = false;
    send(plain(status, why));
  }

  void send(HttpReply reply) {
    set_timeout(work_.options.send_s);
    auto head = std::make_shared<const std::string>(head_of(reply, keep_alive_));
    std::vector<net::const_buffer> parts{net::buffer(*head)};
    if (reply.body && head_.method != "HEAD") parts.push_back(net::buffer(*reply.body));
    net::async_write(wire_, parts,
                     [self = this->shared_from_this(), head, body = reply.body](Failure failed, std::size_t) {
                       if (failed) return;
                       if (self->keep_alive_) return self->read();
                       self->close_connection();
                     });
  }

  void close_connection() {
    if (wire_.tls()) return wire_.tls()->async_shutdown([self = this->shared_from_this()](Failure) {});
    Failure ignored;
    wire_.next_layer().socket().shutdown(tcp::socket::shutdown_send, ignored);
  }

  void become_socket() {
    if (path_ != "/ws" && protocol_.empty()) return refuse(404, "the WebSocket is at /ws");
    if (claim_.how == Shown::nothing || claim_.how == Shown::wrong)
      return refuse(403, "the log-in has ended");
    std::shared_ptr<Stream> stream;
    if (!protocol_.empty()) {
      stream = work_.site.welcome_viewer();
    } else if (!address_.empty()) {
      if (auto client = work_.site.welcome({address_, local_, claim_.role, claim_.login}))
        stream = std::make_shared<ClientStream>(std::move(client));
    }
    if (!stream) return refuse(503, "too many are watching already");
    wire_.next_layer().expires_never();
    wire_.give_back(beast::buffers_to_string(buffer_.data()));  // frames that came with the head
    handed_on_ = true;  // it stays counted as known: only known connections come this far
    const auto socket = std::make_shared<Socket>(work_, std::move(wire_), std::move(stream), claim_.login);
    socket->accept(parser_->get(), protocol_);
  }

  Work& work_;
  Wire wire_;
  beast::flat_buffer buffer_;
  std::optional<http::request_parser<http::string_body>> parser_;
  Head head_;
  Claim claim_;
  std::string path_, protocol_;
  std::string address_;
  bool local_ = false, in_clear_ = false;  ///< in_clear_: came without TLS where TLS is required
  bool first_ = true, keep_alive_ = false, handed_on_ = false, known_ = false, uploads_ = false;
};

void Port::Work::accept() {
  acceptor_.async_accept([this](Failure failed, tcp::socket socket) {
    if (over_) return;
    if (failed && SpareDescriptor::is_shortage(failed.value())) {
      ++refused;
      spare_.turn_away(acceptor_.native_handle());
      return rest_from_accepting(kShortage_s);
    }
    if (!failed) {
      ++connections;
      make_room_for_unauthenticated();
      const auto came = std::make_shared<Http>(*this, std::move(socket));
      unauthenticated_.push_back(came.get());
      came->begin();
    }
    if (!may_accept()) return rest_from_accepting(kCrowd_s);
    accept();
  });
}

/// A handshake takes a millisecond of the thread that reads all stops: the rate of new connections is
/// limited.
bool Port::Work::may_accept() {
  const double now = steady_now(), passed = accepted_at_ > 0 ? now - accepted_at_ : 0;
  accepted_at_ = now;
  may_come_ = std::min<double>(bounds::kAcceptBurst, may_come_ + passed * bounds::kAccepted) - 1;
  return may_come_ >= 0;
}

/// Pauses accepting: there was no descriptor, or too many connections came.
void Port::Work::rest_from_accepting(double seconds) {
  rest_ = std::make_unique<net::steady_timer>(context, duration(seconds));
  rest_->async_wait([this](Failure) {
    if (!over_) accept();
  });
}

/// Evicts a connection without a token: the oldest of the address that has the most of them.
void Port::Work::make_room_for_unauthenticated() {
  if (unauthenticated_.size() < options.most_unauthenticated) return;
  std::map<std::string, std::size_t> counts;
  for (const Http* each : unauthenticated_) ++counts[each->address()];
  const auto most = std::max_element(counts.begin(), counts.end(),
                                     [](const auto& a, const auto& b) { return a.second < b.second; });
  const auto oldest = std::find_if(unauthenticated_.begin(), unauthenticated_.end(),
                                   [&](const Http* each) { return each->address() == most->first; });
  Http* const leaving = *oldest;
  unauthenticated_.erase(oldest);
  ++refused;
  leaving->give_way();
}

void Port::Work::wake() {
  if (woken_.exchange(true)) return;
  net::post(context, [this] {
    woken_ = false;
    for (auto i = sockets_.begin(); i != sockets_.end();) (*i++)->pump();
  });
}

void Port::Work::close_in_order() {
  over_ = true;
  Failure ignored;
  acceptor_.close(ignored);
  rest_.reset();
  for (auto i = sockets_.begin(); i != sockets_.end();) (*i++)->go_away();
  closing_answer_ = std::make_unique<net::steady_timer>(context, duration(sockets_.empty() ? 0 : kClosing_s));
  closing_answer_->async_wait([this](Failure) { context.stop(); });
}

Port::Port(PortOptions options, Site& site) : work_(std::make_unique<Work>(std::move(options), site)) {}
Port::~Port() = default;
std::uint16_t Port::number() const {
  return work_->number();
}
void Port::wake() {
  work_->wake();
}
Port::Counts Port::counts() const {
  return {work_->connections, work_->refused, work_->requests, work_->timed_out};
}

}  // namespace polyarm::server
