#include "testing/chromium.h"

#include <fcntl.h>
#include <poll.h>
#include <signal.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstring>
#include <nlohmann/json.hpp>
#include <stdexcept>
#include <thread>

#include "core/process.h"

namespace partscribe::testing {
namespace {

std::string decoded_base64(const std::string& text) {
  std::string bytes;
  std::uint32_t group = 0;
  int bits = 0;
  for (const char c : text) {
    const int value = c >= 'A' && c <= 'Z'   ? c - 'A'
                      : c >= 'a' && c <= 'z' ? c - 'a' + 26
                      : c >= '0' && c <= '9' ? c - '0' + 52
                      : c == '+'             ? 62
                      : c == '/'             ? 63
                                             : -1;
    if (value < 0) continue;
    group = group << 6 | static_cast<std::uint32_t>(value);
    if ((bits += 6) >= 8) bytes += static_cast<char>(group >> (bits -= 8));
  }
  return bytes;
}

double now() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

}  // namespace

Path find_chromium() {
  for (const char* name : {"chromium-headless-shell", "chromium", "chromium-browser", "google-chrome"})
    if (auto path = find_program(name); !path.empty()) return path;
  return {};
}

Chromium::Chromium(const std::vector<std::string>& flags) {
  int down[2], up[2];
  if (::pipe(down) != 0 || ::pipe(up) != 0) throw std::runtime_error("no pipes for the browser");
  std::vector<std::string> words = {find_chromium().string(),
                                    "--headless",
                                    "--no-sandbox",
                                    "--enable-unsafe-swiftshader",
                                    "--disable-dev-shm-usage",
                                    "--remote-debugging-pipe",
                                    "--user-data-dir=" + profile_.path().string()};
  words.insert(words.end(), flags.begin(), flags.end());
  words.push_back("about:blank");
  std::vector<char*> arguments;
  for (auto& word : words) arguments.push_back(word.data());
  arguments.push_back(nullptr);
  process_ = ::fork();
  if (process_ == 0) {
    // The browser reads from 3 and writes to 4; go by numbers that are neither.
    const int in = ::fcntl(down[0], F_DUPFD, 20), out = ::fcntl(up[1], F_DUPFD, 20),
              nothing = ::open("/dev/null", O_RDWR);
    ::dup2(in, 3), ::dup2(out, 4), ::dup2(nothing, 0), ::dup2(nothing, 1), ::dup2(nothing, 2);
    for (int k = 5; k < 64; ++k) ::close(k);
    ::setpgid(0, 0);
    ::execv(arguments[0], arguments.data());
    ::_exit(127);
  }
  ::close(down[0]), ::close(up[1]);
  to_ = down[1], from_ = up[0];
  const auto targets = call("Target.getTargets").at("targetInfos");
  std::string id;
  for (const auto& target : targets)
    if (target.at("type") == "page") id = target.at("targetId");
  session_ = call("Target.attachToTarget", {{"targetId", id}, {"flatten", true}}).at("sessionId");
  for (const char* domain : {"Page", "Runtime", "Log", "Network", "Accessibility", "DOM"})
    call(std::string(domain) + ".enable");
}

Chromium::~Chromium() {
  if (process_ > 0) {
    ::kill(-process_, SIGKILL);
    ::kill(process_, SIGKILL);
    ::waitpid(process_, nullptr, 0);
  }
  ::close(to_), ::close(from_);
  // Helpers of the browser may still be closing files in the profile.
  std::this_thread::sleep_for(std::chrono::milliseconds(100));
}

Json Chromium::receive(double seconds) {
  const double end = now() + seconds;
  for (;;) {
    if (const auto stop = buffer_.find('\0'); stop != std::string::npos) {
      Json message = Json::parse(buffer_.substr(0, stop));
      buffer_.erase(0, stop + 1);
      return message;
    }
    pollfd wait{from_, POLLIN, 0};
    if (now() > end || ::poll(&wait, 1, static_cast<int>(1000 * std::max(0.0, end - now()))) <= 0)
      throw std::runtime_error("the browser does not answer");
    char bytes[65536];
    const auto count = ::read(from_, bytes, sizeof bytes);
    if (count <= 0) throw std::runtime_error("the browser has ended");
    buffer_.append(bytes, static_cast<std::size_t>(count));
  }
}

void Chromium::note(const Json& event) {
  const std::string method = event.value("method", "");
  if (method == "Runtime.exceptionThrown") complaints_.push_back(event.at("params").at("exceptionDetails").dump());
  if (method == "Runtime.consoleAPICalled") complaints_.push_back(event.at("params").dump());
  // Reading pixels back is slow, says the driver: that is our doing, not the page's.
  if (method == "Log.entryAdded" &&
      event.at("params").at("entry").at("text").get<std::string>().find("GPU stall") == std::string::npos)
    complaints_.push_back(event.at("params").at("entry").dump());
  if (method == "Network.requestWillBeSent") {
    const std::string address = event.at("params").at("request").at("url");
    if (!address.starts_with("data:")) requests_.push_back(address);
  }
}

Json Chromium::call(const std::string& method) { return call(method, Json::object()); }

Json Chromium::call(const std::string& method, Json parameters) {
  Json message = {{"id", ++last_id_}, {"method", method}, {"params", std::move(parameters)}};
  if (!session_.empty()) message["sessionId"] = session_;
  const std::string text = message.dump() + '\0';
  for (std::size_t sent = 0; sent < text.size();) {
    const auto count = ::write(to_, text.data() + sent, text.size() - sent);
    if (count <= 0) throw std::runtime_error("the browser does not listen");
    sent += static_cast<std::size_t>(count);
  }
  for (;;) {
    Json answer = receive(60);
    if (answer.value("id", 0) != last_id_) {
      note(answer);
      continue;
    }
    if (answer.contains("error")) throw std::runtime_error(method + ": " + answer.at("error").dump());
    return answer.at("result");
  }
}

Json Chromium::evaluate(const std::string& expression) {
  const Json answer =
      call("Runtime.evaluate", {{"expression", expression}, {"awaitPromise", true}, {"returnByValue", true}});
  if (answer.contains("exceptionDetails"))
    throw std::runtime_error(expression + ": " + answer.at("exceptionDetails").dump());
  return answer.at("result").value("value", Json());
}

bool Chromium::wait_for(const std::string& expression, double seconds) {
  for (const double end = now() + seconds; now() < end;) {
    if (evaluate("Boolean(" + expression + ")") == true) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(50));
  }
  return false;
}

void Chromium::open(const Path& page, int width, int height) {
  open_address("file://" + std::filesystem::absolute(page).string(), width, height);
}

void Chromium::open_address(const std::string& address, int width, int height) {
  call("Emulation.setDeviceMetricsOverride",
       {{"width", width}, {"height", height}, {"deviceScaleFactor", 1}, {"mobile", false}});
  call("Page.navigate", {{"url", address}});
  if (!wait_for("document.readyState === 'complete' && location.href !== 'about:blank'"))
    throw std::runtime_error("the page does not load");
}

void Chromium::point_at(const std::string& selector, double dx, double dy, bool click) {
  const Json middle = evaluate("(() => { const b = document.querySelector('" + selector +
                               "').getBoundingClientRect(); return [b.x + b.width / 2, b.y + b.height / 2]; })()");
  Json event = {{"type", "mouseMoved"}, {"x", middle.at(0).get<double>() + dx}, {"y", middle.at(1).get<double>() + dy}};
  call("Input.dispatchMouseEvent", event);
  if (!click) return;
  event["button"] = "left", event["clickCount"] = 1;
  for (const char* type : {"mousePressed", "mouseReleased"}) {
    event["type"] = type;
    call("Input.dispatchMouseEvent", event);
  }
}

void Chromium::press(const std::string& key) {
  for (const char* type : {"keyDown", "keyUp"}) call("Input.dispatchKeyEvent", {{"type", type}, {"key", key}});
}

Pixels Chromium::screenshot(const std::string& selector) {
  const Json box =
      evaluate("(() => { const b = document.querySelector('" + selector +
               "').getBoundingClientRect(); return [b.x + scrollX, b.y + scrollY, b.width, b.height]; })()");
  const Json clip = {{"x", box.at(0)}, {"y", box.at(1)}, {"width", box.at(2)}, {"height", box.at(3)}, {"scale", 1}};
  return decoded_png(decoded_base64(
      call("Page.captureScreenshot", {{"format", "png"}, {"clip", clip}, {"captureBeyondViewport", true}}).at("data")));
}

}  // namespace partscribe::testing
