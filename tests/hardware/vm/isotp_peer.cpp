// ISO-TP of ours against the kernel's can-isotp, both ways, on one CAN interface. Runs in the virtual machine.
//
//   isotp_peer INTERFACE sweep classic|fd ours|kernel FROM TO STEP    every so many sizes, sent by us or by the kernel
//   isotp_peer INTERFACE variants                                     block sizes, gaps and padding, with a sample of sizes
//
// In one process: an IsoTpChannel on a raw socket, and a CAN_ISOTP socket. A PDU must arrive as it was, within a deadline; the kernel
// checks our padding; and in the variants a second raw socket watches that each end keeps the block size and the gap that the other
// asked for. Prints counts, and each failure; ends with 0 only if all was right.
#include <linux/can.h>
#include <linux/can/isotp.h>
#include <linux/can/raw.h>
#include <net/if.h>
#include <poll.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <optional>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

#include "firmware/link/iso_tp.h"
#include "firmware/link/socketcan.h"

namespace thimble::test {
namespace {

using firmware::link::CanFrame;
using firmware::link::IsoTpChannel;
using firmware::link::IsoTpConfig;
using firmware::link::IsoTpError;
using firmware::link::Micros;
using Bytes = std::vector<std::uint8_t>;

constexpr std::uint32_t kOurId = firmware::link::request_id(1);
constexpr std::uint32_t kKernelId = firmware::link::response_id(1);
constexpr std::uint8_t kPadding = 0xCC;
constexpr Micros kDeadline_us = 10'000'000;  // the longest gap of the variants takes 0.6 s a PDU
constexpr unsigned kNap_us = 500;
constexpr unsigned kMostFailures = 10;  // then the rest would only repeat them

Micros now_us() {
  return static_cast<Micros>(std::chrono::duration_cast<std::chrono::microseconds>(
                                 std::chrono::steady_clock::now().time_since_epoch())
                                 .count());
}

[[noreturn]] void fail(const std::string& what) {
  throw std::runtime_error(what + ": " + std::strerror(errno));
}

class Socket {
 public:
  Socket(int type, int protocol) : fd_(socket(PF_CAN, type | SOCK_NONBLOCK, protocol)) {
    if (fd_ < 0) fail("cannot open a CAN socket");
  }
  Socket(const Socket&) = delete;
  Socket& operator=(const Socket&) = delete;
  ~Socket() { close(fd_); }

  template <class Value>
  void set(int level, int option, const Value& value) {
    if (setsockopt(fd_, level, option, &value, sizeof(value)) != 0)
      fail("cannot set option " + std::to_string(option));
  }
  void bind_to(const std::string& interface, std::uint32_t receive_id, std::uint32_t transmit_id) {
    sockaddr_can address{};
    address.can_family = AF_CAN;
    address.can_ifindex = static_cast<int>(if_nametoindex(interface.c_str()));
    address.can_addr.tp.rx_id = receive_id;
    address.can_addr.tp.tx_id = transmit_id;
    if (bind(fd_, reinterpret_cast<const sockaddr*>(&address), sizeof(address)) != 0)
      fail("cannot bind to " + interface);
  }
  [[nodiscard]] int get() const { return fd_; }

  void send(const CanFrame& frame) {
    canfd_frame raw;
    const std::size_t bytes = firmware::link::to_socketcan(frame, raw);
    if (write(fd_, &raw, bytes) != static_cast<ssize_t>(bytes)) fail("cannot send a frame");
  }
  std::optional<CanFrame> receive() {
    canfd_frame raw{};
    CanFrame frame;
    const ssize_t got = read(fd_, &raw, sizeof(raw));
    if (got <= 0 || !firmware::link::from_socketcan(raw, static_cast<std::size_t>(got), frame))
      return std::nullopt;
    return frame;
  }

 private:
  int fd_;
};

struct Variant {
  bool fd = false;
  bool kernel_pads = true;
  std::uint8_t our_block = 0, our_gap = 0;        // what we ask of the kernel
  std::uint8_t kernel_block = 0, kernel_gap = 0;  // what it asks of us
};

Micros gap_of(std::uint8_t st_min) {
  return st_min >= 0xF1 ? Micros{100} * (st_min - 0xF0U) : Micros{1000} * st_min;
}

// What went by during one transfer.
struct Seen {
  unsigned consecutive = 0, flow_controls = 0, in_block = 0, longest_block = 0;
};

class Pair {
 public:
  Pair(const std::string& interface, const Variant& variant, bool watched)
      : variant_(variant),
        watched_(watched),
        channel_(kOurId, kKernelId,
                 IsoTpConfig{.fd = variant.fd, .block_size = variant.our_block, .st_min = variant.our_gap}),
        ours_(SOCK_RAW, CAN_RAW),
        watch_(SOCK_RAW, CAN_RAW),
        kernel_(SOCK_DGRAM, CAN_ISOTP) {
    const can_filter from_kernel = {kKernelId | CAN_EFF_FLAG, CAN_EFF_MASK | CAN_EFF_FLAG};
    ours_.set(SOL_CAN_RAW, CAN_RAW_FILTER, from_kernel);
    if (!watched) watch_.set(SOL_CAN_RAW, CAN_RAW_FILTER, can_filter{CAN_INV_FILTER, 0});  // nothing
    for (Socket* raw : {&ours_, &watch_}) {
      raw->set(SOL_CAN_RAW, CAN_RAW_FD_FRAMES, int{1});
      raw->set(SOL_SOCKET, SO_RCVBUFFORCE, int{4} << 20);
      raw->bind_to(interface, 0, 0);
    }
    can_isotp_options options{};
    options.flags = CAN_ISOTP_RX_PADDING | CAN_ISOTP_CHK_PAD_LEN | CAN_ISOTP_CHK_PAD_DATA;
    if (variant.kernel_pads) options.flags |= CAN_ISOTP_TX_PADDING;
    options.txpad_content = options.rxpad_content = kPadding;
    options.frame_txtime =
        CAN_ISOTP_FRAME_TXTIME_ZERO;  // or it waits 50 us between two frames, whatever we ask for
    kernel_.set(SOL_CAN_ISOTP, CAN_ISOTP_OPTS, options);
    kernel_.set(SOL_CAN_ISOTP, CAN_ISOTP_RECV_FC,
                can_isotp_fc_options{variant.kernel_block, variant.kernel_gap, 0});
    if (variant.fd) {
      kernel_.set(SOL_CAN_ISOTP, CAN_ISOTP_LL_OPTS,
                  can_isotp_ll_options{CANFD_MTU, CANFD_MAX_DLEN, CANFD_BRS});
    }
    kernel_.bind_to(interface, kOurId | CAN_EFF_FLAG, kKernelId | CAN_EFF_FLAG);
  }

  // Each returns what was wrong, or nothing.
  std::string ours_to_kernel(const Bytes& pdu) {
    begin(kOurId);
    if (!channel_.send(pdu, now_us())) return "our channel is busy";
    Bytes got(8192);
    ssize_t size = -1;
    while (size < 0 && under_way()) {
      turn();
      size = read(kernel_.get(), got.data(), got.size());
    }
    if (size < 0) return why();
    got.resize(static_cast<std::size_t>(size));
    return got != pdu ? "the kernel received something else"
                      : judge(variant_.kernel_block, variant_.kernel_gap);
  }

  std::string kernel_to_ours(const Bytes& pdu) {
    begin(kKernelId);
    while (write(kernel_.get(), pdu.data(), pdu.size()) < 0) {  // busy with the end of the one before
      if (errno != EAGAIN || !under_way())
        return std::string("the kernel takes no PDU: ") + std::strerror(errno);
      turn();
    }
    while (channel_.received().empty() && under_way()) turn();
    if (channel_.received().empty()) return why();
    const bool same = std::ranges::equal(channel_.received(), pdu);
    const bool right_frames = channel_.received_fd() == variant_.fd;
    channel_.release();
    if (!same) return "we received something else";
    if (!right_frames) return "the kernel sent frames of the other format";
    return judge(variant_.our_block, variant_.our_gap);
  }

  [[nodiscard]] unsigned long frames() const { return frames_; }

 private:
  void begin(std::uint32_t data_id) {
    data_id_ = data_id;
    deadline_us_ = now_us() + kDeadline_us;
    first_us_ = last_us_ = 0;
    seen_ = {};
  }

  bool under_way() {
    if (error_ == IsoTpError::kNone) error_ = channel_.take_error();
    return error_ == IsoTpError::kNone && now_us() < deadline_us_;
  }

  std::string why() {
    const IsoTpError error = std::exchange(error_, IsoTpError::kNone);
    channel_.abort();
    return error == IsoTpError::kNone ? "nothing came in time"
                                      : std::string("our channel gave up: ") + name(error);
  }

  // Sends what is due, takes in what has come, and waits where there was neither.
  void turn() {
    bool idle = true;
    for (CanFrame frame; channel_.next_frame(frame, now_us()); idle = false) {
      ours_.send(frame);
      ++frames_;
    }
    for (; const std::optional<CanFrame> frame = ours_.receive(); idle = false) {
      static_cast<void>(channel_.on_frame(*frame, now_us()));
      ++frames_;
    }
    while (const std::optional<CanFrame> frame = watch_.receive()) see(*frame);
    channel_.poll(now_us());
    if (!idle) return;
    if (channel_
            .receiving()) {  // not woken by each frame of many: under emulation a change of context costs more than ten frames
      usleep(kNap_us);
      return;
    }
    std::array<pollfd, 2> polled = {{{ours_.get(), POLLIN, 0}, {kernel_.get(), POLLIN, 0}}};
    const Micros gap = channel_.gap(now_us());
    const timespec timeout{0, static_cast<long>((gap == 0 ? Micros{1000} : gap) * 1000)};
    static_cast<void>(ppoll(polled.data(), polled.size(), &timeout, nullptr));
  }

  void see(const CanFrame& frame) {
    const unsigned kind = frame.data[0] >> 4U;
    if (frame.id != data_id_) {
      if (kind == 3) ++seen_.flow_controls;
      if (kind == 3) seen_.in_block = 0;
    } else if (kind == 2) {
      if (seen_.consecutive++ == 0) first_us_ = now_us();
      last_us_ = now_us();
      seen_.longest_block = std::max(seen_.longest_block, ++seen_.in_block);
    }
  }

  // Were the block size and the gap kept that the receiver asked for?
  std::string judge(std::uint8_t block, std::uint8_t st_min) {
    while (const std::optional<CanFrame> frame = watch_.receive()) see(*frame);
    if (!watched_ || seen_.consecutive == 0) return {};
    const unsigned blocks = block == 0 ? 1 : (seen_.consecutive + block - 1) / block;
    if (seen_.flow_controls != blocks)
      return "there were " + std::to_string(seen_.flow_controls) + " flow controls, not " +
             std::to_string(blocks);
    if (block != 0 && seen_.longest_block > block) return "a block was longer than asked for";
    // There is a gap between the frames of a block. As a whole: one looks shorter when the frame before it was noticed late, the very
    // first one included.
    const unsigned gaps = seen_.consecutive - blocks;
    const Micros least_us = gap_of(st_min) * (gaps > 1 ? gaps - 1 : 0);
    if (last_us_ - first_us_ < least_us) {
      return std::to_string(seen_.consecutive) + " frames came in " + std::to_string(last_us_ - first_us_) +
             " us, not in " + std::to_string(least_us);
    }
    return {};
  }

  Variant variant_;
  bool watched_;
  IsoTpChannel channel_;
  Socket ours_, watch_, kernel_;
  IsoTpError error_ = IsoTpError::kNone;
  unsigned long frames_ = 0;
  std::uint32_t data_id_ = 0;
  Micros deadline_us_ = 0, first_us_ = 0, last_us_ = 0;
  Seen seen_;
};

Bytes pdu_of(std::size_t size) {
  Bytes pdu(size);
  std::uint32_t state = static_cast<std::uint32_t>(size) * 2654435761U + 1U;
  for (std::uint8_t& byte : pdu)
    byte = static_cast<std::uint8_t>((state = state * 1664525U + 1013904223U) >> 24U);
  return pdu;
}

class Tally {
 public:
  void note(const std::string& what, std::size_t size, const std::string& wrong) {
    ++pdus_;
    if (wrong.empty()) return;
    std::printf("%s, %zu bytes: %s\n", what.c_str(), size, wrong.c_str());
    if (++wrong_ == kMostFailures) throw std::runtime_error("too many failures");
  }
  int end(const char* what, unsigned long frames) const {
    std::printf("figure: %s: %lu PDUs in %lu frames, %u wrong\n", what, pdus_, frames, wrong_);
    return wrong_ == 0 && pdus_ != 0 ? 0 : 1;
  }

 private:
  unsigned long pdus_ = 0;
  unsigned wrong_ = 0;
};

int sweep(const std::string& interface, const std::string& format, const std::string& sender,
          std::size_t from, std::size_t to, std::size_t step) {
  Pair pair(interface, {.fd = format == "fd"}, false);
  Tally tally;
  const std::string what = format + " from " + sender;
  for (std::size_t size = from; size <= to; size += step) {
    const Bytes pdu = pdu_of(size);
    tally.note(what, size, sender == "ours" ? pair.ours_to_kernel(pdu) : pair.kernel_to_ours(pdu));
  }
  return tally.end(
      (what + ", sizes " + std::to_string(from) + " to " + std::to_string(to) + " by " + std::to_string(step))
          .c_str(),
      pair.frames());
}

int variants(const std::string& interface) {
  constexpr std::array<std::size_t, 14> kSizes = {1, 6, 7, 8, 10, 13, 14, 61, 62, 63, 64, 130, 500, 1001};
  constexpr std::array<std::uint8_t, 4> kBlocks = {0, 1, 5, 15};
  constexpr std::array<std::uint8_t, 4> kGaps = {0, 0xF3, 1, 4};
  Tally tally;
  unsigned long frames = 0;
  for (const bool fd : {false, true}) {
    for (const bool pads : {true, false}) {
      for (const std::uint8_t block : kBlocks) {
        for (const std::uint8_t gap : kGaps) {
          Pair pair(interface, {fd, pads, block, gap, block, gap}, true);
          const std::string what = std::string(fd ? "fd" : "classic") + (pads ? ", padded" : "") +
                                   ", block size " + std::to_string(block) + ", STmin " + std::to_string(gap);
          for (const std::size_t size : kSizes) {
            const Bytes pdu = pdu_of(size);
            tally.note(what + ", ours", size, pair.ours_to_kernel(pdu));
            tally.note(what + ", kernel's", size, pair.kernel_to_ours(pdu));
          }
          frames += pair.frames();
        }
      }
    }
  }
  return tally.end("variants", frames);
}

int run(const std::vector<std::string>& words) {
  if (words.size() == 2 && words[1] == "variants") return variants(words[0]);
  if (words.size() == 7 && words[1] == "sweep")
    return sweep(words[0], words[2], words[3], std::stoul(words[4]), std::stoul(words[5]),
                 std::stoul(words[6]));
  std::fprintf(stderr, "isotp_peer INTERFACE variants | sweep classic|fd ours|kernel FROM TO STEP\n");
  return 2;
}

}  // namespace
}  // namespace thimble::test

int main(int argc, char** argv) {
  try {
    return thimble::test::run({argv + 1, argv + argc});
  } catch (const std::exception& error) {
    std::fprintf(stderr, "isotp_peer: %s\n", error.what());
    return 1;
  }
}
