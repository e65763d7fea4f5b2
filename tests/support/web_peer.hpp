#pragma once
/// The far side of the pendant's port: a plain HTTP and WebSocket client on its own socket.
#include <arpa/inet.h>
#include <netinet/in.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <cstdint>
#include <cstring>
#include <deque>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

namespace polyarm::test {

class WebPeer {
 public:
  using Json = nlohmann::json;

  explicit WebPeer(std::uint16_t port, int receive_buffer = 0) : port_(port) {
    fd_ = ::socket(AF_INET, SOCK_STREAM, 0);
    if (receive_buffer > 0) ::setsockopt(fd_, SOL_SOCKET, SO_RCVBUF, &receive_buffer, sizeof receive_buffer);
    sockaddr_in address{};
    address.sin_family = AF_INET;
    address.sin_port = htons(port);
    address.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
    connected = ::connect(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0;
  }
  ~WebPeer() { close_connection(); }
  WebPeer(const WebPeer&) = delete;
  WebPeer& operator=(const WebPeer&) = delete;
  bool connected = false;

  /// Closes the socket without a goodbye, as when the process is killed.
  void close_connection() {
    if (fd_ >= 0) ::close(fd_);
    fd_ = -1;
  }

  bool say(const std::string& bytes) {
    for (std::size_t sent = 0; sent < bytes.size();) {
      const ssize_t n = ::send(fd_, bytes.data() + sent, bytes.size() - sent, MSG_NOSIGNAL);
      if (n <= 0) return false;
      sent += static_cast<std::size_t>(n);
    }
    return true;
  }
  /// Reads what arrives within the time; false at the end of the connection.
  bool listen(int wait_limit_ms = 0) {
    pollfd waiting{fd_, POLLIN, 0};
    if (closed_) return false;
    if (::poll(&waiting, 1, wait_limit_ms) <= 0) return true;
    char buffer[65536];
    const ssize_t n = ::recv(fd_, buffer, sizeof buffer, 0);
    if (n > 0) heard.append(buffer, static_cast<std::size_t>(n));
    closed_ = n <= 0;
    return n > 0;
  }
  /// Reads until the other side closes, or until the time is over.
  std::string rest(int wait_limit_ms = 20'000) {
    while (listen(wait_limit_ms) && !heard.empty()) {
    }
    return heard;
  }
  bool closed() const { return closed_; }
  int descriptor() const { return fd_; }

  std::string host() const { return "localhost:" + std::to_string(port_); }
  /// Sends a request on its own connection and returns the answer with its head.
  static std::string fetch(std::uint16_t port, const std::string& target,
                           const std::vector<std::string>& headers = {}, const std::string& method = "GET",
                           const std::string& body = "") {
    WebPeer peer(port);
    std::string text = method + " " + target + " HTTP/1.1\r\nConnection: close\r\n";
    bool host = false;
    for (const std::string& header : headers) {
      text += header + "\r\n";
      host = host || header.rfind("Host:", 0) == 0;
    }
    if (!host) text += "Host: " + peer.host() + "\r\n";
    if (!body.empty()) text += "Content-Length: " + std::to_string(body.size()) + "\r\n";
    peer.say(text + "\r\n" + body);
    return peer.rest();
  }
  static int status(const std::string& answer) {
    return answer.size() > 12 ? std::atoi(answer.c_str() + 9) : 0;
  }

  /// Requests a WebSocket. Returns the status of the answer: 101 on success.
  int upgrade(const std::vector<std::string>& headers, const std::string& target = "/ws") {
    std::string text =
        "GET " + target +
        " HTTP/1.1\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nSec-WebSocket-Version: 13\r\n"
        "Sec-WebSocket-Key: AAECAwQFBgcICQoLDA0ODw==\r\n";
    bool has_host = false;
    for (const std::string& header : headers) {
      text += header + "\r\n";
      has_host = has_host || header.rfind("Host:", 0) == 0;
    }
    if (!has_host) text += "Host: " + host() + "\r\n";
    say(text + "\r\n");
    while (heard.find("\r\n\r\n") == std::string::npos && listen(20'000)) {
    }
    const int out = status(heard);
    const auto end = heard.find("\r\n\r\n");
    heard.erase(0, end == std::string::npos ? heard.size() : end + 4);
    return out;
  }
  /// One frame, masked with zeros.
  static std::string frame(const std::string& data, int opcode = 1) {
    std::string out(1, static_cast<char>(0x80 | opcode));
    if (data.size() < 126) {
      out += static_cast<char>(0x80 | data.size());
    } else if (data.size() < 65536) {
      out += static_cast<char>(0x80 | 126);
      out += static_cast<char>(data.size() >> 8);
      out += static_cast<char>(data.size() & 255);
    } else {
      out += static_cast<char>(0x80 | 127);
      for (int i = 7; i >= 0; --i)
        out += static_cast<char>((static_cast<std::uint64_t>(data.size()) >> (8 * i)) & 255);
    }
    return out + std::string(4, '\0') + data;
  }
  bool send(const Json& message) { return say(frame(message.dump())); }

  struct Message {
    int opcode = 0;
    std::string data;
  };
  /// Takes the complete messages out of the received bytes.
  void take() {
    for (;;) {
      if (heard.size() < 2) return;
      const auto byte = [&](std::size_t i) {
        return static_cast<std::uint64_t>(static_cast<unsigned char>(heard[i]));
      };
      std::uint64_t size = byte(1) & 127, head = 2;
      const std::size_t more = size == 126 ? 2 : size == 127 ? 8 : 0;
      if (heard.size() < 2 + more) return;
      if (more) size = 0;
      for (std::size_t i = 0; i < more; ++i) size = (size << 8) | byte(2 + i);
      head += more;
      if (heard.size() < head + size) return;
      Message message{static_cast<int>(byte(0) & 15), heard.substr(head, size)};
      heard.erase(0, head + size);
      if (message.opcode == 2) ++frames, last_frame = message.data;
      if (message.opcode == 1) {
        const Json json = Json::parse(message.data, nullptr, false);
        if (json.contains("event"))
          events.push_back(json);
        else
          answers.push_back(json);
      }
      if (message.opcode == 8)
        close_code = message.data.size() >= 2 ? (static_cast<unsigned char>(message.data[0]) << 8) +
                                                    static_cast<unsigned char>(message.data[1])
                                              : 1005;
    }
  }
  /// The newest event of that name; null if there is none.
  Json event(const std::string& name) const {
    for (auto each = events.rbegin(); each != events.rend(); ++each)
      if ((*each)["event"] == name) return *each;
    return {};
  }
  /// The last answer with that id; null if there is none.
  Json answer(int id) const {
    for (auto each = answers.rbegin(); each != answers.rend(); ++each)
      if (each->is_object() && each->value("id", Json()) == id) return *each;
    return {};
  }

  std::string heard, last_frame;
  std::deque<Json> events, answers;
  int frames = 0, close_code = 0;

 private:
  std::uint16_t port_;
  int fd_ = -1;
  bool closed_ = false;
};

}  // namespace polyarm::test
