/// Foxglove's reader and writer of ROS 2 messages on the other side: they parse our schemas, read our bytes,
/// and we read theirs. They come with npm; without it the test says so and is skipped.
#include <gtest/gtest.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <functional>
#include <random>
#include <string>
#include <vector>

#include "polyarm/messages/json.hpp"
#include "tests/messages/bytes.hpp"
#include "tests/messages/random_message.hpp"

namespace polyarm::messages {
namespace {

using nlohmann::json;

bool run(const std::string& command) {
  return std::system((command + " >/dev/null 2>&1").c_str()) == 0;
}

/// A folder with the peer and what it needs, made once for a build.
class Peer {
 public:
  Peer() {
    namespace fs = std::filesystem;
    const fs::path source = fs::path(POLYARM_SOURCE_DIR) / "tests/messages/foxglove";
    folder_ = fs::path(POLYARM_COMMAND).parent_path() / "foxglove";
    fs::create_directories(folder_);
    for (const char* file : {"package.json", "package-lock.json", "peer.mjs"})
      fs::copy_file(source / file, folder_ / file, fs::copy_options::overwrite_existing);
    if (!run("node --version") || !run("npm --version")) {
      missing_ = "npm is not installed";
    } else if (!fs::exists(folder_ / "node_modules/@foxglove/cdr") &&
               !run("cd '" + folder_.string() + "' && npm ci --no-audit --no-fund")) {
      missing_ = "npm cannot fetch @foxglove/cdr and @foxglove/rosmsg2-serialization here";
    }
  }
  const std::string& missing() const { return missing_; }
  std::vector<json> answers(const std::vector<json>& questions) const {
    const std::string in = (folder_ / "in.ndjson").string(), out = (folder_ / "out.ndjson").string();
    std::ofstream file(in);
    for (const json& question : questions) file << question.dump() << "\n";
    file.close();
    EXPECT_TRUE(run("cd '" + folder_.string() + "' && node peer.mjs '" + in + "' '" + out + "'"));
    std::vector<json> all;
    std::ifstream answered(out);
    for (std::string line; std::getline(answered, line);) all.push_back(json::parse(line));
    return all;
  }

 private:
  std::filesystem::path folder_;
  std::string missing_;
};

/// A struct without fields is an empty object there and here.
TEST(Foxglove, ReadsWhatWeWriteAndWeReadWhatItWritesForEveryMessage) {
  const Peer peer;
  if (!peer.missing().empty()) GTEST_SKIP() << peer.missing();
  std::mt19937 random(21);
  std::vector<json> questions, messages;
  std::vector<const TypeInfo*> asked;
  for (const TypeInfo* type : test::all_types()) {
    // Constants alone are no message to their reader.
    if (type->name == std::string("rcl_interfaces/msg/ParameterType")) continue;
    for (int round = 0; round < 3; ++round) {
      messages.push_back(test::random_message(*type, random));
      questions.push_back({{"name", type->name},
                           {"schema", type->schema},
                           {"payload", hex(from_json(*type, messages.back()))}});
      asked.push_back(type);
    }
  }
  const std::vector<json> answers = peer.answers(questions);
  ASSERT_EQ(answers.size(), questions.size());
  for (std::size_t i = 0; i < answers.size(); ++i) {
    const json& answer = answers[i];
    ASSERT_FALSE(answer.contains("error")) << answer << "\n" << asked[i]->schema;
    json theirs;
    ASSERT_EQ(to_json(*asked[i], bytes(answer["written"]), theirs), CdrError::none) << asked[i]->name;
    EXPECT_EQ(theirs, messages[i]) << asked[i]->name << ": what they wrote";
    // Their reader gives a time as {sec, nsec}: so compare as messages of ours.
    json read = answer["read"];
    json shaped;
    const std::function<void(json&)> rename = [&](json& value) {
      if (value.is_object() && value.contains("nsec")) value["nanosec"] = value["nsec"], value.erase("nsec");
      for (json& inner : value)
        if (inner.is_structured()) rename(inner);
    };
    rename(read);
    ASSERT_EQ(to_json(*asked[i], from_json(*asked[i], read), shaped), CdrError::none) << asked[i]->name;
    EXPECT_EQ(shaped, messages[i]) << asked[i]->name << ": what they read";
  }
}

}  // namespace
}  // namespace polyarm::messages
