// Recordings, and their replay. The checksums of the messages are mended first. What is read reads the same when it is written again.
#include <algorithm>
#include <sstream>

#include "host-tools/client/device.h"
#include "host-tools/error.h"
#include "host-tools/lab/recording.h"
#include "host-tools/lab/replay_recording.h"
#include "tests/fuzz/targets/target.h"

namespace {

using namespace thimble;

void mend_checksums(std::string& file) {
  constexpr std::size_t kPrefix = 8;
  for (std::size_t at = host::kRecordingMagic.size(); at + kPrefix <= file.size();) {
    std::size_t size = 0;
    for (std::size_t i = 4; i-- > 0;) size = size << 8U | static_cast<unsigned char>(file[at + i]);
    if (size > file.size() - at - kPrefix) return;
    const std::uint32_t sum = host::crc32(std::as_bytes(std::span(file).subspan(at + kPrefix, size)));
    for (std::size_t i = 0; i < 4; ++i) file[at + 4 + i] = static_cast<char>(sum >> (8 * i) & 0xFFU);
    at += kPrefix + size;
  }
}

host::Recording parse(const std::string& file) {
  return host::parse_recording(std::as_bytes(std::span(file)), "recording");
}

std::string written(const host::Recording& recording) {
  std::ostringstream out;
  host::write_header(out, recording.header);
  for (const host::RecordedTicks& ticks : recording.ticks) host::write_ticks(out, ticks);
  host::write_checks(out, recording.checks);
  host::write_frames(out, recording.frames);
  if (recording.end) host::write_end(out, *recording.end);
  return out.str();
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  std::string file(fuzz::text_of({data, size}));
  mend_checksums(file);
  try {
    const host::Recording recording = parse(file);
    const std::string again = written(recording);
    fuzz::demand(written(parse(again)) == again, "a recording that is written again reads the same");
    constexpr std::uint64_t kMostTicks = 500;
    if (recording.tick_count() > kMostTicks) return 0;
    const host::ReplayVerdict verdict = host::replay_recording(recording);
    fuzz::demand(verdict.ticks <= recording.tick_count() && verdict.checks <= recording.checks.size(),
                 "no more is replayed than is there");
  } catch (const host::Error& error) {
    fuzz::demand(error.code == host::ExitCode::kBadInput || error.code == host::ExitCode::kVersion,
                 "a bad recording is bad input, or of another version");
  }
  return 0;
}
