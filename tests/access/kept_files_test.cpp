/// The token and the certificate of a user are created once, also by several processes at the same time.
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <set>
#include <thread>
#include <vector>

#include "polyarm/access/tls.hpp"
#include "polyarm/access/token.hpp"
#include "polyarm/base/error.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::server {
namespace {

template <typename Make>
std::set<std::string> made_at_once(const Make& make) {
  std::vector<std::string> all(8);
  std::vector<std::thread> threads;
  for (std::string& each : all)
    threads.emplace_back([&each, &make] {
      try {
        each = make();
      } catch (const std::exception& e) {
        each = e.what();
      }
    });
  for (std::thread& each : threads) each.join();
  return {all.begin(), all.end()};
}

TEST(KeptFiles, CellsThatBeginAtOnceShareOneToken) {
  for (int round = 0; round < 10; ++round) {
    const test::Folder folder;
    const auto made = made_at_once([&] { return kept_token(folder.path() / "token"); });
    ASSERT_EQ(made.size(), 1u) << *made.begin() << ", " << *made.rbegin();
    EXPECT_EQ(*made.begin(), kept_token(folder.path() / "token"));
  }
}

TEST(KeptFiles, CellsThatBeginAtOnceShareOneCertificate) {
  for (int round = 0; round < 10; ++round) {
    const test::Folder folder;
    const auto made = made_at_once([&] { return kept_certificate(folder.path(), "press").fingerprint; });
    ASSERT_EQ(made.size(), 1u) << *made.begin() << ", " << *made.rbegin();
    EXPECT_EQ(*made.begin(), kept_certificate(folder.path(), "press").fingerprint);
  }
}

TEST(KeptFiles, ATokenThatIsAPipeIsReplaced) {
  const test::Folder folder;
  const std::string file = (folder.path() / "token").string();
  ASSERT_EQ(::mkfifo(file.c_str(), 0600), 0);
  EXPECT_EQ(kept_token(file), kept_token(file));
}

}  // namespace
}  // namespace polyarm::server
