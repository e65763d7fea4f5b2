#pragma once
/// The reader and writer of each data set format, and what they share. Private to this room.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/data/data_set.hpp"

namespace polyarm::data {

/// Quoted as in JSON and in the program language.
std::string quoted(const std::string& text);

/// x y z roll pitch yaw, or x y z qx qy qz qw if the point was written that way.
std::vector<double> numbers_of(const Point& point);
/// From six or seven numbers; normalises a quaternion. Empty if the numbers are not a pose.
std::optional<Point> point_from(const std::vector<double>& numbers);

// Each reads valid entries into `out` and reports the others in `problems`.
void read_csv(std::string_view text, const std::string& file, DataSet& out, Problems& problems);
void read_json(std::string_view text, const std::string& file, DataSet& out, Problems& problems);
void read_yaml(std::string_view text, const std::string& file, DataSet& out, Problems& problems);
void read_srdf(std::string_view text, const std::string& file, DataSet& out, Problems& problems);

std::string write_csv(const DataSet& set);
std::string write_json(const DataSet& set);
std::string write_yaml(const DataSet& set);
std::string write_srdf(const DataSet& set, const std::string& group, Problems& problems);

}  // namespace polyarm::data
