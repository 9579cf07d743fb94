// meant_frames COUNT: prints COUNT of each real-time frame of node 1, encoded by the firmware's encoder, with
// values over their whole range, as JSON lines: {"id": ..., "data": "hex", "message": "Pose", "meant": [...]}. Each
// entry of "meant" is a signal: {"signal": its name in the DBC, "value", "step", "json": its place in the line of
// `thimble decode --json`, "shown": what stands there}. For dbc_test.py.
#include <array>
#include <bit>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <random>
#include <span>
#include <string>
#include <utility>

#include "firmware/link/messages.h"

namespace thimble {
namespace {

namespace link = firmware::link;

std::string signal_name(const link::Place& place, const char* name) {
  std::string signal = place.part == nullptr ? name : std::string(place.part) + "_" + name;
  return place.index < 0 ? signal : signal + "_" + std::to_string(place.index);
}

nlohmann::json path_of(const link::Place& place, const char* name) {
  nlohmann::json path = nlohmann::json::array();
  if (place.part != nullptr) path.push_back(place.part);
  path.push_back(name);
  if (place.index >= 0) path.push_back(place.index);
  return path;
}

// No template, unlike its callers: JSON takes long to compile.
void means(nlohmann::json& meant, const std::string& signal, double number, double step, nlohmann::json path,
           nlohmann::json shown) {
  meant.push_back({{"signal", signal},
                   {"value", number},
                   {"step", step},
                   {"json", std::move(path)},
                   {"shown", std::move(shown)}});
}

// Sets some of the flags that have a place in the bits, each of which is a signal; the last one says where in the line of `decode` they are.
unsigned means_flags(nlohmann::json& meant, const std::string& signal, std::span<const link::EnumRow> flags,
                     unsigned bits, nlohmann::json path, std::mt19937& random) {
  unsigned value = 0;
  nlohmann::json names = nlohmann::json::array();
  for (const link::EnumRow& flag : flags) {
    if (flag.number >> bits != 0) continue;
    const bool set = random() % 2 == 0;
    if (set) value |= flag.number;
    if (set) names.push_back(flag.name);
    meant.push_back({{"signal", signal + "_" + flag.name}, {"value", set ? 1 : 0}, {"step", 0}});
  }
  meant.back()["json"] = std::move(path);
  meant.back()["shown"] = std::move(names);
  return value;
}

void print_frame(const link::CanFrame& frame, const char* message, const nlohmann::json& meant) {
  std::string hex;
  for (const std::uint8_t byte : frame.bytes()) {
    std::array<char, 3> digits{};
    std::snprintf(digits.data(), digits.size(), "%02X", byte);
    hex += digits.data();
  }
  const nlohmann::json line{
      {"id", frame.id}, {"fd", frame.fd}, {"data", hex}, {"message", message}, {"meant", meant}};
  std::puts(line.dump().c_str());
}

template <class Message>
std::string kind_prefix() {
  if constexpr (requires { Message::kKind; }) return std::string(link::name(Message::kKind)) + "_";
  return "";
}

template <class Message>
void print_random(std::mt19937& random) {
  Message message;
  nlohmann::json meant = nlohmann::json::array();
  link::visit_numbers(message, [&](auto row, auto& value, const link::Place& place) {
    using Row = decltype(row);
    using Value = std::remove_reference_t<decltype(value)>;
    if (Row::kIsKind) return;  // to_frame() needs it as it is
    const std::string signal = kind_prefix<Message>() + signal_name(place, row.name);
    const nlohmann::json path = path_of(place, row.name);
    std::uniform_real_distribution<double> any(-1.0, 1.0);
    if constexpr (!std::is_void_v<typename Row::Flags>) {
      value = static_cast<Value>(
          means_flags(meant, signal, link::EnumTable<typename Row::Flags>::kRows, Row::kBits, path, random));
    } else if constexpr (link::TableEnum<Value>) {
      const auto& rows = link::EnumTable<Value>::kRows;
      const link::EnumRow& one = rows[random() % std::size(rows)];
      value = static_cast<Value>(one.number);
      means(meant, signal, one.number, 0, path, one.name);
    } else if constexpr (std::is_same_v<typename Row::Wire, float>) {
      value = static_cast<float>(1.0e3 * any(random));
      means(meant, signal, static_cast<double>(value), 0, path, value);
    } else if constexpr (std::is_floating_point_v<Value>) {
      constexpr bool kSigned = std::is_signed_v<typename Row::Wire>;
      const double high =
          (std::exp2(kSigned ? Row::kBits - 1 : Row::kBits) - 1) * static_cast<double>(row.scale);
      value = static_cast<Value>(kSigned ? high * any(random) : high * 0.5 * (1.0 + any(random)));
      means(meant, signal, static_cast<double>(value), static_cast<double>(row.scale), path, value);
    } else {
      value = static_cast<Value>(random() & link::wire::kMask<Row::kBits>);
      means(meant, signal, static_cast<double>(value), 0, path, value);
    }
  });
  print_frame(link::to_frame(message, 1), Message::kName, meant);
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
