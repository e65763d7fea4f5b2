/// Log-ins: passwords, wrong ones from near and far, roles, and how log-ins end.
#include "polyarm/access/logins.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "polyarm/access/gate.hpp"
#include "polyarm/base/error.hpp"
#include "polyarm/users/password.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::server {
namespace {

using protocol::Role;

/// Too long to be a password, so that its check takes no time.
const std::string kWrong(users::kMostPassword + 1, 'x');

/// One hash for all tests: making one takes long.
const std::string& hash() {
  static const std::string made = users::hash_of("right password");
  return made;
}

void add_users(const std::filesystem::path& file) {
  users::change_users(file, [](users::UserList& list) {
    list.add({"vera", Role::watch, hash()});
    list.add({"otto", Role::operate, hash()});
    list.add({"petra", Role::program, hash()});
    list.add({"ada", Role::administer, hash()});
  });
}

TEST(Logins, AreRefusedWithoutUsersAndWithAWrongPassword) {
  const test::Folder folder;
  Logins logins(folder.path() / "users");
  EXPECT_FALSE(logins.offered(0));
  EXPECT_EQ(logins.log_in("otto", "right password", "a", 0).why, "no-users");
  add_users(folder.path() / "users");
  EXPECT_TRUE(logins.offered(2));
  EXPECT_EQ(logins.log_in("otto", "wrong password", "a", 2).why, "wrong-password");
  EXPECT_EQ(logins.log_in("nobody", "right password", "a", 2).why, "wrong-password");
  const auto good = logins.log_in("otto", "right password", "a", 2);
  ASSERT_TRUE(good.login);
  EXPECT_EQ(logins.find(good.token, 3)->user, "otto");
  EXPECT_FALSE(logins.find(good.token + "x", 3));
  EXPECT_FALSE(logins.find("", 3));
}

TEST(Logins, WrongPasswordsWaitLongerAndLongerAndTheRightOneToo) {
  const test::Folder folder;
  add_users(folder.path() / "users");
  Logins logins(folder.path() / "users");
  double now = 100, waited = 0;
  int tried = 0;
  for (int n = 0; n < 40; ++n) {
    const auto result = logins.log_in("otto", "wrong " + std::to_string(n), "a", now);
    if (result.why == "wrong-password") ++tried;
    EXPECT_LE(result.wait_s, Logins::kLongestWait_s);
    waited = std::max(waited, result.wait_s);
    now += 1;
  }
  EXPECT_LE(tried, 10) << "of 40 in 40 s";
  EXPECT_GT(waited, 10);
  EXPECT_EQ(logins.log_in("otto", "right password", "a", now).why, "too-fast");
  EXPECT_TRUE(logins.log_in("ada", "right password", "a", now).login) << "another user there";
  EXPECT_TRUE(logins.log_in("otto", "right password", "a", now + Logins::kLongestWait_s).login);
}

TEST(Logins, NobodyElsewhereLocksAUserOut) {
  const test::Folder folder;
  add_users(folder.path() / "users");
  Logins logins(folder.path() / "users");
  for (int n = 0; n < 12; ++n) logins.log_in("otto", kWrong, "10.0.0.66", 100 + n);
  EXPECT_TRUE(logins.log_in("otto", "right password", "10.0.0.5", 112).login);
  // An attacker with very many addresses meets the bound of the name; an address of the user does not.
  int tried = 0;
  for (int n = 0; n < 150; ++n)
    tried += logins.log_in("otto", kWrong, "10.1.0." + std::to_string(n), 113).why == "wrong-password";
  EXPECT_LE(tried, Logins::kFreeOfName);
  EXPECT_EQ(logins.log_in("otto", "right password", "10.2.0.1", 114).why, "too-fast");
  EXPECT_TRUE(logins.log_in("otto", "right password", "10.0.0.5", 114).login);
  EXPECT_TRUE(logins.log_in("otto", "right password", "10.2.0.1", 114 + 2 * Logins::kForgetEvery_s).login);
}

TEST(Logins, GuessesForManyNamesFromOneAddressAreBoundedAndAnOwnLogInDoesNotFreeThem) {
  const test::Folder folder;
  add_users(folder.path() / "users");
  Logins logins(folder.path() / "users");
  int tried = 0;
  for (int n = 0; n < 100; ++n) {
    const std::string name = "user" + std::to_string(n);
    tried += logins.log_in(name, kWrong, "2001:db8::" + std::to_string(n), 100).why == "wrong-password";
    if (n == 10) {
      EXPECT_TRUE(logins.log_in("vera", "right password", "2001:db8::7", 100).login);
    }
  }
  EXPECT_LE(tried, Logins::kFreeOfAddress + 1) << "one network";
}

TEST(Logins, TriesAreForgottenFirstForAddressesWhereNobodyLoggedIn) {
  const test::Folder folder;
  add_users(folder.path() / "users");
  Logins logins(folder.path() / "users");
  ASSERT_TRUE(logins.log_in("otto", "right password", "10.0.0.5", 1).login);
  for (std::size_t n = 0; n < Logins::kMostTracked; ++n)
    logins.log_in("n" + std::to_string(n), kWrong,
                  "10.9." + std::to_string(n / 250) + "." + std::to_string(n % 250), 10);
  for (int n = 0; n < 150; ++n) logins.log_in("otto", kWrong, "10.1.0." + std::to_string(n), 20);
  EXPECT_EQ(logins.log_in("otto", "right password", "10.2.0.1", 21).why, "too-fast");
  EXPECT_TRUE(logins.log_in("otto", "right password", "10.0.0.5", 21).login);
}

TEST(Logins, InventedNamesDoNotMakeGuessesFree) {
  const test::Folder folder;
  add_users(folder.path() / "users");
  Logins logins(folder.path() / "users");
  const auto guess = [&](const std::string& name, int n) {
    const std::string from = "10." + std::to_string(n / 65536) + "." + std::to_string(n / 256 % 256) + "." +
                             std::to_string(n % 256);
    return logins.log_in(name, kWrong, from, 5).why;
  };
  int n = 0;
  while (n < 200) guess("otto", n++);
  for (std::size_t i = 0; i < 2 * Logins::kMostTracked; ++i) guess("invented" + std::to_string(i), n++);
  EXPECT_EQ(guess("otto", n), "too-fast");
}

TEST(Logins, SayWhyTheyEndedToTheirOwnTokenOnly) {
  const test::Folder folder;
  add_users(folder.path() / "users");
  Logins logins(folder.path() / "users", 2 * 3600);
  const auto old = logins.log_in("otto", "right password", "a", 0);
  const auto idle = logins.log_in("vera", "right password", "b", 0);
  for (double t = 0; t <= 2 * 3600; t += 600) {
    ASSERT_TRUE(logins.find(old.token, t)) << "a page renews it";
    logins.tick(t);
  }
  EXPECT_EQ(logins.why_ended(old.token, 2 * 3600), "");
  EXPECT_EQ(logins.why_ended(old.token, 2 * 3600 + 1), "time") << "before the next tick, too";
  logins.tick(2 * 3600 + 1);
  EXPECT_TRUE(old.login->over) << "and it ends nevertheless";
  EXPECT_EQ(logins.why_ended(old.token, 2 * 3600 + 1), "time");
  EXPECT_EQ(logins.why_ended(idle.token, 2 * 3600 + 1), "idle");
  EXPECT_EQ(logins.why_ended("guess", 2 * 3600 + 1), "");
}

TEST(Networks, LeaveOutWhatAClientChoosesFreely) {
  EXPECT_EQ(network_of("10.0.0.5"), "10.0.0.5");
  EXPECT_EQ(network_of("::ffff:10.0.0.5"), "10.0.0.5");
  EXPECT_EQ(network_of("2001:db8::1"), network_of("2001:db8::2:3"));
  EXPECT_NE(network_of("2001:db8:0:1::1"), network_of("2001:db8::1"));
  EXPECT_EQ(network_of("fe80::1%eth0"), network_of("fe80::2"));
  EXPECT_EQ(network_of("not an address"), "not an address");
}

TEST(Logins, EndByTimeByLogOutAndWhenTheUserIsChanged) {
  const test::Folder folder;
  const auto file = folder.path() / "users";
  add_users(file);
  Logins logins(file);
  const auto log_in = [&](const std::string& name, double now) {
    return logins.log_in(name, "right password", name, now);
  };
  const auto idle = log_in("otto", 0);
  EXPECT_TRUE(logins.find(idle.token, Logins::kIdle_s - 1));
  EXPECT_TRUE(logins.find(idle.token, 2 * Logins::kIdle_s - 2)) << "it was used";
  EXPECT_FALSE(logins.find(idle.token, 4 * Logins::kIdle_s));
  logins.tick(4 * Logins::kIdle_s);
  EXPECT_TRUE(idle.login->over);
  double now = 100'000;
  const auto old = log_in("otto", now);
  for (double t = 0; t < Logins::kLongest_s; t += 1000) EXPECT_TRUE(logins.find(old.token, now + t));
  EXPECT_FALSE(logins.find(old.token, now + Logins::kLongest_s + 1));
  now = 200'000;
  const auto out = log_in("otto", now), removed = log_in("vera", now), changed = log_in("petra", now),
             kept = log_in("ada", now);
  logins.log_out(out.token);
  EXPECT_FALSE(logins.find(out.token, now));
  users::change_users(file, [](users::UserList& list) {
    list.remove("vera");
    list.at("petra").role = Role::watch;
  });
  logins.tick(now + 2);
  EXPECT_TRUE(removed.login->over);
  EXPECT_TRUE(changed.login->over);
  EXPECT_FALSE(kept.login->over);
  std::filesystem::permissions(file, std::filesystem::perms::others_read, std::filesystem::perm_options::add);
  logins.tick(now + 4);
  EXPECT_TRUE(kept.login->over) << "rights that cannot be checked are not kept";
}

TEST(Logins, HaveABoundForEachUser) {
  const test::Folder folder;
  add_users(folder.path() / "users");
  Logins logins(folder.path() / "users");
  const auto first = logins.log_in("otto", "right password", "a", 1);
  for (std::size_t n = 0; n < Logins::kMostLoginsOfOne; ++n)
    ASSERT_TRUE(logins.log_in("otto", "right password", "a", 2 + static_cast<double>(n)).login);
  EXPECT_EQ(logins.count(), Logins::kMostLoginsOfOne);
  EXPECT_TRUE(first.login->over) << "the oldest makes room";
}

TEST(Credentials, AreReadFromBasicOnly) {
  EXPECT_EQ(basic_credentials("Basic b3R0bzphOmI=")->first, "otto");
  EXPECT_EQ(basic_credentials("basic b3R0bzphOmI=")->second, "a:b");
  for (const char* wrong : {"", "Basic", "Basic ", "Basic !!!!", "Basic b3R0",
                            "Bearer b3R0bzphOmI=", "Basic b3R0bzphOmI", "Basic OmE="})
    EXPECT_FALSE(basic_credentials(wrong)) << wrong;
  EXPECT_FALSE(basic_credentials("Basic " + std::string(4000, 'a')));
}

}  // namespace
}  // namespace polyarm::server
