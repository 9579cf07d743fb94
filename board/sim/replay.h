// A recording (firmware/observe/recorder.h) fed to a controller of this process: the same core, so the same forces to the bit.
//
//   Replay replay(run);                       // std::invalid_argument: what does not fit
//   for each tick of the recording: replay.tick({counts, levels, command});
//   replay.check() against the recording's RecordingCheck; replay.row() for the forces
//
// One thread. The bytes of the image are copied.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "board/sim/simulation.h"
#include "firmware/link/messages.h"

namespace thimble::board {

// What a recording says of its device.
struct RecordedRun {
  firmware::link::RecordingStart start;
  std::vector<firmware::link::RecordingArm> arms;
  std::vector<std::string> models;  // of the arms
  std::vector<std::pair<std::uint16_t, std::uint32_t>> params;
  std::span<const std::byte> image;
  std::uint8_t trial = 0;  // the parameter of that name as the recording began
};

class Replay {
 public:
  struct Tick {
    std::span<const std::uint16_t> counts;  // kClassicCounts an arm
    firmware::link::Levels levels;
    firmware::link::RecordedCommand command = firmware::link::RecordedCommand::kNone;
    std::optional<std::uint16_t> trial{};  // that was written, and taken by this tick
  };

  explicit Replay(const RecordedRun& run);
  ~Replay();
  Replay(const Replay&) = delete;
  Replay& operator=(const Replay&) = delete;

  void tick(const Tick& tick);
  // What the device would have sent for the tick before: its CRC, its mode, the low bits of its number.
  [[nodiscard]] const firmware::link::RecordingCheck& check() const noexcept { return check_; }
  [[nodiscard]] std::uint8_t fault() const noexcept;
  // A row as in the log of a simulation, but that the tip is where the encoders say. Time counts from the recording's start.
  [[nodiscard]] LogRow row(std::size_t arm) const noexcept;

 private:
  class Board;
  std::unique_ptr<Board> board_;
  firmware::link::RecordingCheck check_;
};

}  // namespace thimble::board
