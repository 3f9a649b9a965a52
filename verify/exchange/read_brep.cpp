#include "verify/exchange/read_brep.h"

#include <BRepAdaptor_Curve.hxx>
#include <BRepBndLib.hxx>
#include <BRepBuilderAPI_MakeSolid.hxx>
#include <BRepBuilderAPI_Sewing.hxx>
#include <BRepCheck_Analyzer.hxx>
#include <BRepLib.hxx>
#include <BRepTools.hxx>
#include <BRep_Builder.hxx>
#include <BRep_Tool.hxx>
#include <BinTools.hxx>
#include <Bnd_Box.hxx>
#include <Geom_Curve.hxx>
#include <IFSelect_ReturnStatus.hxx>
#include <IGESControl_Controller.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESSolid_EdgeList.hxx>
#include <IGESSolid_Face.hxx>
#include <IGESSolid_Loop.hxx>
#include <IGESSolid_ManifoldSolid.hxx>
#include <IGESSolid_Shell.hxx>
#include <IGESSolid_VertexList.hxx>
#include <Interface_Static.hxx>
#include <Message.hxx>
#include <Message_Messenger.hxx>
#include <Message_Printer.hxx>
#include <OSD.hxx>
#include <STEPControl_Reader.hxx>
#include <Standard_Failure.hxx>
#include <Standard_OutOfMemory.hxx>
#include <Standard_Version.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Shape.hxx>
#include <TopoDS_Shell.hxx>
#include <TopoDS_Solid.hxx>
#include <TopoDS_Vertex.hxx>
#include <algorithm>
#include <cmath>
#include <limits>
#include <new>
#include <sstream>

#include "core/number.h"
#include "geometry/mesh/mesh_distance.h"
#include "geometry/mesh/mesh_facets.h"
#include "verify/evaluate/solid.h"
#include "verify/exchange/brep_distance.h"
#include "verify/exchange/check_exchange.h"
#include "verify/exchange/iges_tree.h"
#include "verify/exchange/mesh_shape.h"
#include "verify/report/words.h"

namespace partscribe::verify {
namespace {

void silence() {
  Message::DefaultMessenger()->RemovePrinters(STANDARD_TYPE(Message_Printer));
  IGESControl_Controller::Init();
}

int count(const TopoDS_Shape& shape, TopAbs_ShapeEnum kind) {
  int n = 0;
  for (TopExp_Explorer e(shape, kind); e.More(); e.Next()) ++n;
  return n;
}

/// How far apart the edges that nothing was sewn to are, where that is farthest: from the middle of each to the next of
/// the others.
BrepGap widest_seam(const BRepBuilderAPI_Sewing& sewing) {
  constexpr int pieces = 16, most_edges = 1000;  // of the polygon that stands for an edge
  std::vector<std::vector<Vec3>> edges;
  for (int i = 1; i <= std::min(sewing.NbFreeEdges(), most_edges); ++i) {
    if (BRep_Tool::Degenerated(sewing.FreeEdge(i))) continue;
    const BRepAdaptor_Curve curve(sewing.FreeEdge(i));
    std::vector<Vec3> places;
    for (int k = 0; k <= pieces; ++k) {
      const gp_Pnt p =
          curve.Value(curve.FirstParameter() + (curve.LastParameter() - curve.FirstParameter()) * k / pieces);
      places.emplace_back(p.X(), p.Y(), p.Z());
    }
    edges.push_back(std::move(places));
  }
  BrepGap gap;
  for (std::size_t i = 0; i < edges.size(); ++i) {
    const Vec3& middle = edges[i][pieces / 2];
    double least = std::numeric_limits<double>::infinity();
    for (std::size_t j = 0; j < edges.size(); ++j)
      for (int k = 0; j != i && k < pieces; ++k) {
        const Vec3 &from = edges[j][k], along = edges[j][k + 1] - from;
        const double length = along.squaredNorm(),
                     t = length > 0 ? std::clamp((middle - from).dot(along) / length, 0.0, 1.0) : 0;
        least = std::min(least, (from + t * along - middle).norm());
      }
    if (std::isfinite(least) && least > gap.width) gap = {least, "seam", middle};
  }
  return gap;
}

/// Solids, and how far faces are apart that could not be sewn together.
struct Sewn {
  TopoDS_Shape shape;
  BrepGap seam;
};

/// Loose faces sewn together and closed shells made solids; files that hold solids come back as they are. Edges are
/// united at the least of several distances that leaves no edge free, at most the share of the tolerance within which a
/// file must agree with itself.
Sewn as_solids(const TopoDS_Shape& shape, double tolerance) {
  if (count(shape, TopAbs_SOLID) > 0) return {shape, {}};
  constexpr double rounding = 1e-4;  // mm; faces mode keeps every edge twice, rounded to 9 digits
  const double widest = std::max(rounding, share_of_gap * tolerance);
  Sewn result{shape, {}};
  TopoDS_Shape sewn;
  for (double reach = rounding;; reach = std::min(10 * reach, widest)) {
    BRepBuilderAPI_Sewing sewing(reach);
    sewing.Add(shape);
    sewing.Perform();
    if (sewing.SewedShape().IsNull()) return result;
    sewn = sewing.SewedShape();
    result.seam = widest_seam(sewing);
    if (sewing.NbFreeEdges() == 0 || reach >= widest) break;
  }
  TopoDS_Compound all;
  BRep_Builder builder;
  builder.MakeCompound(all);
  for (TopExp_Explorer shells(sewn, TopAbs_SHELL); shells.More(); shells.Next()) {
    const TopoDS_Shell shell = TopoDS::Shell(shells.Current());
    BRepBuilderAPI_MakeSolid maker(shell);
    if (BRep_Tool::IsClosed(shell) && maker.IsDone()) {
      TopoDS_Solid solid = maker.Solid();
      BRepLib::OrientClosedSolid(solid);
      builder.Add(all, solid);
    } else {
      builder.Add(all, shell);
    }
  }
  for (TopExp_Explorer faces(sewn, TopAbs_FACE, TopAbs_SHELL); faces.More(); faces.Next())
    builder.Add(all, faces.Current());
  result.shape = all;
  return result;
}

/// Largest distance from the corners and centres of `from` to `to`.
double one_way(const TriangleMesh& from, const MeshDistance& to) {
  double worst = 0;
  std::vector<Vec3> places = from.vertices;
  for (std::size_t t = 0; t < from.triangles.size(); ++t)
    places.push_back((from.corner(t, 0) + from.corner(t, 1) + from.corner(t, 2)) / 3);
  for (const auto& hit : to.closest(places, 1)) worst = std::max(worst, hit.distance);
  return worst;
}

/// How finely to mesh the shape: a kilometre to a hundredth of a millimetre would take hours, and is no scanned part.
double mesh_tolerance(const TopoDS_Shape& shape, const EvaluateOptions& options) {
  constexpr double far_too_large = 50;
  if (!(options.scanned_size > 0)) return options.tolerance;
  Bnd_Box box;
  BRepBndLib::Add(shape, box, Standard_False);
  if (box.IsVoid()) return options.tolerance;
  return options.tolerance * std::max(1.0, std::sqrt(box.SquareExtent()) / (far_too_large * options.scanned_size));
}

/// The largest tolerance of a vertex or an edge: how far curves and faces that should meet are apart. The readers widen
/// it without a word until the file agrees with itself.
BrepGap largest_gap(const TopoDS_Shape& shape) {
  BrepGap gap;
  auto offer = [&](double width, const char* kind, auto&& place) {
    if (width > gap.width) gap = {width, kind, place()};
  };
  auto vec = [](const gp_Pnt& p) { return Vec3(p.X(), p.Y(), p.Z()); };
  for (TopExp_Explorer e(shape, TopAbs_VERTEX); e.More(); e.Next()) {
    const TopoDS_Vertex vertex = TopoDS::Vertex(e.Current());
    offer(BRep_Tool::Tolerance(vertex), "vertex", [&] { return vec(BRep_Tool::Pnt(vertex)); });
  }
  for (TopExp_Explorer e(shape, TopAbs_EDGE); e.More(); e.Next()) {
    const TopoDS_Edge edge = TopoDS::Edge(e.Current());
    offer(BRep_Tool::Tolerance(edge), "edge", [&] {
      double first = 0, last = 0;
      const Handle(Geom_Curve) curve = BRep_Tool::Curve(edge, first, last);
      if (!curve.IsNull()) return vec(curve->Value((first + last) / 2));
      const TopoDS_Vertex start = TopExp::FirstVertex(edge);
      return start.IsNull() ? Vec3(Vec3::Zero()) : vec(BRep_Tool::Pnt(start));
    });
  }
  return gap;
}

/// The body as bytes, if its exact surfaces can be asked; empty else. Asking is tried here, where it may take too long.
std::string askable_body(const TopoDS_Shape& body) {
  if (!BrepDistance::make(body)) return {};
  BRepTools::Clean(body);
  std::ostringstream bytes(std::ios::binary);
  BinTools::Write(body, bytes);
  return bytes.str();
}

void take_shape(BrepReading& reading, const TopoDS_Shape& shape, double tolerance) {
  Evaluation& evaluation = reading.evaluation;
  const auto [body, seam] = as_solids(shape, tolerance);
  evaluation.gap = largest_gap(body);
  if (!BRepCheck_Analyzer(body).IsValid()) {
    evaluation.failed = true;
    evaluation.complaints.push_back("OpenCASCADE's checker finds the geometry invalid");
  }
  ShapeMesh meshed = mesh_shape(body, tolerance);
  if (count(shape, TopAbs_SOLID) == 0)
    orient_facets(meshed.mesh), turn_outward(meshed.mesh);  // the sense of loose faces means nothing
  auto check = check_solid(meshed.mesh);
  evaluation.mesh = std::move(check.mesh);
  evaluation.error = meshed.error;
  evaluation.solid = check.solid;
  if (!check.solid && seam.width > 0 && count(shape, TopAbs_FACE) > 1)
    evaluation.complaints.push_back("its faces do not meet: they are up to " + shown(seam.width, 0.0001) +
                                    " mm apart, near " + Words(tolerance).place(seam.place));
  for (auto& fault : check.faults) evaluation.complaints.push_back(std::move(fault));
  // Flat faces are their mesh; and without a solid the shape's own orientation says nothing.
  if (evaluation.solid && evaluation.error > 1e-6 * tolerance && count(body, TopAbs_SOLID) > 0)
    reading.body = askable_body(body);
  // A shell with a gap is not made whole by a loose face that happens to lie in it.
  if (check.solid)
    for (TopExp_Explorer shells(shape, TopAbs_SHELL); shells.More(); shells.Next())
      if (!BRep_Tool::IsClosed(TopoDS::Shell(shells.Current()))) {
        evaluation.failed = true;
        evaluation.complaints.push_back(
            "a shell of the file is open: " + std::to_string(count(shells.Current(), TopAbs_FACE)) +
            " faces that do not close, with loose faces beside it");
        break;
      }
}

void compare_with_tree(BrepReading& reading, IGESControl_Reader& reader, bool has_body,
                       const EvaluateOptions& options) {
  Evaluation& evaluation = reading.evaluation;
  TopoDS_Shape tree_shape;
  const IgesTree tree = evaluate_iges_tree(reader, tree_shape);
  if (!tree.present) return;
  auto refuse = [&](std::string why) {
    evaluation.failed = true;
    evaluation.complaints.push_back(std::move(why));
  };
  if (tree.fault) return refuse("the file's boolean tree cannot be evaluated: " + *tree.fault);
  const double tolerance = mesh_tolerance(tree_shape, options);
  if (!has_body) return take_shape(reading, tree_shape, tolerance);
  const ShapeMesh meshed = mesh_shape(tree_shape, tolerance);
  if (meshed.mesh.empty()) return refuse("the file's boolean tree describes nothing");
  if (evaluation.mesh.empty()) return;
  const double apart = std::max(one_way(meshed.mesh, MeshDistance(evaluation.mesh)),
                                one_way(evaluation.mesh, MeshDistance(meshed.mesh)));
  if (apart > tolerance / 5 + meshed.error + evaluation.error)
    refuse("the file's boolean tree and its body differ by " + shown(apart, 0.0001) + " mm");
}

/// Runs `read` where no exception of OpenCASCADE escapes; only memory that runs out does.
template <class Read>
BrepReading guarded(const char* backend, Read&& read) {
  silence();
  BrepReading reading;
  Evaluation& evaluation = reading.evaluation;
  evaluation.backend = backend;
  evaluation.program = "OpenCASCADE";
  evaluation.version = OCC_VERSION_COMPLETE;
  try {
    Interface_Static::SetCVal("xstep.cascade.unit", "MM");
    read(reading);
  } catch (const Standard_OutOfMemory&) {
    throw std::bad_alloc();
  } catch (const Standard_Failure& failure) {
    evaluation.failed = true;
    const char* text = failure.GetMessageString();
    evaluation.complaints.push_back(std::string("OpenCASCADE gave up: ") +
                                    (text && *text ? text : failure.DynamicType()->Name()));
  }
  return reading;
}

/// True if part of a body refers to nothing, or to something of another kind: OpenCASCADE would follow it all the same.
bool refers_to_nothing(const Handle(IGESData_IGESModel) & model) {
  for (int n = 1; n <= model->NbEntities(); ++n) {
    const auto entity = model->Entity(n);
    if (const auto solid = Handle(IGESSolid_ManifoldSolid)::DownCast(entity); !solid.IsNull()) {
      if (solid->Shell().IsNull()) return true;
      for (int i = 1; i <= solid->NbVoidShells(); ++i)
        if (solid->VoidShell(i).IsNull()) return true;
    } else if (const auto shell = Handle(IGESSolid_Shell)::DownCast(entity); !shell.IsNull()) {
      for (int i = 1; i <= shell->NbFaces(); ++i)
        if (shell->Face(i).IsNull()) return true;
    } else if (const auto face = Handle(IGESSolid_Face)::DownCast(entity); !face.IsNull()) {
      if (face->Surface().IsNull()) return true;
      for (int i = 1; i <= face->NbLoops(); ++i)
        if (face->Loop(i).IsNull()) return true;
    } else if (const auto loop = Handle(IGESSolid_Loop)::DownCast(entity); !loop.IsNull()) {
      for (int i = 1; i <= loop->NbEdges(); ++i)
        if (loop->Edge(i).IsNull()) return true;
    } else if (const auto edges = Handle(IGESSolid_EdgeList)::DownCast(entity); !edges.IsNull()) {
      for (int i = 1; i <= edges->NbEdges(); ++i)
        if (edges->Curve(i).IsNull() || edges->StartVertexList(i).IsNull() || edges->EndVertexList(i).IsNull())
          return true;
    }
  }
  return false;
}

}  // namespace

Result<BrepReading> read_iges(const Path& path, const EvaluateOptions& options) {
  const auto text = read_file(path);
  if (!text.ok()) return text.error();
  return guarded("iges", [&](BrepReading& reading) {
    Evaluation& evaluation = reading.evaluation;
    if (const auto fault = fault_of_iges(*text)) {
      evaluation.failed = true;
      evaluation.complaints.push_back("the file is not whole: " + *fault);
      return;
    }
    IGESControl_Reader reader;
    if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) {
      evaluation.failed = true;
      evaluation.complaints.push_back("OpenCASCADE cannot read the file as IGES");
      return;
    }
    if (refers_to_nothing(reader.IGESModel())) {
      evaluation.failed = true;
      evaluation.complaints.push_back("the file is not whole: a face, loop or edge of its body refers to nothing");
      return;
    }
    reader.TransferRoots();
    const bool has_body = reader.NbShapes() > 0 && count(reader.OneShape(), TopAbs_FACE) > 0;
    if (has_body) take_shape(reading, reader.OneShape(), mesh_tolerance(reader.OneShape(), options));
    compare_with_tree(reading, reader, has_body, options);
    if (evaluation.mesh.empty() && !evaluation.failed) {
      evaluation.failed = true;
      evaluation.complaints.push_back("the file holds no surface");
    }
  });
}

Result<BrepReading> read_step(const Path& path, const EvaluateOptions& options) {
  const auto text = read_file(path);
  if (!text.ok()) return text.error();
  return guarded("step", [&](BrepReading& reading) {
    Evaluation& evaluation = reading.evaluation;
    if (const auto fault = fault_of_step(*text)) {
      evaluation.failed = true;
      evaluation.complaints.push_back("the file is not whole: " + *fault);
      return;
    }
    STEPControl_Reader reader;
    if (reader.ReadFile(path.c_str()) != IFSelect_RetDone) {
      evaluation.failed = true;
      evaluation.complaints.push_back("OpenCASCADE cannot read the file as STEP");
      return;
    }
    reader.TransferRoots();
    if (reader.NbShapes() == 0 || count(reader.OneShape(), TopAbs_FACE) == 0) {
      evaluation.failed = true;
      evaluation.complaints.push_back("the file holds no surface");
      return;
    }
    take_shape(reading, reader.OneShape(), mesh_tolerance(reader.OneShape(), options));
  });
}

}  // namespace partscribe::verify
