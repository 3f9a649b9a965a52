#include "verify/exchange/iges_tree.h"

#include <BRepAlgoAPI_Common.hxx>
#include <BRepAlgoAPI_Cut.hxx>
#include <BRepAlgoAPI_Fuse.hxx>
#include <BRepBuilderAPI_GTransform.hxx>
#include <BRepBuilderAPI_MakeEdge.hxx>
#include <BRepBuilderAPI_MakeFace.hxx>
#include <BRepBuilderAPI_MakeWire.hxx>
#include <BRepBuilderAPI_Transform.hxx>
#include <BRepLib.hxx>
#include <BRepPrimAPI_MakeBox.hxx>
#include <BRepPrimAPI_MakeCone.hxx>
#include <BRepPrimAPI_MakeCylinder.hxx>
#include <BRepPrimAPI_MakePrism.hxx>
#include <BRepPrimAPI_MakeRevol.hxx>
#include <BRepPrimAPI_MakeSphere.hxx>
#include <BRepPrimAPI_MakeTorus.hxx>
#include <BRepPrimAPI_MakeWedge.hxx>
#include <BRep_Builder.hxx>
#include <IGESControl_Reader.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESData_IGESModel.hxx>
#include <IGESGeom_TransformationMatrix.hxx>
#include <IGESSolid_Block.hxx>
#include <IGESSolid_BooleanTree.hxx>
#include <IGESSolid_ConeFrustum.hxx>
#include <IGESSolid_Cylinder.hxx>
#include <IGESSolid_Ellipsoid.hxx>
#include <IGESSolid_RightAngularWedge.hxx>
#include <IGESSolid_SolidAssembly.hxx>
#include <IGESSolid_SolidInstance.hxx>
#include <IGESSolid_SolidOfLinearExtrusion.hxx>
#include <IGESSolid_SolidOfRevolution.hxx>
#include <IGESSolid_Sphere.hxx>
#include <IGESSolid_Torus.hxx>
#include <Standard_Failure.hxx>
#include <TopExp.hxx>
#include <TopExp_Explorer.hxx>
#include <TopoDS.hxx>
#include <TopoDS_Compound.hxx>
#include <TopoDS_Edge.hxx>
#include <TopoDS_Wire.hxx>
#include <cmath>
#include <gp_Ax1.hxx>
#include <gp_Ax2.hxx>
#include <gp_Ax3.hxx>
#include <gp_GTrsf.hxx>
#include <set>
#include <stdexcept>
#include <vector>

namespace partscribe::verify {
namespace {

using Entity = Handle(IGESData_IGESEntity);

template <class T>
Handle(T) as(const Entity& entity) {
  return Handle(T)::DownCast(entity);
}

/// The tree cannot be evaluated; caught in evaluate_iges_tree.
struct TreeFault : std::runtime_error {
  using std::runtime_error::runtime_error;
};

bool is_tree_entity(int type) {
  switch (type) {
    case 150:
    case 152:
    case 154:
    case 156:
    case 158:
    case 160:
    case 162:
    case 164:
    case 168:
    case 180:
    case 184:
    case 430:
      return true;
    default:
      return false;
  }
}

std::vector<Entity> children(const Entity& entity) {
  std::vector<Entity> found;
  if (const auto tree = as<IGESSolid_BooleanTree>(entity); !tree.IsNull()) {
    for (int i = 1; i <= tree->Length(); ++i)
      if (tree->IsOperand(i)) found.push_back(tree->Operand(i));
  } else if (const auto assembly = as<IGESSolid_SolidAssembly>(entity); !assembly.IsNull()) {
    for (int i = 1; i <= assembly->NbItems(); ++i) found.push_back(assembly->Item(i));
  } else if (const auto instance = as<IGESSolid_SolidInstance>(entity); !instance.IsNull()) {
    found.push_back(instance->Entity());
  }
  return found;
}

class Walker {
 public:
  explicit Walker(IGESControl_Reader& reader) : reader_(reader), mm_(reader.IGESModel()->GlobalSection().UnitValue()) {
    if (!(mm_ > 0)) mm_ = 1;
  }

  TopoDS_Shape shape(const Entity& entity, int depth = 0) {
    if (entity.IsNull()) throw TreeFault("an operand is missing");
    if (depth > 200) throw TreeFault("the tree refers to itself");
    return placed(local(entity, depth), entity->Location());
  }

 private:
  IGESControl_Reader& reader_;
  double mm_;  // mm per unit of the file

  gp_Pnt point(const gp_Pnt& p) const { return gp_Pnt(p.XYZ() * mm_); }

  TopoDS_Shape placed(const TopoDS_Shape& shape, const gp_GTrsf& place) const {
    if (place.Form() == gp_Identity) return shape;
    // The file's decimals make no exact rotation: accept what they can mean, and let SetValues straighten it.
    const gp_Mat linear = place.VectorialPart();
    const gp_Mat square = linear.Transposed() * linear;
    for (int i = 1; i <= 3; ++i)
      for (int j = 1; j <= 3; ++j)
        if (std::abs(square(i, j) - (i == j)) > 1e-6 || linear.Determinant() < 0)
          throw TreeFault("a transformation is not rigid");
    const gp_XYZ move = place.TranslationPart() * mm_;
    gp_Trsf rigid;
    rigid.SetValues(linear(1, 1), linear(1, 2), linear(1, 3), move.X(), linear(2, 1), linear(2, 2), linear(2, 3),
                    move.Y(), linear(3, 1), linear(3, 2), linear(3, 3), move.Z());
    return BRepBuilderAPI_Transform(shape, rigid, Standard_True).Shape();
  }

  TopoDS_Shape local(const Entity& entity, int depth) {
    switch (entity->TypeNumber()) {
      case 150: {
        const auto e = as<IGESSolid_Block>(entity);
        return BRepPrimAPI_MakeBox(gp_Ax2(point(e->Corner()), e->ZAxis(), e->XAxis()), e->XLength() * mm_,
                                   e->YLength() * mm_, e->ZLength() * mm_)
            .Shape();
      }
      case 152: {
        const auto e = as<IGESSolid_RightAngularWedge>(entity);
        return BRepPrimAPI_MakeWedge(gp_Ax2(point(e->Corner()), e->ZAxis(), e->XAxis()), e->XBigLength() * mm_,
                                     e->YLength() * mm_, e->ZLength() * mm_, e->XSmallLength() * mm_)
            .Shape();
      }
      case 154: {
        const auto e = as<IGESSolid_Cylinder>(entity);
        return BRepPrimAPI_MakeCylinder(gp_Ax2(point(e->FaceCenter()), e->Axis()), e->Radius() * mm_, e->Height() * mm_)
            .Shape();
      }
      case 156: {
        const auto e = as<IGESSolid_ConeFrustum>(entity);
        const gp_Ax2 axes(point(e->FaceCenter()), e->Axis());
        const double large = e->LargerRadius() * mm_, small = e->SmallerRadius() * mm_, height = e->Height() * mm_;
        if (large == small) return BRepPrimAPI_MakeCylinder(axes, large, height).Shape();
        return BRepPrimAPI_MakeCone(axes, large, small, height).Shape();
      }
      case 158: {
        const auto e = as<IGESSolid_Sphere>(entity);
        return BRepPrimAPI_MakeSphere(point(e->Center()), e->Radius() * mm_).Shape();
      }
      case 160: {
        const auto e = as<IGESSolid_Torus>(entity);
        return BRepPrimAPI_MakeTorus(gp_Ax2(point(e->AxisPoint()), e->Axis()), e->MajorRadius() * mm_,
                                     e->DiscRadius() * mm_)
            .Shape();
      }
      case 162:
        return revolution(as<IGESSolid_SolidOfRevolution>(entity));
      case 164:
        return extrusion(as<IGESSolid_SolidOfLinearExtrusion>(entity));
      case 168: {
        const auto e = as<IGESSolid_Ellipsoid>(entity);
        gp_GTrsf stretch;
        const gp_XYZ half = e->Size() * mm_;
        for (int i = 1; i <= 3; ++i) stretch.SetValue(i, i, half.Coord(i));
        const TopoDS_Shape body =
            BRepBuilderAPI_GTransform(BRepPrimAPI_MakeSphere(1.0).Shape(), stretch, Standard_True).Shape();
        gp_Trsf place;
        place.SetTransformation(gp_Ax3(point(e->Center()), e->ZAxis(), e->XAxis()), gp_Ax3());
        return BRepBuilderAPI_Transform(body, place, Standard_True).Shape();
      }
      case 180:
        return boolean_tree(as<IGESSolid_BooleanTree>(entity), depth);
      case 184: {
        const auto e = as<IGESSolid_SolidAssembly>(entity);
        TopoDS_Compound all;
        BRep_Builder builder;
        builder.MakeCompound(all);
        for (int i = 1; i <= e->NbItems(); ++i) {
          const TopoDS_Shape item = shape(e->Item(i), depth + 1);
          const auto matrix = e->TransfMatrix(i);
          builder.Add(all, matrix.IsNull() ? item : placed(item, matrix->Value()));
        }
        return all;
      }
      case 430:
        return shape(as<IGESSolid_SolidInstance>(entity)->Entity(), depth + 1);
      case 186:
        return transferred(entity);
      default:
        throw TreeFault("entity type " + std::to_string(entity->TypeNumber()) + " is no solid primitive");
    }
  }

  /// An entity that OpenCASCADE itself can convert; the result is in mm and in the entity's own place.
  TopoDS_Shape transferred(const Entity& entity) {
    reader_.ClearShapes();
    if (!reader_.TransferEntity(entity) || reader_.NbShapes() == 0)
      throw TreeFault("entity type " + std::to_string(entity->TypeNumber()) + " cannot be converted");
    const TopoDS_Shape result = reader_.Shape(1);
    reader_.ClearShapes();
    return result;
  }

  TopoDS_Wire wire(const Entity& curve) {
    if (curve.IsNull()) throw TreeFault("a profile is missing");
    const TopoDS_Shape result = transferred(curve);
    if (result.ShapeType() == TopAbs_WIRE) return TopoDS::Wire(result);
    BRepBuilderAPI_MakeWire maker;
    for (TopExp_Explorer edges(result, TopAbs_EDGE); edges.More(); edges.Next())
      maker.Add(TopoDS::Edge(edges.Current()));
    if (!maker.IsDone()) throw TreeFault("a profile is not connected");
    return maker.Wire();
  }

  TopoDS_Shape extrusion(const Handle(IGESSolid_SolidOfLinearExtrusion) & e) {
    BRepBuilderAPI_MakeFace face(wire(e->Curve()), Standard_True);
    if (!face.IsDone()) throw TreeFault("the profile of an extrusion is not plane and closed");
    return oriented(
        BRepPrimAPI_MakePrism(face.Face(), gp_Vec(e->ExtrusionDirection()) * (e->ExtrusionLength() * mm_)).Shape());
  }

  TopoDS_Shape revolution(const Handle(IGESSolid_SolidOfRevolution) & e) {
    TopoDS_Wire profile = wire(e->Curve());
    const gp_Ax1 axis(point(e->AxisPoint()), e->Axis());
    TopoDS_Vertex first, last;
    TopExp::Vertices(profile, first, last);
    if (!profile.Closed() && !first.IsNull() && !first.IsSame(last)) {
      // Form 0 closes the profile by perpendiculars to the axis, form 1 by the chord.
      const gp_Pnt a = BRep_Tool::Pnt(first), b = BRep_Tool::Pnt(last);
      BRepBuilderAPI_MakeWire maker(profile);
      std::vector<gp_Pnt> corners = {b};
      if (e->IsClosedToAxis() || e->FormNumber() == 0) {
        auto on_axis = [&](const gp_Pnt& p) {
          const gp_Vec along(axis.Location(), p);
          return axis.Location().Translated(gp_Vec(axis.Direction()) * along.Dot(gp_Vec(axis.Direction())));
        };
        corners.push_back(on_axis(b)), corners.push_back(on_axis(a));
      }
      corners.push_back(a);
      for (std::size_t i = 0; i + 1 < corners.size(); ++i)
        if (corners[i].Distance(corners[i + 1]) > 1e-7)
          maker.Add(BRepBuilderAPI_MakeEdge(corners[i], corners[i + 1]).Edge());
      if (!maker.IsDone()) throw TreeFault("the profile of a revolution cannot be closed");
      profile = maker.Wire();
    }
    BRepBuilderAPI_MakeFace face(profile, Standard_True);
    if (!face.IsDone()) throw TreeFault("the profile of a revolution is not plane and closed");
    const double turn = e->Fraction();
    const TopoDS_Shape body = turn >= 1 - 1e-12 ? BRepPrimAPI_MakeRevol(face.Face(), axis).Shape()
                                                : BRepPrimAPI_MakeRevol(face.Face(), axis, turn * 2 * M_PI).Shape();
    return oriented(body);
  }

  /// Sweeping a face backwards gives a solid that is inside out.
  static TopoDS_Shape oriented(const TopoDS_Shape& shape) {
    for (TopExp_Explorer solids(shape, TopAbs_SOLID); solids.More(); solids.Next()) {
      TopoDS_Solid solid = TopoDS::Solid(solids.Current());
      BRepLib::OrientClosedSolid(solid);
      return solid;
    }
    throw TreeFault("a sweep encloses no volume");
  }

  TopoDS_Shape boolean_tree(const Handle(IGESSolid_BooleanTree) & tree, int depth) {
    std::vector<TopoDS_Shape> stack;  // the file lists operands and operations in post-order
    for (int i = 1; i <= tree->Length(); ++i) {
      if (tree->IsOperand(i)) {
        stack.push_back(shape(tree->Operand(i), depth + 1));
        continue;
      }
      if (stack.size() < 2) throw TreeFault("a boolean operation lacks an operand");
      const TopoDS_Shape b = stack.back();
      stack.pop_back();
      const TopoDS_Shape a = stack.back();
      stack.pop_back();
      stack.push_back(combined(a, b, tree->Operation(i)));
    }
    if (stack.size() != 1) throw TreeFault("a boolean tree leaves " + std::to_string(stack.size()) + " bodies");
    return stack.back();
  }

  static TopoDS_Shape combined(const TopoDS_Shape& a, const TopoDS_Shape& b, int operation) {
    TopoDS_Shape result;
    bool done = false;
    auto take = [&](auto&& algorithm) {
      done = algorithm.IsDone(), result = done ? algorithm.Shape() : TopoDS_Shape();
    };
    if (operation == 1)
      take(BRepAlgoAPI_Fuse(a, b));
    else if (operation == 2)
      take(BRepAlgoAPI_Common(a, b));
    else if (operation == 3)
      take(BRepAlgoAPI_Cut(a, b));
    else
      throw TreeFault("boolean operation " + std::to_string(operation) + " is unknown");
    if (!done || result.IsNull()) throw TreeFault("a boolean operation failed");
    return result;
  }
};

}  // namespace

IgesTree evaluate_iges_tree(IGESControl_Reader& reader, TopoDS_Shape& shape) {
  IgesTree result;
  const auto model = reader.IGESModel();
  if (model.IsNull()) return result;
  std::set<int> referred;
  std::vector<Entity> found;
  for (int i = 1; i <= model->NbEntities(); ++i) {
    const Entity entity = model->Entity(i);
    if (entity.IsNull() || !is_tree_entity(entity->TypeNumber())) continue;
    result.present = true;
    if (model->IsErrorEntity(i)) {  // its content was not read, and asking for it would crash
      result.fault = "entity " + std::to_string(2 * i - 1) + " cannot be read";
      return result;
    }
    found.push_back(entity);
    for (const auto& child : children(entity))
      if (!child.IsNull()) referred.insert(model->Number(child));
  }
  if (!result.present) return result;
  try {
    Walker walker(reader);
    TopoDS_Compound all;
    BRep_Builder builder;
    builder.MakeCompound(all);
    for (const auto& entity : found)
      if (!referred.count(model->Number(entity))) builder.Add(all, walker.shape(entity));
    shape = all;
  } catch (const TreeFault& fault) {
    result.fault = fault.what();
  } catch (const Standard_Failure& failure) {
    const char* text = failure.GetMessageString();
    result.fault = text && *text ? text : "OpenCASCADE gave up";
  }
  return result;
}

}  // namespace partscribe::verify
