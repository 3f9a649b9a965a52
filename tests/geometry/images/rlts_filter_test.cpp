#include "geometry/images/rlts_filter.h"

#include <Eigen/Geometry>
#include <algorithm>
#include <catch2/catch.hpp>
#include <cmath>
#include <cstring>

#include "testing/range_scenes.h"

using namespace partscribe::geometry;
using namespace partscribe::testing;

namespace {

FilteredImage filtered(const RangeImage& image, const RltsOptions& options = {}, int threads = 1) {
  Context context;
  context.threads = threads;
  return rlts_filter(image, options, context);
}

/// Root mean square of the kept pixels' errors in columns [from, to).
double rms(const RangeScene& s, const FilteredImage& f, int from, int to) {
  double sum = 0;
  int count = 0;
  for (int r = 0; r < s.image.height; ++r)
    for (int c = from; c < to; ++c) {
      const auto i = static_cast<std::size_t>(r * s.image.width + c);
      if (!f.kept[i] || std::isnan(s.truth[i])) continue;
      sum += (f.depth[i] - s.truth[i]) * (f.depth[i] - s.truth[i]), ++count;
    }
  return std::sqrt(sum / std::max(count, 1));
}

double kept_share(const RangeScene& s, const FilteredImage& f) {
  double good = 0, kept = 0;
  for (std::size_t i = 0; i < f.kept.size(); ++i)
    if (!std::isnan(s.truth[i]) && s.flipped[i] < 0) ++good, kept += f.kept[i];
  return kept / good;
}

}  // namespace

TEST_CASE("rlts filter: a plane of any slope is kept, with the noise and the gain that are stated") {
  for (const double slope : {0.0, 0.1, 0.7, 2.0}) {
    const auto s = range_scene({.sigma = 0.05}, [&](double x, double y) { return 5 + slope * x * 0.3 + 0.1 * y; });
    const auto f = filtered(s.image);
    CHECK(kept_share(s, f) > 0.995);
    CHECK(rms(s, f, 4, 76) < 1.1 * 0.05 / 5 * 1.05);
    double pull = 0;
    int count = 0;
    for (std::size_t i = 0; i < f.depth.size(); ++i) {
      CHECK(f.raw_sigma[i] == Approx(0.05).epsilon(0.08));
      if (!f.kept[i]) continue;
      const double u = (f.depth[i] - s.truth[i]) / static_cast<double>(f.sigma[i]);
      pull += u * u, ++count;
    }
    CHECK(std::sqrt(pull / count) == Approx(1).epsilon(0.1));
  }
}

TEST_CASE("rlts filter: steps of every height stay where they are") {
  for (const double height : {0.02, 0.1, 0.2, 0.5, 2.0, 20.0, 60.0}) {
    const auto s = range_scene({.height = 100, .sigma = 0.02},
                               [&](double x, double y) { return 20 + (x < 40 ? 0 : height) + 0.05 * y; });
    const auto f = filtered(s.image);
    INFO("height " << height);
    CHECK(kept_share(s, f) > 0.99);
    // Below some five noise levels no 5x5 window can tell a step from a slope; that costs at most a part of its height.
    CHECK(rms(s, f, 38, 42) < (height > 0.15 ? 0.7 * 0.02 : 0.5 * height));
    CHECK(rms(s, f, 4, 36) < 1.1 * 0.02 / 5 * 1.05);
  }
}

TEST_CASE("rlts filter: creases and round surfaces are not flattened") {
  const auto roof = range_scene({}, [](double x, double y) { return 40 - std::abs(x - 40.3) + 0.2 * y; });
  const auto f = filtered(roof.image);
  CHECK(kept_share(roof, f) > 0.99);
  CHECK(rms(roof, f, 38, 43) < 0.7 * 0.02);
  const auto ball = range_scene({}, [](double x, double y) {
    const double d = 60 * 60 - (x - 40) * (x - 40) - (y - 30) * (y - 30);
    return 70 - std::sqrt(d);
  });
  const auto g = filtered(ball.image);
  CHECK(kept_share(ball, g) > 0.99);
  CHECK(rms(ball, g, 4, 76) < 0.4 * 0.02);
  CHECK(std::count(g.model.begin(), g.model.end(), RltsModel::quadric) > 4000);
}

TEST_CASE("rlts filter: a crease that passes for a quadric is not rounded") {
  // Its slope changes by some seven noise levels per pixel: less than that a window over it cannot tell from a bend.
  for (const double turn : {6.0, 7.0, 8.0}) {
    const auto s =
        range_scene({}, [&](double x, double y) { return 20 + 0.5 * turn * 0.02 * std::abs(x - 40) + 0.1 * y; });
    const auto f = filtered(s.image);
    INFO("turn " << turn);
    CHECK(kept_share(s, f) > 0.99);
    double most = 0;
    for (std::size_t i = 0; i < f.kept.size(); ++i)
      if (f.kept[i]) most = std::max(most, std::abs(f.depth[i] - s.truth[i]));
    CHECK(most < 4 * 0.02);
  }
}

TEST_CASE("rlts filter: a crease that hides in the noise makes places uncertain, and a plane hardly") {
  // Slopes that change by `turn` deviations a pixel: too little for two planes to be significant in every window.
  struct Pulls {
    double rms = 0, beyond = 0;
  };
  const auto pulls = [](double turn) {
    const double sigma = 0.2;
    const auto s = range_scene({.height = 160, .sigma = sigma}, [&](double x, double y) {
      return 10 + 0.5 * turn * sigma * std::abs(x - 40.2) + 0.1 * y;
    });
    const auto f = filtered(s.image);
    Pulls noise, all;
    int count = 0;
    for (int r = 4; r < s.image.height - 4; ++r)
      for (int c = 38; c < 43; ++c) {
        const auto i = static_cast<std::size_t>(r * s.image.width + c);
        if (!f.kept[i] || std::isnan(s.truth[i])) continue;
        const double off = f.depth[i] - s.truth[i], by_noise = off / f.sigma[i],
                     in_all = off / std::hypot(f.sigma[i], f.doubt[i]);
        noise.rms += by_noise * by_noise, noise.beyond += std::abs(by_noise) > 4;
        all.rms += in_all * in_all, all.beyond += std::abs(in_all) > 4;
        ++count;
      }
    for (Pulls* p : {&noise, &all}) p->rms = std::sqrt(p->rms / count), p->beyond /= count;
    return std::pair(noise, all);
  };
  for (const double turn : {1.5, 2.0, 3.0}) {
    INFO("turn " << turn);
    const auto [noise, all] = pulls(turn);
    UNSCOPED_INFO("by noise " << noise.rms << ", " << noise.beyond << " beyond four; in all " << all.rms << ", "
                              << all.beyond);
    CHECK(noise.rms > 1.2 * all.rms);
    CHECK(all.rms < 1.7);
    CHECK(all.beyond < 0.3 * noise.beyond);
  }
  const auto [by_noise, flat] = pulls(0);
  CHECK(flat.rms > 0.8);
  CHECK(flat.rms < 1.05);
}

TEST_CASE("rlts filter: pixels beside a bent edge stay, though no two planes explain their windows") {
  // Twelve round pegs of five pixels radius before a plate.
  for (const std::uint64_t seed : {1, 2, 4, 5}) {
    const auto s = range_scene({.seed = seed}, [](double x, double y) {
      const double across = std::fmod(x, 20.0) - 10, down = std::fmod(y, 20.0) - 10.3;
      return std::hypot(across, down) < 5 ? 20 + 0.3 * x : 40 + 0.2 * y;
    });
    const auto f = filtered(s.image);
    CHECK(kept_share(s, f) > 0.995);  // 0.986 if they are thrown away
    double most = 0, most_stated = 0;
    for (std::size_t i = 0; i < f.kept.size(); ++i) {
      if (!f.kept[i]) continue;
      const double off = std::abs(f.depth[i] - s.truth[i]);
      most = std::max(most, off), most_stated = std::max(most_stated, off / static_cast<double>(f.sigma[i]));
    }
    CHECK(most < 4.5 * 0.02);  // 5 if the likeliest two planes are believed
    CHECK(most_stated < 9);    // 17 then
  }
}

TEST_CASE("rlts filter: the bend of a round face is not carried across its edge") {
  // An arc that falls off in a plane; every seventh sample is missing, so that few windows are whole.
  constexpr double radius = 10, end = 0.7, sigma = 0.2;
  for (const std::uint64_t seed : {1, 2, 3}) {
    Random missing(seed + 50);
    const auto s = range_scene({.height = 80, .sigma = sigma, .q = 0.05, .seed = seed}, [&](double x, double y) {
      if (missing.uniform() < 0.15) return std::numeric_limits<double>::quiet_NaN();
      const double u = std::max((x - 40) / radius, -2 * end) + end;
      return 100 + 0.2 * y - radius * std::sqrt(1 - std::pow(std::min(u, end), 2)) - std::max(x - 40, 0.0);
    });
    const auto f = filtered(s.image);
    double moved = 0, off = 0;
    for (std::size_t i = 0; i < f.kept.size(); ++i) {
      if (!f.kept[i]) continue;
      const double raw = s.image.z0 + s.image.q * (s.image.codes[i] - 1), noise = f.raw_sigma[i];
      moved = std::max(moved, std::abs(f.depth[i] - raw) / noise),
      off = std::max(off, std::abs(f.depth[i] - s.truth[i]) / noise);
    }
    CHECK(moved < 4.5);  // 8 if what the samples refuse is taken from their surroundings
    CHECK(off < 3.5);
  }
}

TEST_CASE("rlts filter: samples that noise carries off their plane are brought back, whole images of them") {
  // At a noise of half a pixel one sample of a few hundred is beyond three deviations, beside the crease, too.
  for (const double left : {-1.0, -0.4, 0.0}) {
    const auto s = range_scene({.height = 80, .sigma = 0.5, .bit_error = 0.01, .q = 0.05}, [&](double x, double y) {
      const double across = x - 40 - 0.2 * y + 8;
      return 200 + (across > 0 ? 2.2 : left) * across + 0.3 * y;
    });
    const auto f = filtered(s.image);
    CHECK(kept_share(s, f) > 0.99);
    for (std::size_t i = 0; i < f.kept.size(); ++i)
      if (f.kept[i]) CHECK(std::abs(f.depth[i] - s.truth[i]) < 3.3 * static_cast<double>(f.raw_sigma[i]));
  }
}

TEST_CASE("rlts filter: a pixel between the two sides of a step is rejected") {
  // Two slanted planes that meet in an oblique step; three pixels of ten beside it are mixtures.
  const auto right = [](double x, double y) { return x - 0.6 * y > 22; };
  const auto depth = [&](double x, double y) { return right(x, y) ? 90 - 0.6 * x + 0.2 * y : 20 + 0.3 * x + 0.2 * y; };
  auto s = range_scene({.sigma = 0.05}, depth);
  Random random(3);
  int mixed = 0;
  for (int r = 1; r < 59; ++r)
    for (int c = 1; c < 79; ++c) {
      const int across = right(c, r) ? c - 1 : c + 1;
      if (right(across, r) == right(c, r) || random.uniform() > 0.3) continue;
      const double share = 0.05 + 0.9 * random.uniform(), z = (1 - share) * depth(c, r) + share * depth(across, r);
      s.image.codes[static_cast<std::size_t>(r * 80 + c)] = static_cast<std::uint16_t>(std::lround(1 + z / s.image.q));
      ++mixed;
    }
  REQUIRE(mixed > 25);
  const auto f = filtered(s.image);
  int wild = 0;
  for (std::size_t i = 0; i < f.kept.size(); ++i) wild += f.kept[i] && std::abs(f.depth[i] - s.truth[i]) > 5 * 0.05;
  CHECK(wild == 0);
  CHECK(kept_share(s, f) > 0.98);
}

TEST_CASE("rlts filter: a round surface stays where it is, however little it bends within the noise") {
  // In pixels of 1 mm the bend within a window is a tenth to a fortieth of the noise.
  for (const double radius : {45.0, 100.0}) {
    const double middle = radius + 3.3, sigma = 0.15;
    const auto rod = range_scene({.width = static_cast<int>(2 * radius) + 6, .height = 120, .sigma = sigma},
                                 [&](double x, double y) {
                                   const double along = 0.98 * (x - middle) + 0.199 * (y - 60);
                                   const double sq = radius * radius - along * along;
                                   return sq > 0.04 * radius * radius ? radius + 5 - std::sqrt(sq) : NAN;
                                 });
    const auto f = filtered(rod.image);
    CHECK(kept_share(rod, f) > 0.99);
    double sum = 0, squares = 0, pull = 0, count = 0, limb = 0, limb_count = 0;
    for (std::size_t i = 0; i < f.kept.size(); ++i) {
      if (!f.kept[i]) continue;
      const double off = (f.depth[i] - rod.truth[i]) / sigma, height = (radius + 5 - rod.truth[i]) / radius;
      if (height < 0.4)
        limb += off, ++limb_count;
      else if (height > 0.6)
        sum += off, squares += off * off, pull += std::pow(off * sigma / static_cast<double>(f.sigma[i]), 2), ++count;
    }
    CHECK(std::abs(sum / count) < 0.04);
    CHECK(std::sqrt(squares / count) < 0.23);
    CHECK(std::sqrt(pull / count) == Approx(1).epsilon(0.1));
    CHECK(std::abs(limb / limb_count) < 0.12);
  }
}

TEST_CASE("rlts filter: figure 2 of the paper, a profile of 12 bits with noise 5 and bit errors 0.015") {
  // Codes are millimetres. Sine, step and roof of 200 samples each, 100 draws.
  const auto profile = [](double x) {
    if (x < 200) return 2000 + 500 * std::sin(x * 0.0314159265);
    if (x < 400) return x < 300 ? 1500.0 : 2500.0;
    return 1500 + 8 * (100 - std::abs(x - 500));
  };
  const auto s =
      range_scene({.width = 600, .height = 100, .bits = 12, .sigma = 5, .bit_error = 0.015, .q = 1, .seed = 7},
                  [&](double x, double) { return profile(x); });
  const auto f = filtered(s.image, {.form = RltsForm::profile});
  const auto all = [&](int from, int to) {  // every sample counts, rejected or not, as in the figure
    double sum = 0;
    for (int r = 0; r < 100; ++r)
      for (int c = from; c < to; ++c) {
        const auto i = static_cast<std::size_t>(r * 600 + c);
        sum += (f.depth[i] - s.truth[i]) * (f.depth[i] - s.truth[i]);
      }
    return std::sqrt(sum / (100.0 * (to - from)));
  };
  INFO("smooth " << all(2, 198) << " step " << all(202, 398) << " roof " << all(402, 598));
  CHECK(all(2, 198) < 3.5);
  CHECK(all(202, 398) < 25);
  CHECK(all(402, 598) < 4.5);
  std::size_t flips = 0, found = 0;
  for (std::size_t i = 0; i < s.flipped.size(); ++i)
    if (s.flipped[i] >= 5) ++flips, found += !f.kept[i];
  CHECK(static_cast<double>(found) >= 0.98 * static_cast<double>(flips));
}

TEST_CASE(
    "rlts filter: a least-squares plane through raw codes is pulled away by a few flipped bits, through filtered not") {
  const auto s =
      range_scene({.sigma = 0.02, .bit_error = 0.01}, [](double x, double y) { return 30 + 0.2 * x - 0.1 * y; });
  const auto f = filtered(s.image);
  const auto off = [&](bool raw) {
    // The normal equations of z = a + b x + c y, about the middle of the image.
    Mat3 normal = Mat3::Zero();
    Vec3 right = Vec3::Zero();
    for (int r = 0; r < s.image.height; ++r)
      for (int c = 0; c < s.image.width; ++c) {
        const auto i = static_cast<std::size_t>(r * s.image.width + c);
        if (!raw && !f.kept[i]) continue;
        const Vec3 row(1, (c - 39.5) / 40, (r - 29.5) / 30);
        const double z = raw ? s.image.z0 + s.image.q * (s.image.codes[i] - 1) : f.depth[i];
        normal += row * row.transpose(), right += z * row;
      }
    const Vec3 plane = normal.inverse() * right, truth(30 + 0.2 * 39.5 - 0.1 * 29.5, 0.2 * 40, -0.1 * 30);
    return (plane - truth).cwiseAbs().maxCoeff();
  };
  INFO("raw " << off(true) << ", filtered " << off(false));
  CHECK(off(true) > 0.02);
  CHECK(off(false) < 0.002);
}

TEST_CASE("rlts filter: bit errors beyond the noise are found and named, low bits as often as is stated") {
  const auto s = range_scene({.width = 300, .height = 300, .sigma = 0.02, .bit_error = 0.03}, [](double x, double y) {
    return 60 + 0.2 * x - 0.1 * y + 4 * std::sin(0.03 * x) * std::cos(0.02 * y);
  });
  const auto f = filtered(s.image);
  std::array<double, 16> flips{}, found{};
  for (std::size_t i = 0; i < s.flipped.size(); ++i)
    if (s.flipped[i] >= 0) {
      const auto b = static_cast<std::size_t>(s.flipped[i]);
      ++flips[b], found[b] += !f.kept[i];
    }
  for (std::size_t b = 0; b < 16; ++b) {
    INFO("bit " << b << ": " << found[b] << " of " << flips[b]);
    if (b >= 6) {  // 0.128 mm and more
      CHECK(found[b] >= 0.98 * flips[b]);
      CHECK(static_cast<double>(f.bit_errors[b]) == Approx(flips[b]).epsilon(0.1));
    }
    CHECK(found[b] / flips[b] == Approx(detectable_share(static_cast<int>(b), 0.002, 0.02)).margin(0.2));
  }
  CHECK(kept_share(s, f) > 0.99);
}

TEST_CASE("rlts filter: rejected pixels are flagged and left as they are, missing ones stay missing") {
  auto s = range_scene({.bit_error = 0.02}, [](double x, double y) {
    return std::fmod(x * 7 + y * 3, 11) < 1 ? std::numeric_limits<double>::quiet_NaN() : 30 + 0.1 * x;
  });
  const auto f = filtered(s.image);
  std::size_t rejected = 0, missing = 0;
  for (std::size_t i = 0; i < f.depth.size(); ++i) {
    if (std::isnan(s.truth[i])) {
      ++missing;
      CHECK(std::isnan(f.depth[i]));
      CHECK(f.kept[i] == 0);
    } else if (!f.kept[i]) {
      ++rejected;
      CHECK(f.depth[i] == Approx((s.image.codes[i] - 1) * s.image.q).epsilon(1e-9));
    }
  }
  CHECK(f.rejected == rejected);
  CHECK(f.returns + missing == f.depth.size());
  CHECK(rejected > 30);
}

TEST_CASE("rlts filter: behind a pinhole a steep plane keeps its place and shape") {
  RangeScene s;
  s.image.projection = Projection::pinhole;
  s.image.width = 120, s.image.height = 90;
  s.image.fx = s.image.fy = 140, s.image.cx = 59.5, s.image.cy = 44.5;
  s.image.z0 = 100, s.image.q = 0.01;
  Random random(9);
  for (int r = 0; r < 90; ++r)
    for (int c = 0; c < 120; ++c) {
      // 2 x + y + 3 z = 900 seen along (x, y, 1).
      const double x = (c - 59.5) / 140, y = (r - 44.5) / 140, z = 900 / (2 * x + y + 3);
      s.truth.push_back(z), s.flipped.push_back(-1);
      s.image.codes.push_back(static_cast<std::uint16_t>(std::lround(1 + (z + 0.3 * random.normal() - 100) / 0.01)));
    }
  const auto f = filtered(s.image);
  CHECK(kept_share(s, f) > 0.995);
  double sum = 0, squares = 0;
  int count = 0;
  for (std::size_t i = 0; i < f.depth.size(); ++i) {
    if (!f.kept[i]) continue;
    const double error = f.depth[i] - s.truth[i];
    sum += error, squares += error * error, ++count;
  }
  CHECK(std::abs(sum / count) < 4 * 0.3 / std::sqrt(count));
  CHECK(std::sqrt(squares / count) < 1.2 * 0.3 / 5);
}

TEST_CASE("rlts filter: quantisation is noise too, so that an image without any other keeps its points") {
  const auto s = range_scene({.sigma = 0, .q = 0.05},
                             [](double x, double y) { return 10 + 0.013 * x * x + 0.11 * y + (x > 50 ? 3 : 0); });
  const auto f = filtered(s.image);
  CHECK(kept_share(s, f) > 0.99);
  CHECK(f.noise.sigma(1) >= 0.05 * 0.28);
  CHECK(rms(s, f, 0, 80) < 0.05 * 0.3);
}

TEST_CASE("rlts filter: the paper's windows reject what is wild and smooth what is not") {
  const auto s = range_scene({.width = 60, .height = 40, .bit_error = 0.03},
                             [](double x, double y) { return 30 + 0.2 * x + 0.1 * y; });
  for (const RltsForm form : {RltsForm::facet, RltsForm::quadric}) {
    const auto f = filtered(s.image, {.form = form});
    CHECK(kept_share(s, f) > 0.97);
    CHECK(rms(s, f, 3, 57) < (form == RltsForm::facet ? 0.3 : 0.5) * 0.02);
    for (std::size_t i = 0; i < f.kept.size(); ++i)
      if (s.flipped[i] >= 7) CHECK(f.kept[i] == 0);
  }
}

TEST_CASE("rlts filter: the same bytes for any number of threads") {
  const auto s = range_scene({.bit_error = 0.02}, [](double x, double y) { return 30 + std::abs(x - 40) + 0.1 * y; });
  for (const RltsForm form : {RltsForm::combined, RltsForm::profile, RltsForm::facet}) {
    const auto one = filtered(s.image, {.form = form}, 1), many = filtered(s.image, {.form = form}, 4);
    CHECK(std::memcmp(one.depth.data(), many.depth.data(), one.depth.size() * sizeof(double)) == 0);
    CHECK(one.sigma == many.sigma);
    CHECK(one.kept == many.kept);
  }
}

TEST_CASE("rlts filter: bad images have answers too") {
  for (const RltsForm form : {RltsForm::combined, RltsForm::profile, RltsForm::facet, RltsForm::quadric}) {
    CHECK(filtered(RangeImage{}, {.form = form}).depth.empty());
    const double none = std::numeric_limits<double>::quiet_NaN();
    const auto nothing = range_scene({}, [&](double, double) { return none; });
    const auto f = filtered(nothing.image, {.form = form});
    CHECK(f.returns == 0);
    CHECK(f.rejected == 0);
    const auto pixel = range_scene({.width = 1, .height = 1}, [](double, double) { return 10; });
    const auto g = filtered(pixel.image, {.form = form});
    CHECK(g.returns == 1);
    CHECK(g.depth[0] == Approx(10).margin(0.1));
    const auto row = range_scene({.width = 50, .height = 1}, [](double, double) { return 10; });
    CHECK(filtered(row.image, {.form = form}).returns == 50);
    const auto noise = range_scene({.width = 30, .height = 30, .sigma = 30}, [](double, double) { return 60; });
    for (const double z : filtered(noise.image, {.form = form}).depth) CHECK(std::isfinite(z));
  }
}
