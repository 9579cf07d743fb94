// The device side of a viewer: one thread that talks to the device, merges its telemetry, executes the messages of pages, and reconnects
// to a device that disappeared. Results go to a ViewSink.
#pragma once

#include <atomic>
#include <cstdint>
#include <deque>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "host-tools/client/device.h"
#include "host-tools/viewer/arm_drawing.h"
#include "host-tools/viewer/live_state.h"
#include "host-tools/viewer/mutex.h"
#include "host-tools/viewer/protocol.h"
#include "host-tools/viewer/scenes.h"
#include "host-tools/viewer/session_recording.h"
#include "host-tools/viewer/simulated_hands.h"

namespace thimble::host {

// Called in the session's thread.
class ViewSink {
 public:
  ViewSink() = default;
  ViewSink(const ViewSink&) = delete;
  ViewSink& operator=(const ViewSink&) = delete;
  virtual ~ViewSink() = default;
  virtual void hello(Json hello) = 0;                           // without may_control
  virtual void scene(std::string scene, ImageBytes image) = 0;  // no image: the server does not know it
  virtual void state(std::string state) = 0;
  virtual void event(const Json& event) = 0;
  virtual void link(bool up) = 0;
  // One that has ended: what is said of it, and its file.
  virtual void recording(const Json& about, std::shared_ptr<const std::string> file) = 0;
};

// How a session gets to its device.
class SessionLink {
 public:
  SessionLink() = default;
  SessionLink(const SessionLink&) = delete;
  SessionLink& operator=(const SessionLink&) = delete;
  virtual ~SessionLink() = default;
  // Throws Error when the device is not there. address: what the page calls it.
  [[nodiscard]] virtual std::unique_ptr<Transport> connect(std::string& address) = 0;
  virtual void pause(link::Micros time_us) = 0;  // before the device is looked for again
};

struct SessionOptions {
  DeviceOptions options;
  std::string version;
  std::optional<kinematics::ArmData> arm_data{};  // of the simulated device, if it is not built in
  // The numbers of the arm with this name and stored image (kept_arms.h); empty: none are known.
  std::function<std::optional<kinematics::ArmData>(const std::string& name, std::uint32_t crc)> arm_of{};
};

class DeviceSession {
 public:
  // hands: of a simulated device; null: it is a real one. first: the scene that a simulated device begins with. What is referred to must
  // outlive the session.
  DeviceSession(SessionOptions options, SessionLink& link, Scenes& scenes, SimulatedHands* hands,
                std::optional<OpenScene> first, ViewSink& sink);

  // From any thread. Messages are queued, at most kMostWaiting and one disarm; those of a hand act at once, and so
  // does a stop, whatever else goes on.
  void post(PageMessage message);

  // Connects (Error when the device is not there), then serves until stopping. `connected` is called once.
  void run(const std::atomic<bool>& stopping, const std::function<void()>& connected);

  static constexpr std::size_t kMostWaiting = 64;

 private:
  struct Disturbed {};  // thrown through an upload when a more urgent message waits

  void connect();
  void begin_simulation();
  void home_simulation();
  void serve(const std::atomic<bool>& stopping);
  // Not inlined, where something waits behind their handlers: a compiler for a page may put that into the handler (docs/in-a-page.md).
  [[nodiscard, gnu::noinline]] bool serve_until_lost(const std::atomic<bool>& stopping);
  void wait_for_device(const std::atomic<bool>& stopping);
  [[nodiscard, gnu::noinline]] bool is_back();
  void send_hello();
  void learn_arms();
  void hear(const link::CanFrame& frame);
  void listen(link::Micros until_us);
  void tend_stop();
  void send_state(link::Micros now);
  void look_at_device();
  void show_scene(const std::string& name, std::uint32_t crc);
  void show_open_scene();

  [[nodiscard]] std::optional<PageMessage> next_message();
  [[nodiscard]] bool urgent_waits();
  [[nodiscard]] bool merge(const MaterialMessage& material);  // under mutex_
  [[nodiscard]] bool merge(DraftMessage& draft);              // under mutex_; moves from it if true
  template <class Message>
  void leave_room() const;  // under mutex_; throws where there is none
  [[gnu::noinline]] void obey(const PageMessage& message);
  void obey(const HandMessage& message);
  void obey(const CommandMessage& message);
  void obey(const PickMessage& message);
  void obey(const ParameterMessage& message);
  void obey(const MaterialMessage& message);
  void obey(const TextMessage& message);
  void obey(const DraftMessage& message);
  void obey(const FileMessage& message);
  void obey(const SaveMessage& message);
  void obey(const AnswerMessage& message);
  void obey(const RecordMessage& message);

  void begin_recording();
  [[nodiscard, gnu::noinline]] std::optional<Error> start_recording();
  [[gnu::noinline]] void abandon_recording();
  void tend_recording();
  [[gnu::noinline]] void finish_recording();
  void break_off_recording(const std::string& reason);
  void hand_over(const RecordingEnd& end);

  void save(bool replaces);
  [[nodiscard]] const OpenScene& known_scene() const;
  void drop_edits();
  void tell(const Error& error);
  void tell_that_draft_runs(const OpenScene& scene);
  void tell_of_draft(const Error& error);
  void tell_of_dropped(std::size_t number, const std::string& why);
  void drop_drafts(const std::string& why);
  void take_done(OpenScene scene);
  void take_failed(const Error& error);
  void begin_next_job();
  void watch_file();
  void take_reread(OpenScene scene);
  void run_as(const OpenScene& scene);
  void forget_save(const std::string& why);
  void begin_job(SceneJob job);
  [[gnu::noinline]] void tend_job();
  void upload(const OpenScene& scene);
  void inform(const std::string& name, const std::string& cause, const std::string& remedy = "");

  SessionOptions options_;
  SessionLink& link_;
  Scenes& scenes_;
  SimulatedHands* hands_;
  ViewSink& sink_;
  const std::atomic<bool>* stopping_ = nullptr;
  std::unique_ptr<Device> device_;
  std::unique_ptr<SessionRecording> recording_;  // refers to the device
  std::string address_;
  std::uint8_t arms_ = 1;
  LiveState live_;
  std::array<std::unique_ptr<ArmDrawing>, 2> drawings_;  // of the arms whose numbers are known
  link::Micros begun_us_;
  link::Micros heard_us_ = 0;
  link::Micros state_due_us_ = 0;
  link::Micros look_due_us_ = 0;
  link::DeviceState device_state_;
  link::Micros device_state_us_ = 0;
  double decimation_ = 40;  // ticks from record to record

  // The scene that runs, where its file is known; and one that is being compiled.
  std::optional<OpenScene> running_;
  std::optional<std::uint32_t> shown_crc_;
  std::optional<OpenScene> edited_;              // running_ with changes that do not run yet
  std::optional<SceneJob::Kind> job_;            // that is being compiled
  std::optional<std::filesystem::path> picked_;  // to be opened when no job runs
  bool edited_since_job_ = false;
  std::optional<DraftMessage> draft_;  // to be compiled when no job runs
  std::size_t draft_number_ = 0;       // of the last one that was compiled
  bool draft_is_bad_ = false;          // it has errors
  std::optional<SaveMessage> save_wanted_;
  bool told_of_other_host_ = false;  // that it changes the materials of what runs
  std::optional<OpenScene> to_upload_;
  link::Micros watch_due_us_ = 0;   // of the running scene's file
  link::Micros upload_due_us_ = 0;  // the force of the last one has risen again
  bool begin_ = false;              // a simulated device that has its scene is homed and armed

  // A page wants to stop: the e-stop frame goes out again and again until the device confirms it.
  std::atomic<bool> stop_wanted_ = false;
  std::atomic<unsigned> stops_ = 0;  // wanted so far
  unsigned stops_before_ = 0;        // before the message that is obeyed was taken
  link::Micros stop_due_us_ = 0;
  link::Micros stop_until_us_ = 0;  // 0: none has gone out yet

  Mutex mutex_;
  std::deque<PageMessage> waiting_;
};

}  // namespace thimble::host
