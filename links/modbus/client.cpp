#include <modbus.h>

#include <algorithm>
#include <cerrno>
#include <string>
#include <tuple>

#include "links/modbus/context.hpp"
#include "links/modbus/port.hpp"
#include "links/modbus/registers.hpp"

namespace polyarm::modbus {

namespace {
using signals::Direction;
using signals::LinkEntry;
using signals::LinkReport;
using signals::LinkTag;
using signals::LinkValue;
using Area = LinkTag::Area;

/// A block of addresses that one request reads.
struct Block {
  Area area{};
  int first = 0, count = 0;
  Nanoseconds every = 0, due = 0;
  std::vector<std::size_t> tags;
};

bool is_bits(Area area) {
  return area == Area::coil || area == Area::discrete;
}

class Client : public signals::LinkPort {
 public:
  explicit Client(const LinkEntry& entry) : entry_(entry), last_(entry.tags.size()) { plan(); }
  ~Client() override { close(); }

  void open() override {
    close();
    context_ = new_context(entry_);
    modbus_set_response_timeout(context_, static_cast<std::uint32_t>(entry_.timeout / 1'000'000'000),
                                static_cast<std::uint32_t>(entry_.timeout % 1'000'000'000 / 1000));
    if (modbus_connect(context_) != 0) fail("cannot be reached");
    for (Block& block : blocks_) block.due = 0;
    for (auto& words : last_) words.clear();
  }

  void close() noexcept override {
    if (!context_) return;
    modbus_close(context_);
    modbus_free(context_);
    context_ = nullptr;
  }

  void exchange(const std::vector<LinkValue>& writes, Nanoseconds now, Nanoseconds, LinkReport& news) override {
    for (const LinkValue& value : writes) write(entry_.tags[value.tag], value, news);
    for (Block& block : blocks_) {
      if (now < block.due) continue;
      block.due = now + block.every;
      read(block, news);
    }
  }

 private:
  /// Groups the tags that one request reads: same table, same group, gaps of at most 8 addresses.
  void plan() {
    constexpr int kGap = 8;
    std::vector<std::size_t> order;
    for (std::size_t i = 0; i < entry_.tags.size(); ++i)
      if (entry_.tags[i].direction != Direction::out) order.push_back(i);
    std::sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) {
      const LinkTag &x = entry_.tags[a], &y = entry_.tags[b];
      return std::tie(x.area, x.group, x.address) < std::tie(y.area, y.group, y.address);
    });
    const LinkTag* before = nullptr;
    for (const std::size_t i : order) {
      const LinkTag& tag = entry_.tags[i];
      const int end = tag.address + tag.registers();
      const int most = is_bits(tag.area) ? MODBUS_MAX_READ_BITS : MODBUS_MAX_READ_REGISTERS;
      const bool joins = before && before->area == tag.area && before->group == tag.group &&
                         tag.address - (blocks_.back().first + blocks_.back().count) <= kGap &&
                         end - blocks_.back().first <= most;
      if (!joins)
        blocks_.push_back(
            {tag.area, tag.address, 0, tag.group.empty() ? 0 : entry_.groups.at(tag.group), 0, {}});
      blocks_.back().count = end - blocks_.back().first;
      blocks_.back().tags.push_back(i);
      before = &tag;
    }
  }

  [[noreturn]] void fail(const std::string& what) {
    const int error = errno;
    throw Error("link-lost", entry_.address() + " " + what + ": " + modbus_strerror(error));
  }

  /// An exception reply of the far side (such as "no such address") does not end the link.
  static bool is_exception(int error) {
    return error > MODBUS_ENOBASE && error < MODBUS_ENOBASE + MODBUS_EXCEPTION_MAX;
  }

  void write(const LinkTag& tag, const LinkValue& write, LinkReport& news) {
    std::vector<std::uint16_t> words = words_of_value(tag, write.value, entry_.low_word_first);
    if (words.empty()) return;
    errno = 0;
    const int done =
        is_bits(tag.area) ? modbus_write_bit(context_, tag.address, words[0] != 0)
        : words.size() == 1
            ? modbus_write_register(context_, tag.address, words[0])
            : modbus_write_registers(context_, tag.address, static_cast<int>(words.size()), words.data());
    if (done < 0 && is_exception(errno))
      return news.refuse(write.tag, std::string("the device reports: ") + modbus_strerror(errno));
    if (done < 0) fail("did not take '" + tag.name + "'");
    last_[write.tag] = std::move(words);
  }

  void read(const Block& block, LinkReport& news) {
    const auto count = static_cast<std::size_t>(block.count);
    std::vector<std::uint8_t> bits(count);
    std::vector<std::uint16_t> words(count);
    errno = 0;
    int got = -1;
    switch (block.area) {
      case Area::coil:
        got = modbus_read_bits(context_, block.first, block.count, bits.data());
        break;
      case Area::discrete:
        got = modbus_read_input_bits(context_, block.first, block.count, bits.data());
        break;
      case Area::holding:
        got = modbus_read_registers(context_, block.first, block.count, words.data());
        break;
      case Area::input:
        got = modbus_read_input_registers(context_, block.first, block.count, words.data());
        break;
    }
    if (got < 0 && is_exception(errno)) {
      const std::string why = modbus_strerror(errno);
      for (const std::size_t tag : block.tags) news.refuse(tag, "the device reports: " + why);
      return;
    }
    if (got != block.count) fail("did not answer");
    if (is_bits(block.area)) std::copy(bits.begin(), bits.end(), words.begin());
    for (const std::size_t i : block.tags)
      take(i, &words[static_cast<std::size_t>(entry_.tags[i].address - block.first)], news);
  }

  void take(std::size_t index, const std::uint16_t* at, LinkReport& news) {
    const LinkTag& tag = entry_.tags[index];
    std::vector<std::uint16_t> words(at, at + tag.registers());
    if (words == last_[index]) return news.seen.push_back(index);
    std::string why;
    auto value = value_of_words(tag, words.data(), entry_.low_word_first, why);
    last_[index] = std::move(words);
    if (!value) return news.refuse(index, why);
    news.seen.push_back(index);
    news.values.push_back({index, std::move(*value)});
  }

  LinkEntry entry_;
  std::vector<Block> blocks_;
  std::vector<std::vector<std::uint16_t>> last_;  ///< by tag: the registers that both sides know
  modbus_t* context_ = nullptr;
};
}  // namespace

std::unique_ptr<signals::LinkPort> make_client(const LinkEntry& entry) {
  return std::make_unique<Client>(entry);
}

}  // namespace polyarm::modbus
