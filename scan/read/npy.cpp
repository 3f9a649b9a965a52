#include "scan/read/npy.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstring>

#include "core/statistics.h"

namespace partscribe::scan {
namespace {

constexpr int largest_side = 65535;
constexpr double farthest = 10;  // of the middle depth: an outlier that far would make the steps coarse

/// What stands behind 'key': in the header, a Python dictionary.
std::string_view value_of(std::string_view header, std::string_view key) {
  const auto at = header.find("'" + std::string(key) + "'");
  if (at == std::string_view::npos) return {};
  const auto colon = header.find(':', at);
  if (colon == std::string_view::npos) return {};
  auto value = header.substr(colon + 1);
  value.remove_prefix(std::min(value.find_first_not_of(' '), value.size()));
  return value;
}

/// Two numbers of "(256, 320)"; zeros if it is anything else.
std::array<int, 2> shape_of(std::string_view text) {
  std::array<int, 2> shape{};
  const char *at = text.data(), *end = at + text.size();
  for (const char mark : {'(', ','}) {
    if (at == end || *at++ != mark) return {};
    while (at != end && *at == ' ') ++at;
    const auto [next, error] = std::from_chars(at, end, shape[mark == ',']);
    if (error != std::errc()) return {};
    at = next;
  }
  if (at == end || *at != ')') return {};
  return shape;
}

/// Little endian, as the file says.
template <class T>
T number_at(std::string_view data, std::size_t i) {
  static_assert(std::endian::native == std::endian::little);
  T value;
  std::memcpy(&value, data.data() + i * sizeof(T), sizeof(T));
  return value;
}

void put_into_steps(const std::vector<double>& depths, RangeCodes& image) {
  std::vector<double> returned;
  for (const double z : depths)
    if (std::isfinite(z) && z > 0) returned.push_back(z);
  image.depth = {1, 1};
  if (returned.empty()) return;
  const double limit = farthest * median(returned);
  std::erase_if(returned, [&](double z) { return z > limit; });
  const auto [low, high] = std::minmax_element(returned.begin(), returned.end());
  image.depth = {*low, std::max((*high - *low) / 65533, 1e-12 * *high)};
  for (std::size_t i = 0; i < depths.size(); ++i)
    if (std::isfinite(depths[i]) && depths[i] > 0 && depths[i] <= limit)
      image.codes[i] = static_cast<std::uint16_t>(1 + std::lround((depths[i] - image.depth->z0) / image.depth->q));
}

}  // namespace

Result<RangeCodes> parse_npy(std::string_view bytes, const std::string& name) {
  const std::size_t width_of_length = bytes.size() > 6 && bytes[6] == 1 ? 2 : 4;
  if (bytes.size() < 8 + width_of_length)
    return bad_input(name + ": expected the header of a numpy array, found the end of the file");
  std::size_t length = 0;
  for (std::size_t k = 0; k < width_of_length; ++k)
    length |= std::size_t(static_cast<unsigned char>(bytes[8 + k])) << (8 * k);
  const std::size_t start = 8 + width_of_length + length;
  if (start > bytes.size())
    return bad_input(name + ": expected the header of a numpy array, found the end of the file");
  const auto header = bytes.substr(8 + width_of_length, length), data = bytes.substr(start);
  const auto kind = value_of(header, "descr").substr(0, 5);
  const std::size_t size = kind == "'<u2'" ? 2 : kind == "'<f4'" ? 4 : kind == "'<f8'" ? 8 : 0;
  if (size == 0)
    return bad_input(name + ": expected an array of '<f4', '<f8' or '<u2', found " +
                     std::string(kind.empty() ? "none" : kind));
  if (value_of(header, "fortran_order").substr(0, 5) != "False")
    return bad_input(name + ": expected an array stored row by row");
  const auto shape = shape_of(value_of(header, "shape"));
  if (shape[0] < 1 || shape[1] < 1 || std::max(shape[0], shape[1]) > largest_side)
    return bad_input(name + ": expected an array of two axes, rows and columns");
  RangeCodes image{shape[1], shape[0], {}, {}};
  const std::size_t count = std::size_t(shape[0]) * std::size_t(shape[1]);
  if (data.size() < count * size)
    return bad_input(name + ": expected " + std::to_string(count) + " numbers, found room for " +
                     std::to_string(data.size() / size));
  image.codes.assign(count, 0);
  std::vector<double> depths(size == 2 ? 0 : count);
  for (std::size_t i = 0; i < count; ++i)
    if (size == 2)
      image.codes[i] = number_at<std::uint16_t>(data, i);
    else
      depths[i] = size == 4 ? double(number_at<float>(data, i)) : number_at<double>(data, i);
  if (size > 2) put_into_steps(depths, image);
  return image;
}

}  // namespace partscribe::scan
