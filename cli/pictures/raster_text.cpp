#include "cli/pictures/raster_text.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <string>
#include <vector>

namespace partscribe::cli {
namespace {

/// Strokes on a grid: x 0 to 4, y 0 (top of capitals) over 2 (top of small letters) and 6 (baseline) to 8. A word of
/// digits is a line through the points x y, x y, ...; a single place twice is a dot.
const std::map<char32_t, std::string_view>& glyphs() {
  static const std::map<char32_t, std::string_view> all = {
      {U'0', "103041453616050110"},
      {U'1', "112026 1636"},
      {U'2', "01103041420646"},
      {U'3', "0110304142334445361605 1333"},
      {U'4', "36300444"},
      {U'5', "400002324345361605"},
      {U'6', "413010010516364544331304"},
      {U'7', "004016"},
      {U'8', "13020110304142331304051636454433"},
      {U'9', "051636454130100102133342"},
      {U'A', "062046 1434"},
      {U'B', "003041423303 334445360600"},
      {U'C', "4130100105163645"},
      {U'D', "00204244260600"},
      {U'E', "40000646 0333"},
      {U'F', "400006 0333"},
      {U'G', "41301001051636454323"},
      {U'H', "0006 4046 0343"},
      {U'I', "1030 2026 1636"},
      {U'J', "2040 3035261605"},
      {U'K', "0006 400346"},
      {U'L', "000646"},
      {U'M', "0600234046"},
      {U'N', "06004640"},
      {U'O', "103041453616050110"},
      {U'P', "06003041423303"},
      {U'Q', "103041453616050110 3446"},
      {U'R', "06003041423303 2346"},
      {U'S', "413010010213334445361605"},
      {U'T', "0040 2026"},
      {U'U', "000516364540"},
      {U'V', "002640"},
      {U'W', "0016233640"},
      {U'X', "0046 4006"},
      {U'Y', "002340 2326"},
      {U'Z', "00400646"},
      {U'a', "12324346 441405163645"},
      {U'b', "0006 0312324345361605"},
      {U'c', "4332120305163645"},
      {U'd', "4046 4332120305163645"},
      {U'e', "04444332120305163645"},
      {U'f', "30201116 0232"},
      {U'g', "4247381807 4332120305163645"},
      {U'h', "0006 0312324346"},
      {U'i', "2226 2020"},
      {U'j', "32372818 3030"},
      {U'k', "0006 320436"},
      {U'l', "2026"},
      {U'm', "0206 03122326 23324346"},
      {U'n', "0206 0312324346"},
      {U'o', "123243453616050312"},
      {U'p', "0208 0312324345361605"},
      {U'q', "4248 4332120305163645"},
      {U'r', "0206 031232"},
      {U's', "43321203143445361605"},
      {U't', "10152636 0232"},
      {U'u', "0205163645 4246"},
      {U'v', "022642"},
      {U'w', "0216243642"},
      {U'x', "0246 4206"},
      {U'y', "0226 4208"},
      {U'z', "02420646"},
      {U'+', "2125 0343"},
      {U'-', "0343"},
      {U'\u2212', "0343"},
      {U'\u00b1', "2024 0242 0646"},
      {U'.', "2626"},
      {U',', "2617"},
      {U':', "2323 2626"},
      {U';', "2323 2617"},
      {U'(', "30212536"},
      {U')', "10212516"},
      {U'/', "0640"},
      {U'%', "0640 1010 3636"},
      {U'=', "0242 0444"},
      {U'_', "0646"},
      {U'\'', "2021"},
      {U'>', "014305"},
      {U'<', "410345"},
      {U'*', "2125 1234 3214"},
      {U'#', "1016 3036 0242 0444"},
      {U'\u00b7', "2323"},
  };
  return all;
}

bool narrow(char32_t c) { return std::u32string_view(U"il.,:;'()I·j").find(c) != std::u32string_view::npos; }
constexpr double slim = 0.84;  // width of a grid unit to its height
double advance(char32_t c) { return slim * (c == U' ' ? 3.4 : narrow(c) ? 3.4 : 5.8); }

/// UTF-8 of one to three bytes; anything broken becomes a gap.
std::u32string decoded(std::string_view text) {
  std::u32string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    auto next = [&](std::size_t k) {
      return i + k < text.size() ? static_cast<char32_t>(static_cast<unsigned char>(text[i + k]) & 0x3f) : 0;
    };
    if (c < 0x80)
      result += c;
    else if ((c & 0xe0) == 0xc0)
      result += static_cast<char32_t>((c & 0x1f) << 6 | next(1)), i += 1;
    else if ((c & 0xf0) == 0xe0)
      result += static_cast<char32_t>((c & 0x0f) << 12 | next(1) << 6 | next(2)), i += 2;
    else
      result += U' ';
  }
  return result;
}

double distance_to(const Vec2& p, const Vec2& a, const Vec2& b) {
  const Vec2 d = b - a;
  const double along = d.squaredNorm() > 0 ? std::clamp((p - a).dot(d) / d.squaredNorm(), 0.0, 1.0) : 0.0;
  return (p - a - along * d).norm();
}

using Segment = std::array<Vec2, 2>;

void draw_segments(Raster& raster, const std::vector<Segment>& segments, double width_px, Color color) {
  Vec2 low(1e9, 1e9), high(-1e9, -1e9);
  for (const auto& s : segments)
    for (const auto& p : s) low = low.cwiseMin(p), high = high.cwiseMax(p);
  const double reach = width_px / 2 + 1;
  const int left = std::max(0, static_cast<int>(low.x() - reach)), top = std::max(0, static_cast<int>(low.y() - reach));
  const int right = std::min(raster.width - 1, static_cast<int>(high.x() + reach));
  const int bottom = std::min(raster.height - 1, static_cast<int>(high.y() + reach));
  for (int row = top; row <= bottom; ++row)
    for (int column = left; column <= right; ++column) {
      double nearest = 1e9;
      for (const auto& s : segments) nearest = std::min(nearest, distance_to({column + 0.5, row + 0.5}, s[0], s[1]));
      const double cover = std::clamp(0.5 + width_px / 2 - nearest, 0.0, 1.0);
      if (cover <= 0) continue;
      auto& pixel = raster.pixels[static_cast<std::size_t>(row) * raster.width + column];
      pixel = mixed(pixel, color, cover);
    }
}

}  // namespace

double text_width(std::string_view text, double height_px) {
  double width = 0;
  for (const auto c : decoded(text)) width += advance(c);
  return std::max(0.0, width - 1.6) * height_px / 6;
}

void draw_text(Raster& raster, double x, double y, double height_px, std::string_view text, Color color,
               TextAlign align) {
  const double unit = height_px / 6, width = text_width(text, height_px);
  if (align != TextAlign::left) x -= align == TextAlign::right ? width : width / 2;
  for (const auto c : decoded(text)) {
    if (const auto found = glyphs().find(c); found != glyphs().end()) {
      std::vector<Segment> segments;
      const double shift = narrow(c) ? -1.1 : 0;
      Vec2 last;
      int points = 0;
      char held = 0;
      for (const char d : found->second) {
        if (d == ' ') {
          points = 0;
        } else if (held == 0) {
          held = d;
        } else {
          const Vec2 place(x + unit * slim * (held - '0' + shift), y - height_px + unit * (d - '0'));
          if (points++) segments.push_back({last, place});
          last = place, held = 0;
        }
      }
      draw_segments(raster, segments, std::max(1.2, 0.15 * height_px), color);
    }
    x += advance(c) * unit;
  }
}

void draw_stroke(Raster& raster, const Vec2& from, const Vec2& to, double width_px, Color color) {
  draw_segments(raster, {{from, to}}, width_px, color);
}

void fill_box(Raster& raster, int left, int top, int width, int height, Color color) {
  for (int row = std::max(0, top); row < std::min(raster.height, top + height); ++row)
    for (int column = std::max(0, left); column < std::min(raster.width, left + width); ++column)
      raster.pixels[static_cast<std::size_t>(row) * raster.width + column] = color;
}

}  // namespace partscribe::cli
