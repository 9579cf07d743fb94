#include "host-tools/lab/recording.h"

#include <algorithm>
#include <cstring>

#include "control/scene/limits.h"
#include "firmware/link/crc32.h"
#include "firmware/params.h"
#include "host-tools/error.h"
#include "thimble_recording_schema/recording_generated.h"

namespace thimble::host {
namespace {

using flatbuffers::FlatBufferBuilder;
using flatbuffers::Offset;
using link::crc32;

constexpr std::size_t kPrefixBytes = 8;                                                // length and CRC
constexpr std::size_t kMostBytes = control::kMaxImageBytes + (std::size_t{1} << 20U);  // of a message
constexpr std::uint32_t kMostGap = 1U << 30U;  // ticks; a file with more is broken

std::uint32_t u32_at(std::span<const std::byte> bytes, std::size_t at) {
  std::uint32_t value = 0;
  for (std::size_t i = 0; i < 4; ++i) value |= std::to_integer<std::uint32_t>(bytes[at + i]) << (8U * i);
  return value;
}

void put_u32(std::ostream& out, std::uint32_t value) {
  for (unsigned shift = 0; shift < 32; shift += 8) out.put(static_cast<char>(value >> shift & 0xFFU));
}

template <class Body>
void write_message(std::ostream& out, FlatBufferBuilder& builder, Offset<Body> body) {
  builder.Finish(recording::CreateMessage(builder, recording::BodyTraits<Body>::enum_value, body.Union()));
  const auto bytes = std::as_bytes(std::span(builder.GetBufferPointer(), builder.GetSize()));
  put_u32(out, static_cast<std::uint32_t>(bytes.size()));
  put_u32(out, crc32(bytes));
  out.write(reinterpret_cast<const char*>(bytes.data()), static_cast<std::streamsize>(bytes.size()));
}

std::uint16_t bits_of(const link::Levels& levels) {
  std::array<std::uint8_t, 2> bytes{};
  static_assert(link::wire_size<link::Levels>() <= bytes.size());
  static_cast<void>(link::encode(levels, bytes));
  return static_cast<std::uint16_t>(bytes[0] | bytes[1] << 8U);
}

link::Levels levels_of(std::uint16_t bits) {
  const std::array<std::uint8_t, 2> bytes = {static_cast<std::uint8_t>(bits),
                                             static_cast<std::uint8_t>(bits >> 8U)};
  link::Levels levels;
  static_cast<void>(link::decode(bytes, levels));
  return levels;
}

std::string text(const flatbuffers::String* from) { return from == nullptr ? std::string() : from->str(); }

// Reads messages into a Recording. Safe for any bytes: invalid content is an Error.
class Reader {
 public:
  Reader(std::span<const std::byte> bytes, std::string name) : bytes_(bytes), name_(std::move(name)) {}

  Recording read() {
    if (bytes_.size() < kRecordingMagic.size() ||
        std::memcmp(bytes_.data(), kRecordingMagic.data(), kRecordingMagic.size()) != 0) {
      throw Error(ExitCode::kBadInput, "not-a-recording", name_ + " is no recording",
                  "give a file that `thimble record` wrote");
    }
    at_ = kRecordingMagic.size();
    bool any = false;
    while (!recording_.end) {
      const std::span<const std::byte> rest = bytes_.subspan(at_);
      if (rest.size() < kPrefixBytes) break;
      const std::size_t size = u32_at(rest, 0);
      if (size > kMostBytes) broken("a message of " + std::to_string(size) + " bytes");
      if (rest.size() - kPrefixBytes < size) break;
      const std::span<const std::byte> message = rest.subspan(kPrefixBytes, size);
      if (crc32(message) != u32_at(rest, 4)) broken("a message whose CRC-32 is not that of its bytes");
      take(message, !any);
      any = true;
      at_ += kPrefixBytes + size;
    }
    if (!any) broken("nothing whole: it was cut off within its header");
    recording_.cut_bytes = bytes_.size() - at_;
    if (recording_.end && recording_.cut_bytes != 0) broken("something behind its end");
    return std::move(recording_);
  }

 private:
  [[noreturn]] void broken(const std::string& what) const {
    throw Error(ExitCode::kBadInput, "broken-recording",
                name_ + " has " + what + ", at byte " + std::to_string(at_),
                "copy it again from where it was recorded");
  }

  void take(std::span<const std::byte> bytes, bool first) {
    // Behind a prefix of 8 bytes, but of any length: aligned as FlatBuffers want it.
    aligned_.assign((bytes.size() + 7) / 8, 0);
    if (!bytes.empty()) std::memcpy(aligned_.data(), bytes.data(), bytes.size());
    const auto* data = reinterpret_cast<const std::uint8_t*>(aligned_.data());
    flatbuffers::Verifier verifier(data, bytes.size());
    if (!verifier.VerifyBuffer<recording::Message>(nullptr)) broken("a message that is none");
    const auto* message = flatbuffers::GetRoot<recording::Message>(data);
    if (first != (message->body_type() == recording::Body::Header))
      broken(first ? "no header" : "a second header");
    if (first && message->body() == nullptr) broken("a header without a body");
    if (message->body() == nullptr) return;  // of a later version
    switch (message->body_type()) {
      case recording::Body::Header:
        return take(*message->body_as_Header());
      case recording::Body::Ticks:
        return take(*message->body_as_Ticks());
      case recording::Body::Checks:
        return take(*message->body_as_Checks());
      case recording::Body::Frames:
        return take(*message->body_as_Frames());
      case recording::Body::End:
        return take(*message->body_as_End());
      case recording::Body::Marks:
        return take(*message->body_as_Marks());
      case recording::Body::NONE:
        return;
    }
  }

  void take(const recording::Header& from) {
    if (from.format() != kRecordingFormat) {
      throw Error(ExitCode::kVersion, "version-mismatch",
                  name_ + " has format " + std::to_string(from.format()) + "; this thimble reads " +
                      std::to_string(kRecordingFormat),
                  "read it with the thimble that wrote it (" + text(from.tool()) + ")");
    }
    RecordingHeader& header = recording_.header;
    header.tool = text(from.tool());
    header.firmware = text(from.firmware());
    header.board = text(from.board());
    header.serial = text(from.serial());
    if (from.models() != nullptr)
      for (const flatbuffers::String* model : *from.models()) header.models.push_back(text(model));
    header.node = from.node();
    header.began = from.began();
    header.scene_name = text(from.scene_name());
    header.scene_crc = from.scene_crc();
    if (from.scene() == nullptr || from.scene()->size() == 0 ||
        from.scene()->size() > control::kMaxImageBytes)
      broken("a header without a scene");
    const auto scene = std::as_bytes(std::span(from.scene()->data(), from.scene()->size()));
    header.scene.assign(scene.begin(), scene.end());
    if (crc32(header.scene) != header.scene_crc) broken("a scene whose CRC-32 is another");
    if (from.start() == nullptr) broken("a header without a start");
    std::span<const std::uint8_t> start(from.start()->data(), from.start()->size());
    if (!link::decode(start, header.start)) broken("a start that is too short");
    if (header.start.arms < 1 || header.start.arms > control::kMaxArms ||
        header.models.size() != header.start.arms)
      broken("a header with " + std::to_string(header.start.arms) + " arms");
    start = start.subspan(link::wire_size<link::RecordingStart>());
    header.arms.resize(header.start.arms);
    for (link::RecordingArm& arm : header.arms) {
      if (!link::decode(start, arm)) broken("a start that is too short");
      start = start.subspan(link::wire_size<link::RecordingArm>());
    }
    if (from.parameters() != nullptr)
      for (const recording::Parameter* parameter : *from.parameters())
        header.parameters.emplace_back(parameter->id(), parameter->bits());
    next_ = std::uint64_t{header.start.tick} + 1;
    last_check_ = last_mark_ = header.start.tick;
  }

  // The whole number of a tick of which the low 32 bits are known, at or after another one.
  std::uint64_t unwrapped(std::uint32_t low, std::uint64_t after) {
    const std::uint32_t gap = low - static_cast<std::uint32_t>(after);
    if (gap > kMostGap) broken("ticks that go back");
    return after + gap;
  }

  void take(const recording::Ticks& from) {
    if (from.counts() == nullptr || from.counts()->size() == 0) return;
    const std::size_t each = kRecordedCounts * recording_.header.start.arms;
    if (from.counts()->size() % each != 0) broken("part of a tick");
    const std::uint64_t first = unwrapped(from.first(), next_);
    if (recording_.ticks.empty() || first != next_) recording_.ticks.push_back({first, {}});
    std::vector<std::uint16_t>& counts = recording_.ticks.back().counts;
    counts.insert(counts.end(), from.counts()->begin(), from.counts()->end());
    next_ = first + from.counts()->size() / each;
  }

  void take(const recording::Checks& from) {
    if (from.checks() == nullptr) return;
    for (const recording::Check* check : *from.checks()) {
      last_check_ = unwrapped(check->tick(), last_check_);
      const auto mode = static_cast<link::Mode>(check->mode());
      const auto command = static_cast<link::RecordedCommand>(check->command());
      if (!link::has_name(mode) || !link::has_name(command)) broken("a mode or command that does not exist");
      recording_.checks.push_back(
          {last_check_, check->crc(), mode, command, check->last() != 0, levels_of(check->levels())});
    }
  }

  void take(const recording::Marks& from) {
    if (from.marks() == nullptr) return;
    for (const recording::Mark* mark : *from.marks()) {
      last_mark_ = unwrapped(mark->tick(), last_mark_);
      const auto what = static_cast<link::MarkKind>(mark->what());
      if (!link::has_name(what)) broken("a mark of a kind that does not exist");
      recording_.marks.push_back({last_mark_, what, mark->value(), mark->before()});
    }
  }

  void take(const recording::Frames& from) {
    if (from.frames() == nullptr) return;
    for (const recording::Frame* frame : *from.frames()) {
      RecordedFrame to;
      to.time_us = frame->time_us();
      to.frame.id = frame->id();
      to.frame.size = frame->size();
      if (frame->size() > link::kClassicDataBytes) broken("a frame of more than 8 bytes");
      for (std::size_t i = 0; i < link::kClassicDataBytes; ++i)
        to.frame.data[i] =
            static_cast<std::uint8_t>((i < 4 ? frame->data_0() : frame->data_1()) >> (8 * (i % 4)));
      recording_.frames.push_back(to);
    }
  }

  void take(const recording::End& from) {
    recording_.end = {text(from.reason()), from.fault(),   from.ticks(),
                      from.dropped(),      from.missing(), from.marks_missing()};
  }

  std::span<const std::byte> bytes_;
  std::string name_;
  std::size_t at_ = 0;
  std::vector<std::uint64_t> aligned_;
  Recording recording_;
  std::uint64_t next_ = 0;
  std::uint64_t last_check_ = 0;
  std::uint64_t last_mark_ = 0;
};

}  // namespace

std::uint64_t Recording::tick_count() const {
  std::uint64_t count = 0;
  for (const RecordedTicks& run : ticks) count += run.counts.size() / (kRecordedCounts * header.start.arms);
  return count;
}

// The host read it at some time after the start; what was written until then tells what it was before.
std::uint8_t Recording::first_trial() const {
  for (const RecordedMark& mark : marks)
    if (mark.what == link::MarkKind::kTrial) return static_cast<std::uint8_t>(mark.before);
  for (const auto& [id, bits] : header.parameters)
    if (id == row_of(firmware::Param::trial).id) return static_cast<std::uint8_t>(bits);
  return 0;
}

void write_header(std::ostream& out, const RecordingHeader& header) {
  out << kRecordingMagic;
  FlatBufferBuilder builder;
  std::vector<std::uint8_t> start(link::wire_size<link::RecordingStart>() +
                                  header.arms.size() * link::wire_size<link::RecordingArm>());
  std::span<std::uint8_t> rest(start);
  rest = rest.subspan(link::encode(header.start, rest));
  for (const link::RecordingArm& arm : header.arms) rest = rest.subspan(link::encode(arm, rest));
  std::vector<Offset<recording::Parameter>> parameters;
  for (const auto& [id, bits] : header.parameters)
    parameters.push_back(recording::CreateParameter(builder, id, bits));
  const auto body = recording::CreateHeader(
      builder, kRecordingFormat, builder.CreateString(header.tool), builder.CreateString(header.firmware),
      builder.CreateString(header.board), builder.CreateString(header.serial),
      builder.CreateVectorOfStrings(header.models), header.node, header.began,
      builder.CreateString(header.scene_name),
      builder.CreateVector(reinterpret_cast<const std::uint8_t*>(header.scene.data()), header.scene.size()),
      header.scene_crc, builder.CreateVector(start), builder.CreateVector(parameters));
  write_message(out, builder, body);
}

void write_ticks(std::ostream& out, const RecordedTicks& ticks) {
  FlatBufferBuilder builder;
  write_message(out, builder,
                recording::CreateTicks(builder, static_cast<std::uint32_t>(ticks.first),
                                       builder.CreateVector(ticks.counts)));
}

void write_checks(std::ostream& out, std::span<const RecordedCheck> checks) {
  FlatBufferBuilder builder;
  std::vector<recording::Check> list;
  for (const RecordedCheck& check : checks)
    list.emplace_back(static_cast<std::uint32_t>(check.tick), check.crc,
                      static_cast<std::uint8_t>(check.mode), static_cast<std::uint8_t>(check.command),
                      check.last ? std::uint8_t{1} : std::uint8_t{0}, bits_of(check.levels));
  write_message(out, builder, recording::CreateChecks(builder, builder.CreateVectorOfStructs(list)));
}

void write_marks(std::ostream& out, std::span<const RecordedMark> marks) {
  FlatBufferBuilder builder;
  std::vector<recording::Mark> list;
  for (const RecordedMark& mark : marks)
    list.emplace_back(static_cast<std::uint32_t>(mark.tick), static_cast<std::uint8_t>(mark.what), mark.value,
                      mark.before);
  write_message(out, builder, recording::CreateMarks(builder, builder.CreateVectorOfStructs(list)));
}

void write_frames(std::ostream& out, std::span<const RecordedFrame> frames) {
  FlatBufferBuilder builder;
  std::vector<recording::Frame> list;
  for (const RecordedFrame& frame : frames) {
    std::array<std::uint32_t, 2> data{};
    for (std::size_t i = 0; i < link::kClassicDataBytes; ++i)
      data[i / 4] |= static_cast<std::uint32_t>(frame.frame.data[i]) << (8U * (i % 4));
    list.emplace_back(frame.time_us, static_cast<std::uint16_t>(frame.frame.id), frame.frame.size, data[0],
                      data[1]);
  }
  write_message(out, builder, recording::CreateFrames(builder, builder.CreateVectorOfStructs(list)));
}

void write_end(std::ostream& out, const RecordingEnd& end) {
  FlatBufferBuilder builder;
  write_message(out, builder,
                recording::CreateEnd(builder, builder.CreateString(end.reason), end.fault, end.ticks,
                                     end.dropped, end.missing, end.marks_missing));
}

Recording parse_recording(std::span<const std::byte> bytes, const std::string& name) {
  return Reader(bytes, name).read();
}

}  // namespace thimble::host
