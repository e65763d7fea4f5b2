/// EGM's datagrams byte for byte, HTTP and the answers of Robot Web Services; damaged ones of each.
#include <random>
#include <thread>

#include "drivers/wire/proto.hpp"
#include "tests/abb/rig.hpp"
#include "tests/support/damaged.hpp"

namespace polyarm {
namespace {

using namespace abb;

std::string hex(const std::vector<std::uint8_t>& bytes) {
  std::string out;
  for (const std::uint8_t byte : bytes) {
    out += "0123456789abcdef"[byte >> 4];
    out += "0123456789abcdef"[byte & 15];
  }
  return out;
}

EgmSensor sensor() {
  EgmSensor out;
  out.header = {300, 1, MessageType::correction};
  Values joints;
  joints.count = 6;
  joints.value = {1, -2, 0.5, 0, 90, 180};
  out.planned.emplace().joints = joints;
  return out;
}

EgmRobot robot() {
  EgmRobot out;
  out.header = {7, 1234, MessageType::data};
  EgmPosition at;
  at.joints.emplace().count = 6;
  at.joints->value = {1, 2, 3, 4, 5, 6};
  at.pose = EgmPose{{100, -200, 300.5}, {0.5, 0.5, -0.5, 0.5}};
  at.external.emplace();
  at.time = EgmClock{1'700'000'000, 4000};
  out.feedback = out.planned = at;
  out.motors = MotorState::on;
  out.state = EgmState::running;
  out.rapid = RapidState::running;
  out.converged = true;
  out.utilization = 12.5;
  return out;
}

TEST(AbbEgm, AMessageToTheRobotHasTheBytesOfProtocolBuffers) {
  // By hand from the field numbers: header {1: 300, 2: 1, 3: 3}, planned {1 {1: each joint as a double}}.
  EXPECT_EQ(hex(encode(sensor())),
            "0a07"
            "08ac02"
            "1001"
            "1803"
            "1238"
            "0a36"
            "09000000000000f03f"
            "0900000000000000c0"
            "09000000000000e03f"
            "090000000000000000"
            "090000000000805640"
            "090000000000806640");
}

TEST(AbbEgm, AMessageOfTheRobotIsReadAsItWasWritten) {
  const auto read = decode_robot(encode(robot()));
  ASSERT_TRUE(read);
  EXPECT_EQ(encode(*read), encode(robot()));
  EXPECT_EQ(read->header.sequence, 7u);
  EXPECT_EQ((*read->feedback->joints)[5], 6);
  EXPECT_EQ(read->feedback->pose->position[2], 300.5);
  EXPECT_EQ(read->state, EgmState::running);
  EXPECT_TRUE(*read->converged);
  EXPECT_EQ(*read->utilization, 12.5);
  EXPECT_FALSE(read->force);
}

// Made by Google's protocol buffers (3.21.12) with the message descriptions of RobotWare 7: the message of
// robot(); the same with force, move index, collision, test signals and RAPID data; the message of sensor()
// with speeds.
constexpr const char* kRobotBytes =
    "0a07080710d2091802128a010a3609000000000000f03f0900000000000000400900000000000008400900000000"
    "0000104009000000000000144009000000000000184012430a1b0900000000000059401100000000000069c01900"
    "00000000c87240122409000000000000e03f11000000000000e03f19000000000000e0bf21000000000000e03f1a"
    "0022090880e2cfaa0610a01f1a8a010a3609000000000000f03f0900000000000000400900000000000008400900"
    "0000000000104009000000000000144009000000000000184012430a1b0900000000000059401100000000000069"
    "c0190000000000c87240122409000000000000e03f11000000000000e03f19000000000000e0bf21000000000000"
    "e03f1a0022090880e2cfaa0610a01f220208012a020803300142020802510000000000002940";
constexpr const char* kFullRobotBytes =
    "0a07080710d2091802128a010a3609000000000000f03f0900000000000000400900000000000008400900000000"
    "0000104009000000000000144009000000000000184012430a1b0900000000000059401100000000000069c01900"
    "00000000c87240122409000000000000e03f11000000000000e03f19000000000000e0bf21000000000000e03f1a"
    "0022090880e2cfaa0610a01f1a8a010a3609000000000000f03f0900000000000000400900000000000008400900"
    "0000000000104009000000000000144009000000000000184012430a1b0900000000000059401100000000000069"
    "c0190000000000c87240122409000000000000e03f11000000000000e03f19000000000000e0bf21000000000000"
    "e03f1a0022090880e2cfaa0610a01f220208012a02080330013a09090000000000002240420208024a3808011100"
    "0000000000f03f1100000000000000c0110000000000000840110000000000001040110000000000001440110000"
    "00000000184051000000000000294058f0a2046214080111000000000000e03f11000000000000d03f6a12110000"
    "00000000f03f110000000000000040";
constexpr const char* kSensorBytes =
    "0a0708ac021001180312380a3609000000000000f03f0900000000000000c009000000000000e03f090000000000"
    "0000000900000000008056400900000000008066401a380a3609000000000000f03f090000000000000040090000"
    "000000000840090000000000001040090000000000001440090000000000001840";

std::vector<std::uint8_t> bytes_of(std::string_view text) {
  std::vector<std::uint8_t> out;
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  for (std::size_t i = 0; i + 1 < text.size(); i += 2)
    out.push_back(static_cast<std::uint8_t>(digit(text[i]) * 16 + digit(text[i + 1])));
  return out;
}

TEST(AbbEgm, TheBytesAreThoseOfTheLibraryOfProtocolBuffers) {
  EXPECT_EQ(hex(encode(robot())), kRobotBytes);
  EgmSensor fast = sensor();
  fast.joint_speed.emplace().count = 6;
  fast.joint_speed->value = {1, 2, 3, 4, 5, 6};
  EXPECT_EQ(hex(encode(fast)), kSensorBytes);
  const auto full = decode_robot(bytes_of(kFullRobotBytes));
  ASSERT_TRUE(full);
  ASSERT_TRUE(full->force);
  EXPECT_EQ(full->force->count, 6u);
  EXPECT_EQ((*full->force)[1], -2);
  EXPECT_TRUE(full->collision.value_or(false));
  EXPECT_EQ((*full->planned->joints)[5], 6);
}

TEST(AbbEgm, UnknownFieldsArePassedOverAndPackedValuesAreRead) {
  wire::ProtoWriter header, packed, joints;
  header.number(1, 9).number(2, 0).number(3, 2).number(99, 5);
  std::vector<std::uint8_t> bytes = wire::ProtoWriter().message(1, header).number(40, 1).f64(41, 2).bytes();
  const auto read = decode_robot(bytes);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->header.sequence, 9u);
  // feedback {1 {1 packed: 1.0, 2.0}}
  const std::vector<std::uint8_t> two{0x12, 0x14, 0x0a, 0x12, 0x0a, 0x10, 0, 0, 0, 0, 0,
                                      0,    0xf0, 0x3f, 0,    0,    0,    0, 0, 0, 0, 0x40};
  bytes.insert(bytes.end(), two.begin(), two.end());
  const auto with_joints = decode_robot(bytes);
  ASSERT_TRUE(with_joints && with_joints->feedback && with_joints->feedback->joints);
  EXPECT_EQ(with_joints->feedback->joints->count, 2u);
  EXPECT_EQ((*with_joints->feedback->joints)[1], 2);
}

TEST(AbbEgm, WhatIsNoMessageIsRefused) {
  EXPECT_FALSE(decode_robot({}));
  EgmRobot many = robot();
  many.feedback->joints->count = Values::kMost;
  EXPECT_TRUE(decode_robot(encode(many)));
  many.feedback->joints->value[2] = std::nan("");
  EXPECT_FALSE(decode_robot(encode(many))) << "NaN";
  const auto whole = encode(robot());
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const auto cut = decode_robot(wire::Bytes(whole).first(size));
    if (cut) {
      EXPECT_LE(encode(*cut).size(), whole.size()) << size;
    }
  }
}

TEST(AbbEgm, DamagedDatagramsNeverGiveANumberThatIsNotFinite) {
  std::mt19937 random(27);
  const std::vector<std::vector<std::uint8_t>> whole{encode(robot()), encode(sensor())};
  std::size_t taken = 0;
  for (int i = 0; i < 200'000; ++i) {
    std::vector<std::uint8_t> bytes = whole[i % 2];
    for (unsigned k = 0; k <= random() % 4; ++k)
      bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    if (random() % 4 == 0) bytes.resize(random() % bytes.size());
    if (const auto read = decode_robot(bytes)) {
      ++taken;
      if (read->feedback && read->feedback->joints) {
        ASSERT_LE(read->feedback->joints->count, Values::kMost);
        for (std::size_t j = 0; j < read->feedback->joints->count; ++j)
          ASSERT_TRUE(std::isfinite((*read->feedback->joints)[j]));
      }
    }
    if (const auto read = decode_sensor(bytes); read && read->planned && read->planned->joints) {
      for (std::size_t j = 0; j < read->planned->joints->count; ++j)
        ASSERT_TRUE(std::isfinite((*read->planned->joints)[j]));
    }
  }
  EXPECT_GT(taken, 1000u) << "the damage reaches behind the head";
}

constexpr const char* kAnswer =
    "HTTP/1.1 200 OK\r\nContent-Type: application/xhtml+xml;v=2.0\r\nContent-Length: 5\r\n\r\nhello";

TEST(AbbHttp, AnAnswerIsFoundWhereverItIsSplit) {
  const std::string text = std::string(kAnswer) + "HTTP/1.1 204 No Content\r\n\r\n";
  for (std::size_t at = 0; at <= text.size(); ++at) {
    wire::HttpReader reader(wire::HttpReader::Kind::answer);
    std::vector<wire::HttpMessage> found;
    for (const std::string& part : {text.substr(0, at), text.substr(at)}) {
      reader.take(part);
      while (auto message = reader.next()) found.push_back(*message);
    }
    ASSERT_EQ(found.size(), 2u) << at;
    EXPECT_EQ(found[0].body, "hello");
    EXPECT_EQ(found[0].header("content-type").value_or(""), "application/xhtml+xml;v=2.0");
    EXPECT_EQ(found[1].status, 204);
  }
}

TEST(AbbHttp, ChunksAreJoinedAndHidingPlacesRefused) {
  const auto read = [](const std::string& text) {
    wire::HttpReader reader(wire::HttpReader::Kind::answer);
    reader.take(text);
    auto message = reader.next();
    return std::pair{message, reader.failed()};
  };
  const auto chunked =
      read("HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n2;x=1\r\nde\r\n0\r\n\r\n");
  ASSERT_TRUE(chunked.first);
  EXPECT_EQ(chunked.first->body, "abcde");
  for (const char* head :
       {"Content-Length: 5\r\nContent-Length: 6\r\n", "Content-Length: -1\r\n",
        "Content-Length: 5\r\nTransfer-Encoding: chunked\r\n", "Content-Length: 99999999\r\n",
        "Content-Length: 5x\r\n", "no colon\r\n", "Transfer-Encoding: gzip\r\n"})
    EXPECT_TRUE(read(std::string("HTTP/1.1 200 OK\r\n") + head + "\r\nhello").second) << head;
  EXPECT_TRUE(read("SSH-2.0-x\r\n\r\n").second);
  EXPECT_TRUE(read(std::string(40000, 'a')).second) << "a head without an end";
}

TEST(AbbHttp, DamagedMessagesKeepTheBounds) {
  std::mt19937 random(28);
  const std::vector<std::string> whole{
      kAnswer, "HTTP/1.1 200 OK\r\nTransfer-Encoding: chunked\r\n\r\n3\r\nabc\r\n0\r\n\r\n",
      "POST /rw/panel/ctrl-state HTTP/1.1\r\nHost: x\r\nContent-Length: 18\r\n\r\nctrl-state=motoron"};
  const std::vector<std::string> pieces{"\r\n", "\r\n\r\n", "Content-Length: 3", "Transfer-Encoding: chunked",
                                        "0",    "ffff"};
  for (int i = 0; i < 100'000; ++i) {
    const std::string text = test::damaged(whole[static_cast<std::size_t>(i) % 3], pieces, 12, random);
    wire::HttpReader reader(i % 3 == 2 ? wire::HttpReader::Kind::request : wire::HttpReader::Kind::answer);
    for (std::size_t at = 0; at < text.size(); at += 16) {
      reader.take(std::string_view(text).substr(at, 16));
      for (int k = 0; k < 4; ++k)
        if (const auto message = reader.next()) {
          ASSERT_LE(message->body.size(), text.size());
        }
    }
    reader.end();
    reader.next();
  }
}

TEST(AbbHttp, DigestIsThatOfTheStandard) {
  // The example of RFC 2617, section 3.5.
  const std::string challenge =
      "Digest realm=\"testrealm@host.com\", qop=\"auth,auth-int\", "
      "nonce=\"dcd98b7102dd2f0e8b11d0f600bfb0c093\", "
      "opaque=\"5ccc069c403ebaf9f0171e9517f40e41\"";
  const std::string answer =
      wire::http_digest(challenge, "Mufasa", "Circle Of Life", "GET", "/dir/index.html", 1, "0a4f113b");
  EXPECT_EQ(wire::http_parameter(answer, "response"), "6629fae49393a05397450978507c4ef1");
  EXPECT_EQ(wire::http_parameter(answer, "nc"), "00000001");
  EXPECT_TRUE(wire::http_digest_matches(answer, "dcd98b7102dd2f0e8b11d0f600bfb0c093", "Mufasa",
                                        "Circle Of Life", "GET"));
  EXPECT_FALSE(
      wire::http_digest_matches(answer, "dcd98b7102dd2f0e8b11d0f600bfb0c093", "Mufasa", "circle", "GET"));
  EXPECT_EQ(wire::http_basic("Aladdin", "open sesame"), "Basic QWxhZGRpbjpvcGVuIHNlc2FtZQ==");
}

TEST(AbbHttp, APasswordIsNotSentReadableWithoutTls) {
  std::string why;
  const Descriptor listener = wire::listen_tcp("127.0.0.1", 0, why);
  ASSERT_TRUE(listener) << why;
  std::vector<wire::HttpMessage> asked;
  std::thread server([&] {
    if (!wire::wait_readable(listener.number(), 60'000'000'000)) return;
    wire::Channel channel(wire::accept_tcp(listener.number()), nullptr);
    wire::HttpReader reader(wire::HttpReader::Kind::request);
    std::array<std::uint8_t, 4096> bytes;
    while (asked.size() < 2 && wire::wait_readable(channel.descriptor(), 60'000'000'000)) {
      const wire::Received got = channel.read(bytes);
      if (got.got != wire::Got::bytes) return;
      reader.take({reinterpret_cast<const char*>(bytes.data()), got.count});
      while (auto request = reader.next()) {
        asked.push_back(*request);
        channel.write("HTTP/1.1 401 -\r\nWWW-Authenticate: Basic realm=\"x\"\r\nContent-Length: 0\r\n\r\n",
                      60'000'000'000);
      }
    }
  });
  wire::HttpSettings settings;
  settings.host = "127.0.0.1";
  settings.port = wire::local_port(listener.number());
  settings.user = "Default User";
  settings.password = "robotics";
  settings.timeout = 60'000'000'000;
  wire::HttpClient client(settings);
  wire::HttpMessage request;
  request.method = "GET";
  request.target = "/rw/system";
  const auto answer = client.ask(request);
  server.join();
  ASSERT_TRUE(answer) << client.why();
  EXPECT_EQ(answer->status, 401);
  ASSERT_EQ(asked.size(), 2u);
  for (const wire::HttpMessage& one : asked) EXPECT_FALSE(one.header("Authorization"));
}

/// True when the other end has closed the connection, or closes it within a minute.
bool is_closed_by_peer(const Descriptor& socket) {
  std::array<std::uint8_t, 64> bytes;
  while (wire::wait_readable(socket.number(), 60'000'000'000)) {
    const wire::Got got = wire::receive(socket.number(), bytes).got;
    if (got == wire::Got::closed || got == wire::Got::failed) return true;
  }
  return false;
}

TEST(AbbRws, ConnectionsThatFinishNoRequestDoNotLockOthersOut) {
  for (const int version : {1, 2}) {
    FarSideOptions options = test::far_options(version);
    options.request_time = 50'000'000;
    FarSide far(std::move(options));
    std::string why;
    std::vector<Descriptor> silent;
    for (std::uint32_t i = 0; i < bounds::kFarSideClients; ++i) {
      silent.push_back(wire::connect_tcp("127.0.0.1", far.rws_port(), 60'000'000'000, why));
      ASSERT_TRUE(silent.back()) << why;
      // None, some bytes of a request, and some bytes of a TLS handshake.
      if (i % 3 == 1) wire::send_frame(silent.back().number(), std::string("GET /rw/sys"));
      if (i % 3 == 2) wire::send_frame(silent.back().number(), std::string("\x16\x03\x01\x01"));
    }
    for (const Descriptor& each : silent) EXPECT_TRUE(is_closed_by_peer(each)) << "version " << version;
    wire::HttpSettings settings;
    settings.host = "127.0.0.1";
    settings.port = far.rws_port();
    settings.tls = version == 2;
    settings.user = "Default User";
    settings.password = "robotics";
    settings.timeout = 60'000'000'000;
    wire::HttpClient client(settings);
    wire::HttpMessage request;
    request.method = "GET";
    request.target = "/rw/system";
    request.headers.emplace_back("Accept", "application/xhtml+xml;v=2.0");
    const auto answer = client.ask(request);
    ASSERT_TRUE(answer) << client.why();
    EXPECT_EQ(answer->status, 200);
  }
}

TEST(AbbRws, AConnectionThatIsIdleBetweenRequestsStays) {
  FarSideOptions options = test::far_options(1);
  options.request_time = 50'000'000;
  FarSide far(std::move(options));
  std::string why;
  const Descriptor idle = wire::connect_tcp("127.0.0.1", far.rws_port(), 60'000'000'000, why);
  ASSERT_TRUE(idle) << why;
  const auto ask = [&] {
    wire::send_frame(idle.number(), std::string("GET /rw/system HTTP/1.1\r\nHost: x\r\n\r\n"));
    std::array<std::uint8_t, 4096> bytes;
    return wire::wait_readable(idle.number(), 60'000'000'000) &&
           wire::receive(idle.number(), bytes).got == wire::Got::bytes;
  };
  ASSERT_TRUE(ask());
  const Descriptor silent = wire::connect_tcp("127.0.0.1", far.rws_port(), 60'000'000'000, why);
  ASSERT_TRUE(silent) << why;
  EXPECT_TRUE(is_closed_by_peer(silent)) << "it came later, and its time is over";
  EXPECT_TRUE(ask());
}

TEST(AbbRws, AnswersAreReadAndDamagedOnesPassedOver) {
  const std::string page =
      "<ul><li class=\"elog-message-li\" title=\"/rw/elog/0/18\"><span class=\"msgtype\">3</span>"
      "<span class=\"code\">41822</span><span class=\"title\">No data &lt;UdpUc&gt;</span></li>"
      "<li class=\"elog-message-li\" title=\"/rw/elog/0/17\"><span class=\"code\">10013</span></li></ul>";
  const auto events = rws_events(page);
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].sequence, 18);
  EXPECT_EQ(events[0].code, 41822);
  EXPECT_EQ(events[0].kind, 3);
  EXPECT_EQ(events[0].title, "No data <UdpUc>");
  EXPECT_EQ(cause_of_event(events[0].code), Cause::commands_late);
  std::mt19937 random(29);
  const std::vector<std::string> pieces{"<li class=\"elog-message-li\" title=\"/rw/elog/",
                                        "</span>",
                                        "<span class=\"code\"",
                                        "\"",
                                        ">",
                                        "99999999999999999999",
                                        "&amp;"};
  for (int i = 0; i < 20'000; ++i)
    for (const RwsEvent& event : rws_events(test::damaged(page, pieces, 20, random))) {
      ASSERT_GT(event.code, 0);
      ASSERT_GT(event.sequence, 0);
    }
}

TEST(AbbWords, EveryCauseHasItsOwnSentenceThatNamesTheController) {
  std::map<std::string, int> seen;
  int causes = 0;
  for (int i = 1; i <= static_cast<int>(Cause::halt_unconfirmed); ++i, ++causes) {
    const std::string said = sentence(static_cast<Cause>(i), 1, "the controller at 1.2.3.4", "what it said");
    EXPECT_NE(said.find("1.2.3.4"), std::string::npos) << i << said;
    EXPECT_GT(said.size(), 20u) << i;
    EXPECT_EQ(seen[said]++, 0) << said;
    EXPECT_EQ(seen[name(static_cast<Cause>(i))]++, 0);
  }
  EXPECT_GE(causes, 25);
}

TEST(AbbRapid, TheModuleNamesWhatTheDriverExpects) {
  RapidSettings settings;
  settings.max_speed = 33;
  const std::string text = rapid_module(settings);
  EXPECT_TRUE(text.starts_with("MODULE PolyarmEGM\n"));
  for (const char* part : {"\"Polyarm\" \\Joint", "\\SampleRate:=4", "\\MaxSpeedDeviation:=33;",
                           "ERR_UDPUC_COMM", "EGM_STOP_RAMP_DOWN", "ENDMODULE"})
    EXPECT_NE(text.find(part), std::string::npos) << part;
  EXPECT_NE(device_text("192.168.1.20", 6510).find("-RemotePort 6510"), std::string::npos);
}

}  // namespace
}  // namespace polyarm
