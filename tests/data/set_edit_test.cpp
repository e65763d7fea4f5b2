#include "polyarm/data/set_edit.hpp"

#include <gtest/gtest.h>
#include <signal.h>
#include <stdlib.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <fstream>
#include <functional>

#include "polyarm/base/file.hpp"

namespace polyarm::data {
namespace {

namespace fs = std::filesystem;

constexpr const char* kText =
    "# points of the table\nName: a\nNum: 1  # one\n\nPose: RPY\nName: p\nPoint: 1, 2, 3, 0, 0, 0\n";

class SetEdit : public testing::Test {
 protected:
  void SetUp() override {
    std::string pattern = (fs::temp_directory_path() / "polyarm_XXXXXX").string();
    folder = ::mkdtemp(pattern.data());
    file = folder / "table.points";
    std::ofstream(file) << kText;
  }
  void TearDown() override {
    ::chmod(folder.c_str(), 0700);
    std::error_code ignored;
    fs::remove_all(folder, ignored);
  }
  void set(const std::string& name, const Value& value) {
    edit_set(file, "set " + name, [&](ImportFile& set) { set.set(name, value); });
  }
  /// In a process of its own, which may be limited or killed; its exit code.
  static int elsewhere(const std::function<int()>& what) {
    const pid_t child = ::fork();
    if (child == 0) ::_exit(what());
    int status = 0;
    ::waitpid(child, &status, 0);
    return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
  }

  fs::path folder, file;
};

TEST_F(SetEdit, ChangesOneLineAndKeepsTheRest) {
  set("a", 2);
  EXPECT_EQ(read_file(file),
            "# points of the table\nName: a\nNum: 2  # one\n\nPose: RPY\nName: p\nPoint: 1, 2, 3, 0, 0, 0\n");
}

TEST_F(SetEdit, TakesBackAsManyChangesAsAreAsked) {
  set("a", 2);
  set("a", 3);
  set("b", true);
  ASSERT_EQ(history(file).size(), 3u);
  EXPECT_EQ(history(file)[1].what, "set a");
  undo(file, 2);
  EXPECT_EQ(*ImportFile::load(file.string()).values().value("a"), Value(2));
  undo(file, 1);
  EXPECT_EQ(read_file(file), kText);
  EXPECT_THROW(undo(file, 1), Error);
  EXPECT_TRUE(fs::exists(folder / ".state" / "history" / "table.points" / "undone"));
}

TEST_F(SetEdit, AFileThatIsDeletedComesBackAndANewOneGoes) {
  delete_set(file);
  EXPECT_FALSE(fs::exists(file));
  undo(file, 1);
  EXPECT_EQ(read_file(file), kText);
  const fs::path other = folder / "new.data";
  edit_set(other, "set x", [](ImportFile& set) { set.set("x", 1); });
  undo(other, 1);
  EXPECT_FALSE(fs::exists(other));
}

TEST_F(SetEdit, NothingIsWrittenWhereNothingChanges) {
  set("a", 1);
  EXPECT_TRUE(history(file).empty());
}

TEST_F(SetEdit, ABrokenFileIsRefusedAndStaysAsItIs) {
  for (const std::string text : {"Name: a\nNum: x\n", "\x80\x04\x95pickle", "Name"}) {
    std::ofstream(file) << text;
    EXPECT_THROW(set("a", 2), Error);
    EXPECT_EQ(read_file(file), text);
  }
}

TEST_F(SetEdit, WithoutANameAllItsLinesGoAndNoOther) {
  Problems problems;
  const ImportFile set = ImportFile::parse(
      "Name: a\nNum: 1\nNum: 2\n# why\nJS: x\nName: p\nPoint: 1\nName: a\nNum: 3\nName: q\nPoint: 2", "t",
      problems);
  EXPECT_EQ(without(set, "a").text(), "# why\nJS: x\nName: p\nPoint: 1\nName: q\nPoint: 2");
  EXPECT_EQ(without(set, "p").values().size(), 2u);
  EXPECT_THROW(without(set, "b"), Error);
}

TEST_F(SetEdit, AWriterThatIsKilledAtAnyTimeLeavesTheOldFileOrTheNewOne) {
  std::string big = kText;
  for (int k = 0; k < 20000; ++k) big += "# a line that makes the file long " + std::to_string(k) + "\n";
  std::ofstream(file) << big;
  int olds = 0;
  for (int k = 0; k < 25; ++k) {
    const std::string before = read_file(file);
    const pid_t child = ::fork();
    if (child == 0) {
      set("a", 100 + k);
      ::_exit(0);
    }
    ::usleep(static_cast<unsigned>(k) * 700);
    ::kill(child, SIGKILL);
    ::waitpid(child, nullptr, 0);
    const std::string after = read_file(file);
    Problems problems;
    const ImportFile now = ImportFile::parse(after, "t", problems);
    ASSERT_TRUE(after == before || *now.values().value("a") == Value(100 + k));
    olds += after == before;
  }
  set("a", 7);
  for (const auto& entry : fs::directory_iterator(folder))
    EXPECT_EQ(entry.path().filename().string().find(".tmp"), std::string::npos) << entry.path();
}

TEST_F(SetEdit, AFullDiskIsToldAndTheFileStaysAsItWas) {
  std::string big = kText;
  for (int k = 0; k < 2000; ++k) big += "# line " + std::to_string(k) + "\n";
  std::ofstream(file) << big;
  const int code = elsewhere([&] {
    ::signal(SIGXFSZ, SIG_IGN);
    const rlimit limit{4096, 4096};  // bytes in one file
    ::setrlimit(RLIMIT_FSIZE, &limit);
    try {
      set("a", 2);
    } catch (const Error& e) {
      return e.problems().front().code == "unwritable" ? 0 : 2;
    }
    return 1;
  });
  EXPECT_EQ(code, 0);
  EXPECT_EQ(read_file(file), big);
}

TEST_F(SetEdit, AReadOnlyFolderIsToldAndTheFileStaysAsItWas) {
  ASSERT_EQ(::chmod(folder.c_str(), 0555), 0);
  const int code = elsewhere([&] {
    if (::geteuid() == 0 && ::setuid(65534) != 0) return 3;  // root may write anywhere
    try {
      set("a", 2);
    } catch (const Error& e) {
      return e.problems().front().code == "unwritable" ? 0 : 2;
    }
    return 1;
  });
  EXPECT_EQ(code, 0);
  EXPECT_EQ(read_file(file), kText);
}

TEST_F(SetEdit, TwoProcessesOnOneFileLoseNoChange) {
  constexpr int kChanges = 40;
  std::vector<pid_t> children;
  for (int who = 0; who < 3; ++who) {
    const pid_t child = ::fork();
    if (child == 0) {
      try {
        for (int k = 0; k < kChanges; ++k)
          edit_set(
              file, "count",
              [&](ImportFile& set) {
                set.set("n" + std::to_string(who), k + 1);
                set.set("a", set.values().value("a")->as_number()->value + 1);
              },
              120000);
      } catch (const Error&) {
        ::_exit(1);
      }
      ::_exit(0);
    }
    children.push_back(child);
  }
  for (const pid_t child : children) {
    int status = 0;
    ::waitpid(child, &status, 0);
    EXPECT_EQ(status, 0);
  }
  const ImportFile now = ImportFile::load(file.string());
  EXPECT_EQ(*now.values().value("a"), Value(1 + 3 * kChanges));
  for (const char* name : {"n0", "n1", "n2"}) EXPECT_EQ(*now.values().value(name), Value(kChanges));
}

TEST_F(SetEdit, WhoWaitsTooLongForAnotherWriterIsTold) {
  edit_set(file, "outer", [&](ImportFile&) {
    try {
      edit_set(
          file, "inner", [](ImportFile& set) { set.set("a", 9); }, 20);
      ADD_FAILURE() << "two writers at once";
    } catch (const Error& e) {
      EXPECT_EQ(e.problems().front().code, "in-use");
    }
  });
}

TEST_F(SetEdit, ANameThatStandsForAnotherFileStaysAndItsModeToo) {
  const fs::path link = folder / "link.points";
  fs::create_symlink(file, link);
  ASSERT_EQ(::chmod(file.c_str(), 0640), 0);
  edit_set(link, "set a", [](ImportFile& set) { set.set("a", 5); });
  EXPECT_TRUE(fs::is_symlink(link));
  EXPECT_EQ(*ImportFile::load(file.string()).values().value("a"), Value(5));
  struct stat now {};
  ASSERT_EQ(::stat(file.c_str(), &now), 0);
  EXPECT_EQ(now.st_mode & 07777, 0640u);
}

}  // namespace
}  // namespace polyarm::data
