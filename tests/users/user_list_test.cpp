#include "polyarm/users/user_list.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <thread>

#include "polyarm/base/error.hpp"
#include "tests/support/damaged.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::users {
namespace {

using protocol::Role;

const std::string kHash = "$y$j9T$abcdefgh$ABCDEFGHIJKLMNOP";

std::string code_of(const std::function<void()>& work) {
  try {
    work();
  } catch (const Error& e) {
    return e.problems().front().code;
  }
  return "none";
}

TEST(UserList, IsReadAsItWasWritten) {
  const test::Folder folder;
  const auto file = folder.path() / "own" / "users";
  change_users(file, [](UserList& list) {
    list.add({"anna", Role::operate, kHash});
    list.add({"Bob.2", Role::watch, kHash});
  });
  change_users(file, [](UserList& list) { list.at("anna").role = Role::administer; });
  const UserList read = read_users(file);
  ASSERT_EQ(read.all().size(), 2u);
  EXPECT_EQ(read.find("anna")->role, Role::administer);
  EXPECT_EQ(read.find("Bob.2")->role, Role::watch);
  EXPECT_EQ(read.find("Bob.2")->hash, kHash);
  EXPECT_NE(read.text().find("Bob.2 watch "), std::string::npos)
      << "the role has its one name: " << read.text();
  EXPECT_EQ(parse_users(read.text()).text(), read.text());
  struct stat status {};
  ASSERT_EQ(::stat(file.c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
}

TEST(UserList, AListThatOthersMayReadIsRefused) {
  const test::Folder folder;
  const auto file = folder.path() / "users";
  change_users(file, [](UserList& list) { list.add({"anna", Role::operate, kHash}); });
  ::chmod(file.c_str(), 0640);
  EXPECT_EQ(code_of([&] { read_users(file); }), "bad-users");
  ::chmod(file.c_str(), 0600);
  EXPECT_EQ(code_of([&] { read_users(file); }), "none");
  std::filesystem::rename(file, folder.path() / "other");
  std::filesystem::create_symlink(folder.path() / "other", file);
  EXPECT_EQ(code_of([&] { read_users(file); }), "bad-users") << "a link may lead anywhere";
}

TEST(UserList, AMissingFileIsAnEmptyList) {
  const test::Folder folder;
  EXPECT_TRUE(read_users(folder.path() / "users").all().empty());
}

TEST(UserList, WrongNamesRolesAndLinesAreRefused) {
  UserList list;
  for (const char* name : {"", "1a", "a b", "a:b", "../a", "ä", "a\n"})
    EXPECT_EQ(code_of([&] { list.add({name, Role::watch, kHash}); }), "bad-user") << name;
  EXPECT_EQ(code_of([&] { list.add({std::string(kMostName + 1, 'a'), Role::watch, kHash}); }), "bad-user");
  list.add({"anna", Role::watch, kHash});
  EXPECT_EQ(code_of([&] { list.add({"anna", Role::watch, kHash}); }), "bad-user") << "twice";
  EXPECT_EQ(code_of([&] { list.remove("ana"); }), "unknown-user");
  EXPECT_EQ(code_of([] { role_of_word("root"); }), "bad-role");
  for (const char* text :
       {"users\n", "polyarm users 2\n", "polyarm users 1\nanna operate\n",
        "polyarm users 1\nanna boss $y$j9T$a$b\n", "polyarm users 1\nanna operate plainpassword\n"})
    EXPECT_EQ(code_of([&] { parse_users(text); }), "bad-users") << text;
}

TEST(UserList, AddsFromManyThreadsAreAllKept) {
  const test::Folder folder;
  const auto file = folder.path() / "users";
  std::vector<std::thread> threads;
  for (int n = 0; n < 8; ++n)
    threads.emplace_back([&file, n] {
      for (int i = 0; i < 5; ++i)
        change_users(file, [&](UserList& list) {
          list.add({"u" + std::to_string(n) + "." + std::to_string(i), Role::watch, kHash});
        });
    });
  for (std::thread& each : threads) each.join();
  EXPECT_EQ(read_users(file).all().size(), 40u);
}

TEST(UserList, AnyTextIsReadOrRefused) {
  UserList list;
  for (int i = 0; i < 5; ++i) list.add({"user" + std::to_string(i), Role::operate, kHash});
  std::mt19937 random(5);
  for (int n = 0; n < 20'000; ++n) {
    const std::string text = test::damaged(
        list.text(), {"\n", " ", "$", "anna operate ", std::string("\0", 1), "\xff"}, 30, random);
    try {
      const UserList read = parse_users(text);
      for (const User& user : read.all()) require_good_name(user.name);
    } catch (const Error& e) {
      EXPECT_EQ(e.problems().front().code, "bad-users");
    }
  }
}

}  // namespace
}  // namespace polyarm::users
