#include <fmt/format.h>

#include <filesystem>
#include <map>
#include <vector>

#include "apps/options.hpp"
#include "apps/picture.hpp"
#include "apps/robots.hpp"
#include "polyarm/base/file.hpp"
#include "polyarm/base/text.hpp"
#include "polyarm/description/look.hpp"
#include "polyarm/ik/inverse_kinematics.hpp"
#include "polyarm/server/assets.hpp"
#include "polyarm/shapes/robot_shapes.hpp"

namespace polyarm::apps {

namespace {

namespace fs = std::filesystem;
using description::CatalogueEntry;
using description::RobotModel;

std::string cell_number(const std::optional<double>& value, const char* unit) {
  return value ? fmt::format("{:.4g} {}", *value, unit) : "–";
}

/// Text for a table cell: without | and line breaks.
std::string cell(std::string text) {
  for (std::size_t at = 0; (at = text.find_first_of("|\n", at)) != std::string::npos; ++at) text[at] = ' ';
  return text;
}

std::string solved_by(const RobotModel& model) {
  const ik::InverseKinematics arm(kinematics::Chain(model, model.tool_link()));
  return arm ? "closed form: " + arm.report() : "by iteration: " + arm.report();
}

std::string display(const RobotModel& model) {
  return model.controller_axes.empty() ? "not known" : model.provenance.controller_axes;
}

/// The page of one manufacturer: a picture of each robot and all facts of the catalogue besides numbers.
std::string maker_page(const std::string& maker,
                       const std::vector<std::pair<CatalogueEntry, RobotModel>>& robots) {
  std::string out = fmt::format(
      "# {}\n\nWritten by `polyarm robots page`; see [the index](README.md). Kinematics, limits and masses "
      "of each: "
      "`polyarm describe NAME`.\n",
      maker);
  for (const auto& [entry, model] : robots) {
    out += fmt::format("\n## {}\n\n<img src=\"{}.svg\" alt=\"{} at home\" width=\"260\">\n\n", entry.model,
                       entry.name, entry.model);
    out += fmt::format("`{}`: {} axes, reach {}, payload {}, mass {}{}.\n\n", entry.name, entry.axes,
                       cell_number(entry.reach_m, "m"), cell_number(entry.payload_kg, "kg"),
                       cell_number(entry.mass_kg, "kg"), entry.mass_estimated ? " (in part estimated)" : "");
    out += "- Inverse kinematics: " + solved_by(model) + "\n- The controller's display: " + display(model) +
           "\n- Source: " + model.provenance.source + " (" + model.provenance.licence + ")\n";
    for (const std::string& note : model.provenance.notes) out += "- " + note + "\n";
  }
  return out;
}

std::string index_page(
    const std::map<std::string, std::vector<std::pair<CatalogueEntry, RobotModel>>>& makers,
    std::size_t robots) {
  std::string out = fmt::format(
      "# The catalogue\n\n{} robots of {} makers at their home. Written by `polyarm robots page`; find by "
      "figures with `polyarm robots --axes 6 --reach '>=1.2'`; [looks](looks.md).\n\n",
      robots, makers.size());
  for (const auto& [folder, list] : makers)
    out += fmt::format("[{}](#{}) ({}) ", list.front().first.maker, folder, list.size());
  out += "\n";
  for (const auto& [folder, list] : makers) {
    out += fmt::format(
        "\n<a id=\"{0}\"></a>\n\n## [{1}]({0}.md)\n\n| | robot | axes | reach | payload | mass |\n"
        "|---|---|---|---|---|---|\n",
        folder, list.front().first.maker);
    for (const auto& [entry, model] : list)
      out += fmt::format(
          "| <img src=\"{0}.svg\" width=\"110\"> | {1}<br>`{0}` | {2} | {3} | {4} | {5}{6} |\n", entry.name,
          cell(entry.model), entry.axes, cell_number(entry.reach_m, "m"), cell_number(entry.payload_kg, "kg"),
          cell_number(entry.mass_kg, "kg"), entry.mass_estimated ? " (est.)" : "");
  }
  return out;
}

/// Measured distances between looks and meshes, by robot: lines of `polyarm robots fit --csv`. Empty without
/// the file.
std::map<std::string, std::vector<std::string>> fits_in(const fs::path& file) {
  std::map<std::string, std::vector<std::string>> out;
  std::error_code error;
  if (!fs::exists(file, error)) return out;
  for (const std::string& line : split_fields(read_file(file), '\n')) {
    std::vector<std::string> fields = split_fields(line, ',');
    if (fields.size() == 6) out[fields.front()] = std::move(fields);
  }
  return out;
}

/// "12 mm, 1.4 %"
std::string fit_text(const std::vector<std::string>& fields) {
  const double reach = parse_number(fields[3]).value_or(0), p95 = parse_number(fields[4]).value_or(0);
  return fmt::format("{:.0f} mm{}", 1000 * p95,
                     reach > 0 ? fmt::format(", {:.1f} %", 100 * p95 / reach) : "");
}

/// "surfaces, 21 kB", "boxes of 7 links" or "kinematics".
std::string made_from(const RobotModel& model, std::size_t outlines) {
  if (const auto look = model.look.find(description::kMeasuredLook); look != model.look.end())
    return fmt::format("surfaces, {:.0f} kB", static_cast<double>(fs::file_size(look->second)) / 1000);
  return outlines > 0 ? fmt::format("boxes of {} links", outlines) : "kinematics";
}

/// What each robot's look is made of, how large it is, and how far it is from the meshes of its maker.
std::string shapes_page(
    const std::map<std::string, std::vector<std::pair<CatalogueEntry, RobotModel>>>& makers,
    const std::map<std::string, std::vector<std::string>>& fits) {
  std::string rows;
  std::size_t robots = 0, measured = 0, boxed = 0;
  for (const auto& [folder, list] : makers)
    for (const auto& [entry, model] : list) {
      std::size_t outlines = 0, triangles = 0;
      for (const description::Link& link : model.links) outlines += link.outline.has_value();
      Problems ignored;
      const auto bodies = shapes::robot_shapes(model, ignored);
      for (const shapes::LinkShape& body : bodies) triangles += meshes::triangles_of(body.mesh);
      const auto fit = fits.find(entry.name);
      rows += fmt::format("| `{}` | {} | {} | {} | {:.0f} |", entry.name, bodies.size(),
                          made_from(model, outlines), triangles,
                          static_cast<double>(server::zipped(shapes::robot_glb(model)).size()) / 1000);
      if (!fits.empty()) rows += " " + (fit == fits.end() ? "–" : fit_text(fit->second)) + " |";
      rows += "\n";
      ++robots;
      measured += model.look.contains(description::kMeasuredLook);
      boxed += outlines > 0 && !model.look.contains(description::kMeasuredLook);
    }
  const char* const about_fit =
      fits.empty() ? ""
                   : " *Fit*: 95 % of the visible surfaces of look and meshes are nearer to each "
                     "other than this, at home; in % of "
                     "the reach (`polyarm robots fit`); – where no mesh was compared.";
  return fmt::format(
             "# Looks of the catalogue\n\nWritten by `polyarm robots page`. The surfaces of {} of {} robots "
             "were measured on meshes of public descriptions (decision 0033). Those of {} are made from a "
             "measured box around each link and the style of the maker (decision 0025), the others from "
             "the kinematics.{}\n\n"
             "| robot | bodies | made from | triangles | kB, compressed |{}\n|---|---|---|---|---|{}\n",
             measured, robots, boxed, about_fit, fits.empty() ? "" : " fit |", fits.empty() ? "" : "---|") +
         rows;
}

void write(const fs::path& file, const std::string& text) {
  fs::create_directories(file.parent_path());
  write_file_atomically(file, text);
}

}  // namespace

int run_robots_picture(int argc, char** argv) {
  CommandLine app("Draws a robot as SVG", "polyarm robots picture");
  RobotOption robot;
  std::vector<double> joints;
  robot.add_to(app)->required();
  app.add_option("--joints", joints, "one value for each joint, rad or m (home by default)")->expected(-1);
  app.footer(examples({"polyarm robots picture kuka/kr_16_2 > kr16.svg",
                       "polyarm robots picture my_arm.urdf --joints 0 -1 1 0 0 0 > arm.svg"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  Problems warnings;
  const RobotModel model = robot.load(warnings, open_catalogue());
  if (joints.empty()) joints = model.start();
  if (joints.size() != model.actuated.size())
    throw Error("bad-value",
                fmt::format("--joints takes {} numbers for this robot ({}), here are {}",
                            model.actuated.size(), join(model.joint_names(), " "), joints.size()));
  fmt::print("{}", picture_of(model, joints));
  return kOk;
}

int run_robots_page(int argc, char** argv) {
  CommandLine app(
      "Writes pages of the whole catalogue: an index, one page for each maker, one picture for each robot",
      "polyarm robots page");
  std::string folder, catalogue_folder;
  app.add_option("folder", folder, "output folder; existing files are overwritten")->required();
  app.add_option("--catalogue", catalogue_folder, "the folder of robots (default: the catalogue)")
      ->existing_folder();
  app.footer(
      examples({"polyarm robots page docs/robots", "polyarm robots page pages --catalogue my/robots"}));
  if (const auto code = app.parse(argc, argv)) return *code;
  const description::Catalogue catalogue =
      catalogue_folder.empty() ? open_catalogue() : description::Catalogue({catalogue_folder});
  std::map<std::string, std::vector<std::pair<CatalogueEntry, RobotModel>>> makers;
  std::size_t count = 0;
  fs::path fits;  // beside the folders of the makers
  for (const CatalogueEntry& entry : catalogue.entries()) {
    if (const auto file = catalogue.find(entry.name); file && fits.empty())
      fits = file->parent_path().parent_path() / "look_fit.csv";
    RobotModel model = catalogue.load(entry.name);
    write(fs::path(folder) / (entry.name + ".svg"), picture_of(model, model.start()));
    makers[entry.name.substr(0, entry.name.find('/'))].emplace_back(entry, std::move(model));
    ++count;
  }
  for (const auto& [maker, list] : makers)
    write(fs::path(folder) / (maker + ".md"), maker_page(list.front().first.maker, list));
  write(fs::path(folder) / "README.md", index_page(makers, count));
  write(fs::path(folder) / "looks.md", shapes_page(makers, fits_in(fits)));
  fmt::print("{} robots of {} makers written to {}\n", count, makers.size(), folder);
  return kOk;
}

}  // namespace polyarm::apps
