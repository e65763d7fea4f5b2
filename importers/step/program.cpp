/// polyarm_step_import: reads one STEP file with Open CASCADE, computes triangles near its surfaces, and
/// writes them to the process that started it.
#include <BRepBndLib.hxx>
#include <BRepMesh_IncrementalMesh.hxx>
#include <BRep_Tool.hxx>
#include <Bnd_Box.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Poly_Triangulation.hxx>
#include <Quantity_Color.hxx>
#include <STEPCAFControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <TDocStd_Document.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Face.hxx>
#include <XCAFDoc_ColorTool.hxx>
#include <XCAFDoc_DocumentTool.hxx>
#include <XCAFDoc_ShapeTool.hxx>
#include <XCAFPrs_DocumentExplorer.hxx>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "importers/importer.hpp"
#include "polyarm/base/bounds.hpp"

namespace polyarm::meshes {
namespace {

/// Open CASCADE gives millimetres.
constexpr double kMetres = 1e-3;
/// Distance of triangles from the surface, of the size of the shape, and angle between them.
constexpr double kAway = 5e-4, kAngle = 0.35;

using Color = std::array<float, 4>;

Color color_of(const Quantity_Color& from) {
  double r = 0, g = 0, b = 0;
  from.Values(r, g, b, Quantity_TOC_sRGB);
  return {static_cast<float>(r), static_cast<float>(g), static_cast<float>(b), 1};
}

std::optional<Color> own_color(const Handle(XCAFDoc_ColorTool) & tool, const TopoDS_Shape& shape) {
  Quantity_Color color;
  for (const XCAFDoc_ColorType type : {XCAFDoc_ColorSurf, XCAFDoc_ColorGen})
    if (tool->GetColor(shape, type, color)) return color_of(color);
  return std::nullopt;
}

/// Parts of one colour each.
class Triangles {
 public:
  void add(const TopoDS_Face& face, const TopLoc_Location& at, const std::optional<Color>& color) {
    TopLoc_Location own;
    const Handle(Poly_Triangulation) mesh = BRep_Tool::Triangulation(face, own);
    if (mesh.IsNull()) return;
    if ((count_ += static_cast<std::size_t>(mesh->NbTriangles())) > kMostTriangles)
      throw Refused{"its surfaces need too many triangles"};
    MeshPart& part = parts_[color.value_or(Color{-1, -1, -1, -1})];
    if (color) part.color = *color;
    part.colored = color.has_value();
    const gp_Trsf place = (at * own).Transformation();
    const auto first = static_cast<std::uint32_t>(part.positions.size());
    for (int i = 1; i <= mesh->NbNodes(); ++i) {
      const gp_Pnt p = mesh->Node(i).Transformed(place);
      part.positions.push_back({static_cast<float>(kMetres * p.X()), static_cast<float>(kMetres * p.Y()),
                                static_cast<float>(kMetres * p.Z())});
    }
    const bool turned = (face.Orientation() == TopAbs_REVERSED) != place.IsNegative();
    for (int i = 1; i <= mesh->NbTriangles(); ++i) {
      int a = 0, b = 0, c = 0;
      mesh->Triangle(i).Get(a, b, c);
      if (turned) std::swap(b, c);
      for (const int corner : {a, b, c})
        part.triangles.push_back(first + static_cast<std::uint32_t>(corner - 1));
    }
  }
  Mesh mesh() {
    Mesh out;
    for (auto& [color, part] : parts_) out.push_back(std::move(part));
    return out;
  }

 private:
  std::map<Color, MeshPart> parts_;
  std::size_t count_ = 0;
};

double size_of(const TopoDS_Shape& shape) {
  Bnd_Box box;
  BRepBndLib::Add(shape, box);
  return box.IsVoid() ? 1 : std::sqrt(box.SquareExtent());
}

void add_shape(const XCAFPrs_DocumentNode& node, const Handle(XCAFDoc_ColorTool) & colors, Triangles& out) {
  TopoDS_Shape shape;
  if (!XCAFDoc_ShapeTool::GetShape(node.RefLabel, shape)) return;
  BRepMesh_IncrementalMesh(shape, kAway * size_of(shape), Standard_False, kAngle);
  std::optional<Color> whole = own_color(colors, shape);
  if (node.Style.IsSetColorSurf()) whole = color_of(node.Style.GetColorSurf());
  for (TopExp_Explorer solid(shape, TopAbs_FACE); solid.More(); solid.Next()) {
    const TopoDS_Face face = TopoDS::Face(solid.Current());
    const std::optional<Color> own = own_color(colors, face);
    out.add(face, node.Location, own ? own : whole);
  }
}

Mesh read(const std::string& bytes, const std::string&) {
  Message::DefaultMessenger()->ChangePrinters().Clear();  // errors reach the caller as one sentence
  try {
    STEPCAFControl_Reader reader;
    reader.SetColorMode(Standard_True);
    reader.SetNameMode(Standard_False);
    std::istringstream stream(bytes);
    if (reader.ChangeReader().ReadStream("file", stream) != IFSelect_RetDone)
      throw Refused{"it is not a whole STEP file"};
    Handle(TDocStd_Document) document = new TDocStd_Document("BinXCAF");
    if (!reader.Transfer(document)) throw Refused{"it has no shape"};
    const Handle(XCAFDoc_ColorTool) colors = XCAFDoc_DocumentTool::ColorTool(document->Main());
    Triangles out;
    for (XCAFPrs_DocumentExplorer at(document, XCAFPrs_DocumentExplorerFlags_OnlyLeafNodes); at.More();
         at.Next())
      add_shape(at.Current(), colors, out);
    return out.mesh();
  } catch (const Standard_Failure& failure) {
    throw Refused{std::string("Open CASCADE: ") + failure.GetMessageString()};
  }
}

}  // namespace
}  // namespace polyarm::meshes

int main(int argc, char** argv) {
  constexpr std::size_t kMostMemory = polyarm::bounds::kStepImportMemory;  // bytes
  return polyarm::meshes::run_importer(argc, argv, kMostMemory, polyarm::meshes::read);
}
