// The verbs of `thimble`, one function each. main.cpp parses the command line into these options. Each prints
// its data on stdout and throws Error.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "host-tools/client/key_file.h"

namespace thimble::host {

struct Common {
  bool json = false;
};

struct Remote {
  std::string device;  // URI or name; empty: the only one
  unsigned node = 1;
  double timeout_s = 2.0;  // for an answer, all tries together
  std::filesystem::path key = default_key_file();
  std::string program = "thimble";  // and the verb: for the device's audit record
};

void list(const Common& common);
void info(const Common& common, const Remote& remote);

struct DoctorChoice {
  std::string device;  // address, interface or name; empty: all that is there
  bool board = false;  // and what thimble-board needs
};
void doctor(const Common& common, const DoctorChoice& choice);

struct UploadChoice {
  std::filesystem::path file;
  std::string model;  // whose walls are warned of; empty: what is known of the device's arms
  bool verify = true;
};
void upload(const Common& common, const Remote& remote, const UploadChoice& choice);

void arm(const Common& common, const Remote& remote);
void disarm(const Common& common, const Remote& remote);
void stop(const Common& common, const Remote& remote);
void restart(const Common& common, const Remote& remote);
void home(const Common& common, const Remote& remote, double wait_s);

struct MonitorChoice {
  double seconds = 0;       // 0: until Ctrl-C
  std::uint64_t count = 0;  // frames with --json, rows without (pictures in a terminal); 0: no limit
  bool rows = false;        // in a terminal, too
  bool keep_alive = false;  // feed host supervision
};
void monitor(const Common& common, const Remote& remote, const MonitorChoice& choice);

struct PublishChoice {
  std::string broker;  // host or host:port
  std::string topic;   // empty: thimble/SERIAL_NUMBER
  std::string user;
  std::filesystem::path password_file;
  std::filesystem::path ca_file;
  double seconds = 0;  // 0: until Ctrl-C
};
void publish(const Common& common, const Remote& remote, const PublishChoice& choice);

struct ViewChoice {
  std::filesystem::path scene;  // start a simulated device with it
  std::string arm = "premium-1.5";
  unsigned arms = 1;
  std::filesystem::path scenes;
  std::string listen;
  std::uint16_t port = 0;
  bool browser = true;
};
void view(const Common& common, const Remote& remote, const ViewChoice& choice);

struct ScanChoice {
  std::filesystem::path plan;
  std::filesystem::path log;
  std::filesystem::path output;  // the scene file
  bool resume = false;
  bool allow_moves = false;
  bool simulate = false;
  std::filesystem::path specimen;  // of the simulated arm, like the rest
  std::string arm = "premium-1.5";
  std::uint64_t seed = 1;
};
void scan(const Common& common, const Remote& remote, const ScanChoice& choice);

void param_list(const Common& common, const Remote& remote);
void param_get(const Common& common, const Remote& remote, const std::string& name);
void param_save(const Common& common, const Remote& remote);
void param_set(const Common& common, const Remote& remote, const std::string& name, const std::string& value);

void fault_list(const Common& common, const Remote& remote);
void fault_clear(const Common& common, const Remote& remote);

// Empty: the file of `remote`.
void key_set(const Common& common, const Remote& remote, const std::filesystem::path& file);
void key_remove(const Common& common, const Remote& remote);
void fault_explain(const Common& common, const std::string& which);  // number or name

void audit(const Common& common, const Remote& remote);

void write_dbc(unsigned node, const std::filesystem::path& output);   // empty: stdout
void decode(const Common& common, const std::filesystem::path& log);  // "-": stdin

struct CompileChoice {
  std::filesystem::path scene;
  std::filesystem::path output;
  bool report = false;              // every count of each mesh; JSON always has them
  double rate_Hz = 4000;            // of the loop and the arm that will render it, for the warnings
  std::string arm = "premium-1.5";  // chosen_arm()
  std::string board;                // of whose core the cost is told; empty: none is
};
void compile(const Common& common, const CompileChoice& choice);

struct MeshChoice {
  std::filesystem::path file;
  std::filesystem::path output;  // *.obj, in metres
  double scale_m = 1;            // metres per unit of the file
  double max_hole_m = 0;
  bool keep_crossings = false;
};
void mesh(const Common& common, const MeshChoice& choice);

// model: the name of an arm that comes with Thimble, or the path of an arm file.
void model_check(const Common& common, const std::string& model);

struct ModelCompileChoice {
  std::string model;
  std::filesystem::path output;
};
struct ModelUploadChoice {
  std::string model;
  unsigned arm = 0;  // of the device
};
void model_upload(const Common& common, const Remote& remote, const ModelUploadChoice& choice);
void model_compile(const Common& common, const ModelCompileChoice& choice);
void model_show(const Common& common, const std::string& model);
void model_list(const Common& common);

struct ModelImportChoice {
  std::filesystem::path urdf;
  std::filesystem::path output;  // *.arm.json
  std::string tip;               // a link; empty: the only leaf
};
void model_import(const Common& common, const ModelImportChoice& choice);

struct CommissionChoice {
  std::string model;
  bool simulate = false;
  unsigned arm = 0;                 // its number on the device
  std::vector<std::string> faults;  // planted_fault()
  std::uint64_t seed = 1;           // of the simulated arm and builder
  bool ask = false;                 // the prompts on standard input; always so with a page
  bool accept_corrections = false;
  std::filesystem::path state;  // empty: beside the arm file
  std::optional<int> step;      // only this one
  bool restart = false;
  bool page = false;
  std::string listen;  // of the page
  std::uint16_t port = 0;
  bool browser = true;
};
void commission(const Common& common, const Remote& remote, const CommissionChoice& choice);

struct ImportVolumeChoice {
  std::filesystem::path volume;
  std::string from;  // "x,y,z"
  std::string to;
  bool in_voxels = false;
  std::filesystem::path table;  // empty: classes by k-means
  std::size_t classes = 4;
  double thinnest_mm = 2.0;
  std::filesystem::path output;
};
void import_volume(const Common& common, const ImportVolumeChoice& choice);

struct ImportDeviceLogChoice {
  std::filesystem::path log;
  std::filesystem::path path;    // for `simulate --path`; empty: none
  std::filesystem::path forces;  // a log for `plot`; empty: none
  bool thimble_frame = false;    // x to the right, y away from the user, z up, instead of H3D's axes
};
void import_device_log(const Common& common, const ImportDeviceLogChoice& choice);

struct RecordChoice {
  std::filesystem::path output;
  std::filesystem::path scene;
  double seconds = 0;  // 0: until Ctrl-C, or the recording ends
  bool home = false;
  bool arm = false;
  bool force = false;  // OUT may be there, and another program recording
};
void record(const Common& common, const Remote& remote, const RecordChoice& choice);

struct ReplayChoice {
  std::filesystem::path file;
  std::filesystem::path log;     // empty: none
  std::filesystem::path events;  // the same
};
void replay(const Common& common, const ReplayChoice& choice);

struct PlotChoice {
  std::filesystem::path file;  // a recording or a log
  std::filesystem::path output;
  std::string kind = "all";
  unsigned tip = 0;  // of this arm
};
void plot(const Common& common, const PlotChoice& choice);

struct SimulateChoice {
  std::filesystem::path scene;
  std::filesystem::path path;
  std::filesystem::path log;
  bool ideal = false;
  double rate_Hz = 4000;
  std::string arm = "premium-1.5";
  std::uint64_t seed = 1;
  std::uint8_t trial = 0;
  bool watch = false;  // again each time a file is saved, until a signal ends it
};
void simulate(const Common& common, const SimulateChoice& choice);

struct SweepChoice {
  std::filesystem::path plan;
  std::filesystem::path output;
  std::filesystem::path table;  // Markdown; empty: none
  std::size_t jobs = 0;         // threads; 0: all processors, or of a task of Slurm one
  std::string array;            // "I/N": this part of N only
  std::size_t slurm = 0;        // tasks of a job array; 0: here
  bool dry_run = false;
};
void sweep(const Common& common, const SweepChoice& choice);

void new_scene(const Common& common, const std::string& name);
struct ShowChoice {
  std::filesystem::path scene;
  double rate_Hz = 4000;  // for the costs
};
void show(const Common& common, const ShowChoice& choice);

}  // namespace thimble::host
