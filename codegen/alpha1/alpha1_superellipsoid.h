/// Control nets of B-spline surfaces that stand for superellipsoids and supertoroids within a given deviation.
#pragma once

#include <vector>

#include "model/shapes.h"

namespace partscribe::codegen {

/// The net is a product: its corner (i, j) is
///   ( a1 C_j (R_i + taper_x Q_i),  a2 S_j (R_i + taper_y Q_i),  a3 Z_i )
/// so that sizes and tapers stay parameters; only the two exponents are baked in. Bent by b over a3, where the places
/// along it are turned by b z and z becomes w, it is
///   ( a3 U_i + a1 C_j (Rc_i + taper_x Qc_i),  a2 S_j (R_i + taper_y Q_i),  a3 W_i - a1 C_j (Rs_i + taper_x Qs_i) ),
/// and b is baked in as well.
struct SuperellipsoidNet {
  struct Around {
    double c, s;
  };
  struct Along {
    double r, q, z;
    double rc = r, qc = q, rs = 0, qs = 0, u = 0, w = z;
  };
  int order = 4;               ///< 4: cubic; 2: facets, where corners are too sharp for a cubic
  std::vector<Around> around;  ///< periodic, uniform knots
  std::vector<Along> along;    ///< clamped, uniform knots, from the lower pole to the upper
  double deviation = 0;        ///< mm, largest found between the surface and the superellipsoid
};

SuperellipsoidNet superellipsoid_net(const SuperellipsoidOf<double>& shape, double deviation);

/// Corner (i, j) is ( (major_radius + minor_radius T_i.c) C_j, (major_radius + minor_radius T_i.c) S_j,
/// half_height T_i.s ), periodic with uniform knots both ways.
struct SupertoroidNet {
  int order = 4;
  std::vector<SuperellipsoidNet::Around> around, tube;
  double deviation = 0;  ///< mm
};

SupertoroidNet supertoroid_net(const SupertoroidOf<double>& shape, double deviation);

}  // namespace partscribe::codegen
