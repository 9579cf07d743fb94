#include "board/sim/live_board.h"

#include <algorithm>
#include <chrono>
#include <iterator>
#include <stdexcept>

#include "board/posix/can_port.h"
#include "board/posix/link_ports.h"
#include "board/posix/pair_port.h"
#include "board/posix/pty_port.h"
#include "board/posix/tcp_port.h"
#include "board/posix/tty_port.h"
#include "board/sim/announcement.h"
#include "board/sim/file_storage.h"
#include "board/sim/hand_path_file.h"
#include "board/sim/injection_file.h"
#include "board/sim/specimen_file.h"

namespace thimble::board {
namespace {

constexpr std::uint64_t kWait_us = 500;

}  // namespace

// The ports, for the loop.
class LiveBoard::Ports final : public LiveLoop::Carrier, public LinkPorts {
 public:
  void send(const firmware::link::CanFrame& frame) override { LinkPorts::send(frame); }
  [[nodiscard]] std::optional<firmware::link::CanFrame> receive() override { return LinkPorts::receive(); }
  [[nodiscard]] std::uint64_t dropped() const override { return LinkPorts::dropped(); }
};

LiveBoard::LiveBoard(const LiveOptions& options) : options_(options), ports_(std::make_unique<Ports>()) {
  if (options.host_socket >= 0) ports_->add(std::make_unique<PairPort>(Descriptor(options.host_socket)));
  // The preferred one first: TCP has more capacity than a pty, whose buffer is 4 kB.
  if (options.tcp_port)
    ports_->add(std::make_unique<TcpPort>(
        *options.tcp_port, options.open ? TcpPort::Hosts::kEveryone : TcpPort::Hosts::kOwnUser));
  if (options.pty) ports_->add(std::make_unique<PtyPort>(options.link));
  if (!options.can.empty()) ports_->add(std::make_unique<CanPort>(options.can, firmware::Config{}.node_id));
  if (!options.tty.empty()) ports_->add(std::make_unique<TtyPort>(options.tty));
  if (ports_->empty())
    throw std::runtime_error("the device has no connection: use the pty, --tcp, --can or --tty");

  constexpr std::size_t kSlotBytes = control::kMaxImageBytes + firmware::SceneStore::kHeaderBytes;
  if (options.store.empty()) {
    memory_ = std::make_unique<MemoryStorage>(kSlotBytes);
  } else {
    file_ = std::make_unique<FileStorage>(options.store, kSlotBytes);
  }
  loop_ =
      std::make_unique<LiveLoop>(*ports_, [this](const char* reset_reason) { return start(reset_reason); });
  announced_ = std::make_unique<Announced>(Announcement{options.name, options.arm, ports_->uris()});
}

LiveBoard::~LiveBoard() = default;

std::vector<std::string> LiveBoard::uris() const { return ports_->uris(); }

std::uint64_t LiveBoard::dropped() const { return ports_->dropped(); }

std::unique_ptr<SimBoard> LiveBoard::start(const char* reset_reason) {
  SimBoardOptions board_options;
  board_options.arm = options_.arm_data;
  if (!board_options.arm) board_options.variant = options_.arm;
  board_options.rate_Hz = options_.rate_Hz;
  board_options.seed = options_.seed;
  board_options.storage = file_ ? static_cast<firmware::Storage*>(file_.get()) : memory_.get();
  board_options.reset_reason = reset_reason;
  board_options.utc_s =
      static_cast<std::uint32_t>(std::chrono::system_clock::to_time_t(std::chrono::system_clock::now()));
  board_options.bus_bits_per_s = ports_->classic_bits_per_s();
  board_options.time_ticks = true;
  board_options.sensors = options_.sensors;
  if (!options_.specimen.empty()) {
    board_options.specimen = std::make_shared<const Specimen>(read_specimen(options_.specimen));
    board_options.hand = kNoHand;  // no hand holds an arm that scans
  }
  std::vector<PathPoint> points;
  if (!options_.hand.empty()) points = read_hand_path(options_.hand);
  const bool two = std::ranges::any_of(points, [](const PathPoint& point) { return point.arm == 1; });
  board_options.arm_count = two ? std::uint8_t{2} : options_.arm_count;
  auto board = std::make_unique<SimBoard>(board_options);
  for (int arm = 0; arm < board_options.arm_count; ++arm) {
    std::vector<PathPoint> own;
    std::ranges::copy_if(points, std::back_inserter(own), [arm](const PathPoint& p) { return p.arm == arm; });
    if (!own.empty()) board->follow(static_cast<std::size_t>(arm), HandPath(std::move(own)), options_.loop);
  }
  if (!options_.inject.empty())
    for (const PlannedFault& fault : read_injections(options_.inject, board->arm(0).axes()))
      board->inject(fault);
  // Run two ticks first, so an early request does not get the state from before the first encoder sample.
  board->step(2 / options_.rate_Hz);
  return board;
}

void LiveBoard::run(const std::function<bool()>& stopping,
                    const std::function<void(const LiveLoop::Round&)>& each,
                    const std::function<void(const std::string&)>& news) {
  while (!stopping()) {
    loop_->round(each);
    ports_->flush();
    if (const std::optional<std::string> trouble = ports_->news(); trouble && news) news(*trouble);
    ports_->wait(kWait_us);
  }
}

}  // namespace thimble::board
