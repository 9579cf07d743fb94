#include "board/sim/scene_cost.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "board/walk/scene_walk.h"

namespace thimble::board {
namespace {

using control::kMaxObjects;

constexpr std::uint64_t kLeastBusy = 100;  // ticks of a walk that say something

class Account {
 public:
  Account(const control::SceneView& scene, const BoardCost& board, double rate_Hz, std::uint32_t work_units,
          std::size_t arms)
      : board_(board),
        period_s_(static_cast<float>(1.0 / rate_Hz)),
        walk_(scene, period_s_, work_units, arms) {
    cost_.work_units = work_units;
    cost_.period = board.clock_Hz / rate_Hz;
  }

  SceneCost cost() {
    walk_.go({.tick = [this](auto tips, auto touches) { tick(tips, touches); },
              .end_of_walk = [this](bool dart) { end_of_walk(dart); }});
    const Sum& typical = touching_.ticks != 0 ? touching_ : all_;
    const auto ticks = static_cast<double>(std::max<std::uint64_t>(typical.ticks, 1));
    cost_.typical = {static_cast<std::uint32_t>(std::lround(static_cast<double>(typical.units) / ticks)),
                     typical.instructions / ticks};
    cost_.worst.instructions = board_.core.empty() ? 0.0 : BoardCost::worst(most_instructions_);
    cost_.put_off =
        static_cast<double>(put_off_) / static_cast<double>(std::max<std::uint64_t>(all_.ticks, 1));
    return cost_;
  }

 private:
  struct Sum {
    std::uint64_t ticks = 0;
    std::uint64_t units = 0;
    double instructions = 0;
  };
  struct OneWalk {
    std::array<std::uint32_t, kMaxObjects> put_off_at{};
    std::uint64_t busy = 0, put_off = 0;
  };

  void tick(std::span<const control::Tip> tips, std::span<control::Touch> touches) {
    walk_.renderer().tick(tips, period_s_, touches);
    const bool touched = count(touches);
    const bool is_put_off = walk_.renderer().is_put_off();
    if (touched || is_put_off) ++now_.busy;
    if (!is_put_off) return;
    ++now_.put_off;
    ++put_off_;
    if (const std::uint8_t object = walk_.renderer().counters().put_off_object; object < kMaxObjects)
      ++now_.put_off_at[object];
  }

  void end_of_walk(bool dart) {
    const OneWalk walk = std::exchange(now_, {});
    if (dart || walk.busy < kLeastBusy || 2 * walk.put_off <= walk.busy || cost_.slow_object) return;
    cost_.slow_object =
        static_cast<std::size_t>(std::ranges::max_element(walk.put_off_at) - walk.put_off_at.begin());
  }

  // Of the last tick. Whether something was touched in it.
  bool count(std::span<const control::Touch> touches) {
    std::size_t touching = 0, contacts = 0;
    for (const control::Touch& touch : touches) {
      touching += touch.contacts != 0 ? 1U : 0U;
      contacts += touch.contacts;
    }
    const std::uint32_t units = walk_.renderer().tick_work();
    const double instructions =
        board_.core.empty()
            ? 0.0
            : board_.of(terms_of(walk_.renderer().load(), period_s_, touches.size(), touching, contacts));
    for (Sum* sum : {&all_, touching != 0 ? &touching_ : nullptr}) {
      if (sum == nullptr) continue;
      ++sum->ticks;
      sum->units += units;
      sum->instructions += instructions;
    }
    cost_.worst.units = std::max(cost_.worst.units, units);
    most_instructions_ = std::max(most_instructions_, instructions);
    return touching != 0;
  }

  const BoardCost& board_;
  float period_s_;
  SceneWalk walk_;
  SceneCost cost_;
  Sum all_, touching_;
  OneWalk now_;
  double most_instructions_ = 0;
  std::uint64_t put_off_ = 0;
};

}  // namespace

std::optional<SceneCost> scene_cost(std::span<const std::byte> image, const BoardCost& board, double rate_Hz,
                                    std::uint32_t work_units, std::size_t arms) {
  const CheckedScene scene(image);
  if (scene.view() == nullptr) return std::nullopt;
  return Account(*scene.view(), board, rate_Hz, work_units, arms).cost();
}

std::optional<double> highest_fitting_rate_Hz(std::span<const std::byte> image, const BoardCost& board,
                                              double below_Hz, std::size_t arms) {
  const CheckedScene scene(image);
  if (scene.view() == nullptr) return std::nullopt;
  const auto fits_at = [&](double rate_Hz) {
    return Account(*scene.view(), board, rate_Hz, board.work_units(rate_Hz, arms), arms).cost().fits();
  };
  // Bisection: what fits at a rate fits at lower ones.
  int fits = 0;
  for (int not_fits = static_cast<int>(std::ceil(below_Hz / kRateStep_Hz)); not_fits - fits > 1;) {
    const int middle = fits + (not_fits - fits) / 2;
    (fits_at(kRateStep_Hz * middle) ? fits : not_fits) = middle;
  }
  return fits == 0 ? std::nullopt : std::optional(kRateStep_Hz * fits);
}

}  // namespace thimble::board
