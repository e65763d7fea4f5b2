#pragma once
/// A connection to a cell, with or without TLS, as a stream for Beast. One thread. Handlers have one type
/// here, so that Beast's operations are compiled once. Only cell_client.cpp includes this.
#include <array>
#include <boost/asio/buffer.hpp>
#include <boost/asio/io_context.hpp>
#include <boost/asio/post.hpp>
#include <boost/asio/ssl/context.hpp>
#include <boost/asio/ssl/stream.hpp>
#include <boost/beast/core/bind_handler.hpp>
#include <boost/beast/core/role.hpp>
#include <boost/beast/core/tcp_stream.hpp>
#include <functional>
#include <memory>
#include <type_traits>
#include <utility>

namespace polyarm::fleet {

class CellStream {
 public:
  using Tcp = boost::beast::tcp_stream;
  using Tls = boost::asio::ssl::stream<Tcp&>;
  using Failure = boost::system::error_code;
  using next_layer_type = Tcp;
  using executor_type = Tcp::executor_type;

  explicit CellStream(boost::asio::io_context& context) : tcp_(context) {}

  Tcp& next_layer() { return tcp_; }
  const Tcp& next_layer() const { return tcp_; }
  executor_type get_executor() { return tcp_.get_executor(); }
  /// Reads and writes go through TLS from now on; the caller must still do the handshake.
  Tls& begin_tls(boost::asio::ssl::context& context) {
    return *(tls_ = std::make_unique<Tls>(tcp_, context));
  }

  template <typename Buffers, typename Handler>
  void async_read_some(const Buffers& buffers, Handler&& handler) {
    boost::asio::mutable_buffer into;
    for (auto it = boost::asio::buffer_sequence_begin(buffers);
         it != boost::asio::buffer_sequence_end(buffers) && into.size() == 0; ++it)
      into = *it;
    read(into, one_type(std::forward<Handler>(handler)));
  }
  template <typename Buffers, typename Handler>
  void async_write_some(const Buffers& buffers, Handler&& handler) {
    const std::size_t size = boost::asio::buffer_copy(boost::asio::buffer(outgoing_), buffers);
    write(boost::asio::buffer(outgoing_, size), one_type(std::forward<Handler>(handler)));
  }

 private:
  using Done = std::function<void(Failure, std::size_t)>;
  /// Handlers may be movable only.
  template <typename Handler>
  static Done one_type(Handler&& handler) {
    auto kept = std::make_shared<std::decay_t<Handler>>(std::forward<Handler>(handler));
    return [kept = std::move(kept)](Failure failed, std::size_t size) { std::move (*kept)(failed, size); };
  }
  void read(boost::asio::mutable_buffer into, Done done) {
    if (tls_)
      tls_->async_read_some(into, std::move(done));
    else
      tcp_.async_read_some(into, std::move(done));
  }
  void write(boost::asio::const_buffer from, Done done) {
    if (tls_)
      tls_->async_write_some(from, std::move(done));
    else
      tcp_.async_write_some(from, std::move(done));
  }

  Tcp tcp_;
  std::unique_ptr<Tls> tls_;
  std::array<char, 16384> outgoing_;  // of one write at a time
};

/// Beast calls these to close a WebSocket's connection.
template <typename Handler>
void async_teardown(boost::beast::role_type, CellStream& stream, Handler&& handler) {
  boost::system::error_code failed;
  stream.next_layer().socket().shutdown(boost::asio::ip::tcp::socket::shutdown_both, failed);
  boost::asio::post(stream.get_executor(),
                    boost::beast::bind_front_handler(std::forward<Handler>(handler), failed));
}
inline void teardown(boost::beast::role_type, CellStream& stream, boost::system::error_code& failed) {
  stream.next_layer().socket().shutdown(boost::asio::ip::tcp::socket::shutdown_both, failed);
}

}  // namespace polyarm::fleet
