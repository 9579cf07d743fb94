// All services of the controller: the tables that lead from a request to its handler (services.cpp), and what the handlers
// work with. A new service or routine is a handler in a file of this folder, its declaration in handlers.h, and a row.
//
// Who calls it: the router, in the background context.
#pragma once

#include <cstdint>
#include <optional>

#include "control/scene/scene_view.h"
#include "firmware/core/core.h"
#include "firmware/observe/recording_frames.h"
#include "firmware/observe/status_frames.h"
#include "firmware/observe/telemetry_frames.h"
#include "firmware/params.h"
#include "firmware/services/audit.h"
#include "firmware/services/authenticator.h"
#include "firmware/services/download.h"
#include "firmware/services/force_orders.h"
#include "firmware/services/jobs.h"
#include "firmware/services/lease.h"
#include "firmware/services/router.h"
#include "firmware/store/arm_store.h"
#include "firmware/store/key_store.h"
#include "firmware/store/param_store.h"
#include "firmware/store/persistent_state.h"
#include "firmware/store/scene_store.h"

namespace thimble::firmware {

struct LinkCounts {
  std::uint32_t frames_received = 0;
  std::uint32_t link_losses = 0;  // frames or bytes that the board's link has lost since start
};

// What belongs to the controller and the services work with.
struct ServiceParts {
  const Config& config;
  Params& params;
  Core& core;
  SceneStore& store;
  control::SceneView& running;  // the scene posted last
  ArmStore& arms;
  ParamStore& param_store;
  KeyStore& keys;
  PersistentState& persistent;
  Audit& audit;
  TelemetryFrames& telemetry;
  StatusFrames& status;
  RecordingFrames& recording;
  const LinkCounts& link;
  const ForceOrders& orders;
};

class Services final : public RequestHandler {
 public:
  explicit Services(const ServiceParts& controller) noexcept;

  [[nodiscard]] Nrc handle(Call& call) noexcept override;
  [[nodiscard]] bool urgent(std::span<const std::uint8_t> request) const noexcept override;
  void give_up(Host& host) noexcept override {
    jobs.give_up(host);
    host.disarming = false;
  }
  void session_ended(Host& host) noexcept override {
    download.end(host);
    lease.end(host);
  }
  void host_alive(const Host& host, link::Micros now) noexcept override;
  void restart(link::Reset kind) noexcept override;

  // kOk: the host has the key, where there is one, and the lease. Otherwise the answer.
  [[nodiscard]] Nrc may_command(Call& call, bool orders_arm = false) noexcept;
  [[nodiscard]] const Host* commander() const noexcept;  // the host that commands; null: none

  ServiceParts parts;
  Jobs jobs;
  CommandJob command;
  EndRecordingJob end_recording;
  MarkJob mark;
  SwitchSceneJob switch_scene;
  Download download;
  Lease lease;
  Authenticator authenticator;
  std::uint32_t recording_scene_crc = 0;      // of the scene that the last recording began with
  std::optional<link::Reset> restart_wanted;  // the board is to start again

 private:
  link::Micros now_us_ = 0;  // of the request that is handled
};

}  // namespace thimble::firmware
