/// The bytes of RTDE and of the primary interface.
#include "drivers/ur/rtde.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "drivers/ur/primary.hpp"
#include "drivers/ur/script.hpp"

namespace polyarm::ur {
namespace {

using Octets = std::vector<std::uint8_t>;

TEST(Rtde, AFrameHasItsSizeItsTypeAndItsPayload) {
  EXPECT_EQ(frame(PackageType::protocol_version, wire::Writer().u16(2)), (Octets{0, 5, 86, 0, 2}));
  EXPECT_EQ(frame(PackageType::start), (Octets{0, 3, 83}));
  wire::Writer outputs;
  outputs.f64(125).text("timestamp,robot_mode");
  const Octets made = frame(PackageType::setup_outputs, outputs);
  EXPECT_EQ(made.size(), 3u + 8 + 20);
  EXPECT_EQ(made[0], 0);
  EXPECT_EQ(made[1], 31);
  EXPECT_EQ(made[2], 'O');
  EXPECT_EQ(made[3], 0x40);  // 125.0 is 40 5F 40 00 …
  EXPECT_EQ(made[4], 0x5F);
  EXPECT_EQ(made[5], 0x40);
  EXPECT_EQ(made[11], 't');
}

TEST(Rtde, FramesAreFoundHoweverTheStreamIsCut) {
  Octets stream;
  for (const auto& one : {frame(PackageType::start), frame(PackageType::data, wire::Writer().u8(1).f64(2.5)),
                          frame(PackageType::pause, wire::Writer().u8(1))})
    stream.insert(stream.end(), one.begin(), one.end());
  for (std::size_t piece = 1; piece <= stream.size(); ++piece) {
    FrameStream frames;
    std::string types;
    std::size_t bytes = 0;
    for (std::size_t at = 0; at < stream.size(); at += piece)
      EXPECT_TRUE(frames.feed(Bytes(stream).subspan(at, std::min(piece, stream.size() - at)),
                              [&](PackageType type, Bytes payload) {
                                types += static_cast<char>(type);
                                bytes += payload.size();
                              }));
    EXPECT_EQ(types, "SUP");
    EXPECT_EQ(bytes, 0u + 9 + 1);
  }
}

TEST(Rtde, ASizeBelowTheHeaderBreaksTheStream) {
  FrameStream frames;
  int found = 0;
  EXPECT_FALSE(frames.feed(Octets{0, 2, 85, 0, 3, 83}, [&](PackageType, Bytes) { ++found; }));
  EXPECT_EQ(found, 0);
  frames.reset();
  EXPECT_TRUE(frames.feed(Octets{0, 3, 83}, [&](PackageType, Bytes) { ++found; }));
  EXPECT_EQ(found, 1);
}

TEST(Rtde, ValuesOfEveryTypeComeBackAsTheyWent) {
  Recipe recipe;
  std::vector<double> values, back;
  for (const char* type : {"BOOL", "UINT8", "UINT32", "UINT64", "INT32", "DOUBLE", "VECTOR3D", "VECTOR6D",
                           "VECTOR6INT32", "VECTOR6UINT32"}) {
    ASSERT_NE(find_type(type), nullptr) << type;
    recipe.add(*find_type(type));
  }
  for (std::size_t i = 0; i < recipe.elements; ++i)
    values.push_back(static_cast<double>(i % 7 + (i == 0 ? 1 : 0)));
  values[4] = -5;
  values[5] = -0.125;
  wire::Writer out;
  encode(recipe, values, out);
  EXPECT_EQ(out.bytes().size(), 1u + 1 + 4 + 8 + 4 + 8 + 24 + 48 + 24 + 24);
  back.resize(recipe.elements);
  ASSERT_TRUE(decode(recipe, out.bytes(), back));
  EXPECT_EQ(back, values);
  back.resize(recipe.elements - 1);
  EXPECT_FALSE(decode(recipe, out.bytes(), back));
}

TEST(Rtde, IntegersAreLimitedToTheirRange) {
  Recipe recipe;
  recipe.add(*find_type("UINT8"));
  recipe.add(*find_type("INT32"));
  wire::Writer out;
  encode(recipe, std::vector<double>{999, std::nan("")}, out);
  EXPECT_EQ(out.bytes(), (Octets{255, 0, 0, 0, 0}));
}

TEST(Rtde, NamesHaveTheTypesOfTheMakersTable) {
  const auto type = [](const FieldType* found) { return found ? std::string(found->name) : "none"; };
  EXPECT_EQ(type(find_output("actual_q")), "VECTOR6D");
  EXPECT_EQ(type(find_output("actual_digital_input_bits")), "UINT64");
  EXPECT_EQ(type(find_output("safety_mode")), "INT32");
  EXPECT_EQ(type(find_output("output_int_register_47")), "INT32");
  EXPECT_EQ(type(find_output("output_bit_register_64")), "BOOL");
  EXPECT_EQ(type(find_output("output_bit_register_63")), "none");
  EXPECT_EQ(type(find_output("output_int_register_48")), "none");
  EXPECT_EQ(type(find_output("output_int_register_")), "none");
  EXPECT_EQ(type(find_output("output_int_register_007")), "none");
  EXPECT_EQ(type(find_input("input_double_register_24")), "DOUBLE");
  EXPECT_EQ(type(find_input("speed_slider_mask")), "UINT32");
  EXPECT_EQ(type(find_input("actual_q")), "none");
  EXPECT_EQ(type(find_output("")), "none");
}

TEST(Rtde, TextMessagesOfBothProtocols) {
  wire::Writer two;
  two.u8(2).text("hi").u8(3).text("arm").u8(1);
  const auto read = read_text(two.bytes(), 2);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->text + "|" + read->source, "hi|arm");
  EXPECT_EQ(read->level, 1);
  EXPECT_FALSE(read_text(Octets{200, 'h'}, 2)) << "a text that is longer than its package";
  EXPECT_EQ(read_text(Octets{3, 'o', 'k'}, 1)->text, "ok");
}

TEST(Script, AMessageHasTheNumbersThatTheProgramReads) {
  Message message{7, 100, Mode::position, {1, -1, 0.5, 0, 3.14159265, -6.28}};
  const auto bytes = encode(message);
  EXPECT_EQ(bytes[3], 7);
  EXPECT_EQ(bytes[7], 100);
  EXPECT_EQ(bytes[11], 1);
  EXPECT_EQ((Octets(bytes.begin() + 12, bytes.begin() + 16)), (Octets{0x00, 0x98, 0x96, 0x80}))
      << "1 rad is 10,000,000";
  const Message back = decode_message(bytes);
  EXPECT_EQ(back.sequence, 7);
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(back.values[i], message.values[i], 0.5 / kScale);
  message.values = {1e9, -1e9, std::nan(""), HUGE_VAL, 0, 0};
  EXPECT_GT(decode_message(encode(message)).values[0], 200) << "limited, not wrapped";
  EXPECT_LT(decode_message(encode(message)).values[1], -200);
  EXPECT_EQ(decode_message(encode(message)).values[2], 0);
}

TEST(Script, TheProgramHasNoPlaceLeftToFill) {
  ScriptSettings settings;
  settings.host = "10.0.0.2";
  settings.port = 50123;
  const std::string text = program_text(settings);
  EXPECT_EQ(text.find('{'), std::string::npos);
  EXPECT_NE(text.find("socket_open(\"10.0.0.2\", 50123, \"polyarm_stream\")"), std::string::npos) << text;
  EXPECT_TRUE(text.starts_with("def polyarm():\n"));
  EXPECT_TRUE(text.ends_with("\nend\n"));
  int depth = 0;  // every block has its end
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    std::string line = text.substr(at, end - at);
    line.erase(0, line.find_first_not_of(' '));
    for (const char* opener : {"def ", "if ", "while ", "thread "}) depth += line.starts_with(opener);
    depth -= line == "end";
    EXPECT_GE(depth, 0) << line;
    at = end + 1;
  }
  EXPECT_EQ(depth, 0);
}

TEST(Primary, MessagesComeBackAsTheyWent) {
  PrimaryStream stream;
  std::vector<PrimaryEvent> events;
  for (const auto& one :
       {version_message(1, 5, 15, 2), key_message(2, "PROGRAM_XXX_STARTED", "polyarm"),
        error_message(3, kReadOnly, 0, 3, "read-only"), exception_message(4, 12, 3, "name_not_found")})
    for (const std::uint8_t byte : one) ASSERT_TRUE(stream.feed(Octets{byte}, events));
  ASSERT_EQ(events.size(), 4u);
  EXPECT_EQ(events[0].text, "5.15.2");
  EXPECT_EQ(events[1].kind, PrimaryEvent::Kind::started);
  EXPECT_EQ(events[1].text, "polyarm");
  EXPECT_EQ(events[2].code, kReadOnly);
  EXPECT_EQ(events[2].text, "read-only");
  EXPECT_EQ(events[3].code, 12);
  EXPECT_EQ(events[3].text, "name_not_found");
}

TEST(Primary, ASizeThatCannotBeBreaksTheStream) {
  for (const Octets& broken :
       {Octets{0, 0, 0, 4, 16}, Octets{0xFF, 0xFF, 0xFF, 0xFF, 20}, Octets{0, 0x20, 0, 0, 16}}) {
    PrimaryStream stream;
    std::vector<PrimaryEvent> events;
    EXPECT_FALSE(stream.feed(broken, events));
    EXPECT_TRUE(events.empty());
  }
}

/// Bytes that are wrong anywhere never do more than break a stream. Sanitizers watch this test.
TEST(Fuzz, ForeignBytesAreRefusedAndNothingElse) {
  std::mt19937 random(27);
  const auto byte = [&] { return static_cast<std::uint8_t>(random()); };
  Recipe recipe;
  for (const char* type : {"DOUBLE", "VECTOR6D", "INT32", "UINT64"}) recipe.add(*find_type(type));
  std::vector<double> values(recipe.elements);
  std::size_t frames_found = 0, events_found = 0;
  for (int round = 0; round < 20'000; ++round) {
    Octets bytes = round % 3 == 0   ? version_message(1, 5, 1, 1)
                   : round % 3 == 1 ? error_message(3, 210, 0, 3, "a text of an error")
                                    : frame(PackageType::data, wire::Writer().u8(1).f64(1).f64(2));
    for (int i = 0; i < round % 4; ++i) bytes[random() % bytes.size()] = byte();
    if (round % 7 == 0) bytes.resize(random() % (bytes.size() + 1));
    if (round % 11 == 0)
      for (std::size_t i = random() % 40; i > 0; --i) bytes.push_back(byte());
    FrameStream frames;
    frames.feed(bytes, [&](PackageType, Bytes payload) {
      ++frames_found;
      decode(recipe, payload, values);
      read_text(payload, 2);
      split_names({reinterpret_cast<const char*>(payload.data()), payload.size()});
    });
    PrimaryStream stream;
    std::vector<PrimaryEvent> events;
    stream.feed(bytes, events);
    events_found += events.size();
  }
  EXPECT_GT(frames_found, 1000u);
  EXPECT_GT(events_found, 1000u);
}

TEST(Rtde, AListOfTooManyNamesIsRefused) {
  std::string names = "a";
  for (std::size_t i = 1; i < bounds::kRtdeNames; ++i) names += ",a";
  EXPECT_EQ(split_names(names).size(), bounds::kRtdeNames);
  EXPECT_TRUE(split_names(names + ",a").empty());
}

}  // namespace
}  // namespace polyarm::ur
