#pragma once
/// A connection, with or without TLS, as a stream for Asio and Beast. I/O thread. Only port.cpp includes
/// this.
#include <boost/asio/buffer.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/bind_handler.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <memory>
#include <string>
#include <utility>

namespace polyarm::server {

class Wire {
 public:
  using Tcp = boost::beast::tcp_stream;
  using Tls = boost::asio::ssl::stream<Tcp&>;
  using next_layer_type = Tcp;
  using executor_type = Tcp::executor_type;

  explicit Wire(boost::asio::ip::tcp::socket socket) : tcp_(std::make_unique<Tcp>(std::move(socket))) {}

  Tcp& next_layer() { return *tcp_; }
  const Tcp& next_layer() const { return *tcp_; }
  executor_type get_executor() { return tcp_->get_executor(); }

  /// Reads and writes go through TLS from now on; the caller must still do the handshake.
  Tls& begin_tls(boost::asio::ssl::context& context) {
    tls_ = std::make_unique<Tls>(*tcp_, context);
    return *tls_;
  }
  Tls* tls() { return tls_.get(); }

  /// Returns bytes that were read but not used; the next reads deliver them first.
  void give_back(std::string bytes) { given_back_ = std::move(bytes); }

  template <typename Buffers, typename Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    if (!given_back_.empty()) {
      const std::size_t n = boost::asio::buffer_copy(buffers, boost::asio::buffer(given_back_));
      given_back_.erase(0, n);
      boost::asio::post(get_executor(), boost::beast::bind_front_handler(std::forward<Handler>(handler),
                                                                         boost::system::error_code(), n));
    } else if (tls_) {
      tls_->async_read_some(buffers, std::forward<Handler>(handler));
    } else {
      tcp_->async_read_some(buffers, std::forward<Handler>(handler));
    }
  }
  template <typename Buffers, typename Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    if (tls_)
      tls_->async_write_some(buffers, std::forward<Handler>(handler));
    else
      tcp_->async_write_some(buffers, std::forward<Handler>(handler));
  }

 private:
  std::unique_ptr<Tcp> tcp_;
  std::unique_ptr<Tls> tls_;
  std::string given_back_;
};

/// Beast calls these to close a WebSocket's connection.
template <typename Handler>
void async_teardown(boost::beast::role_type role, Wire& wire, Handler&& handler) {
  using boost::beast::websocket::async_teardown;
  if (wire.tls())
    wire.tls()->async_shutdown(std::forward<Handler>(handler));
  else
    async_teardown(role, wire.next_layer(), std::forward<Handler>(handler));
}
inline void teardown(boost::beast::role_type, Wire& wire, boost::system::error_code& failed) {
  wire.next_layer().socket().shutdown(boost::asio::ip::tcp::socket::shutdown_both, failed);
}

}  // namespace polyarm::server
