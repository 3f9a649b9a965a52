#include "fit/search/search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "core/number.h"
#include "fit/evidence/face_ends.h"
#include "fit/evidence/seen_through.h"
#include "fit/outliers/readmit.h"
#include "fit/propose/drilled.h"
#include "fit/propose/extrude.h"
#include "fit/propose/fillet.h"
#include "fit/propose/half_spaces.h"
#include "fit/propose/quadrics.h"
#include "fit/propose/revolve.h"
#include "fit/propose/ring.h"
#include "fit/propose/torus_piece.h"
#include "fit/refine/dimension.h"
#include "fit/refine/refine.h"
#include "fit/refine/tidy.h"
#include "fit/search/rivals.h"
#include "model/distance/distance.h"

namespace partscribe::fit {
namespace {

/// Its exact distance takes microseconds.
bool is_slow(const Candidate& c) {
  return std::holds_alternative<Superellipsoid>(c.shape) || std::holds_alternative<Supertoroid>(c.shape);
}

constexpr const char* bends_too_little = "bends too little to be told from a plane";

/// A round body so much larger than the data that its wall is a plane to them.
bool hardly_bends(const Candidate& c, double size) {
  constexpr double times = 5;
  const std::vector<Expr> radii = radii_of(c.shape);
  const auto large = [&](const Expr& radius) {
    return radius.is_parameter() && std::any_of(c.parameters.begin(), c.parameters.end(), [&](const Parameter& p) {
             return p.name == radius.parameter && p.value > times * size;
           });
  };
  return !radii.empty() && std::ranges::all_of(radii, large);
}

/// Share of a shape's walls that may be thinner than the noise. Bodies that end in a tip have some; in a plate that is
/// as thin as this, two sheets share the noise of one face and fit it more closely than the truth does.
double most_thin(const Candidate& c) {
  return std::holds_alternative<Extrude>(c.shape) || std::holds_alternative<Box>(c.shape) ? 0.12 : 0.3;
}

/// Share of the points on a shape that may have been seen through it: outliers next to it may, 3 % for a true shape
/// where a third of all points are outliers.
constexpr double most_through = 0.1;

/// Welsch constants for scans with many outliers, of the search and of the last steps: outliers next to the surface get
/// less weight, and at 1.5 the error due to noise grows by 8 % only. With such a narrow kernel a search would stay
/// where it starts.
constexpr double narrow = 2, narrow_last = 1.5;

double kernel_for(const Candidate& c, double among, const FitInput& input) {
  return among_outliers(input) && !axes_from_slopes(c.shape) ? among : RefineOptions{}.welsch;
}

Judged judge(Candidate candidate, const FitInput& input, Context& context) {
  Judged j;
  auto senseless = [&] {
    // Before and after: a refinement may leave the domain (a negative radius, a crossing profile).
    if (!drawable(candidate)) {
      j.reason = "makes no sense: its outline is none";
      j.evidence.local_max = input.bounds.diagonal();
      return true;
    }
    const auto outcome = check(bare_model(candidate));
    const auto* complaints = std::get_if<Complaints>(&outcome);
    if (!complaints) return false;
    j.reason = "makes no sense: " + complaints->lines.front();
    j.evidence.local_max = input.bounds.diagonal();
    return true;
  };
  if (senseless()) {
    j.candidate = std::move(candidate);
    return j;
  }
  RefineOptions quick;
  quick.points = is_slow(candidate) ? 1500 : 6000;
  quick.iterations = 25;
  quick.uncertainty = false;
  quick.welsch = kernel_for(candidate, narrow, input);
  quick.near = among_outliers(input) && !is_slow(candidate) &&
               evidence_of(candidate, input, context).local_max <= input.tolerance;
  refine(candidate, input, quick, context);
  if (senseless()) {
    j.candidate = std::move(candidate);
    return j;
  }
  j.evidence = evidence_of(candidate, input, context);
  const bool within = j.evidence.local_max <= input.tolerance;
  if (within) j.coverage = coverage_of(candidate, input, context);
  const double through = within ? share_seen_through(candidate, input, context) : 0;
  j.candidate = std::move(candidate);
  if (!within)
    j.reason = "deviates by " + millimetres(j.evidence.local_max, input.tolerance) + " at (" +
               print_number(snapped(j.evidence.worst.x(), 0.1)) + ", " +
               print_number(snapped(j.evidence.worst.y(), 0.1)) + ", " +
               print_number(snapped(j.evidence.worst.z(), 0.1)) + ")";
  else if (hardly_bends(j.candidate, input.bounds.diagonal()))
    j.reason = bends_too_little;
  else if (through > most_through)
    j.reason = print_number(std::round(100 * through)) + " % of the points on it could be seen through it only";
  else if (j.coverage.covered < 0.25)
    j.open = true,
    j.reason = "only " + print_number(std::round(100 * j.coverage.covered)) + " % of its surface was seen";
  else if (j.coverage.contradicted > 0.001)
    j.reason =
        print_number(snapped(100 * j.coverage.contradicted, 0.1)) + " % of its surface lies off the scanned mesh";
  else if (!j.candidate.unseen.empty())
    j.open = true, j.reason = j.candidate.unseen;
  else if (j.coverage.thin > most_thin(j.candidate))
    j.open = true,
    j.reason = print_number(std::round(100 * j.coverage.thin)) + " % of its walls are thinner than noise can tell";
  else
    j.meets = true;
  return j;
}

/// Nats by which `a` explains the borders of its flat faces better than `b`. With many outliers, where sparse points
/// were set aside as well, this is weak evidence; nor does it outweigh a large difference in everything else.
double ends_told(const Judged& a, const Judged& b, const FitInput& input) {
  constexpr double at_most = 200;
  const auto flat = [](const Candidate& c) {
    return std::holds_alternative<Box>(c.shape) || std::holds_alternative<Wedge>(c.shape) ||
           std::holds_alternative<Extrude>(c.shape);
  };
  if (among_outliers(input) || !flat(a.candidate) || !flat(b.candidate) ||
      std::abs(b.evidence.total() - a.evidence.total()) > at_most)
    return 0;
  return face_ends_told(a.candidate, b.candidate, input);
}

/// True if `a`, with the longer description, is to be preferred to `b`. It must cost less in total, and one of these
/// must hold:
/// - it ends where the points of its flat faces end, and the shorter one does not (ends_told);
/// - it is clearly closer to the data everywhere. With many outliers a body of another kind may come closer by fitting
///   noise, so there the shorter one must also be off by more than noise;
/// - it explains points that the shorter one does not;
/// - the tolerance is not much wider than the noise, and it is far more likely even without the points that may be
///   outliers;
/// - both descriptions are about equally long.
bool worth_its_length(const Judged& a, const Judged& b, const FitInput& input) {
  constexpr double clearly = 0.7, more_than_noise = 1.5, few_points = 15, surely = 1.5, a_number = 6;
  const CandidateEvidence &longer = a.evidence, &shorter = b.evidence;
  const double told = ends_told(a, b, input), gain = shorter.total() - longer.total() + told;
  const double explained = double(shorter.unexplained) - double(longer.unexplained);
  // A body that ends where the points of its faces end needs no shadow. That outliers lie near a superfluous face is no
  // evidence for it.
  if (told > 0 && gain - nats_per_outlier * explained > 0 && explained > -few_points) return true;
  if (!(gain > 0)) return false;
  const bool same = a.candidate.procedure == b.candidate.procedure;
  const bool off = same || !among_outliers(input) || shorter.local_max > more_than_noise * input.sampling.sigma;
  if (longer.description < shorter.description + 0.1 || (off && longer.local_max < clearly * shorter.local_max))
    return true;
  if (explained > worth_a_shape(input)) return true;
  // About equally long.
  if (same && longer.description < shorter.description + a_number && gain > more_likely) return true;
  // A hole with a few points on its wall: too few to justify a body of another kind, too many for chance.
  if (same && explained > few_points && gain > surely * far_more_likely(input)) return true;
  const bool only_noise = input.sampling.sigma > 0.2 * input.tolerance;
  const double enough = same ? more_likely : far_more_likely(input);
  return only_noise && gain - gained_by_outliers(longer, shorter, input) > enough;
}

/// Each candidate of the list was preferred to the one before it, so the last one is the choice. But the evidence from
/// the borders of faces is not always transitive: an earlier candidate may be preferred to the last one. Then the last
/// that no other clearly beats is taken.
std::size_t best_of(const std::vector<Judged>& judged, const std::vector<std::size_t>& led, const FitInput& input) {
  std::size_t best = led.back();
  double least = INFINITY;
  for (auto at = led.rbegin(); at != led.rend() && least > more_likely; ++at) {
    double behind = 0;
    for (const std::size_t other : led)
      if (other != *at && worth_its_length(judged[other], judged[*at], input) &&
          !worth_its_length(judged[*at], judged[other], input))
        behind = std::max(behind, judged[*at].evidence.total() - judged[other].evidence.total() +
                                      ends_told(judged[other], judged[*at], input));
    if (behind < least) best = *at, least = behind;
  }
  return best;
}

/// Of the candidates from `first` on, the shortest description that meets the tolerance comes first, unless a longer
/// one is worth its length. They are sorted by description.
void put_best_first(std::vector<Judged>& judged, std::size_t first, const FitInput& input) {
  std::vector<std::size_t> led{first};
  for (std::size_t i = first + 1; i < judged.size() && judged[i].meets; ++i)
    if (worth_its_length(judged[i], judged[led.back()], input)) led.push_back(i);
  const std::size_t best = best_of(judged, led, input);
  const auto begin = judged.begin();
  if (best > first)
    std::rotate(begin + std::ptrdiff_t(first), begin + std::ptrdiff_t(best), begin + std::ptrdiff_t(best) + 1);
}

/// Why a rival that meets the tolerance is not the model.
std::string why_not(const Judged& winner, const Judged& rival, const FitInput& input, Context& context) {
  // nats of misfit; odds of 400 where outliers do not bias both
  const double told_apart = among_outliers(input) ? more_likely : 6;
  const std::string by_size = told_apart_by(winner.candidate, rival.candidate, input, context);
  if (!by_size.empty()) return by_size;
  const CandidateEvidence &w = winner.evidence, &r = rival.evidence;
  const std::string longer = print_number(std::round(r.description - w.description)) + " nats more";
  const bool everywhere = among_outliers(input);
  if (const std::string open = leaves_out_outliers(w, r, input); !open.empty()) return open;
  const std::string alike =
      winner.candidate.procedure == rival.candidate.procedure ? "" : hardly_told_apart(w, r, input);
  if (r.description < w.description && alike.empty()) {
    const double more = r.total() - w.total(), ends = ends_told(winner, rival, input);
    if (more >= 0)
      return "shorter, but follows the data less closely: costs " + print_number(std::round(more)) +
             " nats more in all";
    return "shorter, and costs " + print_number(std::round(-more)) + " nats less in all" +
           (ends > 0 ? ", but goes on where the points of its faces end: " + print_number(std::round(ends)) +
                           " nats against it"
                     : " than the model as printed");
  }
  if (std::abs(r.misfit - w.misfit) < told_apart) return "fits as well, takes " + longer + " to describe";
  if (r.total() < w.total() && r.unexplained < w.unexplained)
    return "the data cannot tell whether " + print_number(double(w.unexplained - r.unexplained)) +
           " points that lie on it are outliers";
  if (!alike.empty()) return alike;
  if (everywhere && r.total() < w.total())
    return "the data cannot tell: costs " + print_number(std::round(w.total() - r.total())) +
           " nats less in all, as outliers may have it";
  return "describes the part in " + longer;
}

using Proposals = std::vector<Candidate>;

/// What the makers look at, and what was found so far.
struct Sought {
  const FitInput& input;
  const SuperellipsoidFit& hypothesis;
  const std::vector<Vec3>& directions;
  bool body = false;     ///< within tolerance
  bool drilled = false;  ///< one with holes in it
};

/// A maker of candidates.
struct Maker {
  bool last_resort;  ///< its shapes serve as a description only where no procedure of the trade does
  std::function<Proposals(const Sought&, Context&)> propose;
};

Proposals drilled_bodies(const Sought& s, Context& context);

/// In the order in which their results are listed. Outlines cost more than all else: where a body with holes was found
/// only clear ones are looked for.
const std::vector<Maker>& makers() {
  using S = const Sought&;
  static const std::vector<Maker> list = {
      {false, [](S s, Context& c) { return propose_quadrics(s.input, s.hypothesis, c); }},
      {false, [](S s, Context& c) { return propose_polyhedra(s.input, c); }},
      {false, [](S s, Context& c) { return propose_revolves(s.input, s.directions, c); }},
      {false, [](S s, Context&) { return propose_torus_piece(s.input); }},
      {false, [](S s, Context& c) { return s.body ? Proposals() : drilled_bodies(s, c); }},
      {false, [](S s, Context& c) { return propose_extrudes(s.input, s.directions, s.drilled, c); }},
      {false, [](S s, Context& c) { return s.drilled ? Proposals() : propose_fillets(s.input, c); }},
      {true, [](S s, Context&) { return propose_superellipsoids(s.input, s.hypothesis); }},
      {true, [](S s, Context& c) { return propose_rings(s.input, s.directions, c); }},
  };
  return list;
}

/// Of the bodies that all other makers find beside the holes.
Proposals drilled_bodies(const Sought& s, Context& context) {
  const auto bodies = [&](const FitInput& rest) {
    Sought undrilled{rest, s.hypothesis, s.directions};
    undrilled.body = true;  // none of them is asked for holes again
    Proposals all;
    for (const auto& maker : makers())
      if (!maker.last_resort)
        for (auto& candidate : maker.propose(undrilled, context)) all.push_back(std::move(candidate));
    return all;
  };
  return propose_drilled(s.input, bodies, context);
}

/// A ring that is better described as a torus or a turned part.
bool is_round_ring(const Candidate& c) {
  const auto* ring = std::get_if<Supertoroid>(&c.shape);
  return ring && std::any_of(c.parameters.begin(), c.parameters.end(), [&](const Parameter& p) {
           return ring->e2.is_parameter() && p.name == ring->e2.parameter && std::abs(p.value - 1) < 0.1;
         });
}

/// True if an equivalent candidate was proposed before.
bool said_before(const Judged& j, const std::vector<Judged>& judged, double tolerance) {
  const auto sorted_values = [](const Candidate& c) {
    std::vector<double> values;
    for (const Parameter& p : c.parameters) values.push_back(p.value);
    std::ranges::sort(values);
    return values;
  };
  const auto same_sizes = [&](const Candidate& a, const Candidate& b) {
    return std::ranges::equal(sorted_values(a), sorted_values(b),
                              [&](double x, double y) { return std::abs(x - y) < tolerance; });
  };
  return std::any_of(judged.begin(), judged.end(), [&](const Judged& known) {
    return known.candidate.procedure == j.candidate.procedure && known.meets == j.meets &&
           same_sizes(known.candidate, j.candidate) && std::abs(known.evidence.total() - j.evidence.total()) < 1 &&
           std::abs(known.evidence.local_max - j.evidence.local_max) < tolerance / 50;
  });
}

/// mm, from its surface; the largest number for one that makes no sense.
double distance_to(const Candidate& candidate, const Vec3& p) {
  if (!makes_sense(candidate)) return std::numeric_limits<double>::max();
  return std::abs(ModelDistance(bare_model(candidate))(candidate.scan_from_part.inverse() * p).distance);
}

/// Asks the makers of one kind and judges what they propose.
void consider_makers(ProcedureSearch& search, bool last_resort, const FitInput& input, const BuildOptions& options,
                     Context& context) {
  std::vector<Vec3> directions;
  for (int k = 2; k >= 0; --k) directions.push_back(search.hypothesis.scan_from_shape.rotation.col(k));
  const auto consider = [&](Candidate candidate) {
    if (!asked_for(options.force, candidate) || (search.found && is_round_ring(candidate))) return;
    const auto otherwise = candidate.otherwise;
    Judged j = judge(std::move(candidate), input, context);
    const auto reaches_worst = [&](const Candidate& c) { return distance_to(c, j.evidence.worst) < input.tolerance; };
    if (otherwise && !j.meets && reaches_worst(*otherwise) && !reaches_worst(j.candidate))
      if (Judged other = judge(*otherwise, input, context); other.meets) j = std::move(other);
    context.say(j.candidate.procedure + ": deviation " + millimetres(j.evidence.local_max, options.tolerance) +
                ", cost " + print_number(std::round(j.evidence.total())) + (j.reason.empty() ? "" : ", " + j.reason));
    if (!said_before(j, search.judged, options.tolerance)) search.judged.push_back(std::move(j));
  };
  Sought sought{input, search.hypothesis, directions};
  for (const auto& maker : makers()) {
    if (maker.last_resort != last_resort) continue;
    for (auto& candidate : maker.propose(sought, context))
      if (!context.cancelled) consider(std::move(candidate));
    for (const Judged& j : search.judged)
      if (j.meets) (j.candidate.steps.empty() ? sought.body : sought.drilled) = true;
  }
  if (context.cancelled) return;
  // Those that meet the tolerance by length of description, then the others by deviation.
  std::stable_sort(search.judged.begin(), search.judged.end(), [](const Judged& a, const Judged& b) {
    if (a.meets != b.meets) return a.meets;
    return a.meets ? a.evidence.description < b.evidence.description : a.evidence.local_max < b.evidence.local_max;
  });
  put_best_first(search.judged, 0, input);
}

/// Refined with all points. A length that hardly any point depends on, and that has no limit, keeps the value of the
/// search, which had set outliers aside: those few points would move it across points of other faces.
RefineReport make_exact(Candidate& candidate, const FitInput& input, const RefineOptions& options, Context& context) {
  Candidate held = candidate;
  RefineReport report = refine_with_outliers_near(candidate, input, options, context);
  for (const Parameter& p : candidate.parameters) {
    const bool unlimited =
        std::find(report.unlimited.begin(), report.unlimited.end(), p.name) != report.unlimited.end();
    const bool is_held =
        std::any_of(held.held.begin(), held.held.end(), [&](const HeldParameter& h) { return h.name == p.name; });
    if (p.quantity == Quantity::length && p.points < hardly_any_points && unlimited && !is_held)
      held.held.push_back({p.name, p.sigma});
  }
  if (held.held.size() == candidate.held.size() || context.cancelled) return report;
  candidate = std::move(held);
  return refine_with_outliers_near(candidate, input, options, context);
}

/// Fewer numbers, where that costs no more.
void relate(Candidate& exact, const FitInput& input, const RefineOptions& options, Context& context) {
  constexpr double alike = 1;  // nats: what two refinements of the same numbers may differ by
  auto fewer = related(exact, input.tolerance / 2);
  if (!fewer) return;
  make_exact(*fewer, input, options, context);
  const CandidateEvidence before = evidence_of(exact, input, context), after = evidence_of(*fewer, input, context);
  if (after.local_max <= input.tolerance && after.total() < before.total() + alike) exact = std::move(*fewer);
}

/// Adds a note on their origin to lengths that are open or that hardly any point depends on.
void name_unseen(Candidate& candidate, const std::vector<std::string>& open, const FitInput& input) {
  constexpr double on_any_face = 0.05;  // share of the outliers
  if (input.closed) return;
  const double outliers = input.outlier_share * double(input.cloud.size());
  for (auto& p : candidate.parameters) {
    const double points = double(p.points);
    if (p.quantity != Quantity::length || p.note.find("not scanned") != std::string::npos) continue;
    if (points < hardly_any_points || std::find(open.begin(), open.end(), p.name) != open.end())
      p.note += "; its face was not scanned, the data end there";
    else if (points < hardly_any_points + on_any_face * outliers)
      p.note += "; its face was not scanned or hardly, " + print_number(points) + " points may be outliers";
  }
}

/// Index of the later candidate that describes the same surface with fewer numbers, within the sigmas of a refined
/// candidate; the list's size if none meets the tolerance or if it is far less likely.
std::size_t simpler_than(const std::vector<Judged>& judged, std::size_t at, const Candidate& refined,
                         const FitInput& input) {
  const std::string kind = simpler_kind(refined);
  for (std::size_t i = at + 1; i < judged.size() && !kind.empty(); ++i)
    if (judged[i].meets && kind_of(judged[i].candidate.shape) == kind &&
        judged[i].evidence.total() - judged[at].evidence.total() < far_more_likely(input))
      return i;
  return judged.size();
}

/// True if the winner itself is far off at some place, and another candidate of the same procedure costs less and was
/// refused only for a place where outliers may be: then the winner fits outliers, and its numbers are not those of the
/// part.
bool bent_by_outliers(const ProcedureSearch& search, std::size_t at, const FitInput& input) {
  constexpr double far_off = 0.6;
  const Judged& winner = search.judged[at];
  if (!(winner.evidence.local_max > far_off * input.tolerance)) return false;
  return std::any_of(search.judged.begin(), search.judged.end(), [&](const Judged& j) {
    const bool same = j.candidate.procedure == winner.candidate.procedure;
    return !j.meets && same && !off_where_outliers_are(winner.evidence, j.evidence, input).empty();
  });
}

/// Refuses a candidate that fits the data if the data do not determine its numbers. With many outliers the
/// candidates that fit far less closely are refused as well.
void refuse(ProcedureSearch& search, std::size_t at, const std::string& reason, const FitInput& input) {
  Judged& refused = search.judged[at];
  refused.meets = false, refused.open = true, refused.reason = reason;
  const auto next = search.judged.begin() + static_cast<std::ptrdiff_t>(at) + 1;
  for (auto j = next; j != search.judged.end() && among_outliers(input); ++j)
    if (j->meets && j->evidence.total() > refused.evidence.total() + far_more_likely(input))
      j->meets = false, j->reason = "follows the data far less closely than a shape whose numbers they do not fix";
  std::stable_partition(next, search.judged.end(), [](const Judged& j) { return j.meets; });
  put_best_first(search.judged, at + 1, input);
}

/// What became of the best candidate.
struct Printed {
  std::size_t winner = 0;
  Model model;
  CandidateEvidence evidence;
  double covered = 0;
};

/// With many outliers the last steps, which give points beside the surface less weight, may end elsewhere than the
/// search: at a higher cost than another candidate of the same procedure. Moves that other one next in the list; false
/// if there is none.
bool puts_cheaper_next(ProcedureSearch& search, const FitInput& input) {
  if (!among_outliers(input)) return false;
  const std::size_t at = search.winner;
  const auto& judged = search.judged;
  std::size_t cheapest = judged.size();
  for (std::size_t i = at + 1; i < judged.size() && judged[i].meets; ++i)
    if (judged[i].candidate.procedure == judged[at].candidate.procedure &&
        judged[i].evidence.total() + more_likely < search.evidence.total() &&
        (cheapest == judged.size() || judged[i].evidence.total() < judged[cheapest].evidence.total()))
      cheapest = i;
  if (cheapest == judged.size()) return false;
  const auto next = search.judged.begin() + static_cast<std::ptrdiff_t>(at) + 1,
             other = search.judged.begin() + static_cast<std::ptrdiff_t>(cheapest);
  std::rotate(next, other, other + 1);
  return true;
}

/// Why a refined candidate is rejected however well it fits; else empty.
std::string numbers_unknown(const Candidate& exact, const FitInput& input) {
  if (hardly_bends(exact, input.bounds.diagonal())) return bends_too_little;
  const std::string radius = unknown_radius(exact);
  return radius.empty() ? unknown_wall(exact) : radius;
}

/// Makes the best candidate exact and its numbers fit for print; the next best where that leaves the tolerance.
void choose(ProcedureSearch& search, const FitInput& input, const BuildOptions& options, Context& context) {
  context.report("refine", 0.6);
  search.winner = search.judged.size(), search.found = false;
  std::optional<Printed> dearer;  // unless the next costs more
  for (std::size_t i = 0; i < search.judged.size() && search.judged[i].meets; ++i) {
    if (bent_by_outliers(search, i, input)) {
      search.judged[i].meets = false,
      search.judged[i].reason = "costs more than another that outliers keep from being within tolerance";
      break;  // the next would fit them as well
    }
    Candidate exact = search.judged[i].candidate;
    RefineOptions full;
    full.points = is_slow(exact) ? 2000 : 30000;
    full.near = among_outliers(input);
    full.welsch = kernel_for(exact, narrow_last, input);
    RefineReport report = make_exact(exact, input, full, context);
    if (const std::size_t simpler = simpler_than(search.judged, i, exact, input); simpler < search.judged.size()) {
      const auto first = search.judged.begin() + static_cast<std::ptrdiff_t>(i),
                 other = search.judged.begin() + static_cast<std::ptrdiff_t>(simpler);
      std::rotate(first, other, other + 1);
      exact = search.judged[i].candidate;
      full.welsch = kernel_for(exact, narrow_last, input);
      report = make_exact(exact, input, full, context);
    }
    if (const std::string unknown = numbers_unknown(exact, input); !unknown.empty()) {
      refuse(search, i, unknown, input);
      continue;
    }
    name_unseen(exact, report.unlimited, input);
    dimension(exact);
    relate(exact, input, full, context);
    for (const bool nominal : {true, false}) {
      if (nominal && !options.nominal) continue;
      Candidate tidy = exact;
      snap_parameters(tidy, {options.tolerance, input.bounds.diagonal(), nominal});
      // Round numbers shift what depends on them: the rest is refined once more.
      Candidate settled = tidy;
      RefineOptions rest;
      rest.points = 6000, rest.iterations = 8, rest.uncertainty = false;
      rest.near = full.near, rest.welsch = full.welsch;
      for (const auto& p : tidy.parameters) rest.fixed.push_back(p.name);
      refine(settled, input, rest, context);
      tidy.scan_from_part = settled.scan_from_part;
      Model proposal = model_of(tidy, input);
      if (std::holds_alternative<Complaints>(check(proposal))) continue;
      Candidate as_printed = tidy;
      as_printed.scan_from_part = evaluate(proposal.scan_from_part, values_of(proposal));
      search.evidence = evidence_of(as_printed, input, context);
      if (search.evidence.local_max > options.tolerance) continue;
      search.covered = coverage_of(as_printed, input, context).covered;
      search.model = std::move(proposal);
      search.found = true;
      search.winner = i;
      break;
    }
    if (search.found && !dearer && puts_cheaper_next(search, input)) {
      dearer = Printed{i, std::move(search.model), search.evidence, search.covered};
      search.found = false;
      continue;
    }
    if (search.found || dearer) break;
    search.judged[i].meets = false,
    search.judged[i].reason = "left the tolerance when its numbers were rounded for print";
    put_best_first(search.judged, i + 1, input);
  }
  if (dearer && !(search.found && search.evidence.total() < dearer->evidence.total())) {
    search.winner = dearer->winner, search.model = std::move(dearer->model), search.evidence = dearer->evidence,
    search.covered = dearer->covered;
    search.found = true;
  }
}

}  // namespace

std::string reason_of(const Judged& winner, const Judged& rival, const FitInput& input, Context& context) {
  if (rival.reason.empty()) return why_not(winner, rival, input, context);
  const double margin = among_outliers(input) ? far_more_likely(input) : 0;
  if (rival.open && rival.evidence.total() < winner.evidence.total() + margin)
    return "the data cannot tell: " + rival.reason;
  std::string open = off_where_outliers_are(winner.evidence, rival.evidence, input);
  if (open.empty()) open = leaves_out_outliers(winner.evidence, rival.evidence, input);
  return open.empty() ? rival.reason : open + ", but " + rival.reason;
}

bool is_rough(const ProcedureSearch& search, const FitInput& input) {
  constexpr std::size_t many_faces = 9, some_faces = 7;
  constexpr double rough = 0.31, rough_among_outliers = 0.4;  // nats per point; 0.25 where there is only noise
  // sigma: of the largest local deviation; the truth of three hard plates has 0.8 to 1
  constexpr double off_among_outliers = 1;
  const auto deepest = std::max_element(input.facet_depth.begin(), input.facet_depth.end());
  const double facets = deepest == input.facet_depth.end() ? 0 : 1.5 * double(*deepest);  // these are not the body's
  if (!search.found) return false;
  const Shape& shape = search.judged[search.winner].candidate.shape;
  const auto* body = std::get_if<HalfSpaces>(&shape);
  const CandidateEvidence& e = search.evidence;
  const double misfit = (e.misfit - nats_per_outlier * double(e.unexplained)) / double(input.cloud.size());
  if (body && body->planes.size() >= some_faces && facets == 0 && misfit > rough) return true;
  const bool flat = body || std::holds_alternative<Box>(shape) || std::holds_alternative<Wedge>(shape);
  const bool plate = std::holds_alternative<Extrude>(shape);
  if (among_outliers(input)) {
    // Flat faces cut the corners off a rounded block within the tolerance, and straight walls pass through a ring's
    // section.
    if (flat && misfit > rough_among_outliers) return true;
    if ((flat || plate) && e.local_max > off_among_outliers * input.sampling.sigma) return true;
  }
  if (!(e.local_max > std::max({1.5 * input.sampling.sigma, 0.5 * input.tolerance, facets}))) return false;
  return body ? body->planes.size() >= many_faces
              : plate || std::holds_alternative<Torus>(shape) || std::holds_alternative<Revolve>(shape) ||
                    std::holds_alternative<Ellipsoid>(shape);
}

void search_procedure(ProcedureSearch& search, bool last_resort, const FitInput& input, const BuildOptions& options,
                      Context& context) {
  if (!last_resort) {
    context.report("hypothesis", 0.15);
    search.hypothesis = recover_superellipsoid(input.cloud.points, context, input.cloud.normals);
    context.say("hypothesis: " + search.hypothesis.hypothesis.suggests);
  }
  if (options.force == only_a_mesh) return;
  context.report("candidates", 0.25);
  const std::size_t known = search.judged.size();
  consider_makers(search, last_resort, input, options, context);
  if (search.found && search.judged.size() == known) return;  // nothing to choose from anew
  if (!context.cancelled) choose(search, input, options, context);
}

void choose_another(ProcedureSearch& search, const std::string& reason, const FitInput& input,
                    const BuildOptions& options, Context& context) {
  Judged refused = std::move(search.judged[search.winner]);
  refused.meets = false, refused.refused = true, refused.reason = reason;
  search.judged.erase(search.judged.begin() + std::ptrdiff_t(search.winner));
  search.judged.push_back(std::move(refused));
  std::stable_partition(search.judged.begin(), search.judged.end(), [](const Judged& j) { return j.meets; });
  put_best_first(search.judged, 0, input);
  choose(search, input, options, context);
}

}  // namespace partscribe::fit
