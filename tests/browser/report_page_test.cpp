/// The report in a real browser: drawn, read, turned, printed, without a complaint and without a network.
#include "cli/report/report_page.h"

#include <catch2/catch.hpp>
#include <cmath>
#include <iostream>
#include <nlohmann/json.hpp>
#include <set>

#include "core/number.h"
#include "core/random.h"
#include "testing/chromium.h"

namespace partscribe::testing {

using namespace cli;

namespace {

/// Says so and ends the test where no browser is installed; ctest then counts it as skipped.
#define NEEDS_CHROMIUM                                                                                       \
  if (find_chromium().empty()) {                                                                             \
    std::cout << "skipped: no Chromium is installed; script/setup --with-browser installs one" << std::endl; \
    return;                                                                                                  \
  }

/// A disc of radius 20 and height 6 as a fan of triangles, scanned from above: its rim is 0.15 mm too far out and its
/// lower face was not scanned.
struct Disc {
  Verdict verdict;
  PointCloud cloud;
  Disc() {
    ArtifactVerdict a;
    a.file = "disc.scad", a.program = "openscad", a.version = "2021.01";
    a.verdict = verdict.verdict = Outcome::out_of_tolerance;
    verdict.tolerance = 0.1, verdict.noise = 0.01, verdict.smallest_honest_tolerance = 0.02;
    const std::vector<std::string> names = {"top", "rim", "bottom"};
    for (const auto& name : names) {
      FeatureVerdict row;
      row.name = name, row.kind = "plane", row.covered = name == "bottom" ? 0 : 1;
      row.verdict = name == "rim" ? Outcome::out_of_tolerance : Outcome::verified;
      row.max = name == "rim" ? 0.15 : 0.02, row.points = 900;
      row.dimensions = {{"offset", Quantity::length, 6, 6.01, 0.002, 0.01, true}};
      a.objects.push_back(row);
    }
    constexpr int sides = 96;
    a.mesh.vertices = {{0, 0, 6}, {0, 0, 0}};
    for (int k = 0; k < sides; ++k)
      for (const double z : {6.0, 0.0})
        a.mesh.vertices.push_back({20 * std::cos(2 * pi * k / sides), 20 * std::sin(2 * pi * k / sides), z});
    for (std::uint32_t k = 0; k < sides; ++k) {
      const std::uint32_t up = 2 + 2 * k, down = up + 1, next_up = 2 + 2 * ((k + 1) % sides), next_down = next_up + 1;
      a.mesh.triangles.insert(
          a.mesh.triangles.end(),
          {{0, up, next_up}, {1, next_down, down}, {up, down, next_down}, {up, next_down, next_up}});
      a.triangle_object.insert(a.triangle_object.end(), {0, 2, 1, 1});
    }
    Random random(5);
    for (int i = 0; i < 30000; ++i) {
      const double angle = random.uniform(0, 2 * pi), radius = 20 * std::sqrt(random.uniform());
      const bool rim = i % 3 == 0;
      const double off = rim ? 0.15 : 0.02 * std::sin(angle);
      cloud.points.push_back(rim ? Vec3(20.15 * std::cos(angle), 20.15 * std::sin(angle), random.uniform(0, 6))
                                 : Vec3(radius * std::cos(angle), radius * std::sin(angle), 6 + off));
      a.point_deviation.push_back(static_cast<float>(off));
      a.point_object.push_back(rim ? 1 : 0);
    }
    a.data_to_model.points = cloud.size(), a.data_to_model.local_max = 0.15, a.data_to_model.rms = 0.09;
    a.model_to_data = {3267, 2010, 1257, 0};
    Finding finding;
    finding.feature = "rim", finding.place = Vec3(0, -20, 3), finding.direction = Vec3(0, -1, 0);
    finding.deviation = 0.15, finding.area = 754, finding.extent = 40, finding.points = 10000;
    finding.text = "rim: 0.15 mm too far out over 754 mm2 at (0, -20, 3)";
    a.findings = {finding};
    // The same disc from another program, without the fault of the rim.
    ArtifactVerdict good = a;
    good.file = "disc.step", good.program = "OpenCASCADE", good.verdict = Outcome::verified;
    good.findings.clear();
    for (auto& row : good.objects) row.verdict = Outcome::verified, row.max = 0.02;
    for (auto& d : good.point_deviation) d = std::abs(d) > 0.1 ? 0.01f : d;
    verdict.artifacts = {a, good};
  }
};

/// The page of the disc in a folder of its own.
struct Page {
  TemporaryDirectory folder;
  Path file = folder.path() / "report.html";
  std::size_t size = 0;
  Page() {
    const Disc disc;
    Context context;
    const std::optional<Model> none;
    const auto scene = report_scene(none, disc.verdict, disc.cloud, context);
    const std::string text =
        report_page({"disc",
                     none,
                     disc.verdict,
                     scene,
                     draw_report(scene, context),
                     {{"disc.scad", "cylinder(r = 20, h = 6);\n"}, {"disc.scl", "# disc\nr : 20;\n"}},
                     {{"disc.ply", "abc"}},
                     {},
                     "1"});
    size = text.size();
    REQUIRE(write_file(file, text).ok());
  }
};

void wait_until_drawn(Chromium& browser) {
  REQUIRE(browser.wait_for("Number(document.getElementById('canvas').dataset.frames) > 0"));
  browser.evaluate(
      "document.documentElement.style.scrollBehavior = 'auto'; document.getElementById('map').scrollIntoView(); 0");
  browser.evaluate("new Promise(done => setTimeout(done, 150))");
}

/// Pixels that a test of a colour accepts.
template <class Test>
std::size_t count_pixels(const Pixels& picture, Test test) {
  std::size_t count = 0;
  for (std::size_t i = 0; i + 2 < picture.rgb.size(); i += 3)
    count += test(picture.rgb[i], picture.rgb[i + 1], picture.rgb[i + 2]);
  return count;
}
bool drawn(int r, int g, int b) { return r < 250 || g < 250 || b < 250; }
bool far_out(int r, int g, int b) { return r > 60 && g < 60 && b < 60 && r > 2 * g; }  // beyond the tolerance, outside

/// Texts whose contrast to their background, where both are plain colours, is less than 4.5 to 1.
Json faint_texts(Chromium& browser) {
  return browser.evaluate(R"js((() => {
    const channel = v => (v /= 255) <= 0.03928 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4;
    const parse = c => c.match(/[\d.]+/g).map(Number);
    const light = c => 0.2126 * channel(c[0]) + 0.7152 * channel(c[1]) + 0.0722 * channel(c[2]);
    const bad = [];
    for (const e of document.querySelectorAll("body *")) {
      const worded = [...e.childNodes].some(n => n.nodeType === 3 && n.textContent.trim());
      if (!worded || !e.getClientRects().length || e.closest("svg")) continue;
      if (["SCRIPT", "STYLE", "OPTION"].includes(e.tagName)) continue;
      let behind = e, back = [255, 255, 255];
      for (; behind; behind = behind.parentElement) {
        const c = parse(getComputedStyle(behind).backgroundColor);
        if (c.length < 4 || c[3] > 0) { back = c; break; }
      }
      const a = light(parse(getComputedStyle(e).color)), b = light(back);
      if ((Math.max(a, b) + 0.05) / (Math.min(a, b) + 0.05) < 4.5) bad.push(e.outerHTML.slice(0, 120));
    }
    return bad;
  })())js");
}

void prefer_dark(Chromium& browser) {
  browser.call("Emulation.setEmulatedMedia", {{"features", {{{"name", "prefers-color-scheme"}, {"value", "dark"}}}}});
}

void settle(Chromium& browser) { browser.evaluate("new Promise(done => setTimeout(done, 250))"); }

void expect_quiet(const Chromium& browser, const Page& page) {
  for (const auto& complaint : browser.complaints()) UNSCOPED_INFO(complaint);
  CHECK(browser.complaints().empty());
  for (const auto& address : browser.requests()) CHECK(address == "file://" + page.file.string());
}

}  // namespace

TEST_CASE("browser: the map is drawn alike with WebGL and without, and asks for nothing from a network") {
  NEEDS_CHROMIUM
  const Page page;
  CHECK(page.size < 5'000'000);
  std::vector<std::size_t> covered, red;
  for (const bool webgl : {true, false}) {
    Chromium browser(webgl ? std::vector<std::string>{} : std::vector<std::string>{"--disable-3d-apis"});
    browser.open(page.file, 1200, 900);
    wait_until_drawn(browser);
    CHECK(browser.evaluate("document.getElementById('canvas').dataset.renderer") == (webgl ? "webgl" : "canvas"));
    const auto surface = browser.screenshot("#canvas");
    covered.push_back(count_pixels(surface, drawn));
    red.push_back(count_pixels(surface, far_out));
    for (const char* mode : {"points", "both"}) {
      browser.evaluate(std::string("document.querySelector('input[value=") + mode + "]').click()");
      browser.evaluate("new Promise(done => setTimeout(done, 200))");
      const auto other = browser.screenshot("#canvas");
      CHECK(count_pixels(other, drawn) > covered.back() / 2);
      CHECK_FALSE(other.rgb == surface.rgb);
    }
    expect_quiet(browser, page);
  }
  CHECK(covered[0] > 40000);
  CHECK(red[0] > 2000);  // the rim is beyond the tolerance and says so
  CHECK(std::abs(static_cast<double>(covered[1]) / static_cast<double>(covered[0]) - 1) < 0.03);
  CHECK(std::abs(static_cast<double>(red[1]) / static_cast<double>(red[0]) - 1) < 0.1);
}

TEST_CASE("browser: pointing reads the deviation, choosing a feature leaves it alone, a finding is flown to") {
  NEEDS_CHROMIUM
  const Page page;
  Chromium browser({"--force-prefers-reduced-motion"});
  browser.open(page.file, 1200, 900);
  wait_until_drawn(browser);
  browser.press("6");  // from above
  browser.evaluate("document.getElementById('canvas').focus(); 0");
  browser.press("6");
  browser.evaluate("new Promise(done => setTimeout(done, 200))");
  browser.point_at("#canvas", 30, 20);
  REQUIRE(browser.wait_for("/top/.test(document.getElementById('readout').textContent)"));
  const std::string words = browser.evaluate("document.getElementById('readout').textContent");
  INFO(words);
  CHECK(words.find(" mm") != std::string::npos);
  CHECK(words.find(", 6.0") != std::string::npos);  // its height
  CHECK(browser.evaluate("document.getElementById('hint').hidden") == false);

  browser.press("0");
  browser.evaluate("new Promise(done => setTimeout(done, 300))");
  const auto before = count_pixels(browser.screenshot("#canvas"), far_out);
  browser.evaluate("document.querySelector('.pick[data-feature=\"0\"]').click()");
  REQUIRE(browser.wait_for("document.getElementById('canvas').dataset.feature === '0'"));
  browser.evaluate("new Promise(done => setTimeout(done, 300))");
  CHECK(before > 2000);
  CHECK(count_pixels(browser.screenshot("#canvas"), far_out) < before / 20);  // the rim has lost its colour
  CHECK(browser.evaluate("document.querySelector('.pick[data-feature=\"0\"]').getAttribute('aria-pressed')") == "true");
  CHECK(browser.evaluate("document.querySelectorAll('tr.selected').length") == 2);

  const Json view = browser.evaluate("document.getElementById('canvas').dataset.view");
  browser.evaluate("document.querySelector('.pick[data-finding=\"0\"]').click()");
  REQUIRE(browser.wait_for("document.getElementById('canvas').dataset.view !== " + view.dump()));
  REQUIRE(browser.wait_for("/Finding 1: rim/.test(document.getElementById('readout').textContent)"));
  expect_quiet(browser, page);
}

TEST_CASE("browser: the keyboard turns, moves, zooms, reads and resets") {
  NEEDS_CHROMIUM
  const Page page;
  Chromium browser({"--force-prefers-reduced-motion"});
  browser.open(page.file, 1200, 900);
  wait_until_drawn(browser);
  browser.evaluate("document.getElementById('canvas').focus(); 0");
  auto view = [&] {
    browser.evaluate("new Promise(done => setTimeout(done, 120))");
    return browser.evaluate("document.getElementById('canvas').dataset.view").get<std::string>();
  };
  const std::string start = view();
  std::set<std::string> seen = {start};
  for (const char* key : {"ArrowLeft", "ArrowUp", "+", "2", "5", "-"}) {
    browser.press(key);
    INFO(key);
    CHECK(seen.insert(view()).second);
  }
  browser.press("0");
  CHECK(view() == start);
  browser.press("Enter");
  CHECK(browser.wait_for("/mm|not scanned/.test(document.getElementById('readout').textContent)"));
  expect_quiet(browser, page);
}

TEST_CASE("browser: every control has a name, and nothing overflows a narrow window") {
  NEEDS_CHROMIUM
  const Page page;
  Chromium browser;
  browser.open(page.file, 1200, 900);
  wait_until_drawn(browser);
  const std::set<std::string> controls = {"button", "radio", "checkbox", "combobox", "link",   "application",
                                          "image",  "img",   "region",   "status",   "heading"};
  std::size_t named = 0;
  std::set<std::string> roles;
  const Json tree = browser.call("Accessibility.getFullAXTree");
  for (const auto& node : tree.at("nodes")) {
    if (node.value("ignored", false) || !node.contains("role")) continue;
    const std::string role = node.at("role").value("value", "");
    roles.insert(role);
    if (!controls.count(role) || role == "status") continue;
    INFO(node.dump());
    const std::string name = node.contains("name") ? node.at("name").value("value", "") : "";
    CHECK_FALSE(name.empty());
    named += !name.empty();
  }
  CHECK(named > 40);
  for (const char* role : {"main", "navigation", "banner", "contentinfo", "table", "status"})
    CHECK(roles.count(role) == 1);
  browser.call("Emulation.setDeviceMetricsOverride",
               {{"width", 400}, {"height", 800}, {"deviceScaleFactor", 1}, {"mobile", false}});
  CHECK(browser.evaluate("document.documentElement.scrollWidth <= 400") == true);
  const Json faint = faint_texts(browser);
  INFO(faint.dump());
  CHECK(faint.empty());
  expect_quiet(browser, page);
}

TEST_CASE("browser: a dark screen gets dark colours that can be read, the button changes them, print stays light") {
  NEEDS_CHROMIUM
  const Page page;
  for (const bool webgl : {true, false}) {
    Chromium browser(webgl ? std::vector<std::string>{} : std::vector<std::string>{"--disable-3d-apis"});
    prefer_dark(browser);
    browser.open(page.file, 1200, 900);
    wait_until_drawn(browser);
    const std::string ground = "getComputedStyle(document.body).backgroundColor";
    CHECK(browser.evaluate(ground) == "rgb(21, 26, 32)");
    const auto is_ground = [](int r, int g, int b) { return r == 44 && g == 52 && b == 61; };
    const auto is_white = [](int r, int g, int b) { return r == 255 && g == 255 && b == 255; };
    settle(browser);
    const auto dark = browser.screenshot("#canvas");
    CHECK(count_pixels(dark, is_ground) > 40000);
    CHECK(count_pixels(dark, is_white) < 600);  // the mark of the finding
    CHECK(count_pixels(dark, far_out) > 2000);  // the colours of the deviation are the same
    const Json faint = faint_texts(browser);
    INFO(faint.dump());
    CHECK(faint.empty());
    CHECK(browser.evaluate("document.getElementById('scheme').textContent") == "Light colours");
    browser.evaluate("document.getElementById('scheme').click()");
    CHECK(browser.evaluate(ground) == "rgb(255, 255, 255)");
    settle(browser);
    CHECK(count_pixels(browser.screenshot("#canvas"), is_white) > 40000);
    browser.evaluate("document.getElementById('scheme').click()");
    CHECK(browser.evaluate(ground) == "rgb(21, 26, 32)");
    browser.call("Emulation.setEmulatedMedia",
                 {{"media", "print"}, {"features", {{{"name", "prefers-color-scheme"}, {"value", "dark"}}}}});
    CHECK(browser.evaluate("getComputedStyle(document.documentElement).getPropertyValue('--page').trim()") == "#fff");
    CHECK(browser.evaluate("document.getElementById('scheme').getClientRects().length") == 0);
    expect_quiet(browser, page);
  }
}

TEST_CASE(
    "browser: every artifact has its map, another one is seen from where the first was, findings lead back to the "
    "first") {
  NEEDS_CHROMIUM
  const Page page;
  for (const bool webgl : {true, false}) {
    Chromium browser(webgl ? std::vector<std::string>{"--force-prefers-reduced-motion"}
                           : std::vector<std::string>{"--force-prefers-reduced-motion", "--disable-3d-apis"});
    browser.open(page.file, 1200, 900);
    wait_until_drawn(browser);
    CHECK(browser.evaluate("[...document.getElementById('artifact').options].map(o => o.textContent).join('; ')") ==
          "disc.scad: Out of tolerance; disc.step: Verified");
    browser.evaluate("document.getElementById('canvas').focus(); 0");
    browser.press("2");
    settle(browser);
    const auto first = browser.screenshot("#canvas");
    const Json turned =
        browser.evaluate("document.getElementById('canvas').dataset.view.split(' ').slice(0, 9).join(' ')");
    const std::string choose =
        "(() => { const list = document.getElementById('artifact'); list.value = '1'; list.dispatchEvent(new "
        "Event('change')); })()";
    for (int round = 0; round < 20; ++round) {  // more often than a browser has contexts to draw in
      browser.evaluate(choose);
      if (round < 19) browser.evaluate("document.querySelector('.pick[data-feature=\"0\"]').click()");
    }
    REQUIRE(browser.wait_for("document.getElementById('canvas').dataset.artifact === 'disc.step'"));
    settle(browser);
    const auto second = browser.screenshot("#canvas");
    CHECK(browser.evaluate("document.getElementById('canvas').dataset.renderer") == (webgl ? "webgl" : "canvas"));
    CHECK(count_pixels(first, far_out) > 2000);
    CHECK(count_pixels(second, far_out) < 100);  // this rim is right
    CHECK(count_pixels(second, drawn) > 20000);
    CHECK(browser.evaluate("document.getElementById('canvas').dataset.view.split(' ').slice(0, 9).join(' ')") ==
          turned);
    CHECK(browser.evaluate("[...document.querySelectorAll('[data-map]')].filter(e => !e.hidden).length") ==
          2);  // its scale and remark
    CHECK(browser.evaluate("document.querySelectorAll('.mark').length") == 0);
    browser.evaluate("document.querySelector('.pick[data-finding=\"0\"]').click()");
    REQUIRE(browser.wait_for("document.getElementById('canvas').dataset.artifact === 'disc.scad'"));
    settle(browser);
    CHECK(browser.evaluate("document.getElementById('artifact').value") == "0");
    CHECK(browser.evaluate("document.querySelectorAll('.mark').length") == 1);
    CHECK(count_pixels(browser.screenshot("#canvas"), far_out) > 2000);
    expect_quiet(browser, page);
  }
}

TEST_CASE("browser: prints on A4 without the interactive parts, and every script in full") {
  NEEDS_CHROMIUM
  const Page page;
  Chromium browser;
  browser.open(page.file, 1200, 900);
  wait_until_drawn(browser);
  const auto pdf = browser.call("Page.printToPDF", {{"preferCSSPageSize", true}, {"printBackground", true}})
                       .at("data")
                       .get<std::string>();
  CHECK(pdf.starts_with("JVBERi"));  // "%PDF" in base64
  CHECK(pdf.size() > 30'000);
  CHECK(pdf.size() < 5'000'000);
  browser.call("Emulation.setEmulatedMedia", {{"media", "print"}});
  CHECK(browser.evaluate("document.getElementById('canvas').getClientRects().length") == 0);
  CHECK(browser.evaluate("[...document.querySelectorAll('.panel')].every(p => p.getClientRects().length > 0)") == true);
  CHECK(browser.evaluate("getComputedStyle(document.querySelector('thead')).display") == "table-header-group");
  expect_quiet(browser, page);
}

TEST_CASE("browser: without JavaScript the pictures and all tables are there") {
  NEEDS_CHROMIUM
  const Page page;
  Chromium browser;
  browser.call("Emulation.setScriptExecutionDisabled", {{"value", true}});
  browser.open(page.file, 1200, 900);
  CHECK(browser.evaluate("document.getElementById('viewer').getClientRects().length") == 0);
  CHECK(browser.evaluate("[...document.images].every(i => i.complete && i.naturalWidth > 100)") == true);
  CHECK(browser.evaluate("document.images.length").get<int>() >= 9);
  CHECK(browser.evaluate("document.querySelectorAll('table').length").get<int>() >= 4);
  expect_quiet(browser, page);
}

}  // namespace partscribe::testing
