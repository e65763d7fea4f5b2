#include <gtest/gtest.h>

#include <random>

#include "polyarm/recording/lz4.hpp"
#include "polyarm/recording/mcap_writer.hpp"
#include "tests/recording/bytes.hpp"
#include "tests/recording/mcap_reader.hpp"

namespace polyarm::recording {
namespace {

/// Takes so many bytes and then no more.
class Text : public ByteSink {
 public:
  explicit Text(std::size_t room = SIZE_MAX) : room_(room) {}
  bool write(std::span<const std::byte> bytes) override {
    if (text.size() + bytes.size() > room_) return false;
    text.append(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    return true;
  }
  std::string text;

 private:
  std::size_t room_;
};

std::string lz4(std::string_view text) {
  std::vector<std::byte> out;
  add_lz4_frame(bytes_of(text), out);
  return {reinterpret_cast<const char*>(out.data()), out.size()};
}

TEST(Lz4, GivesBackWhatWentIn) {
  std::mt19937_64 draw(11);
  for (int round = 0; round < 400; ++round) {
    std::string text;
    const std::size_t size = draw() % (round < 300 ? 200 : 100'000);
    const unsigned letters = 1 + static_cast<unsigned>(draw() % 200);
    while (text.size() < size) {
      if (draw() % 3 == 0 && !text.empty()) {
        const std::size_t from = draw() % text.size();
        text += text.substr(from, draw() % 400);
      } else {
        text += static_cast<char>(draw() % letters);
      }
    }
    ASSERT_EQ(test::lz4_frame(lz4(text)), text) << "round " << round;
  }
  const std::string large(9'000'001, 'x');
  const std::string packed = lz4(large);
  EXPECT_LT(packed.size(), large.size() / 200);
  EXPECT_EQ(test::lz4_frame(packed), large);
}

TEST(Crc32, IsThatOfIso3309) {
  EXPECT_EQ(crc32(bytes_of("123456789")), 0xCBF43926u);
  EXPECT_EQ(crc32(bytes_of("6789"), crc32(bytes_of("12345"))), 0xCBF43926u);
}

Channel text_channel(const std::string& topic, const std::string& schema = "a/msg/A") {
  return {topic, "cdr", schema, "ros2msg", "string of " + schema, "", false};
}

/// A file of two channels, one of which comes a little late.
std::string written(bool compress, int messages, Text& sink) {
  McapWriter writer(sink, {"ros2", "test", 2000, compress});
  writer.attachment("cell.yaml", "text/yaml", 5, "polyarm: cell/1\n");
  writer.metadata("polyarm", {{"cell", "demo"}});
  const std::size_t a = writer.add_channel(text_channel("/a")),
                    b = writer.add_channel(text_channel("/b", "b/msg/B"));
  writer.add_channel(text_channel("/never"));
  for (int i = 0; i < messages; ++i) {
    const auto time = static_cast<std::uint64_t>(1000 * (i + 1));
    writer.message(a, time, bytes_of("message " + std::to_string(i)));
    if (i % 3 == 2) writer.message(b, time - 1500, bytes_of(std::string(static_cast<std::size_t>(i), 'b')));
  }
  writer.finish();
  return sink.text;
}

TEST(McapWriter, WritesAFileWhoseEveryCheckAndIndexIsRight) {
  for (const bool compress : {true, false}) {
    Text sink;
    const auto file = test::McapFile::read(written(compress, 300, sink));
    EXPECT_TRUE(file.whole);
    EXPECT_GT(file.chunks, 5u);
    ASSERT_EQ(file.of("/a").size(), 300u);
    EXPECT_EQ(file.of("/b").size(), 100u);
    EXPECT_EQ(file.of("/a")[41]->data, "message 41");
    EXPECT_EQ(file.of("/a")[41]->time, 42'000u);
    EXPECT_EQ(file.of("/a")[41]->sequence, 42u);
    EXPECT_EQ(file.attachments.at("cell.yaml"), "polyarm: cell/1\n");
    EXPECT_EQ(file.metadata.at("polyarm.cell"), "demo");
    EXPECT_EQ(file.channels.at("/b").second, "ros2msg:string of b/msg/B");
  }
}

TEST(McapWriter, AFileThatIsCutOffAnywhereIsReadableUpToItsLastWholeChunk) {
  Text sink;
  const std::string whole = written(true, 200, sink);
  const auto all = test::McapFile::read(whole);
  std::size_t most = 0;
  for (std::size_t size = 60; size < whole.size(); size += 37) {
    const auto part = test::McapFile::read(std::string_view(whole).substr(0, size));
    EXPECT_FALSE(part.whole);
    ASSERT_LE(part.messages.size(), all.messages.size());
    for (std::size_t i = 0; i < part.messages.size(); ++i)
      ASSERT_EQ(part.messages[i].data, all.messages[i].data);
    EXPECT_GE(part.messages.size(), most) << "more bytes never say less";
    most = part.messages.size();
  }
  EXPECT_EQ(most, all.messages.size());
}

TEST(McapWriter, TheSameCallsGiveTheSameBytes) {
  Text a, b;
  EXPECT_EQ(written(true, 100, a), written(true, 100, b));
}

TEST(McapWriter, AFileWithoutAMessageIsWhole) {
  Text sink;
  EXPECT_TRUE(test::McapFile::read(written(true, 0, sink)).whole);
}

TEST(McapWriter, WhereNothingCanBeWrittenItDropsWhatItIsGiven) {
  Text sink(3000);
  McapWriter writer(sink, {"ros2", "test", 500, false});
  const std::size_t a = writer.add_channel(text_channel("/a"));
  for (std::uint64_t i = 0; i < 1000; ++i) writer.message(a, i, bytes_of("something to be written"));
  writer.finish();
  EXPECT_TRUE(writer.failed());
  EXPECT_LE(sink.text.size(), 3000u);
  EXPECT_GT(test::McapFile::read(sink.text).messages.size(), 10u);
}

}  // namespace
}  // namespace polyarm::recording
