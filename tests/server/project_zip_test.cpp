#include "polyarm/server/project_zip.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <map>
#include <random>

#include "polyarm/base/error.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/io/free_space.hpp"
#include "tests/support/lock_step_cell.hpp"

namespace polyarm::server {
namespace {

namespace fs = std::filesystem;

class ProjectZipTest : public ::testing::Test {
 protected:
  void SetUp() override {
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
  for (const auto& [name, text] : std::map<std::string, std::string>{{"arm.so", "x"},
                                                                     {"libarm.so.1", "x"},
                                                                     {"ARM.DLL", "x"},
                                                                     {"points.points",
                                                                      "\x7f"
                                                                      "ELF and more"}}) {
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

TEST_F(ProjectZipTest, NamesThatLookLikeOthersAreNoneOfAProject) {
  const std::string zip = zip_of(project());
  for (const std::string name : {"sub/a\nok: done", "sub/\xe2\x80\xaetpircs"}) {
    std::string bad = zip, as = name;
    as.resize(std::string("sub/a.script").size(), 'x');
    for (std::size_t at = bad.find("sub/a.script"); at != std::string::npos;
         at = bad.find("sub/a.script", at))
      bad.replace(at, as.size(), as);
    EXPECT_EQ(code(bad, folder.path() / "out"), "bad-zip");
    EXPECT_FALSE(fs::exists(folder.path() / "out"));
  }
}

TEST_F(ProjectZipTest, ANameThatIsAFileAndAFolderIsNamed) {
  write_file_atomically(project() / "f.txt", "a file");
  std::string zip = zip_of(project());
  const std::string is = "sub/a.script", as = "f.txt/script";
  for (std::size_t at = zip.find(is); at != std::string::npos; at = zip.find(is, at))
    zip.replace(at, as.size(), as);
  try {
    unzip_into(zip, folder.path() / "out");
    FAIL() << "f.txt is both";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "bad-zip");
    EXPECT_NE(std::string(e.what()).find("f.txt"), std::string::npos) << e.what();
    EXPECT_EQ(std::string(e.what()).find("threw"), std::string::npos) << e.what();
  }
  EXPECT_FALSE(fs::exists(folder.path() / "out"));
}

TEST_F(ProjectZipTest, AFileWithTheNameOfAFolderBeforeItIsNamedWithoutAPathOfThisMachine) {
  write_file_atomically(project() / "zzz", "a file");
  std::string zip = zip_of(project());
  for (std::size_t at = zip.find("zzz"); at != std::string::npos; at = zip.find("zzz", at))
    zip.replace(at, 3, "sub");
  try {
    unzip_into(zip, folder.path() / "out");
    FAIL() << "sub is both";
  } catch (const Error& e) {
    EXPECT_EQ(e.problems().front().code, "bad-zip");
    EXPECT_NE(std::string(e.what()).find("'sub'"), std::string::npos) << e.what();
    EXPECT_EQ(std::string(e.what()).find(folder.path().string()), std::string::npos) << e.what();
  }
  EXPECT_FALSE(fs::exists(folder.path() / "out"));
}

TEST_F(ProjectZipTest, OnlyWhatZlibUnpacksIsUnpacked) {
  std::string zip = zip_of(project());
  // The central directory and the file itself say bzip2, which another library would unpack.
  for (const auto& [mark, at] : {std::pair{std::string("PK\1\2"), 10}, {std::string("PK\3\4"), 8}})
    for (std::size_t found = 0; (found = zip.find(mark, found)) != std::string::npos; found += 4)
      if (zip[found + static_cast<std::size_t>(at)] == 8) zip[found + static_cast<std::size_t>(at)] = 12;
  try {
    unzip_into(zip, folder.path() / "back");
    FAIL() << "it was unpacked";
  } catch (const Error& e) {
    EXPECT_NE(std::string(e.what()).find("by Deflate"), std::string::npos) << e.what();
  }
  EXPECT_FALSE(fs::exists(folder.path() / "back"));
}

TEST_F(ProjectZipTest, AFileThatStandsTwiceIsRefused) {
  write_file_atomically(project() / "sub" / "b.script", "x");
  std::string zip = zip_of(project());
  for (std::size_t at = 0; (at = zip.find("sub/b.script", at)) != std::string::npos;)
    zip.replace(at, 12, "sub/a.script");
  EXPECT_EQ(code(zip, folder.path() / "out"), "bad-zip");
  EXPECT_FALSE(fs::exists(folder.path() / "out"));
}

/// The kind of a file stands in the upper half of its attributes, 8 bytes before the name in the list of all.
TEST_F(ProjectZipTest, LinksAndDevicesAreNoneOfAProject) {
  const std::string zip = zip_of(project());
  const std::size_t name = zip.rfind("sub/a.script"), entry = zip.rfind("PK\x01\x02", name);
  ASSERT_EQ(name, entry + 46);
  for (const auto& [kind, expected] : std::map<int, std::string>{
           {0120777, "bad-zip"}, {0020644, "bad-zip"}, {0010644, "bad-zip"}, {0100644, "ok"}}) {
    std::string made = zip;
    made[entry + 5] = 3;  // made on UNIX
    made[entry + 40] = static_cast<char>(kind & 0xff);
    made[entry + 41] = static_cast<char>(kind >> 8);
    EXPECT_EQ(code(made, folder.path() / "out"), expected) << kind;
    fs::remove_all(folder.path() / "out");
  }
}

TEST_F(ProjectZipTest, AListOfTooManyFilesIsNotEvenRead) {
  const auto why = [&](const std::string& zip) -> std::string {
    try {
      unzip_into(zip, folder.path() / "out");
      return "taken";
    } catch (const Error& e) {
      return e.what();
    }
  };
  std::string zip = zip_of(project());
  const std::size_t end = zip.rfind("PK\5\6");
  std::string many = zip, large = zip;
  many.replace(end + 8, 4, "\x89\x13\x89\x13");  // 5001
  EXPECT_NE(why(many).find("too many files"), std::string::npos) << why(many);
  large.insert(end, "PK\6\7" + std::string(16, '\0'));
  EXPECT_NE(why(large).find("too many files"), std::string::npos) << why(large);
  EXPECT_EQ(why(zip), "taken");
}

TEST(ProjectPlace, IsBesideTheCellHoweverItsFolderIsSpelled) {
  const test::Folder folder;
  const fs::path top = fs::canonical(folder.path());
  fs::create_directories(top / "cell");
  for (const char* spelling : {"cell", "cell/", "cell/.", "./cell/../cell/"})
    EXPECT_EQ(place_beside(folder.path() / spelling, "new"), top / "new") << spelling;
  const fs::path before = fs::current_path();
  fs::current_path(top / "cell");
  EXPECT_EQ(place_beside(".", "new"), top / "new");
  fs::current_path(before);
  for (std::size_t n = 0; n < bounds::kProjects; ++n) fs::create_directory(top / std::to_string(n));
  EXPECT_THROW(place_beside(top / "cell", "new"), Error);
}

TEST(FreeSpace, IsLeftByUploads) {
  const test::Folder folder;
  EXPECT_NO_THROW(cell::require_free_space(folder.path(), 1, 0));
  EXPECT_THROW(cell::require_free_space(folder.path(), 1, std::uintmax_t{1} << 60), Error);
  EXPECT_THROW(cell::require_free_space(folder.path(), ~std::uintmax_t{0}, 1), Error);
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
