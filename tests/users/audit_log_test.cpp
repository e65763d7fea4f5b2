#include "polyarm/users/audit_log.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <fstream>
#include <map>
#include <nlohmann/json.hpp>

#include "polyarm/protocol/jog.hpp"
#include "polyarm/protocol/messages.hpp"
#include "polyarm/protocol/motion.hpp"
#include "polyarm/protocol/session.hpp"
#include "tests/support/folder.hpp"

namespace polyarm::users {
namespace {

using Json = nlohmann::json;

std::vector<Json> entries(const std::filesystem::path& folder) {
  std::vector<Json> out;
  read_audit(folder, [&](const std::string& line) { out.push_back(Json::parse(line)); });
  return out;
}

AuditEntry entry(const std::string& request, const std::string& who = "anna") {
  AuditEntry out;
  out.cell = "test";
  out.actor = {who, "operate", "127.0.0.1", "pendant", ""};
  out.request = request;
  out.outcome = "done";
  return out;
}

TEST(AuditLog, KeepsWhoDidWhatAndWhen) {
  const test::Folder folder;
  {
    AuditLog log(folder.path() / "audit");
    AuditEntry first = entry("control.override");
    first.arguments = R"({"percent":50})";
    log.add(first);
    AuditEntry second = entry("program.start");
    second.outcome = "no-control";
    second.what = "nobody has control";
    log.add(second);
  }
  const auto read = entries(folder.path() / "audit");
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0]["who"], "anna");
  EXPECT_EQ(read[0]["request"], "control.override");
  EXPECT_EQ(read[0]["arguments"]["percent"], 50);
  EXPECT_EQ(read[0]["outcome"], "done");
  EXPECT_EQ(read[0]["time"].get<std::string>().size(), 24u);
  EXPECT_EQ(read[1]["outcome"], "no-control");
  struct stat status {};
  ASSERT_EQ(::stat((folder.path() / "audit" / "audit.jsonl").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0600u);
}

TEST(AuditLog, EqualEntriesBecomeOneLineWithACountAndNoneIsLost) {
  const test::Folder folder;
  {
    AuditLog log(folder.path() / "audit");
    for (int i = 0; i < 1000; ++i) log.add(entry("control.stop"));
    log.add(entry("control.stop", "bob"));
  }
  std::uint64_t anna = 0, bob = 0;
  const auto read = entries(folder.path() / "audit");
  for (const Json& each : read) (each["who"] == "anna" ? anna : bob) += each.value("times", std::uint64_t{1});
  EXPECT_EQ(anna, 1000u);
  EXPECT_EQ(bob, 1u);
  EXPECT_LT(read.size(), 500u);
}

TEST(AuditLog, StreamsOfSeveralClientsDoNotFillTheFiles) {
  const test::Folder folder;
  {
    AuditLog log(folder.path() / "audit");
    for (int i = 0; i < 1000; ++i)
      for (const char* who : {"anna", "bob", "carl"}) log.add(entry("target", who));
  }
  std::map<std::string, std::uint64_t> times;
  const auto read = entries(folder.path() / "audit");
  for (const Json& each : read) times[each["who"]] += each.value("times", std::uint64_t{1});
  EXPECT_EQ(times, (std::map<std::string, std::uint64_t>{{"anna", 1000}, {"bob", 1000}, {"carl", 1000}}));
  EXPECT_LT(read.size(), 500u);
}

TEST(AuditLog, AFloodOfRefusalsIsCountedAndDoesNotPushOutWhatWasDone) {
  const test::Folder folder;
  constexpr std::size_t kFlood = 3000;
  {
    AuditLog log(folder.path() / "audit");
    log.add(entry("program.start"));
    for (std::size_t i = 0; i < kFlood; ++i) {
      AuditEntry refused = entry(i % 2 == 0 ? "tags.set" : "tags.force", "a link");
      refused.outcome = "no-role";
      log.add(refused);
    }
    log.add(entry("program.stop"));
  }
  std::size_t lines = 0, refused = 0, lost = 0, done = 0;
  for (const Json& each : entries(folder.path() / "audit")) {
    ++lines;
    if (each["outcome"] == "lost") lost += std::stoul(each["what"].get<std::string>());
    if (each["outcome"] == "no-role") refused += each.value("times", std::size_t{1});
    if (each["outcome"] == "done") ++done;
  }
  EXPECT_EQ(done, 2u);
  EXPECT_LT(lines, kFlood / 4) << "equal ones are one line";
  EXPECT_EQ(refused + lost, kFlood);
}

TEST(AuditLog, RotatesAndKeepsABoundedNumberOfFiles) {
  const test::Folder folder;
  {
    AuditLog log(folder.path() / "audit", 2000, 3);
    for (int i = 0; i < 200; ++i) log.add(entry("tags.set", "user" + std::to_string(i)));
    log.flush();
  }
  std::size_t bytes = 0, files = 0;
  for (const auto& each : std::filesystem::directory_iterator(folder.path() / "audit"))
    if (each.path().extension() == ".jsonl") ++files, bytes += std::filesystem::file_size(each.path());
  EXPECT_EQ(files, 3u);
  EXPECT_LE(bytes, 6000u);
  const auto read = entries(folder.path() / "audit");
  EXPECT_EQ(read.back()["who"], "user199");
  for (std::size_t i = 1; i < read.size(); ++i)
    EXPECT_LE(read[i - 1]["time"], read[i]["time"]) << "oldest first";
}

TEST(AuditLog, WhatCouldNotBeWrittenIsCountedLater) {
  const test::Folder folder;
  const auto where = folder.path() / "audit";
  {
    AuditLog log(where);
    std::filesystem::remove_all(where);
    log.add(entry("tags.set"));
    log.flush();
    std::filesystem::create_directory(where);
    log.add(entry("tags.force"));
    log.flush();
    log.flush();
  }
  const auto read = entries(where);
  ASSERT_EQ(read.size(), 2u);
  EXPECT_EQ(read[0]["request"], "tags.force");
  EXPECT_EQ(read[1]["outcome"], "lost");
}

TEST(AuditLog, ADamagedLineIsCountedAndTheOthersAreRead) {
  const test::Folder folder;
  {
    AuditLog log(folder.path() / "audit");
    log.add(entry("tags.set"));
  }
  std::ofstream(folder.path() / "audit" / "audit.jsonl", std::ios::app) << "{\"time\": \n"
                                                                        << R"({"time":"x"})"
                                                                        << "\n";
  std::size_t lines = 0;
  EXPECT_EQ(read_audit(folder.path() / "audit", [&](const std::string&) { ++lines; }), 1u);
  EXPECT_EQ(lines, 2u);
}

TEST(AuditedRequests, AreThoseThatChangeSomething) {
  const auto audited = [](const char* name, Json arguments = Json::object()) {
    return is_audited(*protocol::find_request(name), protocol::Any(std::move(arguments)));
  };
  EXPECT_TRUE(audited("control.stop"));
  EXPECT_TRUE(audited("control.hold"));
  EXPECT_TRUE(audited("program.start"));
  EXPECT_TRUE(audited("session.take"));
  EXPECT_TRUE(audited("control.override", {{"percent", 50}}));
  EXPECT_FALSE(audited("control.override"));
  EXPECT_FALSE(audited("health"));
  EXPECT_FALSE(audited("jog.beat"));
  for (const protocol::RequestType* type : protocol::request_types()) {
    if (type->facts->role == protocol::Role::watch || type->facts->watch_without) continue;
    EXPECT_TRUE(is_audited(*type, protocol::Any(Json::object()))) << type->facts->name;
  }
}

TEST(AuditedRequests, RepeatsOfAStreamAreEqual) {
  protocol::FollowTarget target;
  target.robot = "arm", target.joints = protocol::Map{{"elbow", protocol::Any(Json(0.1))}};
  EXPECT_NE(arguments_text(protocol::Request(target)).find("elbow"), std::string::npos)
      << "the first says where to";
  target.session = 3;
  const std::string once = arguments_text(protocol::Request(target));
  target.joints = protocol::Map{{"elbow", protocol::Any(Json(0.2))}};
  EXPECT_EQ(arguments_text(protocol::Request(target)), once);
  EXPECT_EQ(Json::parse(once), (Json{{"robot", "arm"}, {"session", 3.0}}));
  protocol::JogMotion jog;
  jog.session = 4, jog.tcp = protocol::Map{{"z", protocol::Any(Json(0.1))}};
  EXPECT_EQ(Json::parse(arguments_text(protocol::Request(jog))), (Json{{"session", 4.0}}));
  jog.by = true;
  EXPECT_NE(arguments_text(protocol::Request(jog)).find("0.1"), std::string::npos) << "how far";
  jog.by = false, jog.end = true;
  EXPECT_NE(arguments_text(protocol::Request(jog)).find("end"), std::string::npos);
}

TEST(AuditedRequests, ShowNoSecretsAndNoLongTexts) {
  const std::string text =
      arguments_text(protocol::Any(Json{{"request", "x"},
                                        {"id", 3},
                                        {"name", "work.script"},
                                        {"text", std::string(5000, 'a')},
                                        {"values", {{"password", "hunter2"}, {"api_token", "t"}}}}));
  EXPECT_EQ(text.find("hunter2"), std::string::npos);
  EXPECT_EQ(text.find("\"t\""), std::string::npos);
  EXPECT_EQ(text.find("aaaa"), std::string::npos);
  EXPECT_NE(text.find("\"bytes\":5000"), std::string::npos);
  EXPECT_NE(text.find("work.script"), std::string::npos);
  Json many = Json::object();
  for (int i = 0; i < 1000; ++i) many["k" + std::to_string(i)] = i;
  EXPECT_LE(arguments_text(protocol::Any(many)).size(), kAuditArguments);
}

TEST(AuditLog, ATimeIsASpanBeforeNowOrADateInUtc) {
  constexpr std::time_t now = 1795860902;  // 2026-11-28T10:15:02
  EXPECT_EQ(time_since("2h", now), "2026-11-28T08:15:02");
  EXPECT_EQ(time_since("-2h", now), "2026-11-28T08:15:02");
  EXPECT_EQ(time_since("1.5h", now), "2026-11-28T08:45:02");
  EXPECT_EQ(time_since("30min", now), "2026-11-28T09:45:02");
  EXPECT_EQ(time_since("-7d", now), "2026-11-21T10:15:02");
  EXPECT_EQ(time_since("2026-11-28", now), "2026-11-28");
  EXPECT_EQ(time_since("2026-11-28T10", now), "2026-11-28T10");
  EXPECT_EQ(time_since("2026-11-28 10:15:02Z", now), "2026-11-28T10:15:02");
  for (const char* wrong :
       {"", "-", "2", "h", "-h", "2x", "--2h", "2-h", "yesterday", "last-week", "2026-13-01", "2026-02-30",
        "2026-11-28T24:00", "2026-11-28T1", "2026-1-1", "28-11-2026", "1e9d", "99999999999d"})
    EXPECT_FALSE(time_since(wrong, now)) << wrong;
}

}  // namespace
}  // namespace polyarm::users
