#include "geometry/points/spatial_order.h"

#include <algorithm>
#include <array>
#include <limits>
#include <utility>

#include "core/parallel.h"

namespace partscribe::geometry {
namespace {

constexpr int bits = 10;  // per axis

constexpr unsigned rotated_left(unsigned v, unsigned by) { return ((v << by) | (v >> (3 - by))) & 7; }
constexpr unsigned rotated_right(unsigned v, unsigned by) { return ((v >> by) | (v << (3 - by))) & 7; }
constexpr unsigned trailing_ones(unsigned v) { return v & 1 ? 1 + trailing_ones(v >> 1) : 0; }
constexpr unsigned gray(unsigned v) { return v ^ (v >> 1); }

/// The Hilbert curve as an automaton over octants (Hamilton & Rau-Chaplin 2008): a state is the entry corner and the
/// direction of the cell at hand. Two levels at once: six bits in, six bits of the curve's parameter and the next
/// state out.
struct HilbertTable {
  std::array<std::uint16_t, 24 * 64> step{};
  constexpr HilbertTable() {
    for (unsigned state = 0; state < 24; ++state)
      for (unsigned in = 0; in < 64; ++in) {
        unsigned at = state, out = 0;
        for (const unsigned octant : {in >> 3, in & 7}) {
          const unsigned entry = at / 3, direction = at % 3, turn = (direction + 1) % 3;
          const unsigned t = rotated_right(octant ^ entry, turn);
          const unsigned w = t ^ (t >> 1) ^ (t >> 2);  // the inverse of gray()
          out = out << 3 | w;
          const unsigned corner = w == 0 ? 0 : gray(2 * ((w - 1) / 2));
          const unsigned along = w == 0 ? 0 : w % 2 ? trailing_ones(w) % 3 : trailing_ones(w - 1) % 3;
          at = (entry ^ rotated_left(corner, turn)) * 3 + (direction + along + 1) % 3;
        }
        step[state * 64 + in] = static_cast<std::uint16_t>(at << 6 | out);
      }
  }
};
constexpr HilbertTable hilbert;

/// The ten low bits with two zeros between each.
std::uint32_t spread(std::uint32_t v) {
  v = (v | v << 16) & 0x030000ffu;
  v = (v | v << 8) & 0x0300f00fu;
  v = (v | v << 4) & 0x030c30c3u;
  return (v | v << 2) & 0x09249249u;
}

std::uint32_t hilbert_key(std::uint32_t x, std::uint32_t y, std::uint32_t z) {
  const std::uint32_t octants = spread(x) << 2 | spread(y) << 1 | spread(z);
  std::uint32_t key = 0, state = 0;
  for (int shift = 24; shift >= 0; shift -= 6) {
    const std::uint16_t step = hilbert.step[state * 64 + ((octants >> shift) & 63)];
    key = key << 6 | (step & 63u), state = step >> 6;
  }
  return key;
}

}  // namespace

std::vector<std::uint32_t> spatial_order(std::span<const Vec3> points, int threads) {
  const double huge = std::numeric_limits<double>::max();
  Box3 box;
  for (const auto& p : points) {
    // Points that are not finite would leave no box for the others.
    if (p.cwiseAbs().maxCoeff() <= huge) box.add(p);
  }
  const double extent = box.empty() ? 0 : box.size().maxCoeff();
  const double scale = extent > 0 && extent <= huge ? (1 << bits) * (1 - 1e-9) / extent : 0;
  std::vector<std::uint64_t> keyed(points.size()), other;
  parallel_for(
      points.size(), threads,
      [&](std::size_t begin, std::size_t end) {
        for (std::size_t i = begin; i < end; ++i) {
          std::uint32_t cell[3];
          for (int k = 0; k < 3; ++k) {
            const double at = (points[i][k] - box.low[k]) * scale;
            cell[k] = at > 0 && at < (1 << bits) ? static_cast<std::uint32_t>(at) : 0;
          }
          keyed[i] = std::uint64_t(hilbert_key(cell[0], cell[1], cell[2])) << 32 | static_cast<std::uint32_t>(i);
        }
      },
      1 << 14);
  std::vector<std::uint32_t> order(points.size());
  auto finish = [&] {
    for (std::size_t i = 0; i < order.size(); ++i) order[i] = static_cast<std::uint32_t>(keyed[i]);
    return std::move(order);
  };
  if (std::is_sorted(keyed.begin(), keyed.end())) return finish();
  // Stable by digits of ten bits.
  other.resize(points.size());
  std::array<std::array<std::uint32_t, 1 << bits>, 3> start{};
  for (const auto item : keyed)
    for (unsigned digit = 0; digit < 3; ++digit) ++start[digit][(item >> (32 + digit * bits)) & ((1 << bits) - 1)];
  for (unsigned digit = 0; digit < 3; ++digit) {
    std::uint32_t sum = 0;
    for (auto& s : start[digit]) sum += std::exchange(s, sum);
    for (const auto item : keyed) other[start[digit][(item >> (32 + digit * bits)) & ((1 << bits) - 1)]++] = item;
    keyed.swap(other);
  }
  return finish();
}

}  // namespace partscribe::geometry
