#pragma once
/// What the forms of data sets share, and each of them. Private to the room.
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "polyarm/base/error.hpp"
#include "polyarm/data/data_set.hpp"

namespace polyarm::data {

/// In quotes, as JSON and the language have it.
std::string quoted(const std::string& text);

/// x y z roll pitch yaw, or x y z qx qy qz qw where the point was written so.
std::vector<double> numbers_of(const Point& point);
/// Six or seven numbers; a quaternion is made one. Nothing where they are no pose.
std::optional<Point> point_from(const std::vector<double>& numbers);

// Each reads what is right into `out`; what is not goes to `problems`.
void read_csv(std::string_view text, const std::string& file, DataSet& out, Problems& problems);
void read_json(std::string_view text, const std::string& file, DataSet& out, Problems& problems);
void read_yaml(std::string_view text, const std::string& file, DataSet& out, Problems& problems);
void read_srdf(std::string_view text, const std::string& file, DataSet& out, Problems& problems);

std::string write_csv(const DataSet& set);
std::string write_json(const DataSet& set);
std::string write_yaml(const DataSet& set);
std::string write_srdf(const DataSet& set, const std::string& group, Problems& problems);

}  // namespace polyarm::data
