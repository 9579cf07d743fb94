#include "host-tools/python/connection_binding.h"

#include <pybind11/numpy.h>
#include <pybind11/stl.h>
#include <pybind11/stl/filesystem.h>

#include <algorithm>
#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "board/sim/injection.h"
#include "firmware/core/faults.h"
#include "host-tools/client/device.h"
#include "host-tools/client/discovery.h"
#include "host-tools/client/key_file.h"
#include "host-tools/python/binding.h"

namespace py = pybind11;

namespace thimble::host {
namespace {

constexpr link::Micros kSlice_us = 100'000;  // how long Ctrl-C waits at most

// One fingertip as the link tells it. Without padding: numpy sees the fields where they are.
struct TelemetryRow {
  double time_s;  // this machine's clock, from the beginning
  std::int32_t arm;
  std::int32_t contacts;
  std::array<double, 3> tip_m;
  std::array<double, 3> force_N;
};

const firmware::ParamRow& param_named(const std::string& name) {
  const firmware::ParamRow* row = firmware::find_param(std::string_view(name));
  if (row == nullptr) throw py::key_error("there is no parameter '" + name + "'");
  return *row;
}

link::Micros micros_of(double seconds) {
  if (!(seconds >= 0 && seconds <= 1e9))
    throw py::value_error("a time is " + std::to_string(seconds) + " s: give seconds from 0 to 1e9");
  return static_cast<link::Micros>(seconds * 1e6);
}

class Connection {
 public:
  Connection(const std::string& device, unsigned node, double timeout_s, const std::string& key) {
    constexpr unsigned kTries = 5;
    DeviceOptions options;
    options.node = static_cast<std::uint8_t>(node);
    options.tries = kTries;
    options.answer_us = micros_of(timeout_s) / kTries;
    options.prove = prove_with(key.empty() ? default_key_file() : std::filesystem::path(key));
    options.program = "python";
    device_ = std::make_unique<Device>(open_transport(choose_device(device)), options);
  }
  void close() { device_.reset(); }
  [[nodiscard]] Device& device() {
    if (!device_) throw py::value_error("the connection is closed");
    return *device_;
  }

  py::dict info() {
    Device& d = device();
    const link::DeviceState state = d.state();
    py::dict info;
    info["arm"] = d.text(link::kDidArmName);
    info["board"] = d.text(link::kDidBoardName);
    info["firmware"] = d.text(link::kDidFirmwareVersion);
    info["serial_number"] = d.text(link::kDidSerialNumber);
    info["scene"] = d.text(link::kDidSceneName);
    py::list inside;
    for (const Device::Inside& solid : d.inside()) inside.append(py::make_tuple(solid.arm, solid.name));
    info["inside"] = inside;
    info["arms"] = d.info().arms;
    info["mode"] = link::name(state.mode);
    info["key"] = link::name(state.key);
    info["commander"] = state.commander;
    info["stopped_by"] = state.stopped_by == link::StoppedBy::kNothing
                             ? py::object(py::none())
                             : py::str(link::name(state.stopped_by));
    const firmware::FaultRow* fault = firmware::find_fault(static_cast<firmware::Fault>(state.fault));
    info["fault"] = state.fault == 0 || fault == nullptr ? py::object(py::none()) : py::str(fault->name);
    info["tick"] = state.tick;
    info["tick_rate_Hz"] = state.tick_rate_Hz;
    info["worst_tick_s"] = state.worst_tick_s;
    info["overruns"] = state.overruns;
    info["work_units"] = state.work_units;
    info["most_work"] = state.most_work;
    info["put_off"] = state.put_off;
    info["contact_ticks"] = state.contact_ticks;
    info["peak_force_N"] = state.peak_force_N;
    return info;
  }

  // crc: what is announced for the image; none: its own.
  py::dict upload(const py::bytes& given, std::optional<std::uint32_t> crc) {
    const std::vector<std::byte> image = bytes_of(given);
    UploadResult result;
    {
      const py::gil_scoped_release others;
      result = device().upload(image, {crc, true}, [](const UploadProgress&) { heed_python(); });
    }
    py::dict done;
    done["bytes"] = result.bytes;
    done["crc"] = result.crc;
    done["resumed_from"] = result.resumed_from;
    done["rate_bytes_s"] = result.bytes_per_s;
    return done;
  }

  // Every force that the link brings in so long, with the pose that belongs to it.
  py::array_t<TelemetryRow> telemetry(double seconds) {
    std::vector<TelemetryRow> rows;
    {
      const py::gil_scoped_release others;
      Device& d = device();
      const std::uint8_t node = d.info().node;
      std::array<link::Pose, 4> poses{};
      const link::Micros start_us = now_us();
      const link::Micros end_us = start_us + micros_of(seconds);
      while (now_us() < end_us) {
        const std::optional<link::CanFrame> frame = d.telemetry(std::min(end_us, now_us() + kSlice_us));
        heed_python();
        if (!frame) continue;
        link::Pose pose;
        link::Force force;
        if (link::from_frame(*frame, node, pose)) {
          poses[pose.arm & 3U] = pose;
        } else if (link::from_frame(*frame, node, force)) {
          const link::Pose& at = poses[force.arm];
          if (at.sequence != force.sequence) continue;  // of another tick
          rows.push_back({static_cast<double>(now_us() - start_us) * 1e-6,
                          force.arm,
                          force.contacts,
                          {at.x_m, at.y_m, at.z_m},
                          {force.x_N, force.y_N, force.z_N}});
        }
      }
    }
    return py::array_t<TelemetryRow>(static_cast<py::ssize_t>(rows.size()), rows.data());
  }

  // Position, force, limiters, number and when it was heard; none: no reading came in so long.
  py::object next_tip(double timeout_s, unsigned arm) {
    std::optional<TipReading> tip;
    {
      const py::gil_scoped_release others;
      const link::Micros end_us = now_us() + micros_of(timeout_s);
      while (true) {
        const link::Micros slice_us = now_us() + kSlice_us;
        tip = device().next_tip(std::min(end_us, slice_us), arm);
        if (tip || now_us() >= end_us) break;
        heed_python();
      }
    }
    if (!tip) return py::none();
    return py::make_tuple(py::array_t<double>(3, tip->position_m.data()),
                          py::array_t<double>(3, tip->force_N.data()), tip->limiters, tip->sequence,
                          static_cast<double>(tip->heard_us) * 1e-6);
  }

  void order_force(const py::array_t<double>& force_N, unsigned arm) {
    if (force_N.ndim() != 1 || force_N.shape(0) != 3) throw py::value_error("a force has three numbers");
    const auto given = force_N.unchecked<1>();
    const std::array<double, 3> force{given(0), given(1), given(2)};
    const py::gil_scoped_release others;
    device().order_force(force, arm);
  }

  py::dict orders() {
    link::HostOrders counted;
    {
      const py::gil_scoped_release others;
      counted = device().orders();
    }
    py::dict orders;
    orders["taken"] = counted.taken;
    orders["old"] = counted.old;
    orders["wrong"] = counted.wrong;
    orders["expired"] = counted.expired;
    return orders;
  }

  void inject(const std::string& name, unsigned arm, std::optional<unsigned> joint, double value,
              const std::array<double, 3>& force_N, std::optional<double> for_s) {
    const board::InjectionRow* row = board::find_injection(name);
    if (row == nullptr) throw py::key_error("there is no fault '" + name + "' to inject");
    if (arm > 255 || joint.value_or(0) > 254) throw py::value_error("no arm has such a number, or no joint");
    if (for_s && !(*for_s > 0)) throw py::value_error("a fault lasts for a time above 0, or for good");
    const link::InjectedFault fault{.fault = static_cast<std::uint8_t>(row->kind),
                                    .arm = static_cast<std::uint8_t>(arm),
                                    .joint = static_cast<std::uint8_t>(joint.value_or(255)),
                                    .value = static_cast<float>(value),
                                    .force_x_N = static_cast<float>(force_N[0]),
                                    .force_y_N = static_cast<float>(force_N[1]),
                                    .force_z_N = static_cast<float>(force_N[2]),
                                    .for_s = static_cast<float>(for_s.value_or(0))};
    const py::gil_scoped_release others;
    device().inject(fault);
  }

  py::list audit() {
    std::vector<link::AuditRecord> entries;
    {
      const py::gil_scoped_release others;
      entries = device().audit();
    }
    py::list all;
    for (const link::AuditRecord& entry : entries) {
      py::dict one;
      one["number"] = entry.number;
      one["event"] = link::name(entry.event);
      one["host"] = entry.host;
      one["text"] = std::string(entry.text.begin(), std::find(entry.text.begin(), entry.text.end(), 0));
      one["utc_s"] = entry.utc_s;
      one["start"] = entry.start;
      one["uptime_s"] = entry.uptime_s;
      one["detail"] = entry.detail;
      one["value"] = entry.value;
      one["left_out"] = entry.left_out;
      all.append(one);
    }
    return all;
  }

  std::vector<std::string> faults() {
    std::vector<std::string> names;
    for (const std::uint8_t number : device().faults()) {
      const firmware::FaultRow* row = firmware::find_fault(static_cast<firmware::Fault>(number));
      names.push_back(row == nullptr ? std::to_string(number) : row->name);
    }
    return names;
  }

 private:
  std::unique_ptr<Device> device_;
};

template <class... Arguments>
auto without_gil(void (Device::*method)(Arguments...), Arguments... arguments) {
  return [method, arguments...](Connection& c) {
    const py::gil_scoped_release others;
    (c.device().*method)(arguments...);
  };
}

// Ctrl-C ends it, and the arm is disarmed.
void home(Connection& connection) {
  constexpr link::Micros kHome_us = 30'000'000;
  bool interrupted = false;
  const auto heed = [&interrupted] {
    const py::gil_scoped_acquire python;
    return interrupted = PyErr_CheckSignals() != 0;
  };
  {
    const py::gil_scoped_release others;
    connection.device().home(kHome_us, heed);
  }
  if (interrupted) throw py::error_already_set();
}

py::list discovered() {
  py::list all;
  for (const DeviceEntry& entry : discover()) {
    py::dict one;
    one["name"] = entry.name;
    one["kind"] = entry.kind;
    one["arm"] = entry.arm;
    one["uris"] = entry.uris;
    all.append(one);
  }
  return all;
}

}  // namespace

void bind_connection(py::module_& m) {
  PYBIND11_NUMPY_DTYPE(TelemetryRow, time_s, arm, contacts, tip_m, force_N);
  m.def("discover", discovered);
  m.def("now_s", [] { return static_cast<double>(now_us()) * 1e-6; });
  constexpr link::Micros kArm_us = 2'000'000, kDisarm_us = 5'000'000;
  py::class_<Connection>(m, "Connection")
      .def(py::init<std::string, unsigned, double, std::string>())
      .def("close", &Connection::close)
      .def("info", &Connection::info)
      .def("upload", &Connection::upload)
      .def("telemetry", &Connection::telemetry)
      .def("faults", &Connection::faults)
      .def("inject", &Connection::inject)
      .def("audit", &Connection::audit)
      .def("take_over",
           [](Connection& c, double readings_per_s) {
             const py::gil_scoped_release others;
             c.device().take_over(readings_per_s);
           })
      .def("next_tip", &Connection::next_tip)
      .def("order_force", &Connection::order_force)
      .def("hand_back", without_gil(&Device::hand_back))
      .def("orders", &Connection::orders)
      .def("home", home)
      .def("arm", without_gil(&Device::arm, kArm_us))
      .def("disarm", without_gil(&Device::disarm, kDisarm_us))
      .def("stop",
           [](Connection& c) {
             const py::gil_scoped_release others;
             static_cast<void>(c.device().stop());
           })
      .def("clear_faults",
           [](Connection& c) {
             const py::gil_scoped_release others;
             c.device().clear_faults();
           })
      .def("keep_alive", without_gil(&Device::keep_alive))
      .def("parameters",
           [](Connection&) {
             std::vector<std::string> names;
             for (const firmware::ParamRow& row : firmware::kParamTable) names.emplace_back(row.name);
             return names;
           })
      .def("read_parameter",
           [](Connection& c, const std::string& name) { return c.device().read_param(param_named(name)); })
      .def("write_parameter", [](Connection& c, const std::string& name,
                                 double value) { c.device().write_param(param_named(name), value); })
      .def("mark", [](Connection& c, const std::string& name, std::uint16_t value) {
        const py::gil_scoped_release others;
        return c.device().mark(param_named(name), value).tick;
      });
}

}  // namespace thimble::host
