/// The faces that were found beside those that are there.
#pragma once

#include <string>
#include <utility>
#include <vector>

#include "truth.h"

namespace bench {

inline constexpr std::uint32_t no_triangle = ~0u;

/// Where one triangle or point lies on the mesh of the file.
struct Place {
  std::uint32_t triangle = no_triangle;  ///< no_triangle: a point that lies on no face
  double weight = 1;                     ///< mm^2 of a triangle
};

struct ScoreOptions {
  bool of_scan = false;        ///< judge numbers by their sigmas
  double least_share = 0.005;  ///< of the area: smaller faces are not counted
  double radius = 0.002;       ///< largest error over the value, of meshes
  double angle = 0.2;          ///< degrees, of meshes
  double place = 0;            ///< mm: so close the surface must lie to the face, in the median
  double alike = 0;            ///< mm: so close to a free form all of a face must lie to be no false one
};

/// How often numbers lie within three of the sigmas that are stated for them.
struct Within {
  int inside = 0, all = 0;
  void add(double error, double sigma) { ++all, inside += error <= 3 * sigma; }
  Within& operator+=(const Within& o) { return inside += o.inside, all += o.all, *this; }
};

struct Score {
  int truth = 0;                    ///< faces of the CAD file that have a closed form and enough area
  int unseen = 0;                   ///< besides these: the scan shows nothing of them
  int found = 0;                    ///< more than half of the face bears its kind and surface
  int inside_out = 0;               ///< of these: the material on the wrong side
  int split = 0;                    ///< of these: by several faces
  int wrong_kind = 0, off = 0;      ///< most of what is there: another kind; its kind, but not its surface
  int missing = 0;                  ///< more than half of it belongs to no face
  int reported = 0, none = 0;       ///< faces with a closed form and enough area; most of their area is none such
  int free = 0, free_found = 0;     ///< free form in the file, and where free form is said
  int alike = 0;                    ///< faces with a closed form that a free form of the file follows closely
  int vague = 0;                    ///< free form is said of what has a closed form
  double area = 0, right_area = 0;  ///< with closed form, and of it what bears the right face
  Within radii, offsets, axes;      ///< of the faces found in scans
  double seconds = 0;               ///< of processor time
  std::vector<std::string> words;   ///< one line for each face missed or false

  Score& operator+=(const Score& other);
};

/// `places` beside `faces.face_of`.
Score score(const Truth& truth, const std::vector<Place>& places, const Faces& faces, const ScoreOptions& options);

}  // namespace bench
