// Device: the routines that run for longer than a request, guarded moves and recordings; and the audit record.
#include <stdexcept>
#include <utility>

#include "host-tools/client/device.h"
#include "host-tools/client/requests.h"

namespace thimble::host {

using link::Nrc;
using link::Routine;
using link::Session;

namespace {

template <typename Record>
Bytes routine_request_with(Routine routine, const Record& record) {
  Bytes start = routine_request(routine);
  const std::size_t head = start.size();
  start.resize(head + link::wire_size<Record>());
  if (link::encode(record, std::span(start).subspan(head)) == 0)
    throw std::logic_error("the record has its size");
  return start;
}

}  // namespace

void Device::inject(const link::InjectedFault& fault) {
  services_.enter(Session::kExtended);
  const std::string what = "breaking the simulated hardware";
  const ServiceClient::Answer answer = services_.request(routine_request_with(Routine::kInject, fault));
  // Of a board that does not know the routine.
  if (answer.code == Nrc::kIncorrectLength) {
    throw Error(ExitCode::kRefused, "not-simulated",
                what + " was refused: board " + text(link::kDidBoardName) + " has real hardware",
                "connect to a simulator (`thimble-sim`)");
  }
  if (answer.code != Nrc::kOk) services_.refused(what, answer.code);
}

void Device::take_command() {
  services_.enter(Session::kExtended);
  services_.demand(routine_request(Routine::kCommand), "taking command");
}

void Device::set_key(const link::Key& key) {
  services_.enter(Session::kExtended);
  Bytes request = routine_request(Routine::kKey);
  request.insert(request.end(), key.begin(), key.end());
  services_.demand(request, "setting the key");
}

void Device::remove_key() {
  services_.enter(Session::kExtended);
  services_.demand(routine_request(Routine::kKey, kStop), "removing the key");
}

// --- Guarded moves

void Device::start_move(const link::MoveOrder& order) {
  services_.enter(Session::kExtended);
  const ServiceClient::Answer answer = services_.request(routine_request_with(Routine::kMove, order));
  // A repeated request is refused because the move has begun.
  if (answer.code != Nrc::kOk && move_state().phase == link::MovePhase::kNone)
    services_.refused("the move", answer.code);
}

link::MoveState Device::move_state() { return services_.record<link::MoveState>("reading the move's state"); }

std::vector<link::MoveSample> Device::move_samples() {
  const Bytes answer =
      services_.demand(routine_request(Routine::kMove, kResults), "reading what the move measured");
  std::vector<link::MoveSample> samples;
  constexpr std::size_t kEach = link::wire_size<link::MoveSample>();
  for (std::size_t at = 4; at + kEach <= answer.size(); at += kEach) {
    link::MoveSample sample;
    if (link::decode(std::span(answer).subspan(at), sample)) samples.push_back(sample);
  }
  return samples;
}

void Device::end_move() {
  services_.enter(Session::kExtended);
  services_.demand(routine_request(Routine::kMove, kStop), "ending the move");
}

// --- Orders for the axes

void Device::start_axes(const link::AxisOrder& order) {
  services_.enter(Session::kExtended);
  services_.demand(routine_request_with(Routine::kAxes, order), "the motion");
}

link::AxisState Device::axis_state() {
  services_.enter(Session::kExtended);
  const Bytes answer =
      services_.demand(routine_request(Routine::kAxes, kResults), "reading the motion's state");
  link::AxisState state;
  if (!link::decode(std::span(answer).subspan(4), state))
    services_.refused("reading the motion's state", Nrc::kIncorrectLength);
  return state;
}

void Device::home_at(const link::HomePlace& place) {
  services_.enter(Session::kExtended);
  services_.demand(routine_request_with(Routine::kHomeAt, place), "homing");
}

// --- Recordings

void Device::start_recording(bool counts_only) {
  services_.enter(Session::kExtended);
  const ServiceClient::Answer answer =
      services_.request(routine_request(counts_only ? Routine::kRecordCounts : Routine::kRecording));
  // A repeated request is refused because it is running.
  if (answer.code != Nrc::kOk && recording_state().phase != link::RecordingPhase::kRunning)
    services_.refused("starting the recording", answer.code);
}

void Device::end_recording() {
  services_.enter(Session::kExtended);
  services_.demand(routine_request(Routine::kRecording, kStop), "ending the recording");
}

link::RecordingState Device::recording_state() {
  return services_.record<link::RecordingState>("reading the recording's state");
}

std::pair<link::RecordingStart, std::vector<link::RecordingArm>> Device::recording_start() {
  services_.enter(Session::kExtended);
  const Bytes answer =
      services_.demand(routine_request(Routine::kRecording, kResults), "reading how the recording began");
  std::pair<link::RecordingStart, std::vector<link::RecordingArm>> result;
  std::span<const std::uint8_t> rest = std::span(answer).subspan(4);
  if (!link::decode(rest, result.first))
    services_.refused("reading how the recording began", Nrc::kIncorrectLength);
  rest = rest.subspan(link::wire_size<link::RecordingStart>());
  result.second.resize(result.first.arms);
  for (link::RecordingArm& arm : result.second) {
    if (!link::decode(rest, arm)) services_.refused("reading how the recording began", Nrc::kIncorrectLength);
    rest = rest.subspan(link::wire_size<link::RecordingArm>());
  }
  return result;
}

// --- The audit record

std::vector<link::AuditRecord> Device::audit() {
  std::vector<link::AuditRecord> entries;
  constexpr std::size_t kEach = link::wire_size<link::AuditRecord>();
  for (std::uint32_t from = 0;; from = entries.back().number + 1) {
    Bytes page = routine_request(Routine::kAudit, kResults);
    put_u32(page, from);
    const Bytes answer = services_.demand(page, "reading the audit record");
    if (answer.size() < 4 + kEach) return entries;
    for (std::size_t at = 4; at + kEach <= answer.size(); at += kEach) {
      link::AuditRecord entry;
      if (!link::decode(std::span(answer).subspan(at), entry) || (from != 0 && entry.number < from))
        return entries;  // it has begun anew, or is none of this version
      entries.push_back(entry);
    }
  }
}

}  // namespace thimble::host
