#include "codegen/exchange/iges_tree.h"

#include <IGESData_HArray1OfIGESEntity.hxx>
#include <IGESData_IGESEntity.hxx>
#include <IGESGeom_BSplineCurve.hxx>
#include <IGESGeom_CircularArc.hxx>
#include <IGESGeom_CompositeCurve.hxx>
#include <IGESGeom_Line.hxx>
#include <IGESGeom_TransformationMatrix.hxx>
#include <IGESSolid_Block.hxx>
#include <IGESSolid_BooleanTree.hxx>
#include <IGESSolid_ConeFrustum.hxx>
#include <IGESSolid_Cylinder.hxx>
#include <IGESSolid_Ellipsoid.hxx>
#include <IGESSolid_RightAngularWedge.hxx>
#include <IGESSolid_SolidOfLinearExtrusion.hxx>
#include <IGESSolid_SolidOfRevolution.hxx>
#include <IGESSolid_Sphere.hxx>
#include <IGESSolid_Torus.hxx>
#include <TColStd_HArray1OfInteger.hxx>
#include <TColStd_HArray1OfReal.hxx>
#include <TColStd_HArray2OfReal.hxx>
#include <TColgp_HArray1OfXYZ.hxx>
#include <algorithm>
#include <array>
#include <cmath>
#include <gp_GTrsf.hxx>
#include <gp_XY.hxx>
#include <gp_XYZ.hxx>

#include "core/ensure.h"
#include "core/number.h"
#include "model/lower/lower.h"
#include "model/sketch.h"

namespace partscribe::codegen {
namespace {

using Entity = Handle(IGESData_IGESEntity);

const gp_XYZ origin(0, 0, 0), along_x(1, 0, 0), along_y(0, 1, 0), along_z(0, 0, 1);

enum Operation { unite = 1, intersect = 2, subtract = 3 };

void place(const Entity& entity, const Pose& pose) {
  if (pose.rotation == Mat3::Identity() && pose.translation == Vec3::Zero()) return;
  const Handle(TColStd_HArray2OfReal) matrix = new TColStd_HArray2OfReal(1, 3, 1, 4);
  for (int row = 0; row < 3; ++row) {
    for (int column = 0; column < 3; ++column) {
      // cos(90 degrees) is not quite zero in binary.
      const double entry = pose.rotation(row, column);
      matrix->SetValue(row + 1, column + 1, std::abs(entry) < 1e-15 ? 0 : entry);
    }
    matrix->SetValue(row + 1, 4, pose.translation[row]);
  }
  const Handle(IGESGeom_TransformationMatrix) transformation = new IGESGeom_TransformationMatrix;
  transformation->Init(matrix);
  entity->InitTransf(transformation);
}

// Parts of another entity are not to be taken for bodies of their own.
void subordinate(const Entity& entity) { entity->InitStatus(0, 1, 0, 0); }

// ---- curves of a sketch, in the plane z = 0 ---------------------------------------------------------------------

Entity curve_of(const Line2& line) {
  const Handle(IGESGeom_Line) e = new IGESGeom_Line;
  e->Init(gp_XYZ(line.a.x(), line.a.y(), 0), gp_XYZ(line.b.x(), line.b.y(), 0));
  return Entity(e);
}

Entity curve_of(const Arc2& arc) {
  // Entity 100 runs counter-clockwise; a clockwise arc is one that was turned over about the first axis.
  const bool clockwise = arc.to < arc.from;
  const double flip = clockwise ? -1 : 1;
  const bool full = std::abs(arc.to - arc.from) > 2 * pi - 1e-9;
  const Vec2 start = arc.at(arc.from), end = full ? start : arc.at(arc.to);
  const Handle(IGESGeom_CircularArc) e = new IGESGeom_CircularArc;
  e->Init(0, gp_XY(arc.center.x(), flip * arc.center.y()), gp_XY(start.x(), flip * start.y()),
          gp_XY(end.x(), flip * end.y()));
  if (clockwise) {
    Pose over;
    over.rotation = Vec3(1, -1, -1).asDiagonal();
    place(e, over);
  }
  return Entity(e);
}

Entity curve_of(const Nurbs2& curve) {
  const int last = static_cast<int>(curve.points.size()) - 1;
  const Handle(TColStd_HArray1OfReal) knots = new TColStd_HArray1OfReal(-curve.t.degree, last + 1);
  for (std::size_t i = 0; i < curve.t.knots.size(); ++i)
    knots->SetValue(static_cast<int>(i) - curve.t.degree, curve.t.knots[i]);
  const Handle(TColStd_HArray1OfReal) weights = new TColStd_HArray1OfReal(0, last);
  const Handle(TColgp_HArray1OfXYZ) poles = new TColgp_HArray1OfXYZ(0, last);
  bool polynomial = true;
  for (int i = 0; i <= last; ++i) {
    const auto k = static_cast<std::size_t>(i);
    weights->SetValue(i, curve.weights.empty() ? 1 : curve.weights[k]);
    polynomial = polynomial && weights->Value(i) == weights->Value(0);
    poles->SetValue(i, gp_XYZ(curve.points[k].x(), curve.points[k].y(), 0));
  }
  const bool closed = (curve.points.front() - curve.points.back()).norm() < sketch_join;
  const Handle(IGESGeom_BSplineCurve) e = new IGESGeom_BSplineCurve;
  e->Init(last, curve.t.degree, true, closed, polynomial, false, knots, weights, poles, curve.t.knots.front(),
          curve.t.knots.back(), along_z);
  return Entity(e);
}

/// One closed loop: a circle, or a composite curve.
Entity loop_of(const Outline2& outline, int loop) {
  std::vector<Entity> parts;
  for (const auto& c : outline.curves) {
    if (c.loop == loop) parts.push_back(std::visit([](const auto& curve) { return curve_of(curve); }, c.curve));
  }
  for (const auto& part : parts) subordinate(part);
  if (parts.size() == 1) return parts[0];
  const Handle(IGESData_HArray1OfIGESEntity) list = new IGESData_HArray1OfIGESEntity(1, static_cast<int>(parts.size()));
  for (std::size_t i = 0; i < parts.size(); ++i) list->SetValue(static_cast<int>(i) + 1, parts[i]);
  const Handle(IGESGeom_CompositeCurve) e = new IGESGeom_CompositeCurve;
  e->Init(list);
  subordinate(e);
  return Entity(e);
}

// ---- solids -----------------------------------------------------------------------------------------------------

Entity tree_of(const std::vector<Entity>& operands, Operation operation) {
  if (operands.size() == 1) return operands[0];
  const int count = static_cast<int>(2 * operands.size()) - 1;
  const Handle(IGESData_HArray1OfIGESEntity) entities = new IGESData_HArray1OfIGESEntity(1, count);
  const Handle(TColStd_HArray1OfInteger) operations = new TColStd_HArray1OfInteger(1, count, 0);
  int slot = 0;
  for (std::size_t i = 0; i < operands.size(); ++i) {
    subordinate(operands[i]);
    entities->SetValue(++slot, operands[i]);
    if (i > 0) operations->SetValue(++slot, operation);
  }
  const Handle(IGESSolid_BooleanTree) e = new IGESSolid_BooleanTree;
  e->Init(entities, operations);
  return Entity(e);
}

Entity iges_solid(const BoxOf<double>& s) {
  const Handle(IGESSolid_Block) e = new IGESSolid_Block;
  e->Init(gp_XYZ(s.size_x, s.size_y, s.size_z), origin, along_x, along_z);
  return Entity(e);
}

Entity iges_solid(const WedgeOf<double>& s) {
  if (s.top_x >= s.size_x) return {};  // entity 152 knows only wedges that become narrower
  const Handle(IGESSolid_RightAngularWedge) e = new IGESSolid_RightAngularWedge;
  e->Init(gp_XYZ(s.size_x, s.size_y, s.size_z), s.top_x, origin, along_x, along_z);
  return Entity(e);
}

Entity iges_solid(const CylinderOf<double>& s) {
  const Handle(IGESSolid_Cylinder) e = new IGESSolid_Cylinder;
  e->Init(s.height, s.radius, origin, along_z);
  return Entity(e);
}

Entity iges_solid(const ConeOf<double>& s) {
  // Entity 156 starts at its larger face.
  const bool up = s.bottom_radius >= s.top_radius;
  const Handle(IGESSolid_ConeFrustum) e = new IGESSolid_ConeFrustum;
  e->Init(s.height, std::max(s.bottom_radius, s.top_radius), std::min(s.bottom_radius, s.top_radius),
          up ? origin : gp_XYZ(0, 0, s.height), up ? along_z : gp_XYZ(0, 0, -1));
  return Entity(e);
}

Entity iges_solid(const SphereOf<double>& s) {
  const Handle(IGESSolid_Sphere) e = new IGESSolid_Sphere;
  e->Init(s.radius, origin);
  return Entity(e);
}

Entity iges_solid(const EllipsoidOf<double>& s) {
  // Entity 168 wants its sizes in falling order, along x, y and z of its own axes.
  struct Axis {
    double half;
    gp_XYZ direction;
  };
  std::array<Axis, 3> axes{Axis{s.radius_x, along_x}, Axis{s.radius_y, along_y}, Axis{s.radius_z, along_z}};
  std::stable_sort(axes.begin(), axes.end(), [](const Axis& a, const Axis& b) { return a.half > b.half; });
  const Handle(IGESSolid_Ellipsoid) e = new IGESSolid_Ellipsoid;
  e->Init(gp_XYZ(axes[0].half, axes[1].half, axes[2].half), origin, axes[0].direction, axes[2].direction);
  return Entity(e);
}

Entity iges_solid(const TorusOf<double>& s) {
  const Handle(IGESSolid_Torus) e = new IGESSolid_Torus;
  e->Init(s.major_radius, s.minor_radius, origin, along_z);
  return Entity(e);
}

/// Sweeps every loop of a sketch and takes the holes out of the first.
template <class Sweep>
Entity swept(const EvaluatedSketch& sketch, const Sweep& sweep) {
  const Outline2 outline = outline_of(sketch);
  std::vector<Entity> bodies;
  for (std::size_t loop = 0; loop < sketch.loops.size(); ++loop)
    bodies.push_back(sweep(loop_of(outline, static_cast<int>(loop))));
  return tree_of(bodies, subtract);
}

Entity iges_solid(const ExtrudeOf<double>& s) {
  if (s.draft != 0) return {};  // entity 164 knows upright walls only
  Pose raised;
  raised.translation.z() = -s.below;
  return swept(s.sketch, [&](const Entity& curve) {
    const Handle(IGESSolid_SolidOfLinearExtrusion) e = new IGESSolid_SolidOfLinearExtrusion;
    e->Init(curve, s.below + s.height, along_z);
    if (s.below != 0) place(e, raised);
    return Entity(e);
  });
}

Entity iges_solid(const RevolveOf<double>& s) {
  // The profile lies in x-y and turns about y; a rotation puts y onto z.
  Pose upright;
  upright.rotation << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  return swept(s.sketch, [&](const Entity& curve) {
    const Handle(IGESSolid_SolidOfRevolution) e = new IGESSolid_SolidOfRevolution;
    e->Init(curve, std::min(s.angle / (2 * pi), 1.0), origin, along_y);
    e->SetClosedToAxis(false);  // form 1: the curve closes on itself
    place(e, upright);
    return Entity(e);
  });
}

Entity iges_solid(const SuperellipsoidOf<double>&) { return {}; }
Entity iges_solid(const SupertoroidOf<double>&) { return {}; }
Entity iges_solid(const HalfSpacesOf<double>&) { return {}; }
Entity iges_solid(const TriSurfaceOf<double>&) { return {}; }
Entity iges_solid(const SurfaceSetOf<double>&) { return {}; }

template <LoweredAway S>
Entity iges_solid(const S&) {
  ensure(false, "features are lowered before");
  return {};
}

class TreeBuilder {
 public:
  explicit TreeBuilder(const Model& model) : model_(model), values_(values_of(model)) {}

  std::vector<IgesTreeNode> build() {
    const Object& root = model_.objects.back();
    const Pose scan_from_part = model_.as_scanned ? evaluate(model_.scan_from_part, values_) : Pose{};
    const Entity entity = entity_of(root, scan_from_part);
    if (entity.IsNull()) return {};
    // The body beside it shows the part; the tree is there for programs that ask for it.
    entity->InitStatus(1, 0, 0, 0);
    return nodes_;
  }

 private:
  /// Every use of an object has an entity of its own, because an entity has one place only.
  Entity entity_of(const Object& object, const Pose& outer) {
    const Pose pose = outer * evaluate(object.frame, values_);
    Entity entity = std::visit([&](const auto& s) { return node(s); }, evaluate(object.shape, values_));
    if (entity.IsNull()) return entity;
    // A boolean of one operand is that operand; it keeps its own place inside.
    if (entity->HasTransf()) {
      const gp_GTrsf inner = entity->Location();
      Pose own;
      for (int row = 0; row < 3; ++row) {
        for (int column = 0; column < 3; ++column) own.rotation(row, column) = inner.Value(row + 1, column + 1);
        own.translation[row] = inner.Value(row + 1, 4);
      }
      place(entity, pose * own);
    } else {
      place(entity, pose);
    }
    nodes_.push_back({{entity.get(), [entity](IGESData_IGESEntity*) {}}, object.name});
    return entity;
  }

  template <class S>
  Entity node(const S& shape) {
    return iges_solid(shape);
  }
  Entity node(const UnionOf<double>& s) { return combined(s.objects, unite); }
  Entity node(const DifferenceOf<double>& s) { return combined(s.objects, subtract); }
  Entity node(const IntersectionOf<double>& s) { return combined(s.objects, intersect); }

  Entity combined(const std::vector<std::string>& names, Operation operation) {
    std::vector<Entity> operands;
    for (const auto& name : names) {
      for (const Object& object : model_.objects) {
        if (object.name != name) continue;
        operands.push_back(entity_of(object, Pose{}));
        if (operands.back().IsNull()) return {};
      }
    }
    return tree_of(operands, operation);
  }

  const Model& model_;
  Values values_;
  std::vector<IgesTreeNode> nodes_;
};

}  // namespace

std::vector<IgesTreeNode> iges_tree(const Model& model) {
  const Model simple = lowered(model, values_of(model));
  return TreeBuilder(simple).build();
}

}  // namespace partscribe::codegen
