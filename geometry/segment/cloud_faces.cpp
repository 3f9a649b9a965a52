/// Faces of a cloud: grown on even samples, coarse ones first and finer ones where nothing is explained yet, then all
/// points are given to them.
#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <span>

#include "core/ensure.h"
#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "geometry/normals/orient_normals.h"
#include "geometry/points/kd_tree.h"
#include "geometry/points/thin.h"
#include "geometry/segment/cloud_face_details.h"
#include "geometry/segment/faces.h"
#include "geometry/segment/grow_faces.h"
#include "geometry/segment/label_faces.h"
#include "geometry/segment/like_faces.h"
#include "geometry/segment/merge_faces.h"

namespace partscribe::geometry {
namespace {

constexpr int most_passes = 3;
constexpr std::size_t least_points = 50, least_members = 12;
constexpr double seed_cell = 3;          // pitches: one seed is tried in each cube of this edge
constexpr std::size_t places_asked = 8;  // about each point
constexpr double assigned_distance = 4;  // sigmas
constexpr double assigned_turn = 1.0;    // rad; near edges normals are means of both sides

/// What is known of the cloud by all passes.
struct Work {
  explicit Work(const PointCloud& given) : cloud(given) {}
  const PointCloud& cloud;
  double least_sigma = 0;
  int threads = 1;
  std::vector<GrownFace> faces;           // members: samples of their own pass
  std::vector<Vec3> places;               // samples of all passes that a face explains
  std::vector<std::uint32_t> place_face;  // their faces
  double pitch = 0;                       // of the first pass
  std::vector<std::uint32_t> label;       // of each point of the cloud
  std::vector<std::uint8_t> inner;        // of each point: all samples around it belong to one face
  std::vector<double> reach;              // of each point, mm^2: as far as places were asked
};

/// Samples by how flat their surroundings are, one of each small cube.
std::vector<std::uint32_t> seeds_of(const FaceSamples& samples) {
  std::vector<double> bend(samples.size(), 0);
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    const auto near = samples.around(i);
    for (const auto j : near) bend[i] += 1 - std::abs(samples.normals[i].dot(samples.normals[j]));
    bend[i] = near.empty() ? 1 : bend[i] / static_cast<double>(near.size());
  }
  const double edge = seed_cell * samples.pitch;
  std::map<std::array<long, 3>, std::uint32_t> best;
  for (std::uint32_t i = 0; i < samples.size(); ++i) {
    const Vec3 q = samples.points[i] / edge;
    const std::array<long, 3> cell = {std::lround(q.x()), std::lround(q.y()), std::lround(q.z())};
    const auto [at, fresh] = best.try_emplace(cell, i);
    if (!fresh && bend[i] < bend[at->second]) at->second = i;
  }
  std::vector<std::uint32_t> seeds;
  for (const auto& [cell, i] : best) seeds.push_back(i);
  std::stable_sort(seeds.begin(), seeds.end(), [&](std::uint32_t a, std::uint32_t b) { return bend[a] < bend[b]; });
  return seeds;
}

/// One pass: faces of these samples are added.
void find_faces(const FaceSamples& samples, Work& work, Context& context) {
  std::vector<GrownFace> faces;
  std::vector<std::uint8_t> taken(samples.size(), 0);
  std::vector<std::uint8_t> tried(samples.size(), 0);  // about seeds that led to nothing
  const auto seeds = seeds_of(samples);
  for (std::size_t s = 0; s < seeds.size(); ++s) {
    if (taken[seeds[s]] || tried[seeds[s]] || context.cancelled) continue;
    context.report("faces", 0.8 * static_cast<double>(s) / static_cast<double>(seeds.size()));
    auto face = grow_face(samples, seeds[s], taken, work.threads);
    if (!face) {
      tried[seeds[s]] = 1;
      for (const auto j : samples.around(seeds[s])) tried[j] = 1;
      continue;
    }
    for (const auto i : face->members) taken[i] = 1;
    faces.push_back(std::move(*face));
  }
  auto label = label_samples(samples, faces);
  for (int round = 0; round < 3 && merge_faces(samples, faces, label, work.threads); ++round)
    label = label_samples(samples, faces);
  const auto first = static_cast<std::uint32_t>(work.faces.size());
  for (std::uint32_t i = 0; i < samples.size(); ++i)
    if (label[i] != no_face) work.places.push_back(samples.points[i]), work.place_face.push_back(first + label[i]);
  work.faces.insert(work.faces.end(), std::make_move_iterator(faces.begin()), std::make_move_iterator(faces.end()));
}

/// Gives every point that is not left out to the face near it that explains it best. Places before `fresh` were there
/// when it was called last.
void assign_points(const std::vector<std::uint8_t>& left_out, std::size_t fresh, Work& work) {
  if (work.places.size() == fresh) return;
  const KdTree tree(work.places), fresh_tree(std::span(work.places).subspan(fresh));
  parallel_for(work.cloud.size(), work.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    for (std::size_t i = begin; i < end; ++i) {
      if (left_out[i]) continue;
      const Vec3& p = work.cloud.points[i];
      if (fresh > 0 && fresh_tree.nearest_one(p).sq_distance > work.reach[i]) continue;  // all is as it was
      const double sigma = std::max(work.least_sigma, static_cast<double>(work.cloud.sigma[i]));
      tree.nearest(p, places_asked, near);
      double best = 1e300;
      work.label[i] = no_face, work.reach[i] = near.size() < places_asked ? 1e300 : near.back().sq_distance;
      work.inner[i] = !near.empty() && std::all_of(near.begin(), near.end(), [&](const Neighbour& n) {
        return work.place_face[n.index] == work.place_face[near[0].index];
      });
      for (const auto& n : near) {
        if (n.sq_distance > 16 * work.pitch * work.pitch) break;
        const auto f = work.place_face[n.index];
        const GrownFace& face = work.faces[f];
        const double u = distance(face.surface, p) / sigma;
        const double c = work.cloud.normals[i].dot(face.sense * surface_normal(face.surface, p));
        const double turn = std::acos(std::clamp(c, -1.0, 1.0));
        if (std::abs(u) > assigned_distance || turn > assigned_turn) continue;
        const double cost = label_cost(u, turn);
        if (cost < best) best = cost, work.label[i] = f;
      }
    }
  });
}

/// Turns normals outward where no rays tell the side: those of samples `spacing` mm apart as orient_normals does, all
/// others as the samples beside them.
void turn_outward(const std::vector<std::uint8_t>& left_out, double spacing, PointCloud& cloud, Context& context) {
  PointCloud samples;
  for (const auto i : thinned(cloud.points, left_out, spacing))
    samples.points.push_back(cloud.points[i]), samples.normals.push_back(cloud.normals[i]);
  samples.sigma.assign(samples.size(), 0), samples.rejected.assign(samples.size(), 0);
  orient_normals(samples, 12, context, 4);
  const KdTree tree(samples.points);
  parallel_for(cloud.size(), context.threads, [&](std::size_t begin, std::size_t end) {
    std::vector<Neighbour> near;
    for (std::size_t i = begin; i < end; ++i) {
      if (left_out[i]) continue;
      tree.nearest(cloud.points[i], 4, near);
      double most = 0;
      for (const auto& n : near) {
        const double c = cloud.normals[i].dot(samples.normals[n.index]);
        if (std::abs(c) > std::abs(most)) most = c;
      }
      if (most < 0) cloud.normals[i] = -cloud.normals[i];
    }
  });
}

}  // namespace

Faces faces_of_cloud(const PointCloud& given, const FaceOptions& options, Context& context) {
  Faces result;
  result.face_of.assign(given.size(), no_face);
  std::vector<std::uint8_t> left_out(given.size(), 0);
  std::vector<double> sigmas;
  ensure(given.normals.size() == given.size() && given.sigma.size() == given.size(), "a cloud with normals and noise");
  for (std::size_t i = 0; i < given.size(); ++i) {
    left_out[i] = (given.rejected.size() == given.size() && given.rejected[i]) || given.normals[i].isZero() ||
                  !given.points[i].allFinite();
    if (!left_out[i]) sigmas.push_back(given.sigma[i]);
  }
  if (sigmas.size() < least_points) return result;
  double spacing = spacing_for_count(given.points, left_out, options.samples);
  PointCloud turned;
  const bool rays = given.rays.size() == given.size();
  if (!rays) {
    turned = given;
    turn_outward(left_out, spacing, turned, context);
  }
  const PointCloud& cloud = rays ? given : turned;
  result.noise = median_in_place(sigmas);
  const double size = cloud.bounds().diagonal();
  Work work{cloud};
  work.least_sigma = std::max({1e-6 * size, 0.02 * options.tolerance, options.least_noise, 0.5 * result.noise});
  work.threads = context.threads;
  work.label.assign(cloud.size(), no_face), work.inner.assign(cloud.size(), 0), work.reach.assign(cloud.size(), 0);
  std::vector<std::uint8_t> done = left_out;  // or given to a face
  FaceSamples first;
  for (int pass = 0; pass < most_passes; ++pass) {
    if (pass > 0) spacing = spacing_for_count(cloud.points, done, options.samples);
    const FaceSamples samples = face_samples(cloud, done, work.least_sigma, spacing, context.threads);
    if (pass == 0) work.pitch = samples.pitch, first = samples;
    if (samples.size() < 100) break;
    const std::size_t known = work.places.size();
    find_faces(samples, work, context);
    if (work.places.size() == known) break;  // and so it would be again
    assign_points(left_out, known, work);
    for (std::size_t i = 0; i < cloud.size(); ++i) done[i] = left_out[i] || work.label[i] != no_face;
    const auto left = static_cast<std::size_t>(std::count(done.begin(), done.end(), 0));
    if (samples.source.size() * 10 > 9 * static_cast<std::size_t>(sigmas.size()) || left < 100) break;
  }
  if (context.cancelled) return result;
  for (LikeFace& like : like_faces(cloud, left_out, work.label, work.faces, work.least_sigma, work.pitch)) {
    for (const auto i : like.members) work.label[i] = static_cast<std::uint32_t>(work.faces.size());
    work.faces.push_back(std::move(like.face));
  }
  std::vector<std::vector<std::uint32_t>> members(work.faces.size());
  for (std::uint32_t i = 0; i < cloud.size(); ++i)
    if (work.label[i] != no_face) members[work.label[i]].push_back(i);
  std::vector<Face> faces;
  std::vector<std::uint32_t> number(work.faces.size(), no_face);
  const LabelledCloud labelled{cloud, work.inner, work.least_sigma, work.pitch};
  for (std::uint32_t f = 0; f < work.faces.size(); ++f) {
    if (members[f].size() < least_members) continue;
    number[f] = static_cast<std::uint32_t>(faces.size());
    faces.push_back(described(labelled, work.faces[f].surface, std::move(members[f])));
  }
  std::vector<std::uint32_t> label;
  for (const auto i : first.source) label.push_back(work.label[i] == no_face ? no_face : number[work.label[i]]);
  measure_areas(first, label, faces);
  std::stable_sort(faces.begin(), faces.end(), [](const Face& a, const Face& b) {
    return a.area != b.area ? a.area > b.area : a.points > b.points;
  });
  result.faces = std::move(faces);
  for (std::uint32_t f = 0; f < result.faces.size(); ++f)
    for (const auto i : result.faces[f].members) result.face_of[i] = f;
  label.clear();
  for (const auto i : first.source) label.push_back(result.face_of[i]);
  find_neighbours(first, label, result);
  context.report("faces", 1);
  return result;
}

}  // namespace partscribe::geometry
