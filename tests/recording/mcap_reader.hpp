#pragma once
/// A reader of MCAP that believes nothing: every length, check and index is looked at. For tests.
#include <cstdint>
#include <cstring>
#include <map>
#include <stdexcept>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/recording/mcap_writer.hpp"

namespace polyarm::test {

inline std::string lz4_frame(std::string_view in) {
  const auto byte = [&](std::size_t i) -> unsigned {
    if (i >= in.size()) throw std::runtime_error("lz4: short");
    return static_cast<unsigned char>(in[i]);
  };
  const auto word = [&](std::size_t i) {
    return byte(i) | byte(i + 1) << 8 | byte(i + 2) << 16 | byte(i + 3) << 24;
  };
  if (word(0) != 0x184D2204) throw std::runtime_error("lz4: magic");
  std::string out;
  std::size_t at = 7;
  for (;;) {
    const std::uint32_t size = word(at);
    at += 4;
    if (size == 0) break;
    const std::size_t end = at + (size & 0x7FFFFFFF);
    if (size & 0x80000000u) {
      out += in.substr(at, end - at);
      at = end;
      continue;
    }
    const std::size_t block = out.size();
    while (at < end) {
      const unsigned token = byte(at++);
      const auto length = [&](unsigned part) {
        std::size_t n = part;
        if (part == 15)
          for (unsigned more = 255; more == 255;) n += more = byte(at++);
        return n;
      };
      const std::size_t literals = length(token >> 4);
      out += in.substr(at, literals);
      at += literals;
      if (at >= end) break;
      const std::size_t offset = byte(at) | byte(at + 1) << 8;
      at += 2;
      const std::size_t match = length(token & 15) + 4;
      if (offset == 0 || offset > out.size() - block) throw std::runtime_error("lz4: offset");
      for (std::size_t i = 0; i < match; ++i) out += out[out.size() - offset];
    }
    at = end;
  }
  return out;
}

struct McapMessage {
  std::string topic, schema;
  std::uint64_t time = 0;
  std::uint32_t sequence = 0;
  std::string data;
};

struct McapFile {
  std::vector<McapMessage> messages;  ///< in the order of the file
  std::map<std::string, std::string> attachments, metadata;
  std::map<std::string, std::pair<std::string, std::string>> channels;  ///< topic → encoding, schema's
  std::size_t chunks = 0, indexed_messages = 0;
  bool whole = false;  ///< with its summary, whose figures are right

  static McapFile read(std::string_view file) {
    McapFile out;
    Reader reader{out, file};
    reader.run();
    return out;
  }
  std::vector<const McapMessage*> of(const std::string& topic) const {
    std::vector<const McapMessage*> out;
    for (const McapMessage& each : messages)
      if (each.topic == topic) out.push_back(&each);
    return out;
  }

 private:
  struct Cursor {
    std::string_view in;
    std::size_t at = 0;
    std::uint64_t number(int bytes) {
      std::uint64_t out = 0;
      const std::string_view part = take(static_cast<std::size_t>(bytes));
      for (int i = bytes - 1; i >= 0; --i)
        out = out << 8 | static_cast<unsigned char>(part[static_cast<std::size_t>(i)]);
      return out;
    }
    std::string_view take(std::size_t n) {
      if (n > in.size() - at) throw std::out_of_range("short");
      at += n;
      return in.substr(at - n, n);
    }
    std::string text() { return std::string(take(number(4))); }
    bool over() const { return at == in.size(); }
  };
  struct Reader {
    McapFile& out;
    std::string_view file;
    std::map<std::uint64_t, std::pair<std::string, std::string>> schemas;
    std::map<std::uint64_t, std::pair<std::string, std::string>> topics;
    std::vector<std::size_t> chunk_places;
    std::string chunk;

    static void check(bool good, const char* what) {
      if (!good) throw std::runtime_error(what);
    }
    static std::uint32_t crc(std::string_view bytes) {
      return recording::crc32(std::as_bytes(std::span(bytes.data(), bytes.size())));
    }
    void run() {
      const std::string_view magic("\x89MCAP0\r\n", 8);
      check(file.substr(0, 8) == magic, "magic");
      Cursor all{file, 8};
      try {
        while (!out.whole) {
          const std::size_t begin = all.at;
          const auto opcode = static_cast<int>(all.number(1));
          Cursor body{all.take(all.number(8))};
          if (opcode == 15) {
            check(body.number(4) == crc(file.substr(0, begin)), "data check");
            summary(all);
            check(all.take(8) == magic && all.over(), "end");
            out.whole = true;
          } else {
            record(opcode, body, begin);
          }
        }
      } catch (const std::out_of_range&) {  // cut off within a record
      }
    }
    void record(int opcode, Cursor& body, std::size_t begin) {
      if (opcode == 3) {
        const auto id = body.number(2);
        const std::string name = body.text(), encoding = body.text();
        schemas[id] = {name, encoding + ":" + body.text()};
      } else if (opcode == 4) {
        const auto id = body.number(2), schema = body.number(2);
        topics[id] = {body.text(), schemas.at(schema).first};
        out.channels[topics[id].first] = {body.text(), schemas.at(schema).second};
      } else if (opcode == 5) {
        McapMessage message;
        const auto channel = topics.at(body.number(2));
        message.topic = channel.first;
        message.schema = channel.second;
        message.sequence = static_cast<std::uint32_t>(body.number(4));
        message.time = body.number(8);
        check(body.number(8) == message.time, "publish time");
        message.data = std::string(body.take(body.in.size() - body.at));
        out.messages.push_back(message);
      } else if (opcode == 6) {
        take_chunk(body, begin);
      } else if (opcode == 7) {
        const auto channel = body.number(2);
        Cursor entries{body.take(body.number(4))};
        for (; !entries.over(); ++out.indexed_messages) {
          const std::uint64_t time = entries.number(8), offset = entries.number(8);
          Cursor there{std::string_view(chunk), offset};
          check(there.number(1) == 5, "the index names no message");
          there.number(8);
          check(there.number(2) == channel, "the index names another channel's message");
          there.number(4);
          check(there.number(8) == time, "the index has another time");
        }
      } else if (opcode == 9) {
        const std::size_t start = body.at;
        body.number(8), body.number(8);
        const std::string name = body.text(), type = body.text();
        out.attachments[name] = std::string(body.take(body.number(8)));
        const auto checked = crc(body.in.substr(start, body.at - start));
        check(body.number(4) == checked, "attachment check");
      } else if (opcode == 12) {
        const std::string name = body.text();
        Cursor map{body.take(body.number(4))};
        while (!map.over()) {
          const std::string key = map.text();
          out.metadata[name + "." + key] = map.text();
        }
      }
    }
    void take_chunk(Cursor& body, std::size_t begin) {
      const auto first = body.number(8), last = body.number(8), size = body.number(8);
      const auto checked = body.number(4);
      const std::string compression = body.text();
      const std::string_view records = body.take(body.number(8));
      chunk = compression == "lz4" ? lz4_frame(records) : std::string(records);
      check(chunk.size() == size, "chunk size");
      check(crc(chunk) == checked, "chunk check");
      const std::size_t before = out.messages.size();
      for (Cursor inner{chunk}; !inner.over();) {
        const auto opcode = static_cast<int>(inner.number(1));
        Cursor one{inner.take(inner.number(8))};
        record(opcode, one, 0);
      }
      std::uint64_t low = ~0ull, high = 0;
      for (std::size_t i = before; i < out.messages.size(); ++i) {
        low = std::min(low, out.messages[i].time);
        high = std::max(high, out.messages[i].time);
      }
      check(low == first && high == last, "chunk times");
      ++out.chunks;
      chunk_places.push_back(begin);
    }
    void summary(Cursor& all) {
      const std::size_t begin = all.at;
      std::size_t chunk_indexes = 0;
      for (;;) {
        const std::size_t at = all.at;
        const auto opcode = static_cast<int>(all.number(1));
        Cursor body{all.take(all.number(8))};
        if (opcode == 8) {
          body.number(8), body.number(8);
          check(body.number(8) == chunk_places.at(chunk_indexes++), "chunk index");
        } else if (opcode == 11) {
          check(body.number(8) == out.messages.size(), "statistics: messages");
          check(body.number(2) >= schemas.size(), "statistics: schemas");
          check(body.number(4) >= topics.size(), "statistics: channels");
          check(body.number(4) == out.attachments.size(), "statistics: attachments");
          body.number(4);
          check(body.number(4) == out.chunks, "statistics: chunks");
        } else if (opcode == 14) {
          const auto kind = body.number(1), place = body.number(8);
          check(static_cast<unsigned char>(file.at(place)) == kind, "summary offset");
        } else if (opcode == 2) {
          check(body.number(8) == begin, "summary start");
          body.number(8);
          check(body.number(4) == crc(file.substr(begin, at + 9 + 16 - begin)), "summary check");
          break;
        }
      }
      check(chunk_indexes == out.chunks, "every chunk has an index");
      check(out.indexed_messages == out.messages.size(), "every message has an index");
    }
  };
};

}  // namespace polyarm::test
