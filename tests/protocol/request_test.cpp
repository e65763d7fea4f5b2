#include "polyarm/protocol/request.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <set>

#include "polyarm/protocol/controllers.hpp"
#include "polyarm/protocol/jog.hpp"
#include "polyarm/protocol/messages.hpp"
#include "polyarm/protocol/points.hpp"
#include "polyarm/protocol/programs.hpp"
#include "polyarm/protocol/tags.hpp"
#include "polyarm/protocol/wire.hpp"

namespace polyarm::protocol {
namespace {

using Json = nlohmann::json;

Request read(const Json& fields) {
  const Any any{Json(fields)};
  return read_request(request_type_of(any), any);
}

template <class R>
Json any_of_answer(const typename R::Answer& answer) {
  return Answer::of<R>(answer).any().json();
}

Problem refused(const Json& fields) {
  try {
    read(fields);
  } catch (const Error& e) {
    return e.problems().front();
  }
  return {"nothing", {}, "", ""};
}

TEST(Requests, AreReadIntoTheirStructs) {
  const Request request = read({{"request", "control.switch"},
                                {"id", 3},
                                {"activate", "arm"},
                                {"deactivate", {"a", "b"}},
                                {"strictness", "auto"},
                                {"dry", true}});
  ASSERT_STREQ(request.facts().name, "control.switch");
  const auto& asked = request.as<ControlSwitch>();
  EXPECT_EQ(asked.activate, Names{"arm"});
  EXPECT_EQ(asked.deactivate, (Names{"a", "b"}));
  EXPECT_EQ(asked.strictness, Strictness::automatic);
  EXPECT_TRUE(asked.dry);
}

TEST(Requests, OptionalArgumentsMayBeLeftOutOrNull) {
  const auto& asked = read({{"request", "jog"}, {"robot", nullptr}}).as<JogMotion>();
  EXPECT_FALSE(asked.robot || asked.joints || asked.hold);
  EXPECT_FALSE(asked.by);
}

TEST(Requests, SayWhichArgumentIsWrong) {
  EXPECT_EQ(refused({{"request", "control.unload"}}).what, "control.unload needs 'name' (text)");
  EXPECT_EQ(refused({{"request", "control.unload"}, {"name", 3}}).what,
            "'name' of control.unload is not of type text");
  EXPECT_EQ(refused({{"request", "param.set"}, {"name", "x"}, {"values", 3}}).what,
            "'values' of param.set is not of type map");
  EXPECT_EQ(refused({{"request", "watch"}, {"name", "x"}, {"rate", "fast"}}).what,
            "'rate' of watch is not of type number");
  EXPECT_EQ(refused({{"request", "points.shift"}, {"names", {1}}, {"by", Json::object()}}).what,
            "'names' of points.shift is not of type names");
  const Problem unknown = refused({{"request", "control.switch"}, {"activat", "tail"}});
  EXPECT_EQ(unknown.code, "bad-argument");
  EXPECT_EQ(unknown.what, "control.switch has no argument 'activat'; did you mean 'activate'?");
  EXPECT_EQ(unknown.advice, "it takes activate, deactivate, strictness, dry");
}

/// Names become names of files, lines of files and lines on terminals. Only what a file or a program says is free.
TEST(Requests, TakeNoNameWithControlCharacters) {
  std::size_t looked_at = 0;
  for (const RequestType* type : request_types())
    for (const Member& member : type->arguments->members()) {
      const std::string shape = member.type->shape(), word = member.type->word();
      if ((shape != "text" && word != "names" && shape != "[text]") || member.name == "text") continue;
      for (const char* bad : {"a\nb", "a\x1b[2J", "a\x7f", "a\tb", "a\xc2\x9b", "\xe2\x80\xae" "a", "\r"}) {
        Json fields{{"request", type->facts->name}};
        for (const Member& other : type->arguments->members())  // what is needed beside it
          if (other.needed) {
            const std::string kind = other.type->word();
            fields[other.name] = kind == "number"                     ? Json(1)
                                 : kind == "flag"                     ? Json(true)
                                 : kind == "map"                      ? Json::object()
                                 : other.type->shape() == "[x, y, z]" ? Json::array({0, 0, 0})
                                 : kind == "names" || kind == "list"  ? Json::array()
                                                                      : Json("a");
          }
        fields[member.name] = shape == "[text]" ? Json::array({bad}) : Json(bad);
        std::string what;
        try {
          read_request(*type, Any(fields));
        } catch (const Error& e) {
          what = e.problems().front().what;
        }
        EXPECT_NE(what.find("has control characters"), std::string::npos)
            << type->facts->name << " " << member.name << ": " << what;
        EXPECT_EQ(what.find('\x1b'), std::string::npos);
      }
      ++looked_at;
    }
  EXPECT_GT(looked_at, 60u);
  EXPECT_NO_THROW(read({{"request", "files.write"}, {"name", "a b.script"}, {"text", "log 1\n\tlog 2\n"}}));
  EXPECT_NO_THROW(read({{"request", "tags.set"}, {"name", "Kind"}, {"value", "two\nlines"}}));
  EXPECT_EQ(refused({{"request", "param.set"}, {"name", "x"}, {"values", {{"a\nb", 1}}}}).code, "bad-argument");
}

TEST(Requests, SayTheWordsOfAnEnumeration) {
  const Problem wrong = refused({{"request", "program.step"}, {"how", "ovr"}});
  EXPECT_EQ(wrong.code, "bad-argument");
  EXPECT_EQ(wrong.what, "there is no step 'ovr'; did you mean 'over'?");
  EXPECT_EQ(wrong.advice, "into, over or out");
}

TEST(Requests, OfASessionAreUnknownToACellAndIgnoreUnknownArguments) {
  EXPECT_EQ(refused({{"request", "session.hello"}}).code, "unknown-request");
  const Any fields(Json{{"request", "jog.beat"}, {"jog", 3}, {"speed", 0.5}});
  EXPECT_NO_THROW(read_request(*find_request("jog.beat"), fields));
}

TEST(Requests, HaveNamesThatDifferAndArgumentsThatAreMembers) {
  std::set<std::string> names;
  for (const RequestType* type : request_types()) {
    const Facts& facts = *type->facts;
    EXPECT_TRUE(names.insert(facts.name).second) << facts.name << " is there twice";
    EXPECT_EQ(find_request(facts.name), type);
    for (const char* argument : {facts.watch_with, facts.watch_without}) {
      if (!argument) continue;
      EXPECT_TRUE(std::any_of(type->arguments->members().begin(), type->arguments->members().end(),
                              [&](const Member& member) { return member.name == argument; }))
          << facts.name << " has no argument " << argument;
    }
  }
}

/// What may bring to rest is no motion; everything else that moves needs control.
TEST(Requests, ThatMayMoveAreNotForWatchers) {
  const std::set<std::string> rests = {"control.hold", "control.stop"};
  for (const RequestType* type : request_types()) {
    if (!type->facts->moves || rests.contains(type->facts->name)) continue;
    Json full = Json::object();
    if (type->facts->watch_without) full[type->facts->watch_without] = true;
    EXPECT_NE(role_needed(*type, Any(full)), Role::watch) << type->facts->name;
  }
}

TEST(Requests, WithoutTheArgumentThatChangesSomethingOnlyRead) {
  const RequestType& type = *find_request("control.override");
  EXPECT_EQ(role_needed(type, Any(Json{{"percent", 50}})), Role::operate);
  EXPECT_EQ(role_needed(type, Any(Json{{"percent", nullptr}})), Role::watch);
  const RequestType& dry = *find_request("points.frame");
  EXPECT_EQ(role_needed(dry, Any(Json{{"dry", true}})), Role::watch);
  EXPECT_EQ(role_needed(dry, Any(Json{{"dry", false}})), Role::program);
  ControlOverride request;
  EXPECT_EQ(role_needed(Request(request)), Role::watch);
  request.percent = 50;
  EXPECT_EQ(role_needed(Request(request)), Role::operate);
}

/// Law: a request that was written is read as the same request.
TEST(Requests, AreTheSameAfterTheWire) {
  std::mt19937 random(7);
  const auto draw = [&](const Type& type) -> Json {
    const std::string word = type.word();
    if (word == "number") return std::uniform_real_distribution<double>(-1e3, 1e3)(random);
    if (word == "flag") return random() % 2 == 0;
    if (word == "names") return Json::array({"a", "b"});
    if (word == "map") return Json{{"x", 1.5}, {"y", "2mm"}};
    if (word == "message" || word == "any") return Json{{"deep", {1, 2, {{"er", nullptr}}}}};
    const std::string shape = type.shape();
    if (shape == "[x, y, z]") return Json::array({1.5, -2, 0});
    return shape == "text" ? "some text"
                           : shape.substr(0, shape.find(' '));  // the first word of an enumeration
  };
  for (int round = 0; round < 50; ++round)
    for (const RequestType* type : request_types()) {
      Json fields = Json::object();
      for (const Member& member : type->arguments->members()) {
        if (!member.needed && random() % 2) continue;
        fields[member.name] = draw(*member.type);
        const bool whole = type->facts->session || member.name == "offset";  // of a file
        if (member.type->typescript() == "number" && whole) fields[member.name] = random() % 100;
      }
      const Request first = read_request(*type, Any(fields));
      const std::string line = request_line(first, Any(round));
      const Any again = parse_request(line);
      EXPECT_EQ(request_id(again), Any(round));
      EXPECT_EQ(read_request(*type, again).arguments(), first.arguments()) << line;
    }
}

TEST(Answers, LeaveOutWhatIsOptionalAndWriteNullForWhatIsNotKnown) {
  TagState tag;
  tag.name = "Vacuum";
  tag.rules.on_stop = Any(true);
  const Json written = any_of_answer<TagsSet>(tag);
  EXPECT_EQ(written["rules"], (Json{{"on_stop", true}}));
  EXPECT_TRUE(written["output"].is_null());
  EXPECT_TRUE(written["changed_s"].is_null());
  tag.output = 0.5;
  EXPECT_EQ(any_of_answer<TagsSet>(tag)["output"], 0.5);
}

TEST(Answers, WriteNullForNaN) {
  ControlOverride::Answer answer;
  answer.percent = std::numeric_limits<double>::quiet_NaN();
  answer.allowed = std::numeric_limits<double>::infinity();
  EXPECT_EQ(reply_line({Answer::of<ControlOverride>(answer), {}, false}, {}),
            R"({"ok":true,"result":{"allowed":null,"asked":"override","percent":null}})");
}

TEST(Answers, PutMergedMembersBesideTheirOwn) {
  PointsFrame::Answer answer;
  answer.name = "F";
  EXPECT_FALSE(any_of_answer<PointsFrame>(answer).contains("literal"));
  ChangedPoint point;
  point.name = "other";
  point.literal = "pose(…)";
  point.undo = "frame F";
  answer.point.emplace(point);
  const Json whole = any_of_answer<PointsFrame>(answer);
  EXPECT_EQ(whole["name"], "F") << "its own members have the last word";
  EXPECT_EQ(whole["undo"], "frame F");
  EXPECT_EQ(whole["literal"], "pose(…)");
}

TEST(Answers, LeaveTheTrailingUnderscoreOutOfAKey) {
  Parameter parameter;
  parameter.default_ = "7";
  const Json written = any_of_answer<ParamGet>(parameter);
  EXPECT_EQ(written["default"], "7");
  EXPECT_FALSE(written.contains("choices"));
}

TEST(Replies, CarryTheIdAndSayWhetherThereAreMore) {
  const Answer answer = Answer::of<ControlHold>({"hold"});
  EXPECT_EQ(reply_line({answer, {}, true}, Any("x")),
            R"({"id":"x","more":true,"ok":true,"result":{"asked":"hold"}})");
  EXPECT_EQ(reply_line({{}, Error("busy", "too many", "wait"), false}, {}),
            R"({"error":{"advice":"wait","code":"busy","what":"too many","where":""},"ok":false})");
}

TEST(Replies, ListAllProblemsOfARefusal) {
  const Error several(std::vector<Problem>{{"one", {}, "first", ""}, {"two", {}, "second", ""}});
  const Json line = Json::parse(refusal_line(several, {}));
  EXPECT_EQ(line["error"]["code"], "one");
  ASSERT_EQ(line["error"]["all"].size(), 2u);
  EXPECT_EQ(line["error"]["all"][1]["code"], "two");
}

TEST(Wire, RefusesWhatIsNoObjectOrTooDeep) {
  for (const std::string line : {"", "[]", "7", "{", "{\"request\":"})
    EXPECT_THROW(parse_request(line), Error) << line;
  EXPECT_THROW(parse_request("{\"a\":" + std::string(70, '[') + std::string(70, ']') + "}"), Error);
  EXPECT_FALSE(nested_too_deep("{\"a\":\"" + std::string(200, '[') + "\"}")) << "brackets in a text";
  EXPECT_THROW(request_id(Any(Json{{"id", std::string(1000, 'x')}})), Error);
}

}  // namespace
}  // namespace polyarm::protocol
