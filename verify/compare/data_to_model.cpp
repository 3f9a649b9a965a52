#include "verify/compare/data_to_model.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <array>
#include <cmath>

#include "core/number.h"
#include "core/parallel.h"
#include "core/statistics.h"
#include "geometry/normals/local_noise.h"
#include "geometry/points/thin.h"
#include "verify/compare/chance.h"
#include "verify/compare/outliers.h"
#include "verify/report/words.h"

namespace partscribe::verify {
namespace {

constexpr std::size_t most_places = 60000;
constexpr std::size_t fewest = 9;      // points that can prove a deviation
constexpr double same_face = 0.7071;   // cosine of 45 degrees
constexpr double edge_on = 0.17;       // sine of 10 degrees: no sensor sees a surface that steeply
constexpr double false_alarm = 0.001;  // chance of refusing a true model, half for the means, half for the outliers
constexpr double trimming = 1.1;       // a mean of what lies within 2.5 deviations scatters so much more (measured)
constexpr std::size_t most_clusters_told = 3;
constexpr std::size_t spread_of = 24;  // points that a place's scatter is taken from

using Cell = std::array<std::int64_t, 3>;
Cell cell_of(const Vec3& p, double edge) {
  return {std::int64_t(std::floor(p.x() / edge)), std::int64_t(std::floor(p.y() / edge)),
          std::int64_t(std::floor(p.z() / edge))};
}

class Comparison {
 public:
  Comparison(const ScanSource& source, const MeshDistance& surface, const std::vector<Vec3>& normals,
             const VerifyOptions& options, Context& context, const BrepDistance* exact)
      : source_(source),
        surface_(surface),
        exact_(exact),
        normals_(normals),
        options_(options),
        context_(context),
        tolerance_(options.tolerance),
        far_(tolerance_ + 3 * source.noise) {}

  PointField run() {
    measure();
    if (options_.rule == Rule::max) {
      places_of_their_own();
    } else {
      make_places();
      give_suspects_their_own_place();
      const auto independent =
          std::max<std::size_t>(1, size() / static_cast<std::size_t>(neighbours_for(source_, tolerance_)));
      field_.quantile = two_sided_quantile(0.5 * false_alarm / static_cast<double>(independent));
      surface_chance_ = 0.5 * false_alarm / static_cast<double>(independent);
      average();
      find_outliers();
      judge_outliers();
    }
    summarise();
    return std::move(field_);
  }

 private:
  const ScanSource& source_;
  const MeshDistance& surface_;
  const BrepDistance* exact_;
  const std::vector<Vec3>& normals_;
  const VerifyOptions& options_;
  Context& context_;
  double tolerance_, far_;
  std::vector<std::size_t> members_;  // per place
  std::vector<Vec3> feet_;            // of the points of a dense scan on the artifact; else empty
  std::unique_ptr<KdTree> feet_tree_;
  double surface_chance_ = 0;
  PointField field_;

  std::size_t size() const { return source_.points.size(); }

  void measure() {
    field_.distance.resize(size()), field_.triangle.resize(size()), field_.outlier.assign(size(), 0),
        field_.crowded.assign(size(), 0);
    if (source_.dense) feet_.resize(size());
    surface_.for_each_closest(source_.points, context_.threads, Sign::inside_negative,
                              [&](std::size_t i, const MeshHit& hit) {
                                field_.distance[i] = hit.distance, field_.triangle[i] = hit.triangle;
                                if (source_.dense) feet_[i] = hit.point;
                              });
    if (source_.dense) feet_tree_ = std::make_unique<KdTree>(feet_);
    // The mesh was measured to lie close to these surfaces: a distance that contradicts this is not used.
    if (exact_)
      exact_->for_each_closest(source_.points, context_.threads, [&](std::size_t i, const BrepHit& hit) {
        if (std::abs(hit.distance - field_.distance[i]) <= 0.25 * tolerance_) field_.distance[i] = hit.distance;
      });
  }

  /// Both the scanned normals, whatever their sign, and those of the nearest facets agree within 45 degrees.
  bool on_same_face(std::uint32_t a, std::uint32_t b) const {
    if (normals_[field_.triangle[a]].dot(normals_[field_.triangle[b]]) < same_face) return false;
    if (source_.normals.empty()) return true;
    const Vec3 &p = source_.normals[a], &q = source_.normals[b];
    return p.squaredNorm() < 0.5 || q.squaredNorm() < 0.5 || std::abs(p.dot(q)) >= same_face;
  }

  /// Where neighbours are looked for: in a dense scan along the surface, so that they hold noise of all heights alike
  /// however near they are. Those nearest in space err alike there.
  const std::vector<Vec3>& spots() const { return source_.dense ? feet_ : source_.points; }
  const KdTree& spots_tree() const { return source_.dense ? *feet_tree_ : *source_.tree; }

  /// What noise does not explain is another surface, above this one or below it.
  bool apart(std::uint32_t a, std::uint32_t b) const {
    return source_.dense && std::abs(field_.distance[a] - field_.distance[b]) > 2 * thickness_of_noise(source_.noise);
  }

  void places_of_their_own() {
    field_.place.resize(size()), field_.places.resize(size());
    for (std::uint32_t i = 0; i < size(); ++i) {
      field_.place[i] = i;
      field_.places[i] = {i, field_.distance[i], 0, source_.spacing, true};
    }
  }

  /// One place per cube and face; every point joins one.
  void make_places() {
    field_.place.resize(size());
    const double edge = size() <= most_places ? 0 : spacing_for_count(source_.points, most_places);
    if (!(edge > 0)) {
      for (std::uint32_t i = 0; i < size(); ++i) {
        field_.place[i] = i;
        field_.places.push_back({i, 0, 0, 0, true});
      }
      members_.assign(size(), 1);
      return;
    }
    struct Keyed {
      Cell cell;
      std::uint32_t point;
    };
    std::vector<Keyed> keyed(size());
    for (std::uint32_t i = 0; i < size(); ++i) keyed[i] = {cell_of(source_.points[i], edge), i};
    std::sort(keyed.begin(), keyed.end(),
              [](const Keyed& a, const Keyed& b) { return a.cell != b.cell ? a.cell < b.cell : a.point < b.point; });
    for (std::size_t i = 0; i < keyed.size();) {
      std::size_t end = i;
      while (end < keyed.size() && keyed[end].cell == keyed[i].cell) ++end;
      const std::size_t first = field_.places.size();
      // The point in the middle of the run opens the first place: it is rarely at the cube's border.
      const std::size_t count = end - i;
      for (std::size_t k = 0; k < count; ++k) {
        const std::uint32_t p = keyed[i + (k + count / 2) % count].point;
        std::size_t at = first;
        while (at < field_.places.size() && !on_same_face(field_.places[at].point, p)) ++at;
        if (at == field_.places.size()) field_.places.push_back({p, 0, 0, 0, true}), members_.push_back(0);
        field_.place[p] = static_cast<std::uint32_t>(at);
        ++members_[at];
      }
      i = end;
    }
  }

  /// A cube's mean must not hide small features: a neighbourhood whose mean is beyond T has such a point in its middle.
  void give_suspects_their_own_place() {
    if (field_.places.size() == size()) return;
    for (std::uint32_t i = 0; i < size(); ++i) {
      if (std::abs(field_.distance[i]) <= tolerance_ || field_.places[field_.place[i]].point == i) continue;
      field_.place[i] = static_cast<std::uint32_t>(field_.places.size());
      field_.places.push_back({});
      field_.places.back().point = i;
      members_.push_back(1);
    }
  }

  void average() {
    const int least = neighbours_for(source_, tolerance_);
    parallel_for(
        field_.places.size(), context_.threads,
        [&](std::size_t begin, std::size_t end) {
          std::vector<Neighbour> near;
          std::vector<std::uint32_t> group;
          std::vector<double> values;
          for (std::size_t i = begin; i < end; ++i) {
            Place& place = field_.places[i];
            // A crowded cube is averaged as a whole, or its members would be judged by others.
            const auto wanted = static_cast<std::size_t>(std::clamp<std::size_t>(members_[i], std::size_t(least), 100));
            const std::size_t wide = std::max(wanted, spread_of);
            std::size_t asked = 2 * wide;
            double reach = 0;
            for (int attempt = 0; attempt < 2; ++attempt, asked *= 4) {
              spots_tree().nearest(spots()[place.point], asked, near);
              place.spacing =
                  spacing_from_eighth(std::sqrt(near[std::min<std::size_t>(8, near.size() - 1)].sq_distance));
              // Twice the radius of a disc that holds so many points.
              reach = 1.2 * std::min(place.spacing, source_.sparsest) * std::sqrt(double(wanted));
              group.clear();
              values.clear();
              for (const auto& n : near) {
                if (values.size() == wide || n.sq_distance > 2 * reach * reach) break;
                if (n.index != place.point && (!on_same_face(place.point, n.index) || apart(place.point, n.index)))
                  continue;
                values.push_back(field_.distance[n.index]);
                if (n.sq_distance <= reach * reach && group.size() < wanted) group.push_back(n.index);
              }
              if (group.size() >= wanted || near.size() < asked) break;
            }
            const double scatter = robust_mean(values).spread;
            values.clear();
            for (const auto p : group) values.push_back(field_.distance[p]);
            const RobustMean mean = robust_mean(values);
            place.mean = mean.mean, place.spread = mean.spread;
            place.error = trimming * std::max(source_.noise, scatter) / std::sqrt(double(group.size()));
            place.decided = field_.quantile * place.error <= tolerance_;
            if (std::abs(place.mean) > tolerance_) {
              // Of a few mixed pixels beside points of the face no mean is known well, however even the face is around
              // them.
              const double error = std::max(place.error, trimming * mean.spread / std::sqrt(double(group.size())));
              place.surface =
                  std::abs(place.mean) - field_.quantile * error > 0.5 * tolerance_ && is_surface(place, group);
            }
          }
        },
        256);
  }

  /// More than outliers: as dense as no curtain of mixed pixels, or thin and wide as only surface is.
  bool is_surface(const Place& place, const std::vector<std::uint32_t>& group) const {
    if (group.size() < fewest) return false;
    double sq_radius = 0;
    for (const auto p : group) sq_radius = std::max(sq_radius, (spots()[p] - spots()[place.point]).squaredNorm());
    const double outliers = densest_curtain * pi * sq_radius / (source_.spacing * source_.spacing);
    if (poisson_tail(group.size() - 1, outliers) < surface_chance_) return true;
    return place.spacing <= source_.sparsest && is_thin(group);
  }

  /// False for sprays (as thick as wide), for threads of points, and for curtains of points seen edge-on.
  bool is_thin(const std::vector<std::uint32_t>& group) const {
    Vec3 mean = Vec3::Zero();
    for (const auto p : group) mean += source_.points[p];
    mean /= static_cast<double>(group.size());
    Mat3 covariance = Mat3::Zero();
    for (const auto p : group) covariance += (source_.points[p] - mean) * (source_.points[p] - mean).transpose();
    Eigen::SelfAdjointEigenSolver<Mat3> solver;
    solver.computeDirect(covariance / static_cast<double>(group.size()));
    const Vec3 deviation = solver.eigenvalues().cwiseMax(0).cwiseSqrt();
    if (deviation[0] > std::max(3 * source_.noise, 0.25 * deviation[1])) return false;
    if (deviation[1] < 0.1 * deviation[2]) return false;
    if (source_.rays.empty() || deviation[0] > 0.5 * deviation[1]) return true;
    double sum = 0;
    std::size_t count = 0;
    for (const auto p : group)
      if (source_.rays[p].squaredNorm() > 0.5)
        sum += std::abs(source_.rays[p].dot(solver.eigenvectors().col(0))), ++count;
    return count == 0 || sum >= edge_on * static_cast<double>(count);
  }

  void find_outliers() {
    for (std::uint32_t i = 0; i < size(); ++i) {
      if (std::abs(field_.distance[i]) <= tolerance_) continue;
      const Place& place = field_.places[field_.place[i]];
      if (place.surface && std::abs(place.mean) > tolerance_) continue;  // the surface itself is off
      const double off = std::abs(field_.distance[i] - place.mean);
      // Where points of two surfaces mix, their mean lies on neither; a large spread shows this.
      const bool mixed = place.spread > std::max(2.5 * source_.noise, 0.5 * tolerance_);
      field_.outlier[i] = !place.surface || mixed || off > std::max(5 * source_.noise, 0.5 * tolerance_);
    }
  }

  /// Rejected points may be neither too many nor too close together.
  void judge_outliers() {
    // Beyond T, and so far that noise hardly ever gets there.
    const double off_by = std::max(tolerance_, 4 * source_.noise);
    std::vector<std::uint8_t> is_off(size(), 0);
    std::vector<std::uint32_t> index;  // of the source point; nowhere: set aside
    std::vector<double> distance;
    OutlierScene scene;
    auto take = [&](const Vec3& p, std::uint32_t from, double d, const MeshHit& hit) {
      scene.off.push_back(p), scene.feet.push_back(hit.point), scene.foot_normals.push_back(normals_[hit.triangle]);
      index.push_back(from), distance.push_back(d);
    };
    for (std::uint32_t i = 0; i < size(); ++i) {
      if (!field_.outlier[i] || std::abs(field_.distance[i]) <= off_by) continue;
      is_off[i] = 1;
      take(source_.points[i], i, field_.distance[i], surface_.closest(source_.points[i]));
    }
    for (const auto& p : source_.set_aside) {
      MeshHit hit;
      const double d = surface_.signed_distance(p, hit);
      if (std::abs(d) > off_by) take(p, ScanSource::nowhere, d, hit);
    }
    scene.most_outliers = std::max(scene.most_outliers, options_.outlier_rate);
    scene.source = &source_, scene.is_off = &is_off, scene.triangle = &field_.triangle, scene.normals = &normals_;
    const auto clusters = clusters_beyond_chance(scene, 0.5 * false_alarm, context_.threads);
    std::vector<double> values;
    std::vector<char> crowded(scene.off.size(), 0);
    for (std::size_t c = 0; c < clusters.size(); ++c) {
      const auto& members = clusters[c].members;
      values.clear();
      Vec3 middle = Vec3::Zero();
      std::size_t outside = 0, before = 0;
      for (const auto m : members)
        values.push_back(std::abs(distance[m])), middle += scene.off[m], outside += distance[m] > 0;
      for (const auto m : members) before += index[m] == ScanSource::nowhere;
      middle /= static_cast<double>(members.size());
      const double off = robust_mean(values).mean;  // of absolute values: points on either side do not cancel
      std::uint32_t nearest = members.front();
      for (const auto m : members) {
        if ((scene.off[m] - middle).squaredNorm() < (scene.off[nearest] - middle).squaredNorm()) nearest = m;
        crowded[m] = 1;
        if (index[m] != ScanSource::nowhere) field_.outlier[index[m]] = 0, field_.crowded[index[m]] = 1;
      }
      take_worst(off, scene.off[nearest]);
      if (c < most_clusters_told)
        field_.faults.push_back(
            std::to_string(members.size()) + " points" +
            (before > 0 ? " (" + std::to_string(before) + " of them set aside by a filter or by the fit)"
                        : std::string()) +
            " stand together at " + shown(scene.off[nearest], 0.01) + ", " + shown(off, 0.0001) +
            " mm off the artifact" + (outside > 0 && outside < members.size() ? " on both sides of it" : "") +
            ": too close to one another for outliers, of which chance puts " + shown(clusters[c].expected, 0.01) +
            " where there are " + std::to_string(clusters[c].most));
    }
    if (clusters.size() > most_clusters_told)
      field_.faults.push_back(std::to_string(clusters.size() - most_clusters_told) + " more such groups of points");
    std::size_t far = 0;
    for (std::size_t i = 0; i < scene.off.size(); ++i) {
      const bool added = index[i] != ScanSource::nowhere && source_.kept_place[index[i]] == ScanSource::nowhere;
      far += !crowded[i] && !added && std::abs(distance[i]) > far_;
    }
    judge_rate(far);
  }

  void judge_rate(std::size_t far) {
    const double total = static_cast<double>(source_.kept + source_.set_aside.size());
    const double rate = options_.outlier_rate;
    if (static_cast<double>(far) > rate * total + 4 * std::sqrt(rate * total) + 3)
      field_.faults.push_back(std::to_string(far) + " points (" + percent(static_cast<double>(far) / total) +
                              ") were set aside as outliers and lie farther than the tolerance from the artifact; " +
                              percent(rate) + " of the scan may be outliers");
  }

  void take_worst(double mean, const Vec3& place) {
    if (std::abs(mean) > field_.summary.local_max)
      field_.summary.local_max = std::abs(mean), field_.summary.worst = place;
  }

  void summarise() {
    DataToModel& summary = field_.summary;
    for (const auto& place : field_.places)
      if (place.surface) take_worst(place.mean, source_.points[place.point]);
    std::vector<double> sizes;
    double squares = 0;
    for (std::uint32_t i = 0; i < size(); ++i) {
      if (source_.kept_place[i] == ScanSource::nowhere) {
        if (field_.outlier[i]) continue;
      } else if (field_.outlier[i]) {
        ++summary.rejected;
        continue;
      } else {
        ++summary.points;
      }
      sizes.push_back(std::abs(field_.distance[i]));
      squares += sizes.back() * sizes.back();
    }
    summary.set_aside = source_.set_aside.size();
    summary.rejected += summary.set_aside;
    if (!sizes.empty()) {
      std::sort(sizes.begin(), sizes.end());
      auto share = [&](double q) { return sizes[std::min(sizes.size() - 1, std::size_t(q * double(sizes.size())))]; };
      summary.rms = std::sqrt(squares / static_cast<double>(sizes.size()));
      summary.p50 = share(0.5), summary.p95 = share(0.95), summary.p99 = share(0.99), summary.max = sizes.back();
    }
    if (summary.local_max > tolerance_)
      field_.faults.push_back(
          std::string(options_.rule == Rule::max ? "a scanned point is " : "the scanned surface is ") +
          shown(summary.local_max, 0.0001) + " mm off the artifact at " + shown(summary.worst, 0.01));
  }
};

}  // namespace

PointField data_to_model(const ScanSource& source, const MeshDistance& surface, const std::vector<Vec3>& normals,
                         const VerifyOptions& options, Context& context, const BrepDistance* exact) {
  return Comparison(source, surface, normals, options, context, exact).run();
}

}  // namespace partscribe::verify
