#include "polyarm/base/reach.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/approvals.hpp"
#include "polyarm/base/secrets.hpp"
#include "polyarm/base/sha256.hpp"
#include "tests/support/folder.hpp"

namespace polyarm {
namespace {

namespace fs = std::filesystem;
using test::Folder;

template <typename Step>
std::string code_of(Step step) {
  try {
    step();
  } catch (const Error& e) {
    return e.problems().front().code;
  }
  return "nothing was thrown";
}

TEST(ReadFile, WaitsForNoPipeAndReadsNoDevice) {
  const Folder folder;
  const fs::path pipe = folder.path() / "points.points", link = folder.path() / "zero.points";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  fs::create_symlink("/dev/zero", link);
  EXPECT_EQ(code_of([&] { read_file(pipe); }), "not-a-file");
  EXPECT_EQ(code_of([&] { read_file(link); }), "not-a-file");
  EXPECT_EQ(code_of([&] { read_file("/dev/zero"); }), "not-a-file");
  EXPECT_EQ(code_of([&] { write_file_atomically(pipe, "x"); }), "not-a-file");
  EXPECT_EQ(code_of([&] { read_file(folder.path()); }), "no-file");
}

TEST(ReadFile, ReadsNoMoreThanItMay) {
  const Folder folder;
  const fs::path file = folder.write("a.txt", std::string(1000, 'x'));
  EXPECT_EQ(read_file(file, 1000).size(), 1000u);
  EXPECT_EQ(code_of([&] { read_file(file, 999); }), "too-large");
  EXPECT_FALSE(read_file("/proc/self/status").empty()) << "files that say they are empty";
  fs::resize_file(file, std::uintmax_t{1} << 40);  // a hole of a terabyte
  EXPECT_EQ(code_of([&] { read_file(file); }), "too-large");
}

TEST(Resolved, FollowsLinksWhoseTargetsDoNotExist) {
  const Folder cell, outside;
  const fs::path real = fs::canonical(outside.path()) / "out.mcap", here = fs::canonical(cell.path());
  fs::create_symlink(real, cell.path() / "absolute.mcap");
  fs::create_symlink("../" + outside.path().filename().string() + "/out.mcap", cell.path() / "relative.mcap");
  fs::create_symlink("absolute.mcap", cell.path() / "twice.mcap");
  fs::create_symlink(outside.path() / "missing", cell.path() / "folder");
  fs::create_symlink("loop", cell.path() / "loop");
  EXPECT_EQ(resolved(cell.path() / "absolute.mcap"), real);
  EXPECT_EQ(resolved(cell.path() / "relative.mcap"), real);
  EXPECT_EQ(resolved(cell.path() / "twice.mcap"), real);
  EXPECT_EQ(resolved(cell.path() / "folder/a/b"), fs::canonical(outside.path()) / "missing/a/b");
  EXPECT_EQ(resolved(cell.path() / "none/of/them"), here / "none/of/them");
  resolved(cell.path() / "loop");  // ends
}

TEST(WriteFile, GivesANewFileItsModeAndKeepsThatOfAnOldOne) {
  const Folder folder;
  const fs::path file = folder.path() / "secret";
  write_file_atomically(file, "a", 0600);
  EXPECT_EQ(fs::status(file).permissions(), fs::perms(0600));
  write_file_atomically(file, "b");
  EXPECT_EQ(fs::status(file).permissions(), fs::perms(0600));
}

TEST(SweepTemporaries, TakesThoseOfDeadProcessesAndNothingElse) {
  const Folder folder;
  const pid_t dead = ::fork();
  if (dead == 0) ::_exit(0);
  ::waitpid(dead, nullptr, 0);
  const std::string gone = ".a.data.tmp" + std::to_string(dead) + ".0";
  const std::string mine = ".a.data.tmp" + std::to_string(::getpid()) + ".0";
  const std::string other = ".a.tmp" + std::to_string(dead) + ".txt", plain = "a.tmp" + std::to_string(dead) + ".0";
  for (const std::string& name : {gone, mine, other, plain}) folder.write(name, "x");
  sweep_temporaries(folder.path());
  EXPECT_FALSE(fs::exists(folder.path() / gone));
  for (const std::string& name : {mine, other, plain}) EXPECT_TRUE(fs::exists(folder.path() / name)) << name;
}

class AReach : public ::testing::Test {
 protected:
  void SetUp() override {
    place.write("cell/cell.yaml", "x");
    place.write("cell/sub/a.points", "x");
    place.write("home/id", "x");
    place.write("cellar/a", "x");
    fs::create_symlink(place.path() / "home", cell() / "link");
    reach.confine();
    grant = reach.open_cell(cell());
  }
  fs::path cell() const { return place.path() / "cell"; }
  bool reads(const fs::path& path) const { return reach.allows(path, resolved(path), Reach::Use::read); }
  bool writes(const fs::path& path) const { return reach.allows(path, resolved(path), Reach::Use::write); }
  Folder place;
  Reach reach;
  std::shared_ptr<ReachGrant> grant;
};

TEST_F(AReach, KeepsToTheCellsFolderLinksIncluded) {
  EXPECT_TRUE(reads(cell() / "sub/a.points"));
  EXPECT_TRUE(writes(cell() / "sub/new.points"));
  EXPECT_TRUE(reads(cell() / "sub/../cell.yaml"));
  EXPECT_FALSE(reads(cell() / "../home/id"));
  EXPECT_FALSE(reads(cell() / "link/id")) << "a link leads out";
  EXPECT_FALSE(writes(cell() / "link/new"));
  EXPECT_FALSE(reads(place.path() / "cellar/a")) << "the same first letters";
  EXPECT_FALSE(reads("/etc/passwd"));
}

TEST_F(AReach, TheUserMayAllowMore) {
  reach.allow(place.path() / "home");
  EXPECT_TRUE(reads(cell() / "link/id"));
  EXPECT_TRUE(writes(place.path() / "home/new"));
  reach.allow_reading(place.path() / "cellar");
  EXPECT_TRUE(reads(place.path() / "cellar/a"));
  EXPECT_FALSE(writes(place.path() / "cellar/a"));
  EXPECT_FALSE(reads(place.path() / "cellar/../other"));
}

TEST_F(AReach, PackagesMayBeMadeOfLinks) {
  place.write("source/arm.urdf", "x");
  fs::create_directories(place.path() / "install");
  fs::create_symlink(place.path() / "source/arm.urdf", place.path() / "install/arm.urdf");
  EXPECT_FALSE(reads(place.path() / "install/arm.urdf"));
  reach.allow_reading(place.path() / "install");
  EXPECT_TRUE(reads(place.path() / "install/arm.urdf")) << "as colcon --symlink-install makes them";
  EXPECT_FALSE(reads(place.path() / "install/../home/id"));
}

TEST_F(AReach, SaysWhatToDo) {
  try {
    reach.check(cell() / "link/id", Reach::Use::read);
    FAIL() << "it was read";
  } catch (const Error& e) {
    const std::string said = e.what();
    for (const std::string& part : {(cell() / "link/id").string(), std::string("--allow "), std::string("links lead")})
      EXPECT_NE(said.find(part), std::string::npos) << said;
  }
  const AsUser user;
  EXPECT_NO_THROW(reach.check("/etc/passwd", Reach::Use::read));
}

TEST_F(AReach, ACellWithinACellReachesBoth) {
  place.write("cell/far/cell.yaml", "x");
  place.write("cell/deep/down/cell.yaml", "x");
  EXPECT_EQ(project_root(cell() / "far"), resolved(cell()));
  EXPECT_EQ(project_root(cell() / "deep/down"), resolved(cell() / "deep/down")) << "deep is not a cell";
}

TEST_F(AReach, HostsBeyondThisMachineHaveToBeAllowed) {
  const auto allowed = [&](const std::string& host) { return reach.host_allowed(host, grant.get()); };
  EXPECT_TRUE(allowed("127.0.0.1"));
  EXPECT_TRUE(allowed("localhost"));
  EXPECT_FALSE(allowed("127.evil.example"));
  EXPECT_FALSE(allowed("10.0.0.5"));
  EXPECT_FALSE(allowed("")) << "a server would listen everywhere";
  reach.allow_host("10.0.0.5");
  EXPECT_TRUE(allowed("10.0.0.5"));
}

TEST_F(AReach, WhatOneCellIsAllowedEndsWithIt) {
  grant->allow(place.path() / "home");
  grant->allow_reading(place.path() / "cellar");
  grant->allow_host("10.0.0.5");
  grant->allow_secret("broker");
  EXPECT_TRUE(writes(place.path() / "home/id"));
  EXPECT_TRUE(reads(place.path() / "cellar/a"));
  place.write("next/cell.yaml", "x");
  grant = reach.open_cell(place.path() / "next");
  EXPECT_TRUE(reads(place.path() / "next/cell.yaml"));
  EXPECT_FALSE(reads(cell() / "cell.yaml")) << "the folder of the cell before";
  EXPECT_FALSE(writes(place.path() / "home/id"));
  EXPECT_FALSE(reads(place.path() / "cellar/a"));
  EXPECT_FALSE(reach.host_allowed("10.0.0.5", grant.get()));
  EXPECT_FALSE(reach.secret_allowed("broker", grant.get()));
}

TEST_F(AReach, BetweenTwoCellsNothingIsOpen) {
  grant = nullptr;
  EXPECT_FALSE(reads(cell() / "cell.yaml"));
  EXPECT_FALSE(reads("/etc/passwd"));
  reach.allow(place.path() / "home");
  EXPECT_TRUE(writes(place.path() / "home/id")) << "the command line's counts always";
}

TEST_F(AReach, TwoCellsThatAreOpenKeepTheirOwnHosts) {
  place.write("next/cell.yaml", "x");
  const auto next = reach.open_cell(place.path() / "next");
  next->allow_host("10.0.0.5");
  EXPECT_FALSE(reach.host_allowed("10.0.0.5", grant.get()));
  EXPECT_TRUE(reach.host_allowed("10.0.0.5", next.get()));
  EXPECT_TRUE(reads(cell() / "cell.yaml"));
  EXPECT_TRUE(reads(place.path() / "next/cell.yaml"));
}

TEST_F(AReach, ACellThatIsOnlyLookedAtOpensNothing) {
  place.write("next/cell.yaml", "x");
  std::shared_ptr<ReachGrant> looked;
  {
    const AsUser user;
    looked = reach.open_cell(place.path() / "next");
  }
  EXPECT_FALSE(reads(place.path() / "next/cell.yaml"));
}

TEST(Sha256, IsThatOfTheStandard) {
  EXPECT_EQ(sha256(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  EXPECT_EQ(sha256("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(sha256("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(sha256(std::string(1'000'000, 'a')),
            "cdc76e5c9914fb9281a1c7e284d73e67f1809a48a497200e046d39ccc7112cd0");
}

TEST(ApprovalList, KeepsWhatWasApprovedForThisUserAlone) {
  const Folder home;
  ::setenv("XDG_CONFIG_HOME", home.path().c_str(), 1);
  const Approval library{"library", std::string(64, 'a'), "/x/arm.so"}, host{"host", "/my/cell", "10.0.0.5"};
  EXPECT_FALSE(is_approved(library));
  approve(library);
  approve(host);
  approve(host);
  EXPECT_EQ(approvals().size(), 2u);
  EXPECT_TRUE(is_approved({"library", std::string(64, 'a'), "/elsewhere"}));
  EXPECT_FALSE(is_approved({"host", "/other/cell", "10.0.0.5"}));
  EXPECT_EQ(fs::status(home.path() / "polyarm/approved").permissions(), fs::perms(0600));
  EXPECT_EQ(code_of([] { approve({"host", "/my/cell", "a\nlibrary\tb"}); }), "bad-name");
  EXPECT_EQ(revoke("aaaaaaaa").size(), 1u);
  EXPECT_EQ(approvals(), std::vector<Approval>{host});
  ::unsetenv("XDG_CONFIG_HOME");
}

/// What the list is refused for; "" where it counts.
std::string refusal_of_list() {
  try {
    is_approved({"library", std::string(64, 'a'), {}});
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "bad-approvals");
    EXPECT_FALSE(e.problems().front().advice.empty());
    return e.what();
  }
  return "";
}

TEST(ApprovalList, ALineWithinRubbishCountsAsLittleAsTheRubbish) {
  const Folder home;
  ::setenv("XDG_CONFIG_HOME", home.path().c_str(), 1);
  const std::string good = "library\t" + std::string(64, 'a') + "\t/x/arm.so\n";
  const auto holds = [&](const std::string& text) { fs::permissions(home.write("polyarm/approved", text), fs::perms(0600)); };
  holds(good);
  EXPECT_EQ(refusal_of_list(), "");
  EXPECT_TRUE(is_approved({"library", std::string(64, 'a'), {}}));
  for (const std::string& rubbish :
       {std::string("\x7f" "ELF\0\1\2\n", 8), std::string("\xff\xfe\n"), std::string("library\tabc\t/x\n"),
        std::string("host\tmy/cell\t10.0.0.5\n"), std::string("host\t/my/cell\t10.0.0.5\t/more\n"),
        std::string("host\t/my/cell\t10.0.0.5\x1b[2J\n"), std::string("anything\t/a\t/b\n"), std::string(" \n"),
        std::string("path\t/my\t/a\0b\n", 14)}) {
    for (const std::string& text : {rubbish + good, good + rubbish}) {
      holds(text);
      EXPECT_NE(refusal_of_list().find("approved:" + std::string(text == rubbish + good ? "1" : "2")), std::string::npos)
          << refusal_of_list();
    }
    EXPECT_EQ(code_of([] { approve({"host", "/my/cell", "b"}); }), "bad-approvals") << "and it is not written over";
  }
  ::unsetenv("XDG_CONFIG_HOME");
}

TEST(ApprovalList, OneThatSomebodyElseCouldHaveWrittenIsNotUsed) {
  const Folder home;
  ::setenv("XDG_CONFIG_HOME", home.path().c_str(), 1);
  const std::string good = "library\t" + std::string(64, 'a') + "\t/x/arm.so\n";
  const fs::path list = home.write("polyarm/approved", good);
  for (const unsigned mode : {0620u, 0602u, 0666u}) {
    fs::permissions(list, fs::perms(mode));
    EXPECT_NE(refusal_of_list().find("other users may write to it"), std::string::npos) << mode;
  }
  fs::permissions(list, fs::perms(0600));
  EXPECT_EQ(refusal_of_list(), "");
  fs::rename(list, home.path() / "theirs");
  fs::create_symlink(home.path() / "theirs", list);
  EXPECT_NE(refusal_of_list().find("it is a link"), std::string::npos);
  fs::remove(list);
  fs::create_directory(list);
  EXPECT_NE(refusal_of_list().find("not an ordinary file"), std::string::npos);
  fs::remove(list);
  EXPECT_EQ(refusal_of_list(), "");
  if (::geteuid() == 0) {
    const fs::path other = home.write("polyarm/approved", good);
    fs::permissions(other, fs::perms(0600));
    ASSERT_EQ(::chown(other.c_str(), 12345, 0), 0);
    EXPECT_NE(refusal_of_list().find("belongs to another user"), std::string::npos);
  }
  ::unsetenv("XDG_CONFIG_HOME");
}

TEST(ApprovalList, AFolderForDevelopmentIsNobodyElses) {
  const Folder home;
  EXPECT_EQ(unfit_for_development(home.path() / "build"), "") << "it need not be there yet";
  EXPECT_NE(unfit_for_development("/tmp"), "");
  fs::permissions(home.path(), fs::perms::all);
  EXPECT_NE(unfit_for_development(home.path() / "build"), "");
}

TEST(Secrets, AreKnownByNameContentAndUse) {
  const Folder folder;
  for (const char* name : {"cell.key", "broker.password", "password.txt", "plc_secret", "id_ed25519"})
    EXPECT_TRUE(is_secret(folder.write(name, "x"))) << name;
  for (const char* name : {"cell.yaml", "keys.script", "secretary.points", "tokens.data"})
    EXPECT_FALSE(is_secret(folder.write(name, "x"))) << name;
  EXPECT_TRUE(is_secret(folder.write("both.pem", "a\n-----BEGIN EC PRIVATE KEY-----\n")));
  const fs::path plain = folder.write("plain.txt", "x");
  EXPECT_FALSE(is_secret(plain));
  mark_secret(plain);
  EXPECT_TRUE(is_secret(folder.path() / "." / "plain.txt"));
}

TEST(Secrets, AreLeftOutOfTexts) {
  EXPECT_EQ(without_secrets("user: me\npassword: hunter2\nhost: a\n"),
            "user: me\npassword: (left out)\nhost: a\n");
  EXPECT_EQ(without_secrets("{token: abc, x: 1}"), "{token: (left out), x: 1}");
  EXPECT_EQ(without_secrets("<param name=\"password\">hunter2</param>"),
            "<param name=\"password\">(left out)</param>");
  EXPECT_EQ(without_secrets("http://localhost:1/?token=abc"), "http://localhost:1/?token=(left out)");
  const std::string plain = "password_file: secret:broker\ntokens: 3\nno password here\n";
  EXPECT_EQ(without_secrets(plain), plain);
}

TEST(Secrets, ComeFromAPlaceOfTheUser) {
  const Folder home;
  ::setenv("XDG_CONFIG_HOME", home.path().c_str(), 1);
  EXPECT_EQ(code_of([] { secret_file("../approved"); }), "bad-secret");
  EXPECT_EQ(code_of([] { secret_file("broker"); }), "bad-secret");
  const fs::path file = home.write("polyarm/secrets/broker", "hunter2\n");
  fs::permissions(file, fs::perms(0644));
  EXPECT_EQ(code_of([] { secret_file("broker"); }), "bad-secret") << "others may read it";
  fs::permissions(file, fs::perms(0600));
  EXPECT_EQ(secret_file("broker"), file);
  ::unsetenv("XDG_CONFIG_HOME");
}

}  // namespace
}  // namespace polyarm
