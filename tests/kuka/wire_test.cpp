/// The XML of both wires: golden texts, damaged and split ones, and the bounds of the reader.
#include <random>

#include "drivers/kuka/krl.hpp"
#include "drivers/wire/xml.hpp"
#include "polyarm/base/bounds.hpp"
#include "tests/kuka/rig.hpp"
#include "tests/support/damaged.hpp"

namespace polyarm {
namespace {

using namespace kuka;
using wire::XmlDocument;
using Result = XmlDocument::Result;

// As the maker's manuals and other people's programs have it, with tags that a context adds.
constexpr const char* kRobot =
    "<Rob Type=\"KUKA\"><RIst X=\"500.1\" Y=\"-20.0\" Z=\"700\" A=\"-180.0\" B=\"0.5\" C=\"180.0\"/>"
    "<RSol X=\"0.0\" Y=\"0.0\" Z=\"0.0\" A=\"0.0\" B=\"0.0\" C=\"0.0\"/>"
    "<AIPos A1=\"1.5\" A2=\"-90.25\" A3=\"90\" A4=\"0.0\" A5=\"45.0\" A6=\"-0.001\"/>"
    "<ASPos A1=\"1.5\" A2=\"-90.25\" A3=\"90\" A4=\"0.0\" A5=\"45.0\" A6=\"0\"/>"
    "<EIPos E1=\"0.0\" E2=\"0.0\" E3=\"0.0\" E4=\"0.0\" E5=\"0.0\" E6=\"0.0\"/>"
    "<Delay D=\"3\"/><Tech C11=\"0.0\" C12=\"0.0\"/><DiL>5</DiL><IPOC>4208163634</IPOC></Rob>";

TEST(RsiDatagrams, AControllersIsReadWithTagsThatTheDriverDoesNotKnow) {
  const auto robot = decode_robot(kRobot);
  ASSERT_TRUE(robot);
  EXPECT_EQ(robot->ipoc, 4'208'163'634u);
  EXPECT_EQ(robot->axes, (Six{1.5, -90.25, 90, 0, 45, -0.001}));
  EXPECT_EQ(robot->setpoint, (Six{1.5, -90.25, 90, 0, 45, 0}));
  EXPECT_EQ(robot->pose, (Six{500.1, -20, 700, -180, 0.5, 180}));
  EXPECT_EQ(robot->delay, 3);
  EXPECT_EQ(robot->inputs, 5u);
}

TEST(RsiDatagrams, OfAnotherSimulatorIsReadToo) {
  const auto robot = decode_robot(
      "<Rob TYPE=\"KUKA\"><AIPos A1=\"0.0\" A2=\"-90.0\" A3=\"90.0\" A4=\"0.0\" A5=\"90.0\" A6=\"0.0\" />"
      "<Delay D=\"0\" /><IPOC>0</IPOC></Rob>");
  ASSERT_TRUE(robot);
  EXPECT_EQ(robot->axes[1], -90);
  EXPECT_FALSE(robot->setpoint);
  EXPECT_FALSE(robot->pose);
}

TEST(RsiDatagrams, TheAnswerIsWhatAControllerTakes) {
  RsiSensor sensor;
  sensor.ipoc = 4'208'163'634;
  sensor.correction = {0.5, -0.25, 0, 0, 1e-6, -0.0};
  EXPECT_EQ(encode(sensor),
            "<Sen Type=\"Polyarm\"><Stop>0</Stop><AK A1=\"0.500000\" A2=\"-0.250000\" A3=\"0.000000\" "
            "A4=\"0.000000\" A5=\"0.000001\" A6=\"0.000000\"/><IPOC>4208163634</IPOC></Sen>");
  const auto back = decode_sensor(encode(sensor));
  ASSERT_TRUE(back);
  EXPECT_EQ(back->ipoc, sensor.ipoc);
  EXPECT_EQ(back->correction, sensor.correction);
  EXPECT_FALSE(back->stop);
  sensor.stop = true;
  EXPECT_TRUE(decode_sensor(encode(sensor))->stop);
}

TEST(RsiDatagrams, AnswersOfAnotherTypeAreNotTaken) {
  std::string text = encode(RsiSensor{7, {}, false});
  text.replace(text.find("Polyarm"), 7, "ImFree");
  EXPECT_FALSE(decode_sensor(text));
  EXPECT_TRUE(decode_sensor(text, "ImFree"));
  EXPECT_EQ(encode(RsiSensor{7, {}, false}, "ImFree"), text);
}

TEST(RsiDatagrams, WhatIsMissingOrNotFiniteMakesThemUseless) {
  const std::string good = kRobot;
  for (const auto& [from, to] :
       std::initializer_list<std::pair<std::string, std::string>>{{"A6=\"-0.001\"", "A6=\"nan\""},
                                                                  {"A6=\"-0.001\"", "A6=\"inf\""},
                                                                  {"A6=\"-0.001\"", "A6=\"1e999\""},
                                                                  {"A6=\"-0.001\"", "A6=\"0x10\""},
                                                                  {"A6=\"-0.001\"", "A6=\"\""},
                                                                  {"A6=\"-0.001\"", ""},
                                                                  {"4208163634", "-4"},
                                                                  {"4208163634", "99999999999999999999"},
                                                                  {"<IPOC>", "<IPO>"},
                                                                  {"Rob ", "Bob "}}) {
    std::string bad = good;
    bad.replace(bad.find(from), from.size(), to);
    EXPECT_FALSE(decode_robot(bad)) << bad;
  }
}

TEST(RsiDatagrams, DamagedOnesNeverGiveANumberThatIsNotFinite) {
  std::mt19937 random(27);
  const std::vector<std::string> pieces{"<",    ">",    "/",         "\"",     "'",     "&",
                                        "&lt;", "<!--", "<![CDATA[", "?>",     "<?xml", "nan",
                                        "=",    " ",    "<AIPos",    "</Rob>", "1e308", std::string(1, '\0')};
  const std::string sensor = encode(RsiSensor{4'208'000, {1, 2, 3, 4, 5, 6}, false});
  int read = 0;
  for (int i = 0; i < 150'000; ++i) {
    const std::string text = test::damaged(i % 2 ? kRobot : sensor, pieces, 40, random);
    if (const auto robot = decode_robot(text)) {
      ++read;
      for (const double axis : robot->axes) ASSERT_TRUE(std::isfinite(axis)) << text;
    }
    if (const auto answer = decode_sensor(text)) {
      ++read;
      for (const double axis : answer->correction) ASSERT_TRUE(std::isfinite(axis)) << text;
    }
  }
  EXPECT_GT(read, 0) << "some damage does no harm";
}

TEST(Xml, EveryPartOfADocumentIsIncomplete) {
  const std::string text = std::string("<?xml version=\"1.0\"?>\n") + kRobot;
  XmlDocument document;
  for (std::size_t size = 0; size < text.size(); ++size)
    ASSERT_EQ(document.read(std::string_view(text).substr(0, size)), Result::incomplete) << size;
  EXPECT_EQ(document.read(text + "<Next"), Result::whole);
  EXPECT_EQ(document.size(), text.size());
}

TEST(Xml, WhatItDoesNotTakeIsBad) {
  XmlDocument document;
  std::string deep, wide = "<a>", many = "<a";
  for (int i = 0; i < 5; ++i) deep += "<a>";
  for (int i = 0; i < 60; ++i) wide += "<b/>";
  for (int i = 0; i < 200; ++i) many += " x" + std::to_string(i) + "=\"1\"";
  for (const std::string& text :
       {std::string("text"), std::string("<a>&amp;</a>"), std::string("<a b=\"&quot;\"/>"),
        std::string("<!DOCTYPE a>"), std::string("<a><!-- x --></a>"), std::string("<a></b>"),
        std::string("<a b=1/>"), std::string("<a b=\"1\"c=\"2\"/>"), std::string("<1/>"), deep + "</a>",
        wide + "</a>", many + "/>"})
    EXPECT_EQ(document.read(text), Result::bad) << text.substr(0, 60);
  EXPECT_EQ(document.read("<a b='\"'/>"), Result::whole);
  EXPECT_EQ(document.attribute(document.root(), "b"), "\"");
}

EkiReply reply() {
  EkiReply out;
  out.id = 12;
  out.state.inputs = 0x8000'0001u;
  out.state.axes = {1, -2, 3, -4, 5, -6};
  out.state.rsi_return = -3;
  out.state.emergency_stop = true;
  out.identity.robot = "#KR10R1100_3 C4SR <&>";
  out.identity.relative = true;
  out.identity.lower = {-170, -190, -120, -185, -120, -350};
  out.identity.upper = {170, 45, 156, 185, 120, 350};
  return out;
}

TEST(EkiMessages, GoThroughWhole) {
  const auto request = decode_request("<Polyarm Id=\"7\" Do=\"5\" Number=\"3\" Value=\"1\"></Polyarm>");
  ASSERT_TRUE(request);
  EXPECT_EQ(encode(*request), "<Polyarm Id=\"7\" Do=\"5\" Number=\"3\" Value=\"1\"></Polyarm>\n");
  EXPECT_EQ(request->what, EkiDo::output);
  const EkiReply sent = reply();
  const auto got = decode_reply(encode(sent));
  ASSERT_TRUE(got);
  EXPECT_EQ(got->id, 12);
  EXPECT_EQ(got->state.inputs, sent.state.inputs);
  EXPECT_EQ(got->state.axes, sent.state.axes);
  EXPECT_EQ(got->state.rsi_return, -3);
  EXPECT_TRUE(got->state.emergency_stop);
  EXPECT_EQ(got->identity.robot, "#KR10R1100_3 C4SR    ") << "no entities on this wire";
  EXPECT_TRUE(got->identity.relative);
  EXPECT_EQ(got->identity.upper, sent.identity.upper);
}

TEST(EkiMessages, AreFoundInAStreamThatIsSplitAtEveryByte) {
  const std::string one = encode(reply()), stream = "\r\n " + one + one;
  for (std::size_t at = 0; at <= stream.size(); ++at) {
    EkiReader reader;
    int found = 0;
    for (const std::string& part : {stream.substr(0, at), stream.substr(at)}) {
      ASSERT_TRUE(reader.feed(part)) << at;
      for (std::string text = reader.next(); !text.empty(); text = reader.next()) {
        ASSERT_TRUE(decode_reply(text)) << at << ": " << text;
        ++found;
      }
    }
    ASSERT_EQ(found, 2) << at;
  }
}

TEST(EkiMessages, AStreamWithoutAnEndIsGivenUp) {
  EkiReader endless;
  bool fine = true;
  std::size_t fed = 0;
  for (; fine && fed < 1 << 20; fed += 64)
    fine = endless.feed(std::string("<Robot><Answer Id=\"") + std::string(45, '1'));
  EXPECT_FALSE(fine);
  EXPECT_LT(fed, 3 * bounds::kEkiMessageBytes);
  EkiReader text;
  EXPECT_FALSE(text.feed("HTTP/1.1 400 Bad Request\r\n"));
  EkiReader flood;  // messages that nobody takes
  fine = true;
  for (int i = 0; fine && i < 1000; ++i) fine = flood.feed(encode(EkiRequest{i, EkiDo::state, 0, 0, {}}));
  EXPECT_FALSE(fine);
}

TEST(EkiMessages, DamagedStreamsAreReadOrGivenUp) {
  std::mt19937 random(28);
  const std::vector<std::string> pieces{"<", ">", "/>",       "\"",      "&", "<!",
                                        "?", "=", "</Robot>", "<Robot>", "-", "99999999999"};
  const std::string one = encode(reply());
  for (int i = 0; i < 20'000; ++i) {
    EkiReader reader;
    if (!reader.feed(test::damaged(one, pieces, 30, random))) continue;
    for (std::string text = reader.next(); !text.empty(); text = reader.next()) {
      const auto got = decode_reply(text);
      if (!got) continue;
      for (const double axis : got->state.axes) ASSERT_TRUE(std::isfinite(axis));
    }
  }
}

TEST(KrlFiles, HaveNoPlaceLeftAndNameWhatTheDriverExpects) {
  for (const int version : {3, 4, 5}) {
    KrlSettings settings;
    settings.rsi = version;
    settings.own_address = "192.168.7.20";
    const auto files = krl_files(settings);
    ASSERT_EQ(files.size(), 8u);
    for (const KrlFile& file : files) {
      EXPECT_EQ(file.text.find('@' + std::string("A")), file.text.find("@A1\"")) << file.name;
      for (const char* place : {"@RSI", "@CYCLE", "@LATE", "@MODE", "@ADDRESS", "@FILES"})
        EXPECT_EQ(file.text.find(place), std::string::npos) << file.name << " " << place;
    }
    EXPECT_NE(files[0].text.find("<IP_NUMBER>192.168.7.20</IP_NUMBER>"), std::string::npos);
    EXPECT_NE(files[0].text.find("<SENTYPE>Polyarm</SENTYPE>"), std::string::npos);
    EXPECT_NE(files[0].text.find("TAG=\"AK.A6\" TYPE=\"DOUBLE\" INDX=\"7\" HOLDON=\"1\""), std::string::npos);
    EXPECT_EQ(files[1].name, version == 3 ? "PolyarmRsi.rsi.xml" : "PolyarmRsi.rsix");
  }
}

/// The configuration of EthernetKRL sends each tag that the driver reads, and no other one.
TEST(KrlFiles, TheTagsOfAnAnswerAreThoseThatTheDriverReads) {
  const auto files = krl_files({});
  const std::string &configuration = files[2].text, &program = files[4].text;
  std::size_t tags = 0;
  for (std::size_t at = 0; (at = configuration.find("Tag=\"Robot/", at)) != std::string::npos; ++at, ++tags) {
    const std::size_t begin = at + 5, end = configuration.find('"', begin);
    const std::string tag = configuration.substr(begin, end - begin);
    EXPECT_NE(program.find("\"" + tag + "\""), std::string::npos) << tag << " is never set";
    const std::size_t slash = tag.find('/', 6);
    const std::string element = tag.substr(6, slash - 6), attribute = tag.substr(slash + 2);
    const std::string text = encode(reply());
    const std::size_t found = text.find("<" + element + " ");
    ASSERT_NE(found, std::string::npos) << tag;
    EXPECT_NE(text.substr(found, text.find('>', found) - found).find(" " + attribute + "=\""),
              std::string::npos)
        << tag;
  }
  EXPECT_EQ(tags, 44u);
  XmlDocument document;
  EXPECT_EQ(document.read(encode(reply())), Result::whole);
}

}  // namespace
}  // namespace polyarm
