// meant_frames COUNT: prints COUNT of each real-time frame of node 1, encoded by the firmware's encoder, with
// values over their whole range, as JSON lines: {"id": ..., "data": "hex", "message": "Pose", "meant":
// {"x_m": [value, step] ...}}. For dbc_test.py.
#include <array>
#include <cstdio>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>
#include <string>

#include "firmware/link/messages.h"

namespace thimble {
namespace {

namespace link = firmware::link;

template <class Message>
void print_random(std::mt19937& random) {
  Message message;
  nlohmann::json meant;
  link::visit_fields(message, [&]<class Wire>(Wire, const char* name, auto& value, float scale, auto&&...) {
    using Value = std::remove_reference_t<decltype(value)>;
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    if constexpr (std::is_same_v<Wire, float>) {
      value = static_cast<float>(1.0e3 * any(random));
      meant[name] = {static_cast<double>(value), 0.0};
    } else {
      const double high = static_cast<double>(std::numeric_limits<Wire>::max()) * static_cast<double>(scale);
      const double low = std::is_signed_v<Wire> ? -high : 0.0;
      value = static_cast<Value>(low + (high - low) * 0.5 * (1.0 + any(random)));
      meant[name] = {static_cast<double>(value),
                     std::is_same_v<Wire, Value> ? 0.0 : static_cast<double>(scale)};
    }
  });
  const link::CanFrame frame = link::to_frame(message, 1);
  std::string hex;
  for (const std::uint8_t byte : frame.bytes()) {
    std::array<char, 3> digits{};
    std::snprintf(digits.data(), digits.size(), "%02X", byte);
    hex += digits.data();
  }
  std::puts(nlohmann::json{{"id", frame.id}, {"data", hex}, {"message", Message::kName}, {"meant", meant}}
                .dump()
                .c_str());
}

void print_all(int count) {
  std::mt19937 random(1);
  for (int i = 0; i < count; ++i) {
    link::visit_messages([&](auto message) {
      if constexpr (decltype(message)::kIsFrame) print_random<decltype(message)>(random);
    });
  }
}

}  // namespace
}  // namespace thimble

int main(int argc, char** argv) {
  if (argc != 2) return 2;
  thimble::print_all(std::stoi(argv[1]));
}
