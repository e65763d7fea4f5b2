#include "polyarm/signals/file_mailbox.hpp"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <sys/xattr.h>
#include <sys/prctl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cmath>
#include <csignal>
#include <fstream>
#include <initializer_list>
#include <map>
#include <string>
#include <thread>
#include <utility>
#include <vector>

#include "polyarm/base/file.hpp"
#include "polyarm/base/reach.hpp"
#include "polyarm/base/text.hpp"

namespace polyarm::signals {
namespace {

using data::ImportFile;
using data::Value;

/// A folder of its own with one data file.
class Mailbox : public testing::Test {
 protected:
  void SetUp() override {
    folder_ = std::filesystem::temp_directory_path() /
              ("polyarm_mailbox_" + std::to_string(::getpid()) + "_" +
               testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
    path_ = (folder_ / "cycledata.data").string();
  }
  void TearDown() override { std::filesystem::remove_all(folder_); }

  /// As an editor or a script does it: not atomically.
  void rewrite(const std::string& text) { std::ofstream(path_, std::ios::binary | std::ios::trunc) << text; }
  std::string content() const { return read_file(path_); }

  static Value value_of(const std::vector<MailboxEvent>& events, const std::string& name) {
    Value out("nothing");
    for (const MailboxEvent& event : events)
      for (const auto& [changed, value] : event.values)
        if (changed == name) out = value;
    return out;
  }

  MailboxOptions inline_options() {
    MailboxOptions options;
    options.thread = false;
    options.looks_until_settled = 10;
    return options;
  }

  std::filesystem::path folder_;
  std::string path_;
};

constexpr const char* kTwo = "# why\nName: A\nBool: False\n\nName: B\nBool: False\n";

TEST_F(Mailbox, WritesOnlyTheLineOfAPostedValue) {
  rewrite(kTwo);
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  mailbox.post("B", true);
  EXPECT_LT(mailbox.written(), mailbox.posted());
  mailbox.step();
  EXPECT_EQ(content(), "# why\nName: A\nBool: False\n\nName: B\nBool: True\n");
  EXPECT_EQ(mailbox.written(), mailbox.posted());
  EXPECT_TRUE(mailbox.take_events().empty());
}

/// The first problem that the mailbox reports in a few looks; empty if there is none.
std::string problem_of(FileMailbox& mailbox) {
  std::string out;
  for (int k = 0; k < 40; ++k) {
    mailbox.step();
    for (const MailboxEvent& event : mailbox.take_events())
      for (const Problem& problem : event.problems)
        if (out.empty()) out = problem.code;
  }
  return out;
}

TEST_F(Mailbox, WhatTakesItsPlaceIsNeitherReadNorReplaced) {
  for (const char* kind : {"pipe", "device", "large", "folder"}) {
    rewrite(kTwo);
    FileMailbox mailbox(ImportFile::load(path_), inline_options());
    std::filesystem::remove(path_);
    if (kind[0] == 'p') ASSERT_EQ(::mkfifo(path_.c_str(), 0600), 0);
    if (kind[0] == 'd') std::filesystem::create_symlink("/dev/zero", path_);
    if (kind[0] == 'f') std::filesystem::create_directory(path_);
    if (kind[0] == 'l') rewrite("Name: A\nBool: True\n");
    if (kind[0] == 'l') std::filesystem::resize_file(path_, std::uintmax_t{1} << 40);  // nearly all of it a hole
    mailbox.post("B", true);
    EXPECT_EQ(problem_of(mailbox), kind[0] == 'l' ? "too-large" : "not-a-file") << kind;
    EXPECT_LT(mailbox.written(), mailbox.posted());
    std::filesystem::remove(path_);
    rewrite(kTwo);
    EXPECT_EQ(problem_of(mailbox), "") << kind;
    EXPECT_EQ(content(), "# why\nName: A\nBool: False\n\nName: B\nBool: True\n") << kind;
  }
}

/// The permissions of a process hold until it ends, so the test runs in one of its own.
TEST_F(Mailbox, ALinkThatLeadsOutOfTheCellIsNotFollowed) {
  const std::filesystem::path outside = folder_.string() + "_outside";
  std::filesystem::create_directories(outside);
  write_file_atomically(outside / "secret.data", "Name: A\nBool: True\n\nName: B\nBool: False\n");
  rewrite(kTwo);
  const auto in_a_cell = [&] {
    reach().confine();
    const auto grant = reach().open_cell(folder_);
    FileMailbox mailbox(ImportFile::load(path_), inline_options());
    std::filesystem::remove(path_);
    std::filesystem::create_symlink(outside / "secret.data", path_);
    std::string codes;
    bool told_value = false;
    for (int k = 0; k < 40; ++k) {
      mailbox.step();
      for (const MailboxEvent& event : mailbox.take_events()) {
        told_value |= !event.values.empty();
        for (const Problem& problem : event.problems) codes += problem.code + " ";
      }
    }
    const bool refused = codes == "outside-cell " && !told_value;
    std::filesystem::remove(path_);
    write_file_atomically(folder_ / "other.data", "Name: A\nBool: True\n\nName: B\nBool: False\n");
    std::filesystem::create_symlink("other.data", path_);  // stays inside
    for (int k = 0; k < 40; ++k) mailbox.step();
    const bool taken = value_of(mailbox.take_events(), "A") == Value(true);
    std::fprintf(stderr, "%s; %s%s\n", codes.c_str(), refused ? "refused " : "", taken ? "taken" : "");
    std::exit(refused && taken ? 0 : 1);
  };
  EXPECT_EXIT(in_a_cell(), testing::ExitedWithCode(0), "outside-cell ; refused taken");
  std::filesystem::remove_all(outside);
}

TEST_F(Mailbox, TellsWhatWasChangedFromOutside) {
  rewrite(kTwo);
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  mailbox.step();
  rewrite("# other\nName: A\nBool: False\nName: B\nBool: True\nName: C\nNum: 3\n");
  mailbox.step();
  const auto events = mailbox.take_events();
  EXPECT_EQ(value_of(events, "B"), Value(true));
  EXPECT_EQ(value_of(events, "C"), Value(3));
  EXPECT_EQ(value_of(events, "A"), Value("nothing"));
}

TEST_F(Mailbox, TellsWhichGroupsWereChangedFromOutside) {
  rewrite("Name: A\nGroup: left\nBool: False\nName: B\nBool: False\n");
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  mailbox.step();
  rewrite("Name: A\nBool: False\nName: B\nGroup: right\nBool: False\n");
  mailbox.step();
  const auto events = mailbox.take_events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_TRUE(events[0].values.empty());
  const std::vector<std::pair<std::string, std::string>> groups{{"A", ""}, {"B", "right"}};
  EXPECT_EQ(events[0].groups, groups);
  mailbox.post("A", true);
  mailbox.step();
  EXPECT_EQ(content(), "Name: A\nBool: True\nName: B\nGroup: right\nBool: False\n");
}

TEST_F(Mailbox, ARewriteThatHadNotSeenOurWriteKeepsBoth) {
  rewrite(kTwo);
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  mailbox.step();
  const std::string read = content();
  mailbox.post("A", true);
  mailbox.step();
  rewrite("Name: A\nBool: False\nName: B\nBool: True\n");
  mailbox.step();
  EXPECT_EQ(value_of(mailbox.take_events(), "B"), Value(true));
  EXPECT_EQ(content(), "Name: A\nBool: True\nName: B\nBool: True\n");
}

TEST_F(Mailbox, AnOutsiderThatOnlyResetsWhatItSawIsUnderstood) {
  rewrite(kTwo);
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  for (int i = 0; i < 5; ++i) {
    mailbox.post("A", true);
    mailbox.step();
    ASSERT_NE(content().find("Name: A\nBool: True"), std::string::npos);
    rewrite(kTwo);
    mailbox.step();
    ASSERT_EQ(value_of(mailbox.take_events(), "A"), Value(false)) << "round " << i;
    ASSERT_EQ(content(), kTwo);
  }
}

TEST_F(Mailbox, AnEditorThatReplacesTheFileIsSeen) {
  rewrite(kTwo);
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  mailbox.step();
  write_file_atomically(path_, "Name: A\nBool: True\nName: B\nBool: False\n");
  mailbox.step();
  EXPECT_EQ(value_of(mailbox.take_events(), "A"), Value(true));
}

TEST_F(Mailbox, AHalfWrittenFileIsNeitherTakenNorOverwritten) {
  rewrite(kTwo);
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  mailbox.step();
  for (const std::string half :
       {"", "Name: A\nBool: Tr", "Name: A\nBool: True\n", "Name: A\nBool: True\nName: B\nBo"}) {
    rewrite(half);
    mailbox.post("A", true);
    mailbox.step();
    EXPECT_EQ(content(), half);
    EXPECT_TRUE(mailbox.take_events().empty());
  }
  rewrite("Name: A\nBool: False\nName: B\nBool: True\n");
  mailbox.step();
  EXPECT_EQ(value_of(mailbox.take_events(), "B"), Value(true));
  EXPECT_NE(content().find("Name: A\nBool: True"), std::string::npos);
}

TEST_F(Mailbox, AFileThatStaysBrokenIsReportedOnceAndItsRepairToo) {
  rewrite(kTwo);
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  rewrite("Name: A\nBool: perhaps\n");
  for (int i = 0; i < 50; ++i) mailbox.step();
  auto events = mailbox.take_events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, MailboxEvent::Kind::problem);
  EXPECT_EQ(events[0].problems.at(0).where.line, 2);
  rewrite(kTwo);
  mailbox.step();
  events = mailbox.take_events();
  ASSERT_EQ(events.size(), 1u);
  EXPECT_EQ(events[0].kind, MailboxEvent::Kind::recovered);
}

TEST_F(Mailbox, AFileThatIsDeletedComesBack) {
  rewrite(kTwo);
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  mailbox.step();
  std::filesystem::remove(path_);
  for (int i = 0; i < 50; ++i) mailbox.step();
  EXPECT_EQ(content(), kTwo);
}

TEST_F(Mailbox, AFileThatStaysEmptyIsWrittenAgain) {
  rewrite(kTwo);
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  mailbox.step();
  rewrite("");
  for (int i = 0; i < 50; ++i) mailbox.step();
  EXPECT_EQ(content(), kTwo);
}

TEST_F(Mailbox, AWriterThatHoldsTheDisplacedFileIsHeard) {
  rewrite(kTwo);
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  mailbox.step();
  std::fstream slow(path_, std::ios::in | std::ios::out | std::ios::binary);
  mailbox.post("A", true);
  mailbox.step();
  slow << "# WHY\nName: A\nBool: False\n\nName: B\nBool: True \n" << std::flush;
  mailbox.step();
  EXPECT_EQ(value_of(mailbox.take_events(), "B"), Value(true));
  EXPECT_NE(content().find("Name: A\nBool: True"), std::string::npos);
  EXPECT_NE(content().find("Name: B\nBool: True"), std::string::npos);
}

TEST_F(Mailbox, APostThatIsNewerThanTheMergeWins) {
  rewrite(kTwo);
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  rewrite("Name: A\nBool: True\nName: B\nBool: False\n");
  mailbox.step();
  mailbox.post("A", false);
  EXPECT_TRUE(mailbox.take_events().empty());
  mailbox.step();
  EXPECT_NE(content().find("Name: A\nBool: False"), std::string::npos);
}

TEST_F(Mailbox, RefusesAtOnceWhatTheFileCannotHold) {
  rewrite(kTwo);
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  EXPECT_THROW(mailbox.post("A", Value(std::nan(""))), Error);
  EXPECT_THROW(mailbox.post("two\nlines", Value(true)), Error);
}

TEST_F(Mailbox, WritesWhatIsPostedBeforeItEnds) {
  rewrite(kTwo);
  { FileMailbox(ImportFile::load(path_), {}).post("A", true); }
  EXPECT_NE(content().find("Name: A\nBool: True"), std::string::npos);
}

TEST_F(Mailbox, TwoOfOurKindShakeHandsOverAFileAgainAndAgain) {
  rewrite("Name: Ask\nBool: False\nName: Done\nBool: False\n");
  FileMailbox robot(ImportFile::load(path_), inline_options()),
      plc(ImportFile::load(path_), inline_options());
  const auto hears = [](FileMailbox& side, FileMailbox& other, const std::string& name, bool expected) {
    bool heard = false;
    for (int look = 0; look < 20 && !heard; ++look) {
      other.step();
      side.step();
      heard = value_of(side.take_events(), name) == Value(expected);
    }
    return heard;
  };
  for (int round = 0; round < 100; ++round) {  // the file says the same things again in every round
    robot.post("Ask", true);
    ASSERT_TRUE(hears(plc, robot, "Ask", true)) << round;
    plc.post("Ask", false);
    plc.post("Done", true);
    ASSERT_TRUE(hears(robot, plc, "Done", true)) << round;
    robot.post("Done", false);
    ASSERT_TRUE(hears(plc, robot, "Done", false)) << round;
  }
  EXPECT_EQ(content(), "Name: Ask\nBool: False\nName: Done\nBool: False\n");
}

/// One side of a handshake over a file, on the thread of its mailbox.
class Party {
 public:
  Party(const std::string& path, Nanoseconds period)
      : box_(ImportFile::load(path), {.thread = true, .period = period}) {}
  void set(std::initializer_list<std::pair<const char*, bool>> values) {
    std::vector<std::pair<std::string, Value>> posts;
    for (const auto& [name, value] : values) {
      known_[name] = value;
      posts.emplace_back(name, Value(value));
    }
    box_.post(posts);
  }
  /// False if it does not come for minutes: where others write much, one flush to the disk may take half a
  /// minute.
  bool hears(const std::string& name) {
    const auto until = std::chrono::steady_clock::now() + std::chrono::minutes(4);
    while (!known_[name] && std::chrono::steady_clock::now() < until) {
      std::this_thread::sleep_for(
          std::chrono::microseconds(20));  // the two threads of I/O need the processors
      for (const MailboxEvent& event : box_.take_events())
        for (const auto& [changed, value] : event.values) known_[changed] = *value.as_boolean();
    }
    return known_[name];
  }

 private:
  std::map<std::string, bool> known_;
  FileMailbox box_;
};

TEST_F(Mailbox, TwoOfOurKindThatWriteAtTheSameTimeLoseNothing) {
  rewrite(
      "Name: Load\nBool: False\nName: Ask\nBool: False\nName: Set\nBool: False\nName: Act\nBool: False\n"
      "Name: Active\nBool: False\n");
  Party robot(path_, 200'000), plc(path_, 300'000);
  constexpr int kRounds = 300;  // the file says the same things again in every round
  std::string lost;
  std::thread far([&] {
    for (int round = 0; round < kRounds && lost.empty(); ++round) {
      plc.set({{"Load", true}});
      if (!plc.hears("Ask")) return;
      plc.set({{"Ask", false}});
      plc.set({{"Set", true}});
      if (!plc.hears("Act")) return;
      plc.set({{"Act", false}, {"Active", true}});
    }
  });
  for (int round = 0; round < kRounds && lost.empty(); ++round) {
    const auto wait_for = [&](const char* name) {
      if (lost.empty() && !robot.hears(name)) lost = name + (" in round " + std::to_string(round));
    };
    wait_for("Load");
    robot.set({{"Load", false}, {"Ask", true}});
    wait_for("Set");
    robot.set({{"Set", false}, {"Act", true}});
    wait_for("Active");
    robot.set({{"Active", false}});
  }
  far.join();
  EXPECT_EQ(lost, "");
}

/// So much news of a folder that the system drops some.
void flood_the_news(const std::filesystem::path& folder) {
  const std::string one = (folder / "one").string(), two = (folder / "two").string();
  for (int i = 0; i < 20'000; ++i)
    for (const std::string& file : {one, two}) ::close(::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600));
}

bool keeps_marks(const std::filesystem::path& folder) {
  const std::string file = (folder / "marked").string();
  const int fd = ::open(file.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  const bool kept = ::fsetxattr(fd, "user.polyarm.test", "x", 1, 0) == 0;
  ::close(fd);
  return kept;
}

TEST_F(Mailbox, WhatOneOfOurKindTakesBackIsTakenBackWhereTheSystemSaysNothing) {
  if (!keeps_marks(folder_)) GTEST_SKIP() << "the file system keeps no extended attributes";
  rewrite("Name: Ask\nBool: False\n");
  FileMailbox robot(ImportFile::load(path_), inline_options()), plc(ImportFile::load(path_), inline_options());
  robot.post("Ask", true);
  robot.step();
  plc.step();
  ASSERT_EQ(plc.take_events().size(), 1u);
  plc.post("Ask", false);  // the file says what it said at the start
  plc.step();
  flood_the_news(folder_);
  robot.step();
  const std::vector<MailboxEvent> heard = robot.take_events();
  ASSERT_EQ(heard.size(), 1u) << "the answer was taken for an old version of the file";
  ASSERT_EQ(heard[0].values.size(), 1u);
  EXPECT_FALSE(*heard[0].values[0].second.as_boolean());
  EXPECT_EQ(content(), "Name: Ask\nBool: False\n");
}

/// Held as by `polyarm data`, or by another runtime that looks at the file.
class FolderHeld {
 public:
  explicit FolderHeld(const std::filesystem::path& folder)
      : fd_(::open(folder.c_str(), O_RDONLY | O_DIRECTORY)) {
    EXPECT_EQ(::flock(fd_, LOCK_EX | LOCK_NB), 0);
  }
  ~FolderHeld() { ::close(fd_); }
  FolderHeld(const FolderHeld&) = delete;
  FolderHeld& operator=(const FolderHeld&) = delete;

 private:
  int fd_;
};

TEST_F(Mailbox, WritesNothingWhileAnotherHasItsTurn) {
  rewrite(kTwo);
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  mailbox.post("B", true);
  {
    const FolderHeld held(folder_);
    mailbox.step();
    EXPECT_EQ(content(), kTwo);
    EXPECT_LT(mailbox.written(), mailbox.posted());
    EXPECT_EQ(mailbox.looks(), 0u) << "that was no look: a `load` still waits for one";
  }
  mailbox.step();
  EXPECT_EQ(content(), "# why\nName: A\nBool: False\n\nName: B\nBool: True\n");
}

TEST_F(Mailbox, DoesNotWaitForeverForAnotherWhoIsStuckWithItsTurn) {
  rewrite(kTwo);
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  const FolderHeld held(folder_);
  mailbox.post("B", true);
  int looks = 0;
  for (; looks < 1000 && mailbox.written() < mailbox.posted(); ++looks) mailbox.step();
  EXPECT_GT(looks, 50);
  EXPECT_LT(looks, 300);
}

TEST_F(Mailbox, KeepsWhatItCanOfSeveralValues) {
  rewrite(kTwo);
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  const std::vector<std::pair<std::string, Value>> values{
      {"A", Value(true)}, {"C", Value(std::nan(""))}, {"B", Value(true)}};
  EXPECT_THROW(mailbox.post(values), Error);
  mailbox.step();
  EXPECT_EQ(content(), "# why\nName: A\nBool: True\n\nName: B\nBool: True\n");
}

TEST_F(Mailbox, WritesThroughNoLinkThatSomebodyHasPlanted) {
  rewrite("Name: Belt\nBool: False\n");
  const auto victim = folder_ / "victim";
  write_file_atomically(victim, "as it was");
  for (int n = 0; n < 20; ++n)
    std::filesystem::create_symlink(
        victim, folder_ / (".cycledata.data.tmp" + std::to_string(::getpid()) + "." + std::to_string(n)));
  FileMailbox mailbox(ImportFile::load(path_), inline_options());
  mailbox.post("Belt", true);
  mailbox.step();
  EXPECT_EQ(content(), "Name: Belt\nBool: True\n");
  EXPECT_EQ(read_file(victim), "as it was");
}

TEST_F(Mailbox, LeavesNoTemporaryFiles) {
  rewrite(kTwo);
  {
    FileMailbox mailbox(ImportFile::load(path_), inline_options());
    for (int i = 0; i < 20; ++i) mailbox.post("A", i % 2 == 0), mailbox.step();
  }
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder_), {}), 1);
}

// --- a real program outside ---

constexpr int kRounds = 200, kCounters = 4;

double number(const Value& value) {
  return value.as_number() ? value.as_number()->value : -1;
}
double number(const data::DataSet& set, const std::string& name) {
  return set.value(name)->as_number()->value;
}
bool truth(const data::DataSet& set, const std::string& name) {
  return *set.value(name)->as_boolean();
}

/// Reads the whole file, thinks, rewrites the whole file, again and again until told to stop. Every request
/// it sees it answers by resetting it and counting up its own numbers. Ends with 0 if it never saw a number
/// of the runtime go back.
int outsider(const std::string& path) {
  std::map<std::string, double> seen;
  double count = 0;
  volatile unsigned thought = 0;
  for (int round = 0; round < 4'000'000; ++round) {
    Problems problems;
    ImportFile file = ImportFile::parse(read_file(path), path, problems);
    for (int i = 0; i < kCounters; ++i) {
      const double now = number(file.values(), "mine" + std::to_string(i));
      double& before = seen["mine" + std::to_string(i)];
      if (now < before) return 1;
      before = now;
    }
    if (truth(file.values(), "Stop")) return 0;
    for (unsigned i = 0; i < 100'000u * (static_cast<unsigned>(round) % 4); ++i) thought = thought + i;
    if (truth(file.values(), "Ask")) {
      ++count;
      for (int i = 0; i < kCounters; ++i) file.set("theirs" + std::to_string(i), count);
      file.set("Ask", false);
    }
    std::ofstream(path, std::ios::binary | std::ios::trunc) << file.text();
  }
  return 2;
}

/// What the runtime knows of the file.
struct Runtime {
  FileMailbox& mailbox;
  std::map<std::string, Value> values;
  bool went_back = false;

  void set(const std::string& name, const Value& value) {
    values[name] = value;
    mailbox.post(name, value);
  }
  void take() {
    for (const MailboxEvent& event : mailbox.take_events())
      for (const auto& [name, value] : event.values) {
        const auto& before = values[name];
        if (value.as_number() && before.as_number())
          went_back |= value.as_number()->value < before.as_number()->value;
        values[name] = value;
      }
  }
  template <class Until>
  bool wait(Until until) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::minutes(5);
    while (std::chrono::steady_clock::now() < end) {
      if (until()) return true;
      std::this_thread::sleep_for(std::chrono::microseconds(100));  // the two others need the processors
      take();
    }
    return false;
  }
};

TEST_F(Mailbox, AThousandSetsInEachDirectionAllArrive) {
  std::string text = "Name: Ask\nBool: False\nName: Stop\nBool: False\n";
  for (const char* side : {"mine", "theirs"})
    for (int i = 0; i < kCounters; ++i) text += "Name: " + (side + std::to_string(i)) + "\nNum: 0\n";
  rewrite(text);
  const ImportFile start = ImportFile::load(path_);
  const pid_t child = ::fork();
  if (child == 0) {
    ::prctl(PR_SET_PDEATHSIG, SIGKILL);
    ::_exit(outsider(path_));
  }
  MailboxOptions options;
  options.period = 1'000'000;
  options.looks_until_settled = 3000;
  std::map<std::string, Value> known;
  {
    FileMailbox mailbox(start, options);
    Runtime runtime{mailbox, {{"Ask", Value(false)}}};
    double answered = 0;
    for (int round = 1; round <= kRounds && !runtime.went_back; ++round) {
      for (int i = 0; i < kCounters; ++i) runtime.set("mine" + std::to_string(i), round);
      runtime.set("Ask", true);
      ASSERT_TRUE(runtime.wait([&] { return runtime.values["Ask"] == Value(false); })) << "round " << round;
      // An answer may be given twice, where the outsider read in the instant of a write, but never be lost.
      for (int i = 0; i < kCounters; ++i) {
        const double count = number(runtime.values["theirs" + std::to_string(i)]);
        ASSERT_GT(count, answered) << "the request was reset without an answer, in round " << round;
        if (i == kCounters - 1) answered = count;
      }
    }
    runtime.set("Stop", true);
    int status = -1;
    EXPECT_TRUE(runtime.wait([&] { return ::waitpid(child, &status, WNOHANG) == child; }));
    EXPECT_TRUE(WIFEXITED(status) && WEXITSTATUS(status) == 0) << status;
    EXPECT_FALSE(runtime.went_back);
    known = runtime.values;
  }
  const ImportFile last = ImportFile::load(path_);
  for (int i = 0; i < kCounters; ++i) {
    EXPECT_EQ(number(last.values(), "mine" + std::to_string(i)), kRounds);
    EXPECT_EQ(number(last.values(), "theirs" + std::to_string(i)),
              number(known["theirs" + std::to_string(i)]));
  }
}

}  // namespace
}  // namespace polyarm::signals
