#include "verify/features/feature_names.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "core/number.h"
#include "verify/report/words.h"

namespace partscribe::verify {
namespace {

std::string noun_of(const MeshFeature& f) {
  if (f.kind == "cylinder") return f.hollow ? "hollow" : "cylinder";
  if (f.kind == "sphere" && f.hollow) return "hollow sphere";
  return f.kind;
}

int rank_of(const std::string& kind) {
  static const std::array<const char*, 11> order = {"plane", "hole",   "boss",  "cylinder",     "cone",       "sphere",
                                                    "torus", "fillet", "round", "free surface", "small faces"};
  for (std::size_t i = 0; i < order.size(); ++i)
    if (kind == order[i]) return static_cast<int>(i);
  return 99;
}

double size_of(const MeshFeature& f) {
  if (!f.primitive || f.kind == "plane") return f.area;
  return f.primitive->kind == PrimitiveKind::torus && f.kind != "torus" ? f.primitive->tube : f.primitive->radius;
}

std::string face_name(const MeshFeature& f) {
  const Vec3& n = f.primitive->axis;
  Eigen::Index axis;
  if (n.cwiseAbs().maxCoeff(&axis) < std::cos(radians(0.5))) return "slanted face";
  return std::string("face ") + (n[axis] > 0 ? "+" : "-") + "xyz"[axis] + " at " + shown(f.middle[axis], 0.01);
}

}  // namespace

void name_features(std::vector<MeshFeature>& features) {
  auto key = [](const MeshFeature& f) {
    auto r = [](double v) { return std::round(v * 100) / 100; };
    return std::array<double, 5>{double(rank_of(f.kind)), -r(size_of(f)), r(f.middle.x()), r(f.middle.y()),
                                 r(f.middle.z())};
  };
  std::stable_sort(features.begin(), features.end(),
                   [&](const MeshFeature& a, const MeshFeature& b) { return key(a) < key(b); });
  std::map<std::string, int> total, used;
  for (auto& f : features) {
    f.name = f.kind == "plane" ? face_name(f) : noun_of(f);
    ++total[f.name];
  }
  for (auto& f : features) {
    if (f.kind == "small faces") {
      f.name = counted(f.triangles.size(), "small facet");
      continue;
    }
    const int number = ++used[f.name];
    if (f.name.rfind("face ", 0) == 0) {
      if (total[f.name] > 1) f.name += " (" + std::to_string(number) + ")";
    } else {
      f.name += " " + std::to_string(number);
    }
  }
}

}  // namespace partscribe::verify
