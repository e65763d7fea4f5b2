#include "polyarm/base/printer.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <string>
#include <thread>

namespace polyarm {
namespace {

/// A pipe that holds a page.
class Pipe {
 public:
  Pipe() {
    if (::pipe2(ends_.data(), O_CLOEXEC) != 0 || ::fcntl(ends_[1], F_SETPIPE_SZ, 4096) < 0)
      throw std::runtime_error("no pipe");
  }
  ~Pipe() {
    finish();
    ::close(ends_[0]);
  }
  int to() const { return ends_[1]; }
  void finish() {
    if (ends_[1] >= 0) ::close(ends_[1]);
    ends_[1] = -1;
  }
  /// At least so many bytes, or all until its end.
  std::string read(std::size_t bytes) {
    std::string text;
    std::array<char, 1000> piece;
    while (text.size() < bytes) {
      const ssize_t count = ::read(ends_[0], piece.data(), piece.size());
      if (count <= 0) break;
      text.append(piece.data(), static_cast<std::size_t>(count));
    }
    return text;
  }

 private:
  std::array<int, 2> ends_{-1, -1};
};

std::string numbered(int i) {
  return "line " + std::to_string(i) + "\n";
}
std::string gap(std::size_t count) {
  return std::to_string(count) + " left out\n";
}

TEST(Printer, WritesAllInOrderForWhoReadsSlowly) {
  Pipe pipe;
  std::string expected, read;
  std::thread reader([&] { read = pipe.read(std::size_t{1} << 30); });
  {
    Printer printer(pipe.to(), Printer::Full::waits, gap, 100);
    for (int i = 0; i < 5000; ++i) {
      printer.put(numbered(i));
      expected += numbered(i);
    }
    EXPECT_TRUE(printer.settle());
  }
  pipe.finish();
  reader.join();
  EXPECT_EQ(read, expected);
}

TEST(Printer, WaitsForWhoReadsSlowlyThoughTheDescriptorNeverDoes) {
  Pipe pipe;
  ASSERT_EQ(::fcntl(pipe.to(), F_SETFL, O_NONBLOCK), 0);
  Printer printer(pipe.to(), Printer::Full::waits, gap);
  std::string expected;
  for (int i = 0; i < 2000; ++i) expected += numbered(i);  // more than the pipe holds, before anybody reads
  printer.put(expected);
  EXPECT_EQ(pipe.read(expected.size()), expected);
  EXPECT_TRUE(printer.settle());
}

TEST(Printer, LeavesOutWhatNobodyReadsAndSaysHowMuch) {
  Pipe pipe;
  Printer printer(pipe.to(), Printer::Full::leaves_out, gap, 8000);
  constexpr int kLines = 20000;  // far more than pipe and printer hold
  for (int i = 0; i < kLines; ++i) printer.put(numbered(i));
  EXPECT_FALSE(printer.settle());
  // Each line is there, in order, or counted; the thread may have written some before the pipe was full.
  int next = 0, gaps = 0;
  for (std::string text; next < kLines;) {
    text += pipe.read(1);
    for (std::size_t end; (end = text.find('\n')) != std::string::npos; text.erase(0, end + 1)) {
      const std::string line = text.substr(0, end + 1);
      if (line == numbered(next)) {
        ++next;
        continue;
      }
      std::size_t digits = 0;
      const int count = std::stoi(line, &digits);
      ASSERT_EQ(line.substr(digits), " left out\n") << next;
      next += count;
      ++gaps;
    }
  }
  EXPECT_EQ(next, kLines);
  EXPECT_GE(gaps, 1);
  printer.put("it goes on\n");
  EXPECT_EQ(pipe.read(11), "it goes on\n");
  EXPECT_TRUE(printer.settle());
}

TEST(Printer, ATextLongerThanAllThatMayWaitIsTaken) {
  Pipe pipe;
  Printer printer(pipe.to(), Printer::Full::leaves_out, gap, 10);
  const std::string text(3000, 'x');
  printer.put(text);
  EXPECT_EQ(pipe.read(text.size()), text);
}

TEST(Printer, AReaderThatIsGoneHoldsNobody) {
  Printer printer(-1, Printer::Full::waits, gap, 10);
  for (int i = 0; i < 100; ++i) printer.put(numbered(i));
  EXPECT_TRUE(printer.settle());
}

}  // namespace
}  // namespace polyarm
