#include "polyarm/server/project_zip.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <random>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::server {
namespace {

namespace fs = std::filesystem;

class ProjectZipTest : public ::testing::Test {
 protected:
  void SetUp() override {
    if (!can_zip()) GTEST_SKIP() << "built without libzip";
    fs::create_directories(project() / "sub");
    fs::create_directories(project() / ".state");
    write_file_atomically(project() / "cell.yaml", "polyarm: cell/1\n");
    write_file_atomically(project() / "sub" / "a.script", std::string(100'000, 'x'));
    write_file_atomically(project() / ".state" / "hidden", "no");
    fs::create_symlink("/etc/passwd", project() / "link.txt");
  }
  fs::path project() const { return folder.path() / "project"; }
  std::string code(std::string_view zip, const fs::path& into) {
    try {
      unzip_into(zip, into);
      return "ok";
    } catch (const Error& e) {
      return e.problems().front().code;
    }
  }
  test::Folder folder;
};

TEST_F(ProjectZipTest, AProjectComesBackAsItWasWithoutWhatIsHidden) {
  const std::string zip = zip_of(project());
  EXPECT_LT(zip.size(), 10'000u) << "it is compressed";
  const fs::path back = folder.path() / "back";
  unzip_into(zip, back);
  EXPECT_EQ(read_file(back / "cell.yaml"), "polyarm: cell/1\n");
  EXPECT_EQ(read_file(back / "sub" / "a.script"), std::string(100'000, 'x'));
  EXPECT_FALSE(fs::exists(back / ".state"));
  EXPECT_FALSE(fs::exists(back / "link.txt"));
  EXPECT_EQ(code(zip, back), "exists");
}

TEST_F(ProjectZipTest, SecretsStayWhereTheyAre) {
  write_file_atomically(project() / "broker.password", "hunter2\n");
  write_file_atomically(project() / "cell.pem", "-----BEGIN PRIVATE KEY-----\nabc\n");
  write_file_atomically(project() / "ca.pem", "-----BEGIN CERTIFICATE-----\nabc\n");
  const fs::path back = folder.path() / "back";
  unzip_into(zip_of(project()), back);
  EXPECT_FALSE(fs::exists(back / "broker.password"));
  EXPECT_FALSE(fs::exists(back / "cell.pem"));
  EXPECT_TRUE(fs::exists(back / "ca.pem"));
}

TEST_F(ProjectZipTest, NoNativeCodeComesOutOfAZip) {
  for (const auto& [name, text] : std::map<std::string, std::string>{
           {"arm.so", "x"}, {"libarm.so.1", "x"}, {"ARM.DLL", "x"}, {"points.points", "\x7f" "ELF and more"}}) {
    write_file_atomically(project() / name, text);
    EXPECT_EQ(code(zip_of(project()), folder.path() / "back"), "native-code") << name;
    EXPECT_FALSE(fs::exists(folder.path() / "back")) << name;
    fs::remove(project() / name);
  }
}

TEST_F(ProjectZipTest, NoNameLeadsOutOfTheFolder) {
  std::string zip = zip_of(project());
  for (const std::string name :
       {"../a.script", "/tmp/a.scri", "sub/../../x", ".hid/a.scri", "sub\\..\\a.scr"}) {
    std::string bad = zip, as = name;
    as.resize(std::string("sub/a.script").size(), 'x');
    for (std::size_t at = bad.find("sub/a.script"); at != std::string::npos;
         at = bad.find("sub/a.script", at + 1))
      bad.replace(at, as.size(), as);
    EXPECT_EQ(code(bad, folder.path() / "out"), "bad-zip") << as;
    EXPECT_FALSE(fs::exists(folder.path() / "out"));
  }
  EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
}

TEST_F(ProjectZipTest, WhatIsDamagedLeavesNothing) {
  const std::string zip = zip_of(project());
  std::mt19937 random(9);
  for (int n = 0; n < 500; ++n) {
    std::string bad = zip;
    for (unsigned i = 1 + random() % 8; i > 0; --i) bad[random() % bad.size()] = static_cast<char>(random());
    if (n % 3 == 0) bad.resize(random() % bad.size());
    const fs::path into = folder.path() / "out";
    code(bad, into);
    fs::remove_all(into);
    EXPECT_EQ(std::distance(fs::directory_iterator(folder.path()), fs::directory_iterator()), 1);
  }
}

}  // namespace
}  // namespace polyarm::server
