#include "cli/printable.h"

namespace partscribe::cli {

std::string printable(std::string text) {
  for (std::size_t i = 0; i < text.size(); ++i) {
    const auto c = static_cast<unsigned char>(text[i]);
    const bool second_set = c >= 0x80 && c < 0xa0 && i > 0 && text[i - 1] == '\xc2';  // U+0080 to U+009F in UTF-8
    if ((c < 32 && c != '\n' && c != '\t') || c == 127) text[i] = '?';
    if (second_set) text[i - 1] = text[i] = '?';
  }
  return text;
}

}  // namespace partscribe::cli
