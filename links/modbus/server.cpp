#include <fcntl.h>
#include <modbus.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <span>

#include "links/modbus/context.hpp"
#include "links/modbus/frame.hpp"
#include "links/modbus/port.hpp"
#include "links/modbus/registers.hpp"
#include "polyarm/base/bounds.hpp"

namespace polyarm::modbus {

namespace {
using signals::Direction;
using signals::LinkEntry;
using signals::LinkReport;
using signals::LinkTag;
using signals::LinkValue;
using Area = LinkTag::Area;

class Server : public signals::LinkPort {
 public:
  explicit Server(const LinkEntry& entry) : entry_(entry), last_(entry.tags.size()) {
    std::array<int, 4> size{1, 1, 1, 1};
    for (const LinkTag& tag : entry.tags) {
      int& most = size[static_cast<std::size_t>(tag.area)];
      most = std::max(most, tag.address + tag.registers());
    }
    table_ = modbus_mapping_new(size[0], size[1], size[2], size[3]);
    if (!table_) throw Error("link-lost", "out of memory");
    for (std::size_t i = 0; i < entry_.tags.size(); ++i) last_[i] = words_at(entry_.tags[i]);
  }
  ~Server() override {
    close();
    modbus_mapping_free(table_);
  }

  void open() override {
    close();
    context_ = new_context(entry_);
    modbus_set_response_timeout(context_, 0, 1);  // some of libmodbus's refusals wait for this timeout
    listening_ = modbus_tcp_pi_listen(context_, static_cast<int>(bounds::kModbusClients));
    if (listening_ < 0) {
      const std::string why = modbus_strerror(errno);
      throw Error("link-lost", entry_.address() + " cannot listen: " + why);
    }
    do_not_wait(listening_);  // a connection may be closed before it is accepted
    requested_at_ = -1;
  }

  void close() noexcept override {
    for (const Client& client : clients_) ::close(client.socket);
    clients_.clear();
    if (listening_ >= 0) ::close(listening_);
    listening_ = -1;
    if (context_) modbus_free(context_);
    context_ = nullptr;
  }

  bool waits() const override { return true; }

  void remember(const std::vector<LinkValue>& values) override {
    for (const LinkValue& value : values)
      if (value.tag < entry_.tags.size()) put(value);
  }

  void exchange(const std::vector<LinkValue>& writes, Nanoseconds now, Nanoseconds patience,
                LinkReport& news) override {
    for (const LinkValue& write : writes) put(write);
    const bool asked = serve(now, patience);
    if (asked) requested_at_ = now;
    news.alive = requested_at_ >= 0 && now - requested_at_ <= entry_.timeout;
    for (std::size_t i = 0; i < entry_.tags.size(); ++i) look(i, asked, news);
  }

 private:
  struct Client {
    int socket = -1;
    Nanoseconds heard = 0;         ///< time of the connection or of the last request
    Nanoseconds begun = 0;         ///< time of the first byte of an unfinished request
    std::uint64_t answered = 0;    ///< count of requests
    std::size_t size = 0;          ///< bytes received but not answered yet
    bool gone = false;             ///< must be closed
    std::array<std::uint8_t, kMostFrame> bytes{};
  };

  std::vector<std::uint16_t> words_at(const LinkTag& tag) const {
    if (tag.area == Area::coil) return {table_->tab_bits[tag.address]};
    if (tag.area == Area::discrete) return {table_->tab_input_bits[tag.address]};
    const std::uint16_t* at =
        (tag.area == Area::holding ? table_->tab_registers : table_->tab_input_registers) + tag.address;
    return {at, at + tag.registers()};
  }

  void put(const LinkValue& write) {
    const LinkTag& tag = entry_.tags[write.tag];
    const std::vector<std::uint16_t> words = words_of_value(tag, write.value, entry_.low_word_first);
    if (words.empty()) return;
    if (tag.area == Area::coil)
      table_->tab_bits[tag.address] = words[0] != 0;
    else if (tag.area == Area::discrete)
      table_->tab_input_bits[tag.address] = words[0] != 0;
    else
      std::copy(
          words.begin(), words.end(),
          (tag.area == Area::holding ? table_->tab_registers : table_->tab_input_registers) + tag.address);
    last_[write.tag] = words_at(tag);
  }

  /// Returns true if a request was answered. Never waits for a client: reads once what each connection has
  /// received, and answers the complete requests.
  bool serve(Nanoseconds now, Nanoseconds patience) {
    close_unfinished(now);
    std::vector<pollfd> waiting{{listening_, POLLIN, 0}};
    for (const Client& client : clients_) waiting.push_back({client.socket, POLLIN, 0});
    if (::poll(waiting.data(), waiting.size(), static_cast<int>(patience / 1'000'000)) <= 0) return false;
    bool asked = false;
    for (std::size_t k = 1; k < waiting.size(); ++k) {
      if (waiting[k].revents == 0) continue;
      Client& client = clients_[k - 1];
      const std::uint64_t before = client.answered;
      client.gone = !hear(client, now);
      asked |= client.answered != before;
    }
    close_gone();
    if (waiting[0].revents != 0) accept(now);
    return asked;
  }

  /// If all connections are in use, closes the one that was silent for longest, so that idle clients lock
  /// nobody out.
  void accept(Nanoseconds now) {
    int listening = listening_;
    const int socket = modbus_tcp_pi_accept(context_, &listening);
    if (socket < 0) return;
    do_not_wait(socket);
    if (clients_.size() >= bounds::kModbusClients) {
      std::min_element(clients_.begin(), clients_.end(), [](const Client& a, const Client& b) {
        return a.heard < b.heard;
      })->gone = true;
      close_gone();
    }
    Client& client = clients_.emplace_back();
    client.socket = socket;
    client.heard = now;
  }

  static void do_not_wait(int socket) { ::fcntl(socket, F_SETFL, ::fcntl(socket, F_GETFL) | O_NONBLOCK); }

  void close_gone() {
    std::erase_if(clients_, [](const Client& client) { return client.gone && ::close(client.socket) <= 0; });
  }
  void close_unfinished(Nanoseconds now) {
    constexpr auto kMost = static_cast<Nanoseconds>(bounds::kModbusFrame_ms) * 1'000'000;
    for (Client& client : clients_) client.gone |= client.size > 0 && now - client.begun > kMost;
    close_gone();
  }

  /// Returns false if the connection has ended or sends anything but Modbus. The tables keep their values.
  bool hear(Client& client, Nanoseconds now) {
    const ssize_t came =
        ::recv(client.socket, client.bytes.data() + client.size, client.bytes.size() - client.size, MSG_DONTWAIT);
    if (came < 0) return errno == EAGAIN || errno == EWOULDBLOCK || errno == EINTR;
    if (came == 0) return false;
    if (client.size == 0) client.begun = now;
    client.size += static_cast<std::size_t>(came);
    std::size_t taken = 0;
    Frame frame;
    const auto rest = [&] { return std::span<const std::uint8_t>(client.bytes).subspan(taken, client.size - taken); };
    while ((frame = first_frame(rest())).kind == Frame::Kind::request || frame.kind == Frame::Kind::refused) {
      if (!answer(client.socket, rest(), frame)) return false;
      client.heard = client.begun = now;
      ++client.answered;
      taken += frame.length;
    }
    std::copy(client.bytes.begin() + static_cast<std::ptrdiff_t>(taken),
              client.bytes.begin() + static_cast<std::ptrdiff_t>(client.size), client.bytes.begin());
    client.size -= taken;
    return frame.kind != Frame::Kind::broken;
  }

  /// Returns false if the client does not take the answer: its buffer is full, or it is gone.
  bool answer(int socket, std::span<const std::uint8_t> bytes, const Frame& frame) {
    modbus_set_socket(context_, socket);
    errno = 0;
    const int sent = frame.kind == Frame::Kind::refused
                         ? modbus_reply_exception(context_, bytes.data(), static_cast<unsigned>(frame.exception))
                         : modbus_reply(context_, bytes.data(), static_cast<int>(frame.length), table_);
    return sent >= 0 || errno >= MODBUS_ENOBASE;  // an exception reply of ours
  }

  void look(std::size_t index, bool asked, LinkReport& news) {
    const LinkTag& tag = entry_.tags[index];
    std::vector<std::uint16_t> words = words_at(tag);
    const bool ours = tag.direction == Direction::out;
    if (words == last_[index]) {
      if (asked && !ours) news.seen.push_back(index);
      return;
    }
    if (ours) {  // a client wrote to an output, which it may only read: the value is restored
      restore(index);
      return;
    }
    std::string why;
    auto value = value_of_words(tag, words.data(), entry_.low_word_first, why);
    last_[index] = std::move(words);
    if (!value) return news.refuse(index, why);
    news.seen.push_back(index);
    news.values.push_back({index, std::move(*value)});
  }

  void restore(std::size_t index) {
    const LinkTag& tag = entry_.tags[index];
    if (tag.area == Area::coil)
      table_->tab_bits[tag.address] = static_cast<std::uint8_t>(last_[index][0]);
    else if (tag.area == Area::holding)
      std::copy(last_[index].begin(), last_[index].end(), table_->tab_registers + tag.address);
  }

  LinkEntry entry_;
  modbus_mapping_t* table_ = nullptr;
  modbus_t* context_ = nullptr;
  int listening_ = -1;
  std::vector<Client> clients_;
  std::vector<std::vector<std::uint16_t>> last_;  ///< by tag: the registers that both sides know
  Nanoseconds requested_at_ = -1;
};
}  // namespace

std::unique_ptr<signals::LinkPort> make_server(const LinkEntry& entry) {
  return std::make_unique<Server>(entry);
}

}  // namespace polyarm::modbus
