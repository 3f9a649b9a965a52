#include "scan/register/register_judge.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <string>

#include "core/statistics.h"
#include "scan/register/register_pair.h"
#include "scan/register/register_start.h"
#include "scan/register/register_words.h"

namespace partscribe::scan {
namespace {

/// The share of a view that may disagree with the others. At true poses it was 0.014 for range images, creases left
/// out, and 0.11 for unorganised real views. Two views that no third one can contradict must agree better, and the more
/// so the more motions their shape leaves free, because a cap fits any other cap. Without guesses only the shape speaks
/// against chance, and creases count: a part full of edges has up to 0.07 at a true pose, and much in all of its views,
/// so that one view may have three times what is usual. `motions`: those of two views that will be declared free;
/// `usual`: the median over the views.
double most_disagreement(const RegisterOptions& options, const ViewSurface& surface, std::size_t motions,
                         std::size_t views, double usual) {
  constexpr double at_most = 0.15, of_images = 0.05, of_some_motions = 0.03, of_many_motions = 0.02, by_shape = 0.04,
                   of_usual = 3;
  if (!surface.organised) return at_most;
  if (options.arrangement == Arrangement::unknown)
    return std::min(views > 2 ? std::max(by_shape, of_usual * usual) : by_shape, at_most);
  const std::size_t free = views == 2 ? motions : 0;
  return free >= 3 ? of_many_motions : free == 2 ? of_some_motions : of_images;
}

/// Of range images that lie right others look through 0.004 at most; views of a part nearly alike from two sides, some
/// of them half a turn round, through 0.02 to 0.04 of one another, and all of them measure another surface in places,
/// so that none stands out.
double most_seen_through(const RegisterOptions& options, const ViewSurface& surface) {
  constexpr double by_shape = 0.015;
  return options.arrangement == Arrangement::unknown && surface.organised ? std::min(by_shape, options.max_seen_through)
                                                                          : options.max_seen_through;
}

/// Motions of a view that most others do not share: without guesses nothing says where it lies along them. Where most
/// others share one that the view does not have, it is the view that moves against them.
std::size_t motions_of_its_own(std::size_t view, const std::vector<FreeMotion>& motions, std::size_t views) {
  return static_cast<std::size_t>(std::count_if(motions.begin(), motions.end(), [&](const FreeMotion& m) {
    const bool has = std::find(m.views.begin(), m.views.end(), view) != m.views.end();
    return has ? 2 * m.views.size() <= views : 2 * m.views.size() > views;
  }));
}

/// Without guesses a view of hardly more than one face lies on any other face; but then what it and its neighbours show
/// faces sensors that saw nothing there. Of the points of two views true poses left up to 0.05 so, real range images
/// included, a view on the wrong face 0.065 and more.
constexpr double most_unanswered_by_shape = 0.06;

/// The view for which that is so, or the reference if there is none. One view that lies wrong leaves answers open
/// between itself and its neighbours, each of these only with that one: the one that leaves most open with all others.
std::size_t least_answered(const std::vector<ViewSurface>& surfaces, const std::vector<Agreement>& agreements,
                           const std::vector<std::size_t>& used, const RegisterOptions& options) {
  std::size_t result = used.front();
  if (options.arrangement != Arrangement::unknown) return result;
  int most_open = 0;
  for (const std::size_t v : used) {
    if (!surfaces[v].organised || v == used.front()) continue;
    int sum = 0, worst = 0;
    for (const std::size_t o : used) {
      const int open = agreements[v].missing_by[o] + agreements[o].missing_by[v];
      sum += open, worst = std::max(worst, open);
    }
    // Each of the two counts half as many points of the other.
    if (worst > 1.5 * most_unanswered_by_shape * agreements[v].samples && sum > most_open) most_open = sum, result = v;
  }
  return result;
}

/// Of a view of a cap that lies on another cap than its own, much of what speaks against that are places where the
/// other sensor saw nothing: with three free motions they count together (true places left up to 0.030, a cap of a lens
/// on the other side of it 0.038).
constexpr std::size_t many_motions = 3;
constexpr double most_against_many_motions = 0.035;

/// Without guesses, of the part's size: views connected by hardly more than one face may lie on the wrong one.
constexpr double most_unsure_by_shape = 0.02;

/// Each fixes a pose by its noise; with a handful, chance does.
constexpr std::size_t fewest_matches = 50;

/// Why a view has to be refused; no reason if it has not.
struct Trouble {
  std::string reason;
  double contradicted = 0;  ///< by other views, so many times as much as is allowed; 0: the view alone is to blame
};

/// What the placed views say of each other.
struct SharedEvidence {
  const std::vector<ViewSurface>& surfaces;
  const JointResult& joint;
  const std::vector<std::size_t>& used;
  const std::vector<FreeMotion>& free_motions;
  const RegisterOptions& options;
  std::vector<Agreement> agreements;  ///< of each view with the others
  double usual_disagreement = 0;
  std::size_t unanswered = 0;  ///< least_answered
};

Trouble trouble_of(const SharedEvidence& of, std::size_t v, const RegisteredView& view) {
  const std::size_t motions = std::max(of.joint.free_directions.size(), of.free_motions.size());
  const Agreement& found = of.agreements[v];
  const double most_elsewhere =
                   most_disagreement(of.options, of.surfaces[v], motions, of.used.size(), of.usual_disagreement),
               both = found.disagreement() + found.unanswered();
  const Eigen::SelfAdjointEigenSolver<Mat3> shift(view.covariance.bottomRightCorner<3, 3>()),
      turn(view.covariance.topLeftCorner<3, 3>());
  const double sigma =
      std::sqrt(std::max({0.0, shift.eigenvalues()[2], turn.eigenvalues()[2] * of.joint.size * of.joint.size}));
  const std::size_t own =
      of.options.arrangement == Arrangement::unknown ? motions_of_its_own(v, of.free_motions, of.used.size()) : 0;
  if (own >= 2)
    return {"its shape leaves it free to move in " + std::to_string(own) + " ways, and no guess says where it lies"};
  if (v == of.used.front()) return {};
  if (view.overlap < of.options.min_overlap)
    return {"only " + in_percent(view.overlap) + " of its points are confirmed by other views, expected " +
            in_percent(of.options.min_overlap)};
  if (of.joint.matches[v] < fewest_matches)
    return {"only " + std::to_string(of.joint.matches[v]) +
            " places of its surface lie on that of other views, expected " + std::to_string(fewest_matches)};
  if (const double most_through = most_seen_through(of.options, of.surfaces[v]); view.seen_through > most_through)
    return {"another view looked through " + in_percent(view.seen_through) +
                " of what would be there, expected at most " + in_percent(most_through),
            view.seen_through / most_through};
  if (found.disagreement() > most_elsewhere)
    return {in_percent(found.disagreement()) +
                " of its points lie where other views measured another surface, expected at most " +
                in_percent(most_elsewhere),
            found.disagreement() / most_elsewhere};
  if (of.surfaces[v].organised && of.used.size() == 2 && motions >= many_motions && both > most_against_many_motions)
    return {in_percent(both) +
                " of its points lie where the other view measured another surface, or nothing, expected at most " +
                in_percent(most_against_many_motions) + " of a shape that may move in so many ways",
            both / most_against_many_motions};
  if (found.unanswered() > of.options.max_unanswered)
    return {in_percent(found.unanswered()) +
                " of its points face another sensor that saw nothing there, expected at most " +
                in_percent(of.options.max_unanswered),
            found.unanswered() / of.options.max_unanswered};
  if (v == of.unanswered)
    return {"of its points and those of another view more than " + in_percent(most_unanswered_by_shape) +
                " face a sensor that saw nothing there",
            1};
  if (of.options.arrangement == Arrangement::unknown && sigma > most_unsure_by_shape * of.joint.size)
    return {"its pose is known to " + in_steps(sigma, 0.001) + " mm only, and no guess says where it lies"};
  if (of.options.tolerance > 0 && sigma > of.options.tolerance / 4)
    return {"its pose is known to " + in_steps(sigma, 0.001) + " mm only, expected a quarter of the tolerance, " +
            in_steps(of.options.tolerance / 4, 0.001) + " mm"};
  return {};
}

}  // namespace

std::vector<std::size_t> judge_views(const std::vector<ViewSurface>& surfaces, const JointResult& joint,
                                     const std::vector<std::size_t>& used, const std::vector<FreeMotion>& free_motions,
                                     const RegisterOptions& options, std::vector<RegisteredView>& views) {
  const double reach = confirm_reach(surfaces);
  const Creases creases = options.arrangement == Arrangement::unknown ? Creases::count : Creases::left_out;
  SharedEvidence evidence{surfaces, joint, used, free_motions, options, std::vector<Agreement>(surfaces.size())};
  std::vector<double> disagreements;
  for (const std::size_t v : used) {
    evidence.agreements[v] = agreement(surfaces, joint.poses, v, joint.poses[v], used, reach, 1500, creases);
    disagreements.push_back(evidence.agreements[v].disagreement());
  }
  evidence.usual_disagreement = median(std::move(disagreements));
  evidence.unanswered = least_answered(surfaces, evidence.agreements, used, options);
  std::vector<Trouble> troubles;
  bool alone = false;
  double worst = 0;
  for (const std::size_t v : used) {
    RegisteredView& view = views[v];
    view.world_from_view = joint.poses[v], view.covariance = joint.covariance_of(v);
    const Agreement& found = evidence.agreements[v];
    if (used.size() > 1)
      view.overlap = found.overlap(), view.residual_median = found.residual, view.seen_through = found.seen_through();
    troubles.push_back(trouble_of(evidence, v, view));
    alone = alone || (!troubles.back().reason.empty() && troubles.back().contradicted == 0);
    worst = std::max(worst, troubles.back().contradicted);
  }
  std::vector<std::size_t> good;
  for (std::size_t k = 0; k < used.size(); ++k) {
    RegisteredView& view = views[used[k]];
    const Trouble& trouble = troubles[k];
    if (!trouble.reason.empty() && trouble.contradicted == (alone ? 0 : worst)) {
      view.status = ViewStatus::refused, view.reason = trouble.reason;
    } else {
      view.status = used[k] == used.front() ? ViewStatus::reference : ViewStatus::registered, view.reason.clear();
      good.push_back(used[k]);
    }
  }
  return good;
}

}  // namespace partscribe::scan
