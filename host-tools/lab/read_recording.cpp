// Recordings in files.
#include <fstream>

#include "host-tools/files/input_file.h"
#include "host-tools/lab/recording.h"

namespace thimble::host {

bool is_recording(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  std::string begin(kRecordingMagic.size(), '\0');
  in.read(begin.data(), static_cast<std::streamsize>(begin.size()));
  return in && begin == kRecordingMagic;
}

Recording read_recording(const std::filesystem::path& file) {
  const std::string bytes = read_input(file);
  return parse_recording(std::as_bytes(std::span(bytes)), file.string());
}

}  // namespace thimble::host
