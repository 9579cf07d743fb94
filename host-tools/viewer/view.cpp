#include "host-tools/viewer/view.h"

#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <array>
#include <atomic>
#include <chrono>
#include <csignal>
#include <cstdlib>
#include <cstring>
#include <exception>
#include <future>
#include <memory>
#include <optional>
#include <stdexcept>
#include <thread>
#include <utility>

#include "host-tools/client/discovery.h"
#include "host-tools/lab/kept_arms.h"
#include "host-tools/viewer/device_session.h"
#include "host-tools/viewer/scene_book.h"
#include "host-tools/viewer/simulated_device.h"
#include "host-tools/viewer/web_server.h"

extern char** environ;  // NOLINT(readability-redundant-declaration): not in every libc's unistd.h

namespace thimble::host {
namespace {

std::unique_ptr<SimulatedDevice> start_simulated(const ViewOptions& options) {
  board::LiveOptions live;
  live.arm = options.arm;
  live.arm_data = options.arm_data;
  live.arm_count = options.arms;
  live.name = "view-" + std::to_string(getpid());
  try {
    return std::make_unique<SimulatedDevice>(live);
  } catch (const std::invalid_argument& error) {
    throw Error(ExitCode::kUsage, "unknown-arm", error.what(), "`thimble view --help` names the arms");
  } catch (const std::exception& error) {
    throw Error(ExitCode::kRefused, "no-simulator",
                std::string("the simulated controller did not start: ") + error.what(), "see the cause");
  }
}

// To the simulated device, or to the one that the user means.
class DeskLink final : public SessionLink {
 public:
  DeskLink(SimulatedDevice* simulated, std::string device)
      : simulated_(simulated), device_(std::move(device)) {}
  [[nodiscard]] std::unique_ptr<Transport> connect(std::string& address) override {
    address = simulated_ != nullptr ? simulated_->uri() : choose_device(device_);
    return simulated_ != nullptr ? simulated_->connect() : open_transport(address);
  }
  void pause(link::Micros time_us) override {
    std::this_thread::sleep_for(std::chrono::microseconds(time_us));
  }

 private:
  SimulatedDevice* simulated_;
  std::string device_;
};

// Ends the thread when the object is destroyed, also after an exception.
class SessionThread {
 public:
  SessionThread(DeviceSession& session, WebServer& server) {
    connected_ = ready_.get_future();
    thread_ = std::thread([this, &session, &server] {
      bool told = false;
      try {
        session.run(stopping_, [this, &told] {
          told = true;
          ready_.set_value();
        });
      } catch (...) {
        if (!told) {
          ready_.set_exception(std::current_exception());
        } else {
          failure_ = std::current_exception();
          server.stop();
        }
      }
    });
  }
  SessionThread(const SessionThread&) = delete;
  SessionThread& operator=(const SessionThread&) = delete;
  ~SessionThread() { join(); }

  void wait_until_connected() { connected_.get(); }
  void finish() {
    join();
    if (failure_) std::rethrow_exception(failure_);
  }

 private:
  void join() {
    stopping_ = true;
    if (thread_.joinable()) thread_.join();
  }

  std::atomic<bool> stopping_{false};
  std::promise<void> ready_;
  std::future<void> connected_;
  std::exception_ptr failure_;
  std::thread thread_;
};

}  // namespace

void view(const ViewOptions& options,
          const std::function<void(const std::string& url, const std::string& device)>& serving) {
  std::signal(SIGPIPE, SIG_IGN);  // a write to a lost device then returns an error
  std::optional<OpenScene> first;
  if (!options.scene.empty()) first = open_scene(options.scene);
  std::vector<std::filesystem::path> folders = scene_folders(options.scene);
  if (!options.scenes.empty()) {
    std::error_code none;
    if (!std::filesystem::is_directory(options.scenes, none)) {
      throw Error(ExitCode::kBadInput, "no-folder", options.scenes.string() + " is not a folder",
                  "--scenes takes a folder of scene files");
    }
    folders.insert(folders.begin(), options.scenes);
  }
  const SceneBook book(folders);

  // Called in this thread only, when the session is there.
  DeviceSession* session_of_pages = nullptr;
  WebServer server({options.listen, options.port},
                   {.message = [&](PageMessage message) { session_of_pages->post(std::move(message)); },
                    .scenes =
                        [&book] {
                          Json names = Json::array();
                          for (const auto& [name, file] : book.list()) names.push_back(name);
                          return names;
                        }});
  const std::unique_ptr<SimulatedDevice> simulated = first ? start_simulated(options) : nullptr;
  const std::string device = simulated ? simulated->uri() : choose_device(options.device);
  DeskLink link(simulated.get(), options.device);
  SceneFiles scenes(book);
  DeviceSession session({options.device_options, options.version, options.arm_data, data_of_device}, link,
                        scenes, simulated ? &simulated->hands() : nullptr, std::move(first), server);
  session_of_pages = &session;
  SessionThread thread(session, server);
  thread.wait_until_connected();
  server.take_signals();
  serving(server.url(), device);
  server.run();
  thread.finish();
}

std::string open_browser(const std::string& url) {
  const char* wish = std::getenv("BROWSER");
  std::string program = wish != nullptr && *wish != '\0' ? wish : "xdg-open";
  std::string address = url;
  const std::array<char*, 3> arguments{program.data(), address.data(), nullptr};
  posix_spawn_file_actions_t quiet;
  posix_spawn_file_actions_init(&quiet);
  posix_spawn_file_actions_addopen(&quiet, STDIN_FILENO, "/dev/null", 0 /* O_RDONLY */, 0);
  posix_spawn_file_actions_addopen(&quiet, STDOUT_FILENO, "/dev/null", 1 /* O_WRONLY */, 0);
  posix_spawn_file_actions_addopen(&quiet, STDERR_FILENO, "/dev/null", 1 /* O_WRONLY */, 0);
  // A new session, so that Ctrl-C in this terminal does not end the browser.
  posix_spawnattr_t apart;
  posix_spawnattr_init(&apart);
  posix_spawnattr_setflags(&apart, POSIX_SPAWN_SETSID | POSIX_SPAWN_SETSIGDEF);
  sigset_t usual;
  sigemptyset(&usual);
  sigaddset(&usual, SIGPIPE);  // view() ignores it
  posix_spawnattr_setsigdefault(&apart, &usual);
  pid_t child = 0;
  const int failed = posix_spawnp(&child, program.c_str(), &quiet, &apart, arguments.data(), environ);
  posix_spawnattr_destroy(&apart);
  posix_spawn_file_actions_destroy(&quiet);
  if (failed != 0) return program + " cannot be started: " + std::strerror(failed);
  // A command that fails ends at once; one that is a browser may keep running.
  for (int round = 0; round < 20; ++round) {
    int status = 0;
    if (waitpid(child, &status, WNOHANG) == child) {
      return WIFEXITED(status) && WEXITSTATUS(status) == 0 ? "" : program + " found no browser";
    }
    usleep(50'000);
  }
  return {};
}

}  // namespace thimble::host
