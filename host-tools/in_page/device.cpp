// A session with a device as a module of a page: what `thimble view` is on a PC. The device is a simulated board in this module, or a real one
// behind a serial port.
//
//   device_start(json); device_run(); then every few milliseconds: device_round(), and device_run() again where it is device_due().
//
// device_run() is the session's thread. Where it waits, it leaves the module (wait, by Binaryen's Asyncify) and is entered again. So it must not wait
// in a handler of an exception, nor in a destructor that an exception calls: the stack cannot be put away there.
#include <atomic>
#include <memory>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "board/sim/live_loop.h"
#include "host-tools/client/host_name.h"
#include "host-tools/in_page/exports.h"
#include "host-tools/in_page/page_links.h"
#include "host-tools/in_page/page_scenes.h"
#include "host-tools/in_page/tick_log.h"
#include "host-tools/viewer/device_session.h"

// A message of the session for the page: JSON as over the WebSocket of `thimble view`.
THIMBLE_IMPORT(void, message)(const char* text, std::size_t bytes);
THIMBLE_IMPORT(void, image)
(const char* image, std::size_t bytes);  // of the scene of the next message; no bytes: none
THIMBLE_IMPORT(void, recording)(const char* file, std::size_t bytes);  // of the next message

namespace thimble::host {

std::string host_name(const std::string& /*program*/) { return host_name("page", "browser", "thimble"); }

namespace {

constexpr std::size_t kSlotBytes = std::size_t{8} << 20U;  // both are zeroed at the start

void send(const Json& json) {
  const std::string text = to_text(json);
  page_message(text.data(), text.size());
}

class Sink final : public ViewSink {
 public:
  void hello(Json hello) override {
    hello["may_control"] = true;
    send(hello);
  }
  void scene(std::string scene, ImageBytes image) override {
    page_image(image ? reinterpret_cast<const char*>(image->data()) : nullptr, image ? image->size() : 0);
    page_message(scene.data(), scene.size());
  }
  void state(std::string state) override { page_message(state.data(), state.size()); }
  void event(const Json& event) override { send(event); }
  void link(bool up) override { send(link_json(up)); }
  void recording(const Json& about, std::shared_ptr<const std::string> file) override {
    page_recording(file->data(), file->size());
    send(about);
  }
};

struct Options {
  bool serial = false;
  std::string arm = "premium-1.5";
  double rate_Hz = 4000;
  std::uint8_t arms = 1;
  std::uint64_t seed = 1;
};

// The simulated board, its hands, and the forces that they feel.
class Simulated {
 public:
  explicit Simulated(const Options& options)
      : options_(options),
        storage_(kSlotBytes),
        loop_(inner_, [this](const char* reason) { return start(reason); }),
        hands_(loop_.board()) {}

  void round() {
    loop_.round([this](const board::LiveLoop::Round& round) { hands_.move(round); });
  }
  [[nodiscard]] InnerLink& inner() { return inner_; }
  [[nodiscard]] SimulatedHands& hands() { return hands_; }
  [[nodiscard]] board::LiveLoop& loop() { return loop_; }
  [[nodiscard]] TickLog& log() { return log_; }

 private:
  [[nodiscard]] std::unique_ptr<board::SimBoard> start(const char* reason) {
    board::SimBoardOptions options;
    options.variant = options_.arm;
    options.rate_Hz = options_.rate_Hz;
    options.arm_count = options_.arms;
    options.seed = options_.seed;
    options.storage = &storage_;
    options.reset_reason = reason;
    options.time_ticks = true;
    options.each_tick = [this](const firmware::Telemetry& tick) { log_.take(tick); };
    auto board = std::make_unique<board::SimBoard>(options);
    board->step(2 /
                options_.rate_Hz);  // an early request does not get the state from before the first sample
    return board;
  }

  Options options_;
  TickLog log_;
  board::MemoryStorage storage_;
  InnerLink inner_;
  board::LiveLoop loop_;
  SimulatedHands hands_;
};

DeviceOptions options_of_device() {
  DeviceOptions options;
  options.program = "page";
  return options;
}

class PageDevice final : public SessionLink {
 public:
  explicit PageDevice(const Options& options)
      : simulated_(options.serial ? nullptr : std::make_unique<Simulated>(options)),
        session_({options_of_device(), THIMBLE_VERSION, {}, {}}, *this, scenes_,
                 simulated_ ? &simulated_->hands() : nullptr, std::nullopt, sink_) {
    serial_.set_open(options.serial);  // the page has opened it
  }

  // The session's thread.
  void run() {
    while (!first()) wait_for_page(kRetry_us);
  }
  [[nodiscard]] bool is_due() const {
    return simulated_ ? simulated_->inner().has_news() : serial_.has_news();
  }
  void round() {
    if (simulated_) simulated_->round();
  }
  void post(std::string_view text) {
    try {
      session_.post(parse_page_message(text));
    } catch (const Error& error) {
      sink_.event(event_json(error));
    }
  }
  [[nodiscard]] PageScenes& scenes() { return scenes_; }
  [[nodiscard]] SerialLink& serial() { return serial_; }
  [[nodiscard]] Simulated* simulated() { return simulated_.get(); }

  [[nodiscard]] std::unique_ptr<Transport> connect(std::string& address) override {
    address = simulated_ ? "this page" : "serial port";
    return simulated_ ? simulated_->inner().connect() : serial_.connect();
  }
  void pause(link::Micros time_us) override { wait_for_page(time_us); }

 private:
  static constexpr link::Micros kRetry_us = 300'000;

  // False: the device has not answered yet.
  [[nodiscard, gnu::noinline]] bool first() {
    try {
      session_.run(stopping_, [] {});
      return true;
    } catch (const Error& error) {
      if (error.name != told_) sink_.event(event_json(error));
      told_ = error.name;
      return false;
    }
  }

  std::atomic<bool> stopping_ = false;
  Sink sink_;
  PageScenes scenes_;
  SerialLink serial_;
  std::unique_ptr<Simulated> simulated_;
  std::string told_;  // the error of the last try
  DeviceSession session_;
};

std::unique_ptr<PageDevice> device;

}  // namespace
}  // namespace thimble::host

using thimble::host::device;
using thimble::host::give;
using thimble::host::page_buffer;

// In: JSON, all members optional: serial, arm, rate_Hz, arms, seed. Out: why not; nothing: it is there.
THIMBLE_EXPORT(int, device_start)() {
  using namespace thimble::host;
  try {
    const Json json = Json::parse(page_buffer);
    Options options;
    options.serial = json.value("serial", options.serial);
    options.arm = json.value("arm", options.arm);
    options.rate_Hz = json.value("rate_Hz", options.rate_Hz);
    options.arms = json.value("arms", options.arms);
    options.seed = json.value("seed", options.seed);
    device.reset();
    device = std::make_unique<PageDevice>(options);
    return 0;
  } catch (const std::exception& error) {
    return give(error.what());
  }
}
// Where device_run() puts its stack away: `bytes` bytes.
THIMBLE_EXPORT(char*, device_stack)(std::size_t bytes) {
  static std::vector<char> stack;
  stack.resize(bytes);
  return stack.data();
}
THIMBLE_EXPORT(void, device_run)() { device->run(); }
// Whether the session has something to do before the time that it waits for.
THIMBLE_EXPORT(int, device_due)() { return device->is_due() ? 1 : 0; }

// The ticks of the simulated board that are due by the clock.
THIMBLE_EXPORT(void, device_round)() { device->round(); }
THIMBLE_EXPORT(double, device_skipped_s)() {
  return device->simulated() != nullptr ? device->simulated()->loop().skipped_s() : 0;
}
THIMBLE_EXPORT(double, device_ticks)() {
  return device->simulated() == nullptr
             ? 0
             : static_cast<double>(device->simulated()->loop().board().controller().telemetry().tick);
}
// Of the simulated board: whether to keep the forces of its ticks; out: those since the last call, as floats; and the longest tick since the last call.
THIMBLE_EXPORT(void, device_listen)(int yes) {
  if (device->simulated() != nullptr) device->simulated()->log().listen(yes != 0);
}
THIMBLE_EXPORT(int, device_forces)() {
  return device->simulated() == nullptr ? give("") : give(device->simulated()->log().forces());
}
THIMBLE_EXPORT(double, device_worst_tick_us)() {
  return device->simulated() == nullptr ? 0 : static_cast<double>(device->simulated()->log().worst_us());
}

// In: a message of a page, as over the WebSocket.
THIMBLE_EXPORT(void, device_post)() { device->post(page_buffer); }
// In: what the compiler said (JSON, with "text"), and the image.
THIMBLE_EXPORT(void, device_deliver)(std::size_t head_bytes) {
  device->scenes().deliver(std::string_view(page_buffer).substr(0, head_bytes),
                           std::string_view(page_buffer).substr(head_bytes));
}
// The same of a scene that the session has not asked for.
THIMBLE_EXPORT(void, device_learn)(std::size_t head_bytes) {
  device->scenes().learn(std::string_view(page_buffer).substr(0, head_bytes),
                         std::string_view(page_buffer).substr(head_bytes));
}

THIMBLE_EXPORT(void, device_port_open)(int open) { device->serial().set_open(open != 0); }
THIMBLE_EXPORT(void, device_port_in)() { device->serial().take(page_buffer); }
THIMBLE_EXPORT(int, device_port_out)() { return give(device->serial().give()); }
