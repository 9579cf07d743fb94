#include "host-tools/lab/device_log.h"

#include <algorithm>
#include <array>
#include <bit>
#include <charconv>
#include <cmath>
#include <cstdint>
#include <optional>
#include <string_view>

#include "host-tools/error.h"
#include "host-tools/files/input_file.h"

namespace thimble::host {
namespace {

enum class LoggedQuantity : std::uint8_t {
  kTime,
  kTimestamp,
  kPosition,
  kRawPosition,
  kForce,
  kButtons,
  kOther
};
struct LoggedColumn {
  std::string_view name;
  LoggedQuantity quantity;
  std::size_t numbers;
};
constexpr std::array<LoggedColumn, 13> kLoggedColumns = {{{"TIME", LoggedQuantity::kTime, 1},
                                                          {"POSITION", LoggedQuantity::kPosition, 3},
                                                          {"ORIENTATION", LoggedQuantity::kOther, 4},
                                                          {"VELOCITY", LoggedQuantity::kOther, 3},
                                                          {"FORCE", LoggedQuantity::kForce, 3},
                                                          {"TORQUE", LoggedQuantity::kOther, 3},
                                                          {"BUTTONS", LoggedQuantity::kButtons, 1},
                                                          {"RAW_POSITION", LoggedQuantity::kRawPosition, 3},
                                                          {"RAW_ORIENTATION", LoggedQuantity::kOther, 4},
                                                          {"RAW_VELOCITY", LoggedQuantity::kOther, 3},
                                                          {"RAW_FORCE", LoggedQuantity::kOther, 3},
                                                          {"RAW_TORQUE", LoggedQuantity::kOther, 3},
                                                          {"TIMESTAMP", LoggedQuantity::kTimestamp, 1}}};
constexpr std::size_t kLongestName = 64;

class DeviceLogReader {
 public:
  DeviceLogReader(std::span<const char> bytes, std::string name, bool thimble_frame)
      : bytes_(bytes.data(), bytes.size()), name_(std::move(name)), thimble_frame_(thimble_frame) {}

  DeviceLog read() {
    const std::size_t line_end = bytes_.find('\n');
    log_.binary = bytes_.find('\0') < std::min(line_end, bytes_.size());
    if (log_.binary) {
      read_binary();
    } else {
      read_text();
    }
    if (log_.samples.empty()) fail("no row of values");
    return std::move(log_);
  }

 private:
  [[noreturn]] void fail(const std::string& what) const {
    const std::string place = log_.binary ? ", byte " + std::to_string(at_) : ":" + std::to_string(line_);
    throw Error(ExitCode::kBadInput, "bad-device-log", name_ + place + ": " + what,
                "give the log of a HAPI DeviceLog with TIME and POSITION in it");
  }

  void add_column(std::string_view name) {
    const auto* known = std::ranges::find(kLoggedColumns, name, &LoggedColumn::name);
    if (known == kLoggedColumns.end())
      fail("'" + std::string(name.substr(0, kLongestName)) + "' is nothing that a DeviceLog has");
    if (std::ranges::find(log_.columns, name) != log_.columns.end())
      fail(std::string(name) + " stands there twice");
    log_.columns.emplace_back(name);
    columns_.push_back(*known);
  }

  // After all columns.
  void check_columns() {
    const auto has = [&](LoggedQuantity quantity) {
      return std::ranges::any_of(
          columns_, [quantity](const LoggedColumn& column) { return column.quantity == quantity; });
    };
    if (!has(LoggedQuantity::kTime) && !has(LoggedQuantity::kTimestamp)) fail("there is no TIME in it");
    if (!has(LoggedQuantity::kPosition) && !has(LoggedQuantity::kRawPosition))
      fail("there is no POSITION in it");
    time_ = has(LoggedQuantity::kTime) ? LoggedQuantity::kTime : LoggedQuantity::kTimestamp;
    log_.raw = !has(LoggedQuantity::kPosition);
    log_.has_force = has(LoggedQuantity::kForce);
  }

  [[nodiscard]] Eigen::Vector3d turned(const std::array<double, 4>& v) const {
    return thimble_frame_ ? Eigen::Vector3d(v[0], v[1], v[2]) : Eigen::Vector3d(v[0], -v[2], v[1]);
  }

  void put(DeviceLogSample& sample, const LoggedColumn& column, const std::array<double, 4>& value) const {
    if (column.quantity == time_) sample.time_s = value[0];
    if (column.quantity == (log_.raw ? LoggedQuantity::kRawPosition : LoggedQuantity::kPosition))
      sample.position_m = turned(value);
    if (column.quantity == LoggedQuantity::kForce) sample.force_N = turned(value);
  }

  void add(DeviceLogSample sample) {
    if (!std::isfinite(sample.time_s) || !sample.position_m.allFinite() || !sample.force_N.allFinite())
      fail("a number that is not finite");
    if (!start_s_) start_s_ = time_ == LoggedQuantity::kTimestamp ? sample.time_s : 0.0;
    sample.time_s -= *start_s_;
    if (!log_.samples.empty() && !(sample.time_s > log_.samples.back().time_s)) {
      ++log_.repeated;
      return;
    }
    log_.samples.push_back(sample);
  }

  void read_text() {
    std::string_view rest = bytes_;
    while (!rest.empty()) {
      ++line_;
      const std::size_t end = rest.find('\n');
      std::string_view line = rest.substr(0, end);
      rest = end == std::string_view::npos ? std::string_view{} : rest.substr(end + 1);
      const auto next = [&line]() {
        const std::size_t from = std::min(line.find_first_not_of(" \t\r"), line.size());
        line.remove_prefix(from);
        const std::string_view word = line.substr(0, line.find_first_of(" \t\r"));
        line.remove_prefix(word.size());
        return word;
      };
      if (line_ == 1) {
        for (std::string_view word = next(); !word.empty(); word = next()) add_column(word);
        check_columns();
        continue;
      }
      std::string_view word = next();
      if (word.empty()) continue;
      DeviceLogSample sample;
      for (const LoggedColumn& column : columns_) {
        std::array<double, 4> value{};
        for (std::size_t i = 0; i < column.numbers; ++i, word = next()) {
          const auto [stop, error] = std::from_chars(word.data(), word.data() + word.size(), value[i]);
          if (word.empty()) fail("the row ends before its " + std::string(column.name));
          if (error != std::errc() || stop != word.data() + word.size())
            fail("'" + std::string(word.substr(0, kLongestName)) + "' is no number, in " +
                 std::string(column.name));
        }
        put(sample, column, value);
      }
      if (!word.empty()) fail("the row has more numbers than the header names");
      add(sample);
    }
    if (line_ == 0) {
      line_ = 1;
      fail("it is empty");
    }
  }

  template <class Bits, class Value>
  Value take() {
    if (bytes_.size() - at_ < sizeof(Bits)) fail("it ends within a row");
    Bits bits = 0;
    for (std::size_t i = 0; i < sizeof(Bits); ++i)
      bits |= static_cast<Bits>(static_cast<Bits>(static_cast<unsigned char>(bytes_[at_ + i])) << (8 * i));
    at_ += sizeof(Bits);
    return std::bit_cast<Value>(bits);
  }

  void read_binary() {
    while (true) {
      const std::size_t end = bytes_.find('\0', at_);
      if (end == std::string_view::npos) fail("its list of names has no end");
      const std::string_view name = bytes_.substr(at_, end - at_);
      if (name.empty()) break;
      add_column(name);
      at_ = end + 1;
    }
    check_columns();
    ++at_;
    while (at_ < bytes_.size()) {
      DeviceLogSample sample;
      for (const LoggedColumn& column : columns_) {
        std::array<double, 4> value{};
        for (std::size_t i = 0; i < column.numbers; ++i)
          value[i] = column.quantity == LoggedQuantity::kButtons
                         ? static_cast<double>(take<std::uint32_t, std::int32_t>())
                         : take<std::uint64_t, double>();
        put(sample, column, value);
      }
      add(sample);
    }
  }

  std::string_view bytes_;
  std::string name_;
  bool thimble_frame_;
  DeviceLog log_;
  std::vector<LoggedColumn> columns_;
  LoggedQuantity time_ = LoggedQuantity::kTime;
  std::optional<double> start_s_;
  std::size_t at_ = 0;
  std::size_t line_ = 0;
};

}  // namespace

DeviceLog parse_device_log(std::span<const char> bytes, const std::string& name, bool thimble_frame) {
  return DeviceLogReader(bytes, name, thimble_frame).read();
}

DeviceLog read_device_log(const std::filesystem::path& file, bool thimble_frame) {
  return parse_device_log(read_input(file), file.string(), thimble_frame);
}

}  // namespace thimble::host
