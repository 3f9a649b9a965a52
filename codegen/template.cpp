#include "codegen/template.h"

#include <algorithm>

namespace partscribe::codegen {
namespace {

// What a template may ask for; sections of one list within each other multiply.
constexpr std::size_t deepest = 64, most_steps = 30'000'000, most_bytes = 512u << 20;

bool blank(std::string_view text) { return text.find_first_not_of(" \t") == std::string_view::npos; }

std::string_view trimmed(std::string_view text) {
  const auto first = text.find_first_not_of(" \t");
  if (first == std::string_view::npos) return {};
  return text.substr(first, text.find_last_not_of(" \t") - first + 1);
}

/// A piece of a template: text, a key, or the start or end of a section.
struct Token {
  enum class Kind { text, key, open, open_if_empty, close, remark };
  Kind kind = Kind::text;
  std::string text;  // of the text or key
  int line = 1;
  std::string indentation;  // of a key that stands first on its line
  bool alone = false;       // a key with nothing else on its line
};

/// A line's tokens without its line end; sections that stand alone lose their line.
Result<std::vector<Token>> tokens_of(std::string_view text, const std::string& where) {
  std::vector<Token> tokens;
  int number = 0;
  while (!text.empty()) {
    ++number;
    const auto end = text.find('\n');
    std::string_view line = text.substr(0, end);
    const bool ended = end != std::string_view::npos;
    text.remove_prefix(ended ? end + 1 : text.size());
    if (!line.empty() && line.back() == '\r') line.remove_suffix(1);

    std::vector<Token> found;
    std::string_view rest = line;
    for (;;) {
      const auto begin = rest.find("{{");
      if (begin != 0 && !rest.empty())
        found.push_back({Token::Kind::text, std::string(rest.substr(0, begin)), number, {}, false});
      if (begin == std::string_view::npos) break;
      const auto close = rest.find("}}", begin);
      if (close == std::string_view::npos) {
        return bad_input(where + ":" + std::to_string(number) + ": expected }} after {{ on the same line");
      }
      std::string_view tag = trimmed(rest.substr(begin + 2, close - begin - 2));
      rest.remove_prefix(close + 2);
      Token token{Token::Kind::key, {}, number, {}, false};
      if (!tag.empty() && tag.front() == '#') token.kind = Token::Kind::open;
      if (!tag.empty() && tag.front() == '^') token.kind = Token::Kind::open_if_empty;
      if (!tag.empty() && tag.front() == '/') token.kind = Token::Kind::close;
      if (!tag.empty() && tag.front() == '!') token.kind = Token::Kind::remark;
      if (token.kind != Token::Kind::key) tag.remove_prefix(1);
      token.text = std::string(trimmed(tag));
      if (token.text.empty() && token.kind != Token::Kind::remark) {
        return bad_input(where + ":" + std::to_string(number) + ": expected a name between {{ and }}");
      }
      found.push_back(std::move(token));
    }

    const bool only_tags = !found.empty() && std::all_of(found.begin(), found.end(), [](const Token& t) {
      return t.kind == Token::Kind::text ? blank(t.text) : t.kind != Token::Kind::key;
    });
    const bool has_tags =
        std::any_of(found.begin(), found.end(), [](const Token& t) { return t.kind != Token::Kind::text; });
    if (only_tags && has_tags) {
      std::erase_if(found, [](const Token& t) { return t.kind == Token::Kind::text; });
    } else {
      std::size_t first = 0;
      if (!found.empty() && found[0].kind == Token::Kind::text && blank(found[0].text)) first = 1;
      if (first < found.size() && found[first].kind == Token::Kind::key) {
        if (first == 1) found[first].indentation = found[0].text;
        found[first].alone = first + 1 == found.size() && ended;
        if (found[first].alone) {
          // The key brings its own indentation and line end, so that an empty text leaves no line.
          found.erase(found.begin(), found.begin() + static_cast<std::ptrdiff_t>(first));
        }
      }
      if (ended && (found.empty() || !found.back().alone))
        found.push_back({Token::Kind::text, "\n", number, {}, false});
    }
    for (auto& token : found) tokens.push_back(std::move(token));
  }
  return tokens;
}

using Scopes = std::vector<const TemplateRecord*>;

const TemplateValue* sought(const Scopes& scopes, const std::string& key) {
  for (auto scope = scopes.rbegin(); scope != scopes.rend(); ++scope) {
    if (const auto found = (*scope)->find(key); found != (*scope)->end()) return &found->second;
  }
  return nullptr;
}

std::string indented(const std::string& text, const std::string& indentation) {
  if (indentation.empty()) return text;
  std::string result;
  for (std::size_t i = 0; i < text.size(); ++i) {
    result += text[i];
    if (text[i] == '\n' && i + 1 < text.size() && text[i + 1] != '\n') result += indentation;
  }
  return result;
}

class Renderer {
 public:
  Renderer(std::vector<Token> tokens, const std::string& where) : tokens_(std::move(tokens)), where_(where) {}

  /// The token that closes the section opened at `open`; nothing if there is none.
  Result<Done> pair_sections() {
    std::vector<std::size_t> open;
    closing_.assign(tokens_.size(), 0);
    for (std::size_t i = 0; i < tokens_.size(); ++i) {
      const Token& t = tokens_[i];
      if (t.kind == Token::Kind::open || t.kind == Token::Kind::open_if_empty) open.push_back(i);
      if (open.size() > deepest)
        return fault(t, "expected at most " + std::to_string(deepest) + " sections within each other");
      if (t.kind != Token::Kind::close) continue;
      if (open.empty()) return fault(t, "expected no {{/" + t.text + "}} here, no section is open");
      const Token& opened = tokens_[open.back()];
      if (opened.text != t.text) {
        return fault(t, "expected {{/" + opened.text + "}} (opened in line " + std::to_string(opened.line) +
                            "), found {{/" + t.text + "}}");
      }
      closing_[open.back()] = i;
      open.pop_back();
    }
    if (!open.empty()) {
      const Token& opened = tokens_[open.back()];
      return fault(opened, "expected {{/" + opened.text + "}} before the end of the file");
    }
    return Done{};
  }

  Result<Done> render(std::size_t begin, std::size_t end, Scopes& scopes, std::string& out) {
    for (std::size_t i = begin; i < end; ++i) {
      const Token& t = tokens_[i];
      if (++steps_ > most_steps || out.size() > most_bytes)
        return fault(t,
                     "expected a text of at most 512 MB made in 30 million steps, found more: its sections multiply");
      switch (t.kind) {
        case Token::Kind::text:
          out += t.text;
          break;
        case Token::Kind::remark:
        case Token::Kind::close:
          break;
        case Token::Kind::key: {
          const TemplateValue* value = sought(scopes, t.text);
          if (!value) return fault(t, "unknown name '" + t.text + "'");
          const auto* text = std::get_if<std::string>(&value->value);
          if (!text) return fault(t, "'" + t.text + "' is a list or record, expected a text");
          if (t.alone) {
            if (text->empty()) break;
            out += t.indentation;
          }
          out += indented(*text, t.indentation);
          if (t.alone && text->back() != '\n') out += '\n';
          break;
        }
        case Token::Kind::open:
        case Token::Kind::open_if_empty: {
          const TemplateValue* value = sought(scopes, t.text);
          if (!value) return fault(t, "unknown name '" + t.text + "'");
          if (auto done = section(t, *value, i + 1, closing_[i], scopes, out); !done.ok()) return done;
          i = closing_[i];
          break;
        }
      }
    }
    return Done{};
  }

  std::size_t size() const { return tokens_.size(); }

 private:
  Result<Done> section(const Token& t, const TemplateValue& value, std::size_t begin, std::size_t end, Scopes& scopes,
                       std::string& out) {
    const auto* text = std::get_if<std::string>(&value.value);
    const auto* list = std::get_if<TemplateList>(&value.value);
    const bool if_empty = t.kind == Token::Kind::open_if_empty;
    if (text || if_empty) {
      if (!text && !list) return fault(t, "'" + t.text + "' is a record, expected a list or text");
      const bool empty = text ? text->empty() : list->empty();
      return empty == if_empty ? render(begin, end, scopes, out) : Result<Done>(Done{});
    }
    auto inside = [&](const TemplateRecord& record) {
      scopes.push_back(&record);
      auto done = render(begin, end, scopes, out);
      scopes.pop_back();
      return done;
    };
    if (const auto* record = std::get_if<TemplateRecord>(&value.value)) return inside(*record);
    for (const TemplateRecord& record : *list) {
      if (auto done = inside(record); !done.ok()) return done;
    }
    return Done{};
  }

  Error fault(const Token& t, const std::string& what) const {
    return bad_input(where_ + ":" + std::to_string(t.line) + ": " + what);
  }

  std::vector<Token> tokens_;
  std::vector<std::size_t> closing_;
  std::size_t steps_ = 0;
  const std::string& where_;
};

}  // namespace

TemplateList template_lines(const std::vector<std::string>& lines, const std::string& key) {
  TemplateList list;
  for (const auto& line : lines) list.push_back({{key, line}});
  return list;
}

void separate(TemplateList& list, const std::string& separator, const std::string& key) {
  for (std::size_t i = 0; i < list.size(); ++i) list[i][key] = i + 1 < list.size() ? separator : std::string();
}

Result<std::string> render_template(std::string_view text, const TemplateRecord& data, const std::string& where) {
  auto tokens = tokens_of(text, where);
  if (!tokens.ok()) return tokens.error();
  Renderer renderer(std::move(tokens).value(), where);
  if (auto paired = renderer.pair_sections(); !paired.ok()) return paired.error();
  std::string out;
  Scopes scopes{&data};
  if (auto done = renderer.render(0, renderer.size(), scopes, out); !done.ok()) return done.error();
  return out;
}

Result<std::string> TemplatePack::render(const std::string& file, const TemplateRecord& data) const {
  const auto found = files.find(file);
  ensure(found != files.end(), "a backend asks only for templates of its own pack");
  return render_template(found->second, data, where.at(file));
}

Result<TemplatePack> load_template_pack(const std::string& name, const Path& folder) {
  TemplatePack pack;
  pack.name = name;
  for (const auto& embedded : embedded_templates()) {
    if (embedded.pack != name) continue;
    pack.files[std::string(embedded.file)] = std::string(embedded.text);
    pack.where[std::string(embedded.file)] = "templates/" + name + "/" + std::string(embedded.file);
  }
  ensure(!pack.files.empty(), "every text backend has a built-in pack");
  if (folder.empty()) return pack;
  std::error_code code;
  if (!std::filesystem::is_directory(folder, code)) {
    return bad_input(folder.string() + ": expected a folder of template packs");
  }
  const Path own = folder / name;
  if (!std::filesystem::is_directory(own, code)) return pack;
  std::vector<Path> paths;
  for (const auto& entry : std::filesystem::directory_iterator(own, code)) {
    if (entry.is_regular_file()) paths.push_back(entry.path());
  }
  std::sort(paths.begin(), paths.end());
  for (const Path& path : paths) {
    const std::string file = path.filename().string();
    if (!pack.files.count(file)) {
      std::string known;
      for (const auto& [known_name, text] : pack.files) known += (known.empty() ? "" : ", ") + known_name;
      return bad_input(path.string() + ": expected one of the pack's templates (" + known + ")");
    }
    auto text = read_file(path);
    if (!text.ok()) return text.error();
    pack.files[file] = std::move(text).value();
    pack.where[file] = path.string();
  }
  return pack;
}

}  // namespace partscribe::codegen
