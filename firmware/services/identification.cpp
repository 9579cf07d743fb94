// Service 22: records, texts and parameters by their identifiers.
#include <array>
#include <bit>

#include "firmware/services/handlers.h"

namespace thimble::firmware {
namespace {

using link::ByteWriter;

constexpr std::size_t kMaxDataIdentifiers = 8;  // in one request

// --- Records

void link_info(const Services& services, ByteWriter& out) noexcept {
  const Config& config = services.parts.config;
  link::LinkInfo info;
  info.protocol = link::kProtocolVersion;
  info.image = link::kImageVersion;
  info.frame_bytes = config.classic_can ? link::kClassicDataBytes : link::kFdDataBytes;
  info.node = config.node_id;
  info.arms = config.arm_count;
  out.put_record(info);
}

void device_state(const Services& services, ByteWriter& out) noexcept {
  const ServiceParts& parts = services.parts;
  const Telemetry& record = parts.telemetry.record();
  link::DeviceState state;
  state.mode = parts.core.status().mode();
  state.fault = static_cast<std::uint8_t>(parts.core.status().fault());
  state.flags = parts.status.flags();
  state.tick = static_cast<std::uint32_t>(record.tick);
  state.tick_rate_Hz = parts.telemetry.rate_Hz();
  state.worst_tick_s = record.worst_tick_us * 1e-6F;
  state.overruns = record.overruns;
  state.contact_ticks = record.contact_ticks;
  state.peak_force_N = record.peak_force_N;
  state.mean_force_N = record.mean_force_N;
  state.sweep_bound = record.bounds.sweep_bound;
  state.slide_bound = record.bounds.slide_bound;
  state.scene_bytes = static_cast<std::uint32_t>(parts.store.image_bytes());
  state.scene_crc = parts.store.image_crc();
  state.scene_sequence = parts.store.sequence();
  state.frames_received = parts.link.frames_received;
  state.frames_dropped = parts.telemetry.dropped();
  state.link_losses = parts.link.link_losses;
  state.contact_bound = record.bounds.contact_bound;
  state.probes = record.probes;
  const Host* commander = services.commander();
  state.commander = commander == nullptr ? 0 : commander->address;
  state.key = parts.keys.state();
  state.stopped_by = parts.core.status().stopped_by();
  state.work_units = parts.core.setup().work_units;
  state.most_work = record.bounds.most_work;
  state.put_off = record.bounds.put_off;
  state.put_off_object = record.bounds.put_off_object;
  out.put_record(state);
}

void lateness(const Services& services, ByteWriter& out) noexcept {
  const Core& core = services.parts.core;
  link::Lateness late;
  std::uint32_t* const bins[] = {&late.below_1us,   &late.below_2us,  &late.below_5us,   &late.below_10us,
                                 &late.below_20us,  &late.below_50us, &late.below_100us, &late.below_200us,
                                 &late.below_500us, &late.below_1ms,  &late.below_2ms,   &late.below_5ms,
                                 &late.longer};
  static_assert(std::size(bins) == kLateBounds_us.size() + 1);
  for (std::size_t i = 0; i < std::size(bins); ++i) *bins[i] = core.observers().late_ticks.ticks(i);
  late.worst_s = core.observers().late_ticks.worst_us() * 1e-6F;
  out.put_record(late);
}

void move(const Services& services, ByteWriter& out) noexcept {
  out.put_record(move_state(services.parts.core));
}
void recording(const Services& services, ByteWriter& out) noexcept {
  out.put_record(services.parts.core.observers().recorder.state());
}
void host_orders(const Services& services, ByteWriter& out) noexcept {
  out.put_record(services.parts.orders.counts());
}

void arm_images(const Services& services, ByteWriter& out) noexcept {
  const ArmStore& arms = services.parts.arms;
  link::ArmImages images;
  for (std::size_t i = 0; i < services.parts.config.arm_count; ++i) {
    images.crc[i] = arms.image_crc(i);
    images.next_crc[i] = arms.stored_crc(i);
    images.damaged[i] = arms.damaged(i);
  }
  out.put_record(images);
}

// --- Texts

void serial_number(const Services& services, ByteWriter& out) noexcept {
  out.put_text(services.parts.config.serial_number);
}
void firmware_version(const Services& /*services*/, ByteWriter& out) noexcept {
  out.put_text(THIMBLE_VERSION);
}
void board_name(const Services& services, ByteWriter& out) noexcept {
  out.put_text(services.parts.config.board);
}
void reset_reason(const Services& services, ByteWriter& out) noexcept {
  out.put_text(services.parts.config.reset_reason);
}
void set_aside(const Services& services, ByteWriter& out) noexcept {
  const JournalRecord::InUse& aside = services.parts.persistent.set_aside();
  if (aside.scene != 0) out.put_text("scene");
  if (aside.scene != 0 && aside.params != 0) out.put_text(",");
  if (aside.params != 0) out.put_text("parameters");
}
void arm_names(const Services& services, ByteWriter& out) noexcept {
  const Config& config = services.parts.config;
  const Setup& setup = services.parts.core.setup();
  for (std::size_t i = 0; i < config.arm_count; ++i) {
    if (i != 0) out.put_text(",");
    // Of a Config that cannot work it is the name that was asked for.
    out.put_text(setup.arm_count == 0 ? config.arm[i].model : setup.arm[i].data().name.data());
  }
}
void scene_name(const Services& services, ByteWriter& out) noexcept {
  const scene::Scene* scene = services.parts.running.scene();
  if (scene != nullptr) out.put_text(scene->name()->c_str());
}

// As of the last telemetry record. Its scene may be an older one than the one that runs: then the bits name nothing there.
void inside(const Services& services, ByteWriter& out) noexcept {
  const scene::Scene* scene = services.parts.running.scene();
  const Telemetry& record = services.parts.telemetry.record();
  if (scene == nullptr || record.scene_sequence != services.parts.store.sequence()) return;
  for (std::size_t arm = 0; arm < record.arm_count; ++arm) {
    for (std::uint64_t left = record.arm[arm].inside; left != 0; left &= left - 1) {
      const auto object = static_cast<unsigned>(std::countr_zero(left));
      if (object >= scene->objects()->size()) break;
      const std::array<char, 6> head = {
          static_cast<char>('0' + arm),         ' ', static_cast<char>('0' + object / 10),
          static_cast<char>('0' + object % 10), ' ', '\0'};
      out.put_text(head.data());
      out.put_text(scene->objects()->Get(object)->name()->c_str());
      out.put_text("\n");
    }
  }
}

void put_name(const Host& host, ByteWriter& out) noexcept {
  for (const char letter : host.name)
    if (letter != '\0') out.put(static_cast<std::uint8_t>(letter));
}
void commander_name(const Services& services, ByteWriter& out) noexcept {
  if (const Host* host = services.commander(); host != nullptr) put_name(*host, out);
}

struct DataRow {
  std::uint16_t id;
  void (*read)(const Services&, ByteWriter&) noexcept;
};
constexpr std::array<DataRow, 16> kData = {{
    {link::LinkInfo::kId, link_info},
    {link::DeviceState::kId, device_state},
    {link::MoveState::kId, move},
    {link::RecordingState::kId, recording},
    {link::Lateness::kId, lateness},
    {link::HostOrders::kId, host_orders},
    {link::ArmImages::kId, arm_images},
    {link::kDidSerialNumber, serial_number},
    {link::kDidFirmwareVersion, firmware_version},
    {link::kDidBoardName, board_name},
    {link::kDidResetReason, reset_reason},
    {link::kDidSetAside, set_aside},
    {link::kDidArmName, arm_names},
    {link::kDidSceneName, scene_name},
    {link::kDidInside, inside},
    {link::kDidCommander, commander_name},
}};

[[nodiscard]] Nrc read_one(Services& services, const Host& host, std::uint16_t id, ByteWriter& out) noexcept {
  if (id == link::kDidSession) {
    out.put(static_cast<std::uint8_t>(host.session));
    return Nrc::kOk;
  }
  if (id == link::kDidRefusal) {
    out.put_text(host.refusal.data());
    return Nrc::kOk;
  }
  if (id == link::Marked::kId) {
    out.put_record(host.marked);
    return Nrc::kOk;
  }
  if (id == link::kDidHostName) {
    put_name(host, out);
    return Nrc::kOk;
  }
  for (const DataRow& row : kData) {
    if (row.id != id) continue;
    row.read(services, out);
    return Nrc::kOk;
  }
  const BoardData* board = services.parts.config.board_data;
  if (board != nullptr && board->read(id, out)) return Nrc::kOk;
  return read_parameter(services, id, out);
}

}  // namespace

// 22 did(2) ...: the known identifiers are answered, the others left out; out of range only when none is known (ISO 14229-1).
Nrc read_data(Services& services, Call& call) noexcept {
  const std::size_t count = (call.request.size() - 1) / 2;
  if (call.request.size() % 2 == 0 || count == 0 || count > kMaxDataIdentifiers) return Nrc::kIncorrectLength;
  bool any = false;
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint16_t id = u16_at(call.request, 1 + 2 * i);
    const std::size_t before = call.answer.size();
    call.answer.put_u16(id);
    if (read_one(services, call.host, id, call.answer) == Nrc::kOk) {
      any = true;
    } else {
      call.answer.cut_to(before);
    }
  }
  return any ? Nrc::kOk : Nrc::kRequestOutOfRange;
}

}  // namespace thimble::firmware
