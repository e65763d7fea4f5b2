#include "polyarm/catalogue/catalogue_index.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <string>

#include "polyarm/base/file.hpp"

namespace polyarm::description::catalogue_index_test {
namespace {

namespace fs = std::filesystem;

class CatalogueIndexes : public ::testing::Test {
 protected:
  CatalogueIndexes() : folder_{fs::path(::testing::TempDir()) / ("polyarm-catalogue-index-" + std::to_string(::getpid()))} {
    fs::remove_all(folder_);
    fs::create_directories(folder_);
    write(robot(), "a robot");
  }
  ~CatalogueIndexes() override { fs::remove_all(folder_); }
  static void write(const fs::path& file, const std::string& text) { std::ofstream(file) << text; }
  fs::path file() const { return folder_ / "cache" / "catalogue"; }
  fs::path robot() const { return folder_ / "robot.yaml"; }
  CatalogueEntry entry() const {
    return {"maker/model", "Maker & Sons", "M 1", 7, 0.855, {}, 18.25, true, robot()};
  }
  void keep() const {
    CatalogueIndex index(file());
    index.add(entry());
    index.save();
  }

  const fs::path folder_;
};

TEST_F(CatalogueIndexes, KeepWhatARobotFileSaid) {
  EXPECT_FALSE(CatalogueIndex(file()).find(robot()));
  keep();
  const auto found = CatalogueIndex(file()).find(robot());
  ASSERT_TRUE(found);
  EXPECT_EQ(found->name, "maker/model");
  EXPECT_EQ(found->maker, "Maker & Sons");
  EXPECT_EQ(found->model, "M 1");
  EXPECT_EQ(found->axes, 7);
  EXPECT_EQ(found->reach_m, 0.855);
  EXPECT_FALSE(found->payload_kg);
  EXPECT_EQ(found->mass_kg, 18.25);
  EXPECT_TRUE(found->mass_estimated);
  EXPECT_EQ(found->file, robot());
}

TEST_F(CatalogueIndexes, KeepARobotOfWhichLittleIsKnown) {
  CatalogueEntry bare;
  bare.name = "maker/model";
  bare.file = robot();
  CatalogueIndex index(file());
  index.add(bare);
  index.save();
  const auto found = CatalogueIndex(file()).find(robot());
  ASSERT_TRUE(found);
  EXPECT_EQ(found->name, "maker/model");
  EXPECT_TRUE(found->maker.empty());
  EXPECT_FALSE(found->mass_kg);
  EXPECT_FALSE(found->mass_estimated);
}

TEST_F(CatalogueIndexes, ForgetAFileThatWasChangedOrIsGone) {
  keep();
  write(robot(), "another robot");
  EXPECT_FALSE(CatalogueIndex(file()).find(robot()));
  keep();
  EXPECT_TRUE(CatalogueIndex(file()).find(robot()));
  fs::remove(robot());
  EXPECT_FALSE(CatalogueIndex(file()).find(robot()));
}

TEST_F(CatalogueIndexes, AreMadeAnewWhereTheyAreDamaged) {
  keep();
  const std::string good = read_file(file());
  for (std::size_t size = 0; size < good.size(); size += 3) {
    write(file(), good.substr(0, size));
    const auto found = CatalogueIndex(file()).find(robot());
    EXPECT_FALSE(found && (found->name != "maker/model" || found->axes != 7)) << size;
  }
  write(file(), "polyarm: catalogue-index/1 of another build" + good.substr(good.find('\n')));
  EXPECT_FALSE(CatalogueIndex(file()).find(robot()));
}

TEST_F(CatalogueIndexes, SayNothingWrongWhicheverByteIsDamaged) {
  keep();
  const std::string good = read_file(file());
  for (std::size_t at = 0; at < good.size(); ++at) {
    std::string damaged = good;
    damaged[at] = static_cast<char>(damaged[at] ^ 1);
    write(file(), damaged);
    EXPECT_FALSE(CatalogueIndex(file()).find(robot())) << at;
  }
}

TEST_F(CatalogueIndexes, ForgetAFileThatWasReplacedAtTheSameSizeAndTime) {
  keep();
  const fs::file_time_type time = fs::last_write_time(robot());
  write(robot(), "a ROBOT");
  fs::last_write_time(robot(), time);
  EXPECT_FALSE(CatalogueIndex(file()).find(robot()));
}

TEST_F(CatalogueIndexes, AreNotWrittenThroughALink) {
  write(folder_ / "precious", "do not touch");
  fs::create_directories(file().parent_path());
  fs::create_symlink(folder_ / "precious", file());
  keep();
  EXPECT_EQ(read_file(folder_ / "precious"), "do not touch");
}

TEST_F(CatalogueIndexes, AreNoErrorWhereNothingCanBeWritten) {
  write(folder_ / "cache", "a file where the folder would be");
  keep();
  EXPECT_FALSE(CatalogueIndex(file()).find(robot()));
  EXPECT_EQ(read_file(folder_ / "cache"), "a file where the folder would be");
}

TEST_F(CatalogueIndexes, LeaveOutWhatHasNoLineOfItsOwn) {
  CatalogueEntry odd = entry();
  odd.maker = "two\nlines";
  CatalogueIndex index(file());
  index.add(odd);
  index.save();
  EXPECT_FALSE(CatalogueIndex(file()).find(robot()));
}

TEST_F(CatalogueIndexes, AreNothingWithoutAPlace) {
  CatalogueIndex index{fs::path()};
  index.add(entry());
  index.save();
  EXPECT_FALSE(index.find(robot()));
}

}  // namespace
}  // namespace polyarm::description::catalogue_index_test
