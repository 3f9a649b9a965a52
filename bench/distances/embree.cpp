// Embree's point query over its float boxes with the distance to a triangle in double precision.
#include "peers.h"

#if __has_include(<embree3/rtcore.h>) && !defined(PARTSCRIBE_NO_EMBREE)
#include <embree3/rtcore.h>

#include <atomic>
#include <cmath>
#include <limits>

namespace peers {
namespace {

using partscribe::geometry::Vec3;

// Ericson, Real-Time Collision Detection, 5.1.5: the usual way, with its early exits.
inline double sq_distance(const Vec3& p, const Vec3& a, const Vec3& b, const Vec3& c) {
  const Vec3 ab = b - a, ac = c - a, ap = p - a;
  const double d1 = ab.dot(ap), d2 = ac.dot(ap);
  if (d1 <= 0 && d2 <= 0) return ap.squaredNorm();
  const Vec3 bp = p - b;
  const double d3 = ab.dot(bp), d4 = ac.dot(bp);
  if (d3 >= 0 && d4 <= d3) return bp.squaredNorm();
  const double vc = d1 * d4 - d3 * d2;
  if (vc <= 0 && d1 >= 0 && d3 <= 0) return (ap - d1 / (d1 - d3) * ab).squaredNorm();
  const Vec3 cp = p - c;
  const double d5 = ab.dot(cp), d6 = ac.dot(cp);
  if (d6 >= 0 && d5 <= d6) return cp.squaredNorm();
  const double vb = d5 * d2 - d1 * d6;
  if (vb <= 0 && d2 >= 0 && d6 <= 0) return (ap - d2 / (d2 - d6) * ac).squaredNorm();
  const double va = d3 * d6 - d5 * d4;
  if (va <= 0 && d4 - d3 >= 0 && d5 - d6 >= 0)
    return (bp - (d4 - d3) / ((d4 - d3) + (d5 - d6)) * (c - b)).squaredNorm();
  const double denominator = 1 / (va + vb + vc);
  return (ap - vb * denominator * ab - vc * denominator * ac).squaredNorm();
}

std::atomic<long long> held{0};
bool count_bytes(void*, ssize_t bytes, bool) {
  held += bytes;
  return true;
}

struct Search {
  const partscribe::geometry::TriangleMesh* mesh;
  Vec3 query;
  double sq = std::numeric_limits<double>::infinity();
  unsigned triangle = 0;
  float slack = 0;

  // Enough for the rounding of the query to single precision, so that the answer is exact.
  float radius() const { return static_cast<float>(std::sqrt(sq)) * (1 + 1e-6f) + slack; }
  bool offer(unsigned t) {
    const auto& k = mesh->triangles[t];
    const double d = sq_distance(query, mesh->vertices[k[0]], mesh->vertices[k[1]], mesh->vertices[k[2]]);
    if (!(d < sq)) return false;
    sq = d, triangle = t;
    return true;
  }
};

bool visit(RTCPointQueryFunctionArguments* args) {
  auto& search = *static_cast<Search*>(args->userPtr);
  if (!search.offer(args->primID)) return false;
  args->query->radius = search.radius();
  return true;
}

class Embree : public Peer {
 public:
  explicit Embree(const partscribe::geometry::TriangleMesh& mesh) : mesh_(mesh) {
    device_ = rtcNewDevice("threads=1");
    rtcSetDeviceMemoryMonitorFunction(device_, count_bytes, nullptr);
    held = 0;
    scene_ = rtcNewScene(device_);
    rtcSetSceneBuildQuality(scene_, RTC_BUILD_QUALITY_MEDIUM);
    RTCGeometry geometry = rtcNewGeometry(device_, RTC_GEOMETRY_TYPE_TRIANGLE);
    auto* vertices = static_cast<float*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3, 12, mesh.vertices.size()));
    auto* triangles = static_cast<unsigned*>(
        rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3, 12, mesh.triangles.size()));
    double size = 0;
    for (std::size_t i = 0; i < mesh.vertices.size(); ++i)
      for (int k = 0; k < 3; ++k) {
        vertices[3 * i + std::size_t(k)] = static_cast<float>(mesh.vertices[i][k]);
        size = std::max(size, std::abs(mesh.vertices[i][k]));
      }
    slack_ = static_cast<float>(size * 1e-6);
    for (std::size_t t = 0; t < mesh.triangles.size(); ++t)
      for (std::size_t k = 0; k < 3; ++k) triangles[3 * t + k] = mesh.triangles[t][k];
    rtcSetGeometryPointQueryFunction(geometry, visit);
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene_, geometry);
    rtcReleaseGeometry(geometry);
    rtcCommitScene(scene_);
    bytes_ = static_cast<std::size_t>(held.load());
    const std::size_t copy = mesh.vertices.size() * 12 + mesh.triangles.size() * 12;
    bytes_ = bytes_ > copy ? bytes_ - copy : bytes_;
  }
  ~Embree() override { rtcReleaseScene(scene_), rtcReleaseDevice(device_); }

  void distances(const std::vector<Vec3>& queries, std::size_t begin, std::size_t end, bool warm,
                 double* out) const override {
    Search search{&mesh_, {}, 0, 0, slack_};
    for (std::size_t i = begin; i < end; ++i) {
      search.query = queries[i], search.sq = std::numeric_limits<double>::infinity();
      RTCPointQuery query;
      query.x = static_cast<float>(queries[i].x()), query.y = static_cast<float>(queries[i].y()),
      query.z = static_cast<float>(queries[i].z()), query.time = 0;
      query.radius = std::numeric_limits<float>::infinity();
      if (warm && i > begin) search.offer(search.triangle), query.radius = search.radius();
      RTCPointQueryContext context;
      rtcInitPointQueryContext(&context);
      rtcPointQuery(scene_, &query, &context, nullptr, &search);
      out[i] = std::sqrt(search.sq);
    }
  }
  std::size_t bytes() const override { return bytes_; }

 private:
  const partscribe::geometry::TriangleMesh& mesh_;
  RTCDevice device_;
  RTCScene scene_;
  std::size_t bytes_ = 0;
  float slack_ = 0;
};

}  // namespace

std::unique_ptr<Peer> embree(const partscribe::geometry::TriangleMesh& mesh) { return std::make_unique<Embree>(mesh); }

}  // namespace peers
#else
namespace peers {
std::unique_ptr<Peer> embree(const partscribe::geometry::TriangleMesh&) { return nullptr; }
}  // namespace peers
#endif
