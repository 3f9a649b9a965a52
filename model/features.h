/// Features of machined and moulded parts: bodies that are cut away or added, and repetitions of earlier objects.
///
/// Holes, slots and pockets are the material that a cutter removes: they open at z = 0, go down to z = -depth, and
/// reach `overshoot` beyond what they open into, so that no face of the cutter lies in a face of the part. A boss
/// stands on z = 0. A Difference or a Union of earlier objects puts them to use. Millimetres and radians.
#pragma once

#include "model/solids.h"

namespace partscribe::model {

/// A round hole about z. Its mouth may be wider: a counterbore (a flat-bottomed cylinder of head_diameter), below it or
/// at the face a countersink (a cone of the whole angle sink_angle, of sink_diameter where it begins).
template <class N>
struct HoleOf {
  static constexpr std::string_view kind = "hole";
  N diameter{}, depth{};
  bool through = true;  ///< open at z = -depth as well
  N tip_angle = 0, head_diameter = 0, head_depth = 0, sink_diameter = 0, sink_angle = pi / 2, overshoot = 1;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("diameter", s.diameter, Domain::length, "diameter");
    v("depth", s.depth, Domain::length, "how far the full diameter reaches below the face");
    v("through", s.through, "true: open at both ends");
    v("tip_angle", s.tip_angle, Domain::angle, "whole angle of the cone below a blind hole; 0: a flat bottom", 0.0);
    v("head_diameter", s.head_diameter, Domain::length_or_zero, "diameter of the counterbore; 0: none", 0.0);
    v("head_depth", s.head_depth, Domain::length_or_zero, "depth of the counterbore below the face", 0.0);
    v("sink_diameter", s.sink_diameter, Domain::length_or_zero,
      "diameter of the countersink at the face, or at the floor of the counterbore; 0: none", 0.0);
    v("sink_angle", s.sink_angle, Domain::angle, "whole angle of the countersink", pi / 2);
    v("overshoot", s.overshoot, Domain::length, "how far the cut reaches out of the part", 1.0);
  }
  bool operator==(const HoleOf&) const = default;
};

/// A slot with round ends along x, its middle on the z axis.
template <class N>
struct SlotOf {
  static constexpr std::string_view kind = "slot";
  N length{}, width{}, depth{};
  bool through = true;
  N overshoot = 1;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("length", s.length, Domain::length, "from end to end, rounds included");
    v("width", s.width, Domain::length, "across, twice the radius of the ends");
    v("depth", s.depth, Domain::length, "how far it reaches below the face");
    v("through", s.through, "true: open at both ends");
    v("overshoot", s.overshoot, Domain::length, "how far the cut reaches out of the part", 1.0);
  }
  bool operator==(const SlotOf&) const = default;
};

/// A pocket of any outline; loops inside the outline are islands that stay. With a draft it narrows towards its floor,
/// and islands narrow towards the face.
template <class N>
struct PocketOf {
  static constexpr std::string_view kind = "pocket";
  SketchOf<N> sketch;
  N depth{};
  bool through = false;
  N overshoot = 1, draft = 0;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("sketch", s.sketch, "outline at the face");
    v("depth", s.depth, Domain::length, "how far it reaches below the face");
    v("through", s.through, "true: open at both ends");
    v("overshoot", s.overshoot, Domain::length, "how far the cut reaches out of the part", 1.0);
    v("draft", s.draft, Domain::angle, "angle by which the walls lean inwards as they go down", 0.0);
  }
  bool operator==(const PocketOf&) const = default;
};

/// What stands on a face: an outline, moved up to `height`; it begins `root` below the face, inside the part. With a
/// draft it narrows as it rises.
template <class N>
struct BossOf {
  static constexpr std::string_view kind = "boss";
  SketchOf<N> sketch;
  N height{}, root = 1, draft = 0;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("sketch", s.sketch, "outline at the face");
    v("height", s.height, Domain::length, "how far it stands out of the face");
    v("root", s.root, Domain::length_or_zero, "how far it reaches into the part", 1.0);
    v("draft", s.draft, Domain::angle, "angle by which the walls lean inwards as they rise", 0.0);
  }
  bool operator==(const BossOf&) const = default;
};

/// What a B-spline surface passes while it moves along a vector. Cut from a body it leaves the surface as a face;
/// joined to one, it is a pad whose face it is.
template <class N>
struct SweptSurfaceOf {
  static constexpr std::string_view kind = "swept_surface";
  TrimmedPatch surface;           ///< the whole of it: without trims
  std::vector<double> direction;  ///< mm, (x, y, z): how far it moves; it crosses the surface from one side everywhere
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("surface", s.surface, "the surface, without trims");
    v("direction", s.direction, "how far the surface moves along x, y and z");
  }
  bool operator==(const SweptSurfaceOf&) const = default;
};

/// An earlier object `count` times, each a step further than the one before; the first stays where it is.
template <class N>
struct LinearPatternOf {
  static constexpr std::string_view kind = "linear_pattern";
  std::string object;
  N count{}, step_x{}, step_y{}, step_z{};
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("object", s.object, "name of an earlier object");
    v("count", s.count, Domain::count, "how many there are");
    v("step_x", s.step_x, Domain::coordinate, "from each to the next", 0.0);
    v("step_y", s.step_y, Domain::coordinate, "from each to the next", 0.0);
    v("step_z", s.step_z, Domain::coordinate, "from each to the next", 0.0);
  }
  bool operator==(const LinearPatternOf&) const = default;
};

/// An earlier object `count` times, each turned by `step` about the z axis from the one before.
template <class N>
struct CircularPatternOf {
  static constexpr std::string_view kind = "circular_pattern";
  std::string object;
  N count{}, step{};
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("object", s.object, "name of an earlier object");
    v("count", s.count, Domain::count, "how many there are");
    v("step", s.step, Domain::angle, "from each to the next, about z");
  }
  bool operator==(const CircularPatternOf&) const = default;
};

/// An earlier object and its image behind the plane at `offset` along an axis, or the image alone.
template <class N>
struct MirrorOf {
  static constexpr std::string_view kind = "mirror";
  std::string object;
  std::string axis = "x";  ///< normal of the plane: "x", "y" or "z"
  N offset = 0;
  bool keep = true;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("object", s.object, "name of an earlier object");
    v("axis", s.axis, "normal of the plane: x, y or z");
    v("offset", s.offset, Domain::coordinate, "where the plane crosses that axis", 0.0);
    v("keep", s.keep, "true: the object stays beside its image");
  }
  bool operator==(const MirrorOf&) const = default;
};

/// An earlier object whose edge between two of its faces is rounded: a convex edge loses material, a concave one gains
/// it. Faces by their names as ModelDistance has them: "plate top", "hole wall".
template <class N>
struct EdgeFilletOf {
  static constexpr std::string_view kind = "edge_fillet";
  std::string object, face_1, face_2;
  N radius{}, overshoot = 1;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("object", s.object, "name of an earlier object");
    v("face_1", s.face_1, "a face of it");
    v("face_2", s.face_2, "the face beyond the edge");
    v("radius", s.radius, Domain::length, "radius of the round");
    v("overshoot", s.overshoot, Domain::length, "how far the tool reaches beyond the edge", 1.0);
  }
  bool operator==(const EdgeFilletOf&) const = default;
};

/// The same with a flat chamfer.
template <class N>
struct EdgeChamferOf {
  static constexpr std::string_view kind = "edge_chamfer";
  std::string object, face_1, face_2;
  N leg_1{}, leg_2{}, overshoot = 1;
  template <class S, class V>
  static void fields(S& s, V&& v) {
    v("object", s.object, "name of an earlier object");
    v("face_1", s.face_1, "a face of it");
    v("face_2", s.face_2, "the face beyond the edge");
    v("leg_1", s.leg_1, Domain::length, "from the edge along the first face");
    v("leg_2", s.leg_2, Domain::length, "from the edge along the second face");
    v("overshoot", s.overshoot, Domain::length, "how far the tool reaches beyond the edge", 1.0);
  }
  bool operator==(const EdgeChamferOf&) const = default;
};

}  // namespace partscribe::model
