#include "fit/search/search.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <optional>

#include "core/number.h"
#include "fit/evidence/seen_through.h"
#include "fit/outliers/readmit.h"
#include "fit/propose/drilled.h"
#include "fit/propose/extrude.h"
#include "fit/propose/fillet.h"
#include "fit/propose/half_spaces.h"
#include "fit/propose/quadrics.h"
#include "fit/propose/revolve.h"
#include "fit/propose/ring.h"
#include "fit/propose/sculpted.h"
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
  constexpr double hopeless = 5;  // tolerances: where few points leave that, more would not help
  RefineOptions quick;
  quick.iterations = 25;
  quick.uncertainty = false;
  quick.welsch = kernel_for(candidate, narrow, input);
  quick.near = among_outliers(input) && !is_slow(candidate) &&
               evidence_of(candidate, input, context).local_max <= input.tolerance;
  for (const std::size_t points :
       is_slow(candidate) ? std::vector<std::size_t>{300, 1500} : std::vector<std::size_t>{6000}) {
    quick.points = points;
    refine(candidate, input, quick, context);
    if (senseless()) {
      j.candidate = std::move(candidate);
      return j;
    }
    j.evidence = evidence_of(candidate, input, context);
    if (j.evidence.local_max >= hopeless * input.tolerance) break;
  }
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
  else if (j.coverage.contradicted > most_contradicted)
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

/// Those that meet the tolerance come first, the cheapest before all others; then the others by deviation.
void put_best_first(std::vector<Judged>& judged) {
  std::stable_sort(judged.begin(), judged.end(), [](const Judged& a, const Judged& b) {
    if (a.meets != b.meets) return a.meets;
    return a.meets ? a.evidence.total() < b.evidence.total() : a.evidence.local_max < b.evidence.local_max;
  });
}

using Proposals = std::vector<Candidate>;

/// What the makers look at, and what was found so far.
struct Sought {
  const FitInput& input;
  const SuperellipsoidFit& hypothesis;
  const std::vector<Vec3>& directions;
  std::shared_ptr<const Faces>& faces;  ///< of the input, once somebody asked for them
  bool body = false;                    ///< within tolerance
  bool drilled = false;                 ///< one with holes in it
};

const Faces& faces_in(const Sought& s, Context& context) {
  if (!s.faces) {
    FaceOptions options;
    options.tolerance = s.input.tolerance;
    options.least_noise = 0.1 * s.input.tolerance, options.samples = 12000;
    s.faces = std::make_shared<const Faces>(s.input.closed ? faces_of(*s.input.scan, options, context)
                                                           : faces_of_cloud(s.input.cloud, options, context));
  }
  return *s.faces;
}

/// A maker of candidates.
struct Maker {
  bool last_resort;                    ///< its shapes serve as a description only where no procedure of the trade does
  std::vector<std::string> first_for;  ///< words of the procedures for which it is the one to ask
  std::function<Proposals(const Sought&, Context&)> propose;
};

Proposals drilled_bodies(const Sought& s, Context& context);
Proposals sculpted_bodies(const Sought& s, Context& context);

/// In the order in which their results are listed. Outlines cost more than all else: where a body with holes was found
/// only clear ones are looked for.
const std::vector<Maker>& makers() {
  using S = const Sought&;
  static const std::vector<Maker> list = {
      {false, {"sphere", "ellipsoid"}, [](S s, Context& c) { return propose_quadrics(s.input, s.hypothesis, c); }},
      {false, {"box", "wedge"}, [](S s, Context& c) { return propose_polyhedra(s.input, c); }},
      {false,
       {"cylinder", "cone", "revolve"},
       [](S s, Context& c) { return propose_revolves(s.input, s.directions, c); }},
      {false, {}, [](S s, Context&) { return propose_torus_piece(s.input); }},
      {false, {}, [](S s, Context& c) { return s.body ? Proposals() : drilled_bodies(s, c); }},
      {false, {}, [](S s, Context& c) { return propose_extrudes(s.input, s.directions, s.drilled, c); }},
      {false, {}, [](S s, Context& c) { return s.drilled ? Proposals() : propose_fillets(s.input, c); }},
      {true, {}, [](S s, Context& c) { return s.body || s.drilled ? Proposals() : sculpted_bodies(s, c); }},
      {true, {}, [](S s, Context&) { return propose_superellipsoids(s.input, s.hypothesis); }},
      {true, {}, [](S s, Context& c) { return propose_rings(s.input, s.directions, c); }},
  };
  return list;
}

/// What all makers but those of the last resort propose for other points of the same part; `holes`: with holes as well.
BodyMaker bodies_for(const Sought& s, bool holes, Context& context) {
  return [&s, holes, &context](const FitInput& points) {
    std::shared_ptr<const Faces> faces;
    Sought sought{points, s.hypothesis, s.directions, faces};
    sought.body = !holes;
    Proposals all;
    for (const auto& maker : makers())
      if (!maker.last_resort)
        for (auto& candidate : maker.propose(sought, context)) all.push_back(std::move(candidate));
    return all;
  };
}

/// Of the bodies that the others find beside the holes.
Proposals drilled_bodies(const Sought& s, Context& context) {
  return propose_drilled(s.input, faces_in(s, context), bodies_for(s, false, context), context);
}

/// Of the bodies that the others find where the free-form faces have lids.
Proposals sculpted_bodies(const Sought& s, Context& context) {
  return propose_sculpted(s.input, faces_in(s, context), bodies_for(s, true, context), context);
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

/// Whether what the hypothesis calls for was found and leaves nothing to others: it follows the data as closely as
/// noise allows, and nearly all of its surface was seen. What else explains the data is the same surface, said at
/// length.
bool settled(const std::vector<Judged>& judged, const std::string& called, const FitInput& input) {
  constexpr double as_noise = 1.1, nearly_all = 0.95;
  return !among_outliers(input) && std::ranges::any_of(judged, [&](const Judged& j) {
    return j.meets && procedure_word(j.candidate.procedure) == called && j.evidence.roughness < as_noise &&
           j.coverage.covered > nearly_all;
  });
}

/// Asks the makers of one kind and judges what they propose. The one that makes what the hypothesis calls for comes
/// first.
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
  Sought sought{input, search.hypothesis, directions, search.faces};
  const std::string called = procedure_word(search.hypothesis.hypothesis.suggests);
  std::vector<const Maker*> order;
  for (const auto& maker : makers())
    if (maker.last_resort == last_resort) order.push_back(&maker);
  std::stable_partition(order.begin(), order.end(), [&](const Maker* maker) {
    return std::ranges::find(maker->first_for, called) != maker->first_for.end();
  });
  for (const Maker* maker : order) {
    for (auto& candidate : maker->propose(sought, context))
      if (!context.cancelled) consider(std::move(candidate));
    for (const Judged& j : search.judged)
      if (j.meets) (j.candidate.steps.empty() ? sought.body : sought.drilled) = true;
    if (settled(search.judged, called, input)) {
      context.say("the hypothesis, " + called + ", explains all: nothing else is tried");
      break;
    }
  }
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
  if (!makes_sense(*fewer)) return;
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

/// Index of a candidate that describes the same surface with fewer numbers, within the sigmas of the best one, refined;
/// the list's size if none meets the tolerance or if it is clearly less likely.
std::size_t simpler_than(const std::vector<Judged>& judged, const Candidate& refined) {
  const std::string kind = simpler_kind(refined);
  for (std::size_t i = 1; i < judged.size() && !kind.empty(); ++i)
    if (judged[i].meets && kind_of(judged[i].candidate.shape) == kind &&
        judged[i].evidence.total() - judged.front().evidence.total() < told_apart)
      return i;
  return judged.size();
}

/// Why a refined candidate is rejected however well it fits; else empty.
std::string numbers_unknown(const Candidate& exact, const FitInput& input) {
  if (hardly_bends(exact, input.bounds.diagonal())) return bends_too_little;
  const std::string radius = unknown_radius(exact);
  return radius.empty() ? unknown_wall(exact) : radius;
}

/// How a candidate is refined to the last.
RefineOptions to_the_last(const Candidate& candidate, const FitInput& input) {
  RefineOptions options;
  options.points = is_slow(candidate) ? 2000 : 30000;
  options.near = among_outliers(input);
  options.welsch = kernel_for(candidate, narrow_last, input);
  return options;
}

/// The exact candidate with numbers fit for print, nominal ones where wanted, as the search's result. False if that
/// leaves the tolerance.
bool print(ProcedureSearch& search, const Candidate& exact, bool nominal, const FitInput& input, Context& context) {
  Candidate tidy = exact;
  snap_parameters(tidy, {input.tolerance, input.bounds.diagonal(), nominal});
  // Round numbers shift what depends on them: the rest is refined once more.
  RefineOptions rest = to_the_last(exact, input);
  rest.points = 6000, rest.iterations = 8, rest.uncertainty = false;
  for (const auto& p : tidy.parameters) rest.fixed.push_back(p.name);
  Candidate settled = tidy;
  refine(settled, input, rest, context);
  tidy.scan_from_part = settled.scan_from_part;
  Model proposal = model_of(tidy, input);
  if (std::holds_alternative<Complaints>(check(proposal))) return false;
  tidy.scan_from_part = evaluate(proposal.scan_from_part, values_of(proposal));
  search.evidence = evidence_of(tidy, input, context);
  if (search.evidence.local_max > input.tolerance) return false;
  search.covered = coverage_of(tidy, input, context).covered;
  search.model = std::move(proposal);
  return true;
}

/// Makes the best candidate exact and its numbers fit for print; the next best where that leaves the tolerance or the
/// data do not determine the numbers.
void choose(ProcedureSearch& search, const FitInput& input, const BuildOptions& options, Context& context) {
  context.report("refine", 0.6);
  search.found = false;
  auto& judged = search.judged;
  const auto best_meets = [&] { return put_best_first(judged), !judged.empty() && judged.front().meets; };
  while (best_meets() && !context.cancelled) {
    Candidate exact = judged.front().candidate;
    RefineReport report = make_exact(exact, input, to_the_last(exact, input), context);
    if (const std::size_t simpler = simpler_than(judged, exact); simpler < judged.size()) {
      std::rotate(judged.begin(), judged.begin() + std::ptrdiff_t(simpler),
                  judged.begin() + std::ptrdiff_t(simpler) + 1);
      exact = judged.front().candidate;
      report = make_exact(exact, input, to_the_last(exact, input), context);
    }
    std::string reason = numbers_unknown(exact, input);
    judged.front().open = !reason.empty();
    if (reason.empty()) {
      name_unseen(exact, report.unlimited, input);
      dimension(exact);
      relate(exact, input, to_the_last(exact, input), context);
      search.found = (options.nominal && print(search, exact, true, input, context)) ||
                     print(search, exact, false, input, context);
      if (search.found) return;
      reason = "left the tolerance when its numbers were rounded for print";
    }
    judged.front().meets = false, judged.front().reason = reason;
  }
}

}  // namespace

std::string reason_of(const Judged& winner, const Judged& rival, const FitInput& input, Context& context) {
  const CandidateEvidence &w = winner.evidence, &r = rival.evidence;
  const std::string by_size =
      rival.reason.empty() ? told_apart_by(winner.candidate, rival.candidate, input, context) : std::string();
  if (!by_size.empty()) return by_size;
  const double more = std::round(r.total() - w.total());
  const std::string costs =
      "costs " + print_number(std::abs(more)) + (more < 0 ? " nats less" : " nats more") + " in all";
  if (winner.candidate.procedure == rival.candidate.procedure && rival.reason.empty()) return costs;
  // What lies on the winner only may be outliers.
  const double of_outliers = among_outliers(input) ? std::max(0.0, r.far_out - w.far_out) : 0;
  const bool makes_sense = r.description > 0, open = makes_sense && more - of_outliers < told_apart;
  if (rival.reason.empty()) return open ? "the data cannot tell: " + costs : costs;
  if (rival.open && open) return "the data cannot tell: " + rival.reason;
  if (among_outliers(input) && open && r.local_max > input.tolerance)
    return "the data cannot tell whether what it leaves out are outliers: " + costs + ", but " + rival.reason;
  return rival.reason;
}

bool is_rough(const ProcedureSearch& search) {
  constexpr double rough = 1.25;
  return search.found && search.judged.front().evidence.roughness > rough;
}

void search_procedure(ProcedureSearch& search, bool last_resort, const FitInput& input, const BuildOptions& options,
                      Context& context) {
  if (!last_resort) {
    context.report("hypothesis", 0.15);
    search.hypothesis = recover_superellipsoid(input.cloud.points, context, input.cloud.normals);
    context.say("hypothesis: " + search.hypothesis.hypothesis.suggests);
  }
  if (options.force == only_a_mesh || options.force == only_free_form) return;
  context.report("candidates", 0.25);
  const std::size_t known = search.judged.size();
  consider_makers(search, last_resort, input, options, context);
  if (search.found && search.judged.size() == known) return;  // nothing to choose from anew
  if (!context.cancelled) choose(search, input, options, context);
}

void choose_another(ProcedureSearch& search, const std::string& reason, const FitInput& input,
                    const BuildOptions& options, Context& context) {
  Judged& refused = search.judged.front();
  refused.meets = false, refused.refused = true, refused.reason = reason;
  choose(search, input, options, context);
}

}  // namespace partscribe::fit
