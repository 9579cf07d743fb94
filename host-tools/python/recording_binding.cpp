#include "host-tools/python/recording_binding.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "firmware/params.h"
#include "host-tools/files/output_file.h"
#include "host-tools/lab/event_table.h"
#include "host-tools/lab/recording.h"
#include "host-tools/lab/recording_json.h"
#include "host-tools/lab/replay_recording.h"
#include "host-tools/lab/run_log.h"
#include "host-tools/python/binding.h"
#include "host-tools/python/simulation_binding.h"

namespace py = pybind11;

namespace thimble::host {
namespace {

struct CheckRow {
  std::uint64_t tick;
  std::uint32_t crc;
  std::uint8_t mode;
  std::uint8_t command;
};

struct FrameRow {
  double time_s;
  std::uint32_t id;
  std::uint32_t size;
  std::array<std::uint8_t, link::kClassicDataBytes> data;
};

struct EventRow {
  std::uint64_t tick;
  double time_s;
  std::uint16_t code;
  std::uint8_t kind;
};

template <class Row>
py::array_t<Row> to_numpy(const std::vector<Row>& rows) {
  return py::array_t<Row>(static_cast<py::ssize_t>(rows.size()), rows.data());
}

class PyRecording {
 public:
  explicit PyRecording(const std::filesystem::path& file) {
    const py::gil_scoped_release others;
    recording_ = read_recording(file);
    columns_ = SceneColumns(recording_.header.scene);
  }

  [[nodiscard]] std::string about() const {
    nlohmann::ordered_json about = about_json(recording_);
    about["began_utc_s"] = recording_.header.began;
    about["cut_bytes"] = recording_.cut_bytes;
    return about.dump();
  }
  [[nodiscard]] py::bytes scene() const { return to_python(recording_.header.scene); }

  // By name; those that this program does not know by their number.
  [[nodiscard]] py::dict parameters() const {
    py::dict all;
    for (const auto& [id, bits] : recording_.header.parameters) {
      const firmware::ParamRow* row = firmware::find_param(id);
      const bool is_float = row != nullptr && row->type == firmware::ParamType::kFloat;
      all[py::str(row == nullptr ? std::to_string(id) : row->name)] =
          is_float ? static_cast<double>(std::bit_cast<float>(bits)) : static_cast<double>(bits);
    }
    return all;
  }

  [[nodiscard]] py::array_t<std::uint64_t> ticks() const {
    std::vector<std::uint64_t> numbers;
    const std::size_t each = kRecordedCounts * arms();
    for (const RecordedTicks& run : recording_.ticks)
      for (std::size_t i = 0; i < run.counts.size() / each; ++i) numbers.push_back(run.first + i);
    return to_numpy(numbers);
  }
  [[nodiscard]] py::array_t<std::uint16_t> counts() const {
    std::vector<std::uint16_t> counts;
    for (const RecordedTicks& run : recording_.ticks)
      counts.insert(counts.end(), run.counts.begin(), run.counts.end());
    const auto columns = static_cast<py::ssize_t>(arms());
    constexpr auto kEach = static_cast<py::ssize_t>(kRecordedCounts);
    const auto ticks = static_cast<py::ssize_t>(counts.size()) / (columns * kEach);
    return py::array_t<std::uint16_t>({ticks, columns, kEach}, counts.data());
  }
  [[nodiscard]] py::array_t<CheckRow> checks() const {
    std::vector<CheckRow> rows;
    for (const RecordedCheck& check : recording_.checks)
      rows.push_back({check.tick, check.crc, static_cast<std::uint8_t>(check.mode),
                      static_cast<std::uint8_t>(check.command)});
    return to_numpy(rows);
  }
  [[nodiscard]] py::array_t<EventRow> events() const {
    std::vector<EventRow> rows;
    for (const RecordedMark& mark : recording_.marks)
      rows.push_back(
          {mark.tick, time_of(recording_, mark), mark.value, static_cast<std::uint8_t>(mark.what)});
    return to_numpy(rows);
  }
  [[nodiscard]] py::array_t<FrameRow> frames() const {
    std::vector<FrameRow> rows;
    for (const RecordedFrame& frame : recording_.frames) {
      FrameRow row{frame.time_us * 1e-6, frame.frame.id, frame.frame.size, {}};
      std::copy_n(frame.frame.data.begin(), row.data.size(), row.data.begin());
      rows.push_back(row);
    }
    return to_numpy(rows);
  }

  // Rows of the replay, and its verdict as JSON.
  [[nodiscard]] py::tuple replay() const {
    SimulationRows rows(columns_);
    ReplayVerdict verdict;
    {
      const py::gil_scoped_release others;
      verdict = replay_recording(recording_, [&rows](const board::LogRow& row) {
        rows.add(row);
        if (rows.count() % kHeedRows == 0) heed_python();
      });
    }
    return py::make_tuple(rows.to_numpy(), verdict_json(verdict).dump());
  }

  // The file that `thimble replay --log` writes.
  void write_csv(const std::filesystem::path& file) const {
    const py::gil_scoped_release others;
    OutputFile log(file);
    write_log_header(log.stream(), columns_);
    static_cast<void>(replay_recording(
        recording_, [&](const board::LogRow& row) { write_log_row(log.stream(), row, columns_); }));
    log.commit();
  }

 private:
  [[nodiscard]] std::size_t arms() const { return recording_.header.start.arms; }

  Recording recording_;
  SceneColumns columns_;
};

}  // namespace

void bind_recording(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(CheckRow, tick, crc, mode, command);
  PYBIND11_NUMPY_DTYPE(FrameRow, time_s, id, size, data);
  PYBIND11_NUMPY_DTYPE(EventRow, tick, time_s, code, kind);
  py::class_<PyRecording>(m, "Recording")
      .def(py::init<const std::filesystem::path&>())
      .def("about", &PyRecording::about)
      .def("scene", &PyRecording::scene)
      .def("parameters", &PyRecording::parameters)
      .def("ticks", &PyRecording::ticks)
      .def("counts", &PyRecording::counts)
      .def("checks", &PyRecording::checks)
      .def("frames", &PyRecording::frames)
      .def("events", &PyRecording::events)
      .def("replay", &PyRecording::replay)
      .def("write_csv", &PyRecording::write_csv);
  m.def("write_file", [](const std::filesystem::path& path, const std::string& bytes) {
    OutputFile file(path);
    file.stream().write(bytes.data(), static_cast<std::streamsize>(bytes.size()));
    file.commit();
  });
}

}  // namespace thimble::host
