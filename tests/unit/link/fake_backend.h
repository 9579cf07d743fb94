// A backend in memory for tests of the services: what a controller would do, without one.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "firmware/link/service_server.h"

namespace thimble::firmware::link {

class FakeBackend final : public ServiceBackend {
 public:
  static constexpr std::uint16_t kDid = 0x0100;
  static constexpr std::uint32_t kCapacity = 100'000;

  std::vector<std::uint8_t> param = {1, 2, 3, 4};
  Nrc next = Nrc::kOk;  // what routines and writes answer
  int pending = 0;      // how often they say "pending" before
  std::vector<FaultRecord> faults_list;
  std::size_t frames = 0;
  std::vector<std::string> calls;
  std::vector<std::uint8_t> stored;
  std::uint32_t length = 0, crc = 0;
  int alive = 0;

  Nrc read_data(std::uint16_t did, ByteWriter& out) noexcept override {
    if (did == 0x0200) {  // too long for any answer
      for (int i = 0; i < 5000; ++i) out.put(0);
      return Nrc::kOk;
    }
    if (did != kDid) return Nrc::kRequestOutOfRange;
    out.put(param);
    return Nrc::kOk;
  }
  Nrc write_data(std::uint16_t did, std::span<const std::uint8_t> data) noexcept override {
    if (did != kDid) return Nrc::kRequestOutOfRange;
    if (data.size() != 4) return Nrc::kIncorrectLength;
    const Nrc answer = answered("write");
    if (answer == Nrc::kOk) param.assign(data.begin(), data.end());
    return answer;
  }
  Nrc arm() noexcept override { return answered("arm"); }
  Nrc disarm() noexcept override { return answered("disarm"); }
  Nrc home() noexcept override { return answered("home"); }
  Nrc activate() noexcept override { return answered("activate"); }
  Nrc save_parameters() noexcept override { return answered("save"); }
  Nrc start_move(const MoveOrder& order) noexcept override {
    if (!(order.speed_m_s > 0)) return Nrc::kRequestOutOfRange;
    return answered("move");
  }
  Nrc end_move() noexcept override { return answered("end_move"); }
  Nrc move_samples(ByteWriter& out) noexcept override {
    out.put_record(MoveSample{});
    return answered("move_samples");
  }
  Nrc start_trace() noexcept override { return answered("trace"); }
  Nrc end_trace() noexcept override { return answered("end_trace"); }
  Nrc trace_start(ByteWriter& out) noexcept override {
    out.put_record(TraceStart{});
    return answered("trace_start");
  }
  Nrc prepare_download(std::uint32_t new_length, std::uint32_t new_crc,
                       std::uint32_t& has) noexcept override {
    const Nrc answer = answered("prepare");
    if (answer != Nrc::kOk) return answer;
    if (new_length > kCapacity) return Nrc::kDownloadNotAccepted;
    if (new_length != length || new_crc != crc) stored.clear();
    length = new_length;
    crc = new_crc;
    has = static_cast<std::uint32_t>(stored.size());
    return Nrc::kOk;
  }
  Nrc write_download(std::uint32_t offset, std::span<const std::uint8_t> data) noexcept override {
    if (offset != stored.size()) return Nrc::kGeneralReject;
    const Nrc answer = answered("block");
    if (answer == Nrc::kOk) stored.insert(stored.end(), data.begin(), data.end());
    return answer;
  }
  Nrc finish_download() noexcept override { return answered("finish"); }
  std::size_t fault_count() const noexcept override { return faults_list.size(); }
  FaultRecord fault(std::size_t index) const noexcept override { return faults_list[index]; }
  Nrc clear_faults() noexcept override {
    const Nrc answer = answered("clear");
    if (answer == Nrc::kOk) faults_list.clear();
    return answer;
  }
  bool freeze_frame(std::uint8_t, std::size_t index, ByteWriter& out) const noexcept override {
    if (index >= frames) return false;
    FreezeFrame frame;
    frame.tick = static_cast<std::uint32_t>(index);
    out.put_record(frame);
    return true;
  }
  void reset(Reset) noexcept override { calls.emplace_back("reset"); }
  void host_alive(Micros) noexcept override { ++alive; }

 private:
  Nrc answered(const char* call) {
    if (pending > 0) {
      --pending;
      return Nrc::kResponsePending;
    }
    calls.emplace_back(call);
    return next;
  }
};

}  // namespace thimble::firmware::link
